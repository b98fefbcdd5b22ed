#!/bin/sh
# Builds the test programs of `cargo test "$@"` and runs two at a time, because most of them use one
# core; then the documentation tests. Prints how many tests passed, and how many checks of the
# conformance suite on how many devices are among them. Fails at the end if any program failed.
set -eu

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# Two lines each: the folder of the package, in which its tests run, and the program.
cargo test "$@" --no-run --message-format=json-render-diagnostics >"$folder/built"
manifest='"manifest_path":"\([^"]*\)/Cargo.toml"'
executable='"test":true.*"executable":"\([^"]*\)"'
sed -n "s|.*$manifest.*$executable.*|\1\\
\2|p" "$folder/built" >"$folder/programs"

one='
    cd "$2"
    log="$1/$(basename "$3")"
    { echo "     Running $3"; "$3" || echo "$3" >>"$1/failed"; } >"$log" 2>&1
    cat "$log"'
tr '\n' '\0' <"$folder/programs" |
    xargs -0 -P 2 -n 2 sh -c "$one" run "$folder" | tee "$folder/all"
{ cargo test "$@" --doc --no-fail-fast 2>&1 || echo documentation >>"$folder/failed"; } |
    tee -a "$folder/all"

# Tests of a check end in `_holds` or `_hold`; the module around them is a device with its schedule.
awk '
    /^test result:/ { passed += $4 }
    /^ *Running / { program = $NF }
    /^test .*::[a-z_]+_holds? \.\.\. ok$/ {
        device = check = $2
        sub(/::[a-z_]+$/, "", device)
        sub(/.*::/, "", check)
        if (!seen[program, device]++) devices++
        if (!known[check]++) checks++
    }
    END { printf "%d tests, %d checks x %d devices\n", passed, checks, devices }' "$folder/all"

if [ -s "$folder/failed" ]; then
    echo "failed:"
    cat "$folder/failed"
    exit 1
fi
