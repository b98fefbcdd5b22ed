"""Puts single faults into a copy of the workspace. The named check must notice each of them.

    native-faults.py           all faults of crates/populace-native/faults.toml
    native-faults.py gaze yaw  those whose name or check contains one of these words
"""

import os
import shutil
import subprocess
import sys
import tomllib

import fetched

FOLDER = fetched.TARGET / "faults"
COPY = FOLDER / "workspace"
# Each fault costs a build of populace-native, so it is built fast rather than for speed.
PROFILE = ["profile.dev.debug=0", *(f"profile.dev.package.populace-native.{setting}" for setting in
           ("opt-level=1", "incremental=true", "codegen-units=256"))]


def copy_workspace():
    """Copies all files that belong to the workspace, if they differ."""
    listed = subprocess.run(["git", "ls-files", "-co", "--exclude-standard"], cwd=fetched.ROOT,
                            check=True, capture_output=True, text=True).stdout
    for name in listed.splitlines():
        source, copy = fetched.ROOT / name, COPY / name
        if source.is_file() and not (copy.is_file()
                                     and copy.read_bytes() == source.read_bytes()):
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(source, copy)


def run(check):
    """Runs a check on the staged schedule. Returns whether it passed, and what it said."""
    config = [option for setting in PROFILE for option in ("--config", setting)]
    env = {**os.environ, "CARGO_TARGET_DIR": str(FOLDER / "target")}
    done = subprocess.run(["cargo", "test", "-q", "-p", "populace-native", "--test", "conformance",
                           *config, "--", "--exact", f"conformance::{check}"], cwd=COPY, env=env,
                          text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    return done.returncode == 0 and "1 passed" in done.stdout, done.stdout


def caught(fault):
    """Returns why a fault was not caught; None if it was."""
    file = COPY / fault["file"]
    text = file.read_text()
    if text.count(fault["right"]) != 1:
        return f"{fault['file']} does not hold this once: {fault['right']}"
    file.write_text(text.replace(fault["right"], fault["wrong"]))
    try:
        passed, said = run(fault["check"])
    finally:
        file.write_text(text)
    if passed:
        return f"{fault['check']} passes"
    # A row beside the clip's own is noticed by the judge, one beside all rows by the slice.
    noticed = "off by" in said or "out of range for slice" in said
    return None if noticed else f"{fault['check']} fails for another reason:\n{said}"


def main():
    with open(fetched.ROOT / "crates/populace-native/faults.toml", "rb") as file:
        faults = tomllib.load(file)["fault"]
    words = sys.argv[1:] or [""]
    faults = [f for f in faults if any(w in f["name"] or w in f["check"] for w in words)]
    copy_workspace()
    for check in sorted({fault["check"] for fault in faults}):
        passed, said = run(check)
        if not passed:
            sys.exit(f"{check} does not pass without a fault:\n{said}")
    missed = 0
    for fault in faults:
        reason = caught(fault)
        missed += reason is not None
        print(f"{fault['name']}: {reason or 'caught'}", flush=True)
    print(f"{len(faults) - missed} of {len(faults)} faults caught")
    sys.exit(missed > 0)


if __name__ == "__main__":
    main()
