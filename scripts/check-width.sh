#!/bin/sh
# Lists tracked lines of Rust, kernels, shaders, scripts and build files that are longer than 100
# columns, and fails if there are any. Lines with a URL may be longer, since nothing can break them.
set -eu
cd "$(dirname "$0")/.."

files=$(mktemp)
trap 'rm -f "$files"' EXIT
set -- '*.rs' '*.cl' '*.glsl' '*.vert' '*.frag' '*.sh' '*.yml' Makefile .ci/run
git ls-files -z -- "$@" >"$files"
[ -s "$files" ] || { echo "check-width: git lists no files here" >&2; exit 2; }

# Counts characters, not bytes.
LC_ALL=C.UTF-8
export LC_ALL
if xargs -0 grep -nHE '^.{101,}' <"$files" | grep -v '://'; then
    echo "check-width: the lines above are longer than 100 columns" >&2
    exit 1
fi
