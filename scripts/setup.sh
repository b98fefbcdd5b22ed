#!/bin/sh
# Installs what Populace uses from the system: an OpenCL driver for the CPU (PoCL), the OpenCL loader, EGL, and Mesa's
# software OpenGL driver. Does so on Debian and Ubuntu as root or where sudo asks for no password; elsewhere it says
# what to install, and goes on. Never stops at a prompt.
set -eu

packages="pocl-opencl-icd ocl-icd-libopencl1 libegl1 libgl1-mesa-dri"

say() { printf 'setup: %s\n' "$*" >&2; }

installed() { dpkg-query -W -f '${Status}' "$1" 2>/dev/null | grep -q 'install ok installed'; }

install_with() { # PREFIX...
    "$@" env DEBIAN_FRONTEND=noninteractive apt-get update -qq </dev/null &&
        "$@" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $missing </dev/null
}

if command -v apt-get >/dev/null 2>&1 && command -v dpkg-query >/dev/null 2>&1; then
    missing=""
    for package in $packages; do
        installed "$package" || missing="$missing $package"
    done
    if [ -z "$missing" ]; then
        exit 0
    fi
    say "installing$missing"
    if [ "$(id -u)" = 0 ]; then
        install_with env && exit 0
    elif command -v sudo >/dev/null 2>&1 && sudo -n true 2>/dev/null; then
        install_with sudo -n && exit 0
    fi
    say "could not install them here; as root, run:"
    say "  apt-get install$missing"
else
    say "this is not Debian or Ubuntu; install an OpenCL driver and EGL with OpenGL 4.3 or later, for example"
    say "  Fedora: dnf install pocl ocl-icd mesa-libEGL mesa-dri-drivers"
    say "  Arch:   pacman -S pocl ocl-icd mesa"
fi
say "going on without; tests that need what is missing fail, unless POPULACE_SKIP=opencl,gl leaves them out"
