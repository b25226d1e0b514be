#!/bin/sh
# check.sh BUILD CC CMAKE FLAGS: install into a temporary prefix, move it, and build a program with
# it twice, by pkg-config and by find_package; every public header must compile on its own.
set -eu
build=$1 cc=$2 cmake=$3 flags=$4
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
unset DESTDIR
"$cmake" --install "$build" --prefix "$work/first" >"$work/log"
mv "$work/first" "$work/moved"
PKG_CONFIG_PATH=$(dirname "$(find "$work/moved" -name sand-reckoner.pc)")
export PKG_CONFIG_PATH

cd "$work"
cflags="-std=c17 -Wall -Wextra -Werror $flags $(pkg-config --cflags sand-reckoner)"
cd moved/include/sand-reckoner
for header in */*.h; do
    # shellcheck disable=SC2086
    echo "#include \"$header\"" | "$cc" $cflags -fsyntax-only -x c - || exit 1
done
cd "$work"

# shellcheck disable=SC2086,SC2046
"$cc" $cflags "$here/two_grains.c" $(pkg-config --libs sand-reckoner) -o by-pkg-config
./by-pkg-config | tee first
grep -q '^kinetic energy 0.0625 before, 0\.0[0-5][0-9]* after$' first
moved/bin/reckon --version

mkdir user
cp "$here/two_grains.c" user
cat >user/CMakeLists.txt <<'EOF'
cmake_minimum_required(VERSION 3.25)
project(user C)
find_package(SandReckoner 0.1 REQUIRED)
add_executable(two_grains two_grains.c)
target_link_libraries(two_grains PRIVATE SandReckoner::rk_engine)
add_executable(whole two_grains.c)
target_link_libraries(whole PRIVATE SandReckoner::rk_ensemble)
EOF
"$cmake" -S user -B user/build -DCMAKE_C_COMPILER="$cc" -DCMAKE_C_FLAGS="$flags" \
    -DCMAKE_PREFIX_PATH="$work/moved" >>"$work/log" || { cat "$work/log"; exit 1; }
"$cmake" --build user/build >>"$work/log" || { cat "$work/log"; exit 1; }
user/build/two_grains | cmp - first
user/build/whole | cmp - first
