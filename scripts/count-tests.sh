#!/bin/sh
# Passes the output of `cargo test` on, and says at its end how many tests passed, how many checks
# of the conformance suite are among them, and on how many devices they ran. Tests of a check end in
# `_holds`, `_hold` or `_can_fail`; the module around them is a device with its schedule.
set -eu

awk '
    { print; fflush() }
    /^test result:/ { passed += $4 }
    /^ *Running / { program = $NF }
    /^test .*::[a-z_]+_(holds?|can_fail)( - should panic)? \.\.\. ok$/ {
        device = check = $2
        sub(/::[a-z_]+$/, "", device)
        sub(/.*::/, "", check)
        if (!seen[program, device]++) devices++
        if (!known[check]++) checks++
    }
    END { printf "%d tests, %d checks x %d devices\n", passed, checks, devices }'
