#!/bin/sh
# build.sh SOURCE BUILD OUTPUT - builds the timing program for ozz-animation, from the folder of its
# source and the one in which it was built. CXX and CXXFLAGS name another compiler and flags.
set -e
[ $# -eq 3 ] || { echo "usage: build.sh SOURCE BUILD OUTPUT" >&2; exit 2; }
find_library() {
    # Names end with the kind of build, such as _r, unless that is switched off.
    found=$(find "$1" -name "lib$2.a" -o -name "lib$2_[dr]*.a" | head -n 1)
    [ -n "$found" ] || { echo "no lib$2.a or lib$2_r.a in $1" >&2; exit 1; }
    echo "$found"
}
offline=$(find_library "$2" ozz_animation_offline)
animation=$(find_library "$2" ozz_animation)
base=$(find_library "$2" ozz_base)
${CXX:-c++} -std=c++20 -O3 -DNDEBUG ${CXXFLAGS:--march=native} -I"$1/include" \
    "$(dirname "$0")/ozz_frames.cc" "$offline" "$animation" "$base" -pthread -o "$3"
