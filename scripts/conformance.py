"""Runs tests of the devices on another OpenCL driver, which is fetched and not installed.

    conformance.py intel      Intel's runtime for CPUs, from PyPI: all tests of populace-opencl
    conformance.py oclgrind   Oclgrind's interpreter, from Debian: a small scene of everything, under
                              its race detector; and once more without the barriers between levels
                              of the hierarchy, which it must notice
    conformance.py pocl       the driver that is installed: all tests of populace-opencl
"""

import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import fetched

INTEL = ["intel-opencl-rt==2026.2.0", "intel-cmplr-lib-rt==2026.2.0", "tbb==2023.*"]
ALL = ["-p", "populace-opencl", "--lib"]
# What PoCL can be split into; Intel's parts are others.
OF_POCL = ["--skip", "parts_divide_the_compute_units_equally", "--skip", "conformance_on_a_part"]
SMALL = ["-p", "populace", "--test", "controls", "small_scene_of_everything_gives_equal_bits"]
# Oclgrind 21.10 lacks intrinsics: llvm.usub.sat, which the optimizer makes of "a > b ? a - b : 0";
# llvm.experimental.noalias.scope.decl, which inlining leaves behind; llvm.prefetch and
# llvm.vector.reduce.or, which kernels use where the compiler has builtins for them.
FOR_OCLGRIND = "-cl-opt-disable -D always_inline=noinline -D __has_builtin(name)=0"
WITHOUT_LEVEL_BARRIERS = "-D LEVEL_BARRIER="


def with_driver(library, folder, *libraries):
    """Returns the environment in which a library is the only OpenCL driver."""
    vendors = Path(folder) / "vendors"
    vendors.mkdir(exist_ok=True)
    (vendors / "driver.icd").write_text(f"{library}\n")
    # Kernels of another driver do not belong into the user's cache.
    return {**fetched.with_libraries(*libraries), "OCL_ICD_VENDORS": str(vendors),
            "POPULACE_CACHE_DIR": str(Path(folder) / "cache")}


def tests(names, env, *options):
    """Runs tests, prints what they print, and returns whether they passed and how many."""
    command = ["cargo", "test", *names, "--", *options]
    run = subprocess.Popen(command, cwd=fetched.ROOT, env=env, text=True, stdout=subprocess.PIPE)
    passed = 0
    for line in run.stdout:
        print(line, end="", flush=True)
        passed += sum(map(int, re.findall(r"^test result: \w+\. (\d+) passed", line)))
    return run.wait() == 0, passed


def races(env, log, more=""):
    """Runs the small scene under the race detector. Returns whether it passed, and the races."""
    log.unlink(missing_ok=True)
    # The cache of kernels does not know these options.
    cache = tempfile.mkdtemp(dir=log.parent)
    env = {**env, "OCLGRIND_DATA_RACES": "1", "OCLGRIND_LOG": str(log),
           "OCLGRIND_BUILD_OPTIONS": f"{FOR_OCLGRIND} {more}", "POPULACE_CACHE_DIR": cache}
    passed, count = tests(SMALL, env, "--nocapture")
    said = log.read_text(errors="replace") if log.exists() else ""
    return passed and count > 0, re.findall(r"^.*data race.*$", said, re.M)


def oclgrind(folder):
    root = fetched.debian("oclgrind", ["oclgrind"])
    lib = root / "usr/lib"
    icd = (lib / "oclgrind/liboclgrind-rt-icd.so").resolve()
    env = with_driver(icd, folder, fetched.only(lib, "*-linux-gnu"))
    log = Path(folder) / "oclgrind.log"
    passed, found = races(env, log)
    if not passed or found:
        sys.exit("\n".join(["the small scene fails on Oclgrind, or races:", *found[:9]]))
    _, found = races(env, log, WITHOUT_LEVEL_BARRIERS)
    if not found:
        sys.exit("Oclgrind reports no race where levels of the hierarchy have no barrier")
    print(f"oclgrind: the small scene is equal and has no race; {len(found)} "
          "where levels of the hierarchy have no barrier")


def whole_suite(driver, env, *options):
    total = 0
    for which in [(), ("--ignored", "::slow::")]:
        passed, count = tests(ALL, env, *which, *options)
        if not passed or count == 0:
            sys.exit(f"{driver}: tests fail")
        total += count
    print(f"{driver}: {total} tests passed")


def intel(folder):
    root = fetched.wheels("intel-2026.2", INTEL)
    libraries = sorted(root.glob("*.data/data/lib"))
    icd = fetched.only(root, "*/data/lib/libintelocl.so").resolve()
    whole_suite("intel", with_driver(icd, folder, *libraries), *OF_POCL)


def pocl(_folder):
    whole_suite("pocl", os.environ)


def main():
    drivers = {"intel": intel, "oclgrind": oclgrind, "pocl": pocl}
    if len(sys.argv) != 2 or sys.argv[1] not in drivers:
        sys.exit(f"usage: conformance.py {'|'.join(drivers)}")
    with tempfile.TemporaryDirectory() as folder:
        drivers[sys.argv[1]](folder)


if __name__ == "__main__":
    main()
