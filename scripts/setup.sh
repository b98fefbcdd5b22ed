#!/bin/sh
# Installs the system packages that Populace uses: an OpenCL driver for the CPU (PoCL), the OpenCL
# loader, EGL, and Mesa's software OpenGL driver.
#
#   setup.sh           installs what is missing, as root or with sudo
#   setup.sh --ask     the same, but asks before it uses sudo
#   setup.sh --check   installs nothing: lists what is missing and exits with 1
#   setup.sh --tests   installs what only tests need: Xvfb, a display without a screen; never fails
#
# It installs on Debian and Ubuntu only. On other systems it names the packages.
set -eu

packages="pocl-opencl-icd ocl-icd-libopencl1 libegl1 libgl1-mesa-dri"
mode="${1:-install}"

say() { printf 'setup: %s\n' "$*" >&2; }

case "$mode" in
install | --ask | --check) ;;
--tests)
    packages="xvfb"
    trap 'exit 0' EXIT
    mode=install
    ;;
*)
    say "unknown argument $mode; --ask, --check and --tests are known"
    exit 2
    ;;
esac

consequence() {
    if [ "$packages" = xvfb ]; then
        say "without it the tests of the window show as ignored"
        return
    fi
    say "without them Populace evaluates crowds on the native device, and draws nothing"
    say "tests that need them fail; POPULACE_SKIP=opencl,gl shows those tests as ignored"
}

installed() { dpkg-query -W -f '${Status}' "$1" 2>/dev/null | grep -q 'install ok installed'; }

library() { ldconfig -p 2>/dev/null | grep -q "$1"; }

# The command that installs the missing packages as root, for a person to type.
command_line() { echo "apt-get install$missing"; }

install_with() { # PREFIX...
    "$@" env DEBIAN_FRONTEND=noninteractive apt-get update -qq </dev/null &&
        "$@" env DEBIAN_FRONTEND=noninteractive \
            apt-get install -y -qq --no-install-recommends $missing </dev/null
}

# Asks on the terminal; anything but y or yes means no.
agreed() {
    printf 'setup: run "sudo %s" now? [y/N] ' "$(command_line)" >&2
    read -r answer || return 1
    case "$answer" in [yY] | [yY][eE][sS]) return 0 ;; *) return 1 ;; esac
}

if ! command -v apt-get >/dev/null 2>&1 || ! command -v dpkg-query >/dev/null 2>&1; then
    if [ "$packages" = xvfb ]; then
        command -v Xvfb >/dev/null 2>&1 || say "install Xvfb for the tests of the window"
        exit 0
    fi
    if library libOpenCL.so && library libEGL.so; then
        exit 0
    fi
    say "this is not Debian or Ubuntu: install an OpenCL driver, and EGL with OpenGL 4.3 or later"
    say "  Fedora: dnf install pocl ocl-icd mesa-libEGL mesa-dri-drivers"
    say "  Arch:   pacman -S pocl ocl-icd mesa"
    consequence
    [ "$mode" != --check ] || exit 1
    exit 0
fi

missing=""
for package in $packages; do
    installed "$package" || missing="$missing $package"
done
if [ -z "$missing" ]; then
    exit 0
fi

if [ "$mode" = --check ]; then
    say "not installed:$missing"
    say "\"make setup\" installs them"
    consequence
    exit 1
fi

if [ "$(id -u)" = 0 ]; then
    say "installing as root:$missing"
    install_with env && exit 0
elif ! command -v sudo >/dev/null 2>&1; then
    say "root is needed to install:$missing"
elif [ -t 0 ]; then
    # sudo may ask for a password here.
    if [ "$mode" = install ] || agreed; then
        say "installing with sudo:$missing"
        install_with sudo && exit 0
    fi
elif [ "$mode" = install ] && sudo -n true 2>/dev/null; then
    say "installing with sudo:$missing"
    install_with sudo -n && exit 0
fi
say "not installed; as root, run:"
say "  $(command_line)"
consequence
