"""What two threads of a program do, beside one thread and beside two programs of one thread each.

Usage: two_threads.py RECKON [--study FILE] [--turns N]

The study is run in turns: by one thread, by two threads, and by two programs that have nothing in
common, each with a half of the runs in a folder of its own. Two programs are what the machine itself
gives: what they lose against one is no business of the runner's. The clock depends on who else is at
work on the machine, and on how evenly the runs end; CPU time (user and system, of all threads) much
less. Medians over turns, with the quartiles.
"""
import argparse
import pathlib
import resource
import statistics
import subprocess
import tempfile
import time


def cpu_of_children():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def carry_out(commands):
    """Clock and CPU time of programs that run at once."""
    clock, cpu = time.monotonic(), cpu_of_children()
    programs = [subprocess.Popen(command, stdout=subprocess.DEVNULL) for command in commands]
    assert all([program.wait() == 0 for program in programs]), commands
    return time.monotonic() - clock, cpu_of_children() - cpu


def ways(reckon, study, folder):
    def run(name, *more):
        return [str(reckon), "run", str(study), "-o", f"{folder}/{name}", "--quiet", *more]

    return [
        ("one thread", [run("one", "-j", "1")]),
        ("two threads", [run("two", "-j", "2")]),
        ("two programs", [run(f"half{i}", "-j", "1", "--shard", f"{i}/2") for i in (1, 2)]),
    ]


def quartiles(values):
    low, middle, high = statistics.quantiles(values, n=4) if len(values) > 1 else values * 3
    return f"{middle:.3f} ({low:.3f} to {high:.3f})"


def compare(turns, way, other):
    print(f"{way} against {other}: "
          f"{quartiles([t[other][0] / t[way][0] for t in turns])} times as fast by the clock, "
          f"{quartiles([t[way][1] / t[other][1] for t in turns])} of the CPU time")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("reckon", type=pathlib.Path)
    parser.add_argument("--study", type=pathlib.Path,
                        default=pathlib.Path(__file__).with_name("equal.yaml"))
    parser.add_argument("--turns", type=int, default=5)
    options = parser.parse_args()
    turns = []
    for k in range(options.turns):
        turns.append({})
        with tempfile.TemporaryDirectory(prefix="rk-threads-") as folder:
            these = ways(options.reckon.resolve(), options.study.resolve(), folder)
            for way, commands in these[k % 3:] + these[:k % 3]:
                turns[-1][way] = carry_out(commands)
                print("turn {}, {:12}  clock {:6.2f} s  CPU {:6.2f} s".format(
                    k + 1, way, *turns[-1][way]), flush=True)
    compare(turns, "two threads", "one thread")
    compare(turns, "two programs", "one thread")
    compare(turns, "two threads", "two programs")


main()
