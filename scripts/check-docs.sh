#!/bin/sh
# Checks what the documentation names: paths in backticks, links between pages, and the tests of
# docs/paper.md and docs/contributing/. Lists what does not exist, and fails if there is any. Also
# looks for files with unsafe code that decision 29 does not list.
set -eu
cd "$(dirname "$0")/.."

failed=0
missing() { # PAGE NAME
    echo "$1 names $2, which does not exist" >&2
    failed=1
}

pages=$(git ls-files -- '*.md')
[ -n "$pages" ] || { echo "check-docs: git lists no pages here" >&2; exit 2; }

for page in $pages; do
    # Paths from the root. Those of a new file that a walk-through adds have the name "twist".
    for path in $(grep -oE '`(crates|docs|scripts|fuzz|\.github)/[^` ]*`' "$page" | tr -d '`'); do
        case "$path" in *twist*) continue ;; esac
        [ -e "$path" ] || missing "$page" "$path"
    done
    # Paths from the root of a crate, in its own page.
    for path in $(grep -oE '`(src|tests|examples|benches)/[^` ]*`' "$page" | tr -d '`'); do
        case "$page" in crates/*/README.md) ;; *) continue ;; esac
        [ -e "$(dirname "$page")/$path" ] || missing "$page" "$path"
    done
    # Links, relative to the page.
    for link in $(grep -oE '\]\([^)#: ]+' "$page" | cut -c3-); do
        case "$link" in http | https | mailto) continue ;; esac
        [ -e "$(dirname "$page")/$link" ] || missing "$page" "$link"
    done
done

# Names of tests: long words in snake case.
for page in docs/paper.md docs/contributing/*.md; do
    for name in $(grep -oE '`[a-z0-9]+(_[a-z0-9]+){2,}`' "$page" | tr -d '`' | sort -u); do
        grep -rqwF --include='*.rs' --include='*.cl' "$name" crates || missing "$page" "$name"
    done
done

unsafe=docs/decisions/029-unsafe-code-has-named-places.md
for file in $(git grep -l unsafe_code -- 'crates/*/src/*.rs'); do
    grep -qF -e "\`$file\`" -e "\`$(dirname "$file")/\`" "$unsafe" || {
        echo "$unsafe does not list $file, which allows unsafe code" >&2
        failed=1
    }
done
exit $failed
