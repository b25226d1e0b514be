#!/bin/sh
# Install what is missing, build, and run every test but the slow ones: sh tests/run.sh
# Arguments are handed to ctest: sh tests/run.sh -R scene
set -eu
cd "$(dirname "$0")/.."
sh packages.sh build tests
[ -f build/build.ninja ] && grep -q '^RK_TESTS:BOOL=ON' build/CMakeCache.txt ||
    cmake -S . -B build -G Ninja -DRK_TESTS=ON -DRK_WERROR=ON >/dev/null
cmake --build build
ctest --test-dir build --output-on-failure -LE slow -j "$(nproc)" "$@"
