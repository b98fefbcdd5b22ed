"""Runs all fuzz targets, each for some seconds, from the seeds of the ordinary tests.

    fuzz.py 60            every target for 60 s
    fuzz.py 60 gltf calls two of them

Needs the nightly toolchain and cargo-fuzz. Corpora stay in fuzz/corpus, minimised; inputs that
fail are written to fuzz/artifacts.
"""

import os
import re
import subprocess
import sys

import fetched

CORPUS = fetched.ROOT / "fuzz" / "corpus"
# Tests that write seeds: crate, options, filter.
SEEDS = [
    ("populace-assets", "gltf", "seeds"),
    ("populace-trajectory", "text", "seeds"),
    ("populace-trajectory", "simulations", "seeds"),
    ("populace-scene", "scene_file", "read"),
    ("populace-cli", "sequences", "seeds"),
    ("populace-cli", None, "seed"),
]
# An input of a slow target takes up to some milliseconds; one that takes longer than this hangs.
TIMEOUT_SECS = 25


def fuzz(*arguments):
    """Runs cargo-fuzz and returns whether it succeeded, with its output."""
    # AddressSanitizer takes a table of meshoptimizer for two.
    env = {**os.environ, "ASAN_OPTIONS": "detect_odr_violation=0"}
    run = subprocess.run(["cargo", "+nightly", "fuzz", *arguments], cwd=fetched.ROOT, env=env,
                         text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    return run.returncode == 0, run.stdout


def write_seeds():
    """Writes the seeds of all targets to their corpora."""
    env = {**os.environ, "POPULACE_WRITE_SEEDS": "fuzz/corpus"}
    for crate, test, name in SEEDS:
        of = ["--test", test] if test else ["--lib"]
        subprocess.run(["cargo", "test", "-q", "-p", crate, *of, name], cwd=fetched.ROOT, env=env,
                       check=True)


def main():
    if len(sys.argv) < 2:
        sys.exit("usage: fuzz.py SECONDS [TARGET...]")
    secs, *chosen = sys.argv[1:]
    if not fuzz("--version")[0]:
        sys.exit("rustup toolchain install nightly; cargo install cargo-fuzz")
    targets = chosen or fuzz("list")[1].split()
    write_seeds()
    total, failed = 0, []
    for target in targets:
        (CORPUS / target).mkdir(parents=True, exist_ok=True)
        passed, said = fuzz("run", target, "--", f"-max_total_time={secs}",
                            f"-timeout={TIMEOUT_SECS}", "-print_final_stats=1")
        count = re.search(r"stat::number_of_executed_units: *(\d+)", said)
        count = int(count.group(1)) if count else 0
        total += count
        if not passed:
            failed.append(target)
            print(said[-4000:])
        else:
            fuzz("cmin", target)
        kept = len(list((CORPUS / target).iterdir()))
        print(f"{target}: {count} executions, {kept} inputs kept", flush=True)
    print(f"{total} executions in all")
    if failed:
        sys.exit(f"failed: {', '.join(failed)}")


if __name__ == "__main__":
    main()
