#!/usr/bin/env python3
"""Grain-steps per CPU-second of reckon's engine and of LAMMPS (gran/hooke/history) on one scene.

    python3 tests/bench/against_lammps.py BENCH_ENGINE [--sides periodic|walls] [--repeats N]
                                          [--warm STEPS] [--steps STEPS] [--skin S]

Both programs settle 2500 discs and an intruder and are warmed up by --warm steps of shaking; then
they take turns, --steps steps each, so that a machine whose speed drifts treats them alike. LAMMPS
is charged its user CPU time less that of a run of no steps; the engine measures its own.
"""
import argparse
import math
import os
import random
import re
import resource
import statistics
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
GRAINS = 2500


def write_scene(path, width, periodic):
    """A loose jittered lattice around an intruder at the bottom centre, as LAMMPS data."""
    rng = random.Random(1)
    largest, spacing = 0.5 * 1.025, 1.145
    jitter = 0.5 * (spacing - 2 * largest)
    room = width if periodic else width - 2 * largest - 2 * jitter
    columns = int(room / spacing)
    rows = [(2, 2.5, 0.0, 2.5)]
    site = 0
    while len(rows) <= GRAINS:
        x = (site % columns + 0.5) * room / columns - 0.5 * room
        y = largest + jitter + (site // columns) * spacing
        site += 1
        if math.hypot(x, y - 2.5) < 2.5 + largest + 2 * jitter:
            continue
        radius = 0.5 * (1 + 0.025 * rng.uniform(-1, 1))
        rows.append((1, radius, x + jitter * rng.uniform(-1, 1), y + jitter * rng.uniform(-1, 1)))
    top = max(r[3] for r in rows) + 20
    edge = 0.5 * width + (0 if periodic else 1)
    with open(path, "w", encoding="ascii") as f:
        f.write(f"Brazil-nut box\n\n{len(rows)} atoms\n2 atom types\n\n")
        f.write(f"{-edge} {edge} xlo xhi\n-3 {top} ylo yhi\n-0.5 0.5 zlo zhi\n\nAtoms # sphere\n\n")
        for tag, (kind, radius, x, y) in enumerate(rows, 1):
            density = 3 / (4 * math.pi * radius)  # so that a sphere's mass is radius^2
            f.write(f"{tag} {kind} {2 * radius:.12g} {density:.12g} {x:.12g} {y:.12g} 0\n")


def lammps(folder, **variables):
    """Run the deck; return (user CPU seconds, log)."""
    words = ["lmp", "-in", os.path.join(HERE, "lammps", "in.bne"), "-log", "none"]
    for name, value in variables.items():
        words += ["-var", name, str(value)]
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    done = subprocess.run(words, cwd=folder, env=dict(os.environ, OMP_NUM_THREADS="1"),
                          capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"lmp failed:\n{done.stdout[-2000:]}{done.stderr[-500:]}")
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before, done.stdout


def engine(program, sides, warm, steps, skin):
    words = [program, "--warm", str(warm), "--steps", str(steps), "--repeat", "1",
             "--skin", str(skin)]
    words += ["--walls"] if sides == "walls" else []
    out = subprocess.run(words, capture_output=True, text=True, check=True).stdout
    rate = float(re.search(r"median ([0-9.]+) M", out).group(1))
    touching = float(re.search(r"touching: ([0-9.]+)", out).group(1))
    return rate, touching


def main():
    p = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    p.add_argument("bench_engine")
    p.add_argument("--sides", choices=("periodic", "walls"), default="periodic")
    p.add_argument("--repeats", type=int, default=5)
    p.add_argument("--warm", type=int, default=100000)
    p.add_argument("--steps", type=int, default=50000)
    p.add_argument("--skin", type=float, default=0.1)
    a = p.parse_args()
    width = 28 if a.sides == "periodic" else 37.5
    with tempfile.TemporaryDirectory() as folder:
        write_scene(os.path.join(folder, "scene.data"), width, a.sides == "periodic")
        common = dict(sides=a.sides, width=width, skin=a.skin, after="none")
        lammps(folder, **common, stage="settle", steps=60000, data="scene.data", restart="rest")
        lammps(folder, **{**common, "after": "warm"}, stage="shake", steps=a.warm, restart="rest")
        base = statistics.median(
            lammps(folder, **common, stage="shake", steps=0, restart="warm")[0] for _ in range(3))
        ours, theirs = [], []
        for turn in range(a.repeats):
            seconds, log = lammps(folder, **common, stage="shake", steps=a.steps, restart="warm")
            theirs.append((GRAINS + 1) * a.steps / (seconds - base) / 1e6)
            rate, touching = engine(os.path.abspath(a.bench_engine), a.sides, a.warm, a.steps,
                                    a.skin)
            ours.append(rate)
            print(f"turn {turn + 1}: engine {rate:.2f} M, LAMMPS {theirs[-1]:.2f} M, "
                  f"ratio {rate / theirs[-1]:.2f}", flush=True)
        coordination = [float(line.split()[3]) for line in log.splitlines()
                        if re.match(r"\s*\d+\s+[0-9.]+\s+[0-9.e+-]+\s+[0-9.]+\s*$", line)]
        ratios = [x / y for x, y in zip(ours, theirs)]
        print(f"{a.sides}, {GRAINS} grains, grain-steps per CPU-second, medians of {a.repeats}:")
        print(f"  engine {statistics.median(ours):.2f} M   LAMMPS {statistics.median(theirs):.2f} M"
              f"   ratio {statistics.median(ratios):.2f} (least {min(ratios):.2f},"
              f" most {max(ratios):.2f})")
        print(f"  contacts a grain: engine {2 * touching:.2f} on average, "
              f"LAMMPS {', '.join(f'{c:.2f}' for c in coordination)} at the moments it printed")


if __name__ == "__main__":
    main()
