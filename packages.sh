#!/bin/sh
# Install the Debian packages that are missing: packages.sh [build] [tests] [peers] [mpi] [slurm]
# With nothing missing it does nothing, needs no network and no rights.
set -eu

build="gcc libc6-dev make cmake ninja-build pkg-config libgsl-dev libfftw3-dev libhdf5-dev \
libyaml-dev libxxhash-dev librandom123-dev gnuplot-nox"
tests="libcmocka-dev python3 python3-h5py python3-numpy"
peers="lammps python3 python3-numpy python3-scipy"
mpi="libopenmpi-dev openmpi-bin"
slurm="slurm-wlm munge"

wanted=""
for set in "$@"; do
    case "$set" in
    build) wanted="$wanted $build" ;;
    tests) wanted="$wanted $tests" ;;
    peers) wanted="$wanted $peers" ;;
    mpi) wanted="$wanted $mpi" ;;
    slurm) wanted="$wanted $slurm" ;;
    *)
        echo "packages.sh: '$set' is none of build, tests, peers, mpi, slurm" >&2
        exit 2
        ;;
    esac
done

missing=""
for package in $wanted; do
    dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q 'install ok installed' ||
        missing="$missing $package"
done
[ -n "$missing" ] || exit 0

as_root=""
[ "$(id -u)" -eq 0 ] || as_root="sudo"
echo "installing:$missing"
$as_root apt-get update -qq
# shellcheck disable=SC2086
DEBIAN_FRONTEND=noninteractive $as_root apt-get install -y -qq --no-install-recommends $missing \
    >/dev/null
