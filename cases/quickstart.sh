#!/bin/sh
# From nothing to large-deviation functions: sh cases/quickstart.sh
# Installs what is missing for it (not h5py, for reading runs in Python: sh packages.sh tests), builds
# reckon, shakes the Brazil-nut box with walls and with periodic sides, and analyses it. A second
# call finds everything done.
set -eu
cd "$(dirname "$0")/.."
sh packages.sh build
[ -f build/build.ninja ] || cmake -S . -B build -G Ninja >/dev/null
cmake --build build --target reckon
build/ensemble/reckon run cases/bne/quickstart.yaml -o out/quickstart
build/ensemble/reckon analyze out/quickstart
