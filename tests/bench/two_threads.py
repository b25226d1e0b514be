"""What two threads of a program do, beside one thread and beside two programs of one thread each.

Usage: two_threads.py RECKON [--study FILE] [--turns N]

The study is run in turns: by one thread, by two threads, and by two programs that have nothing in
common, each with a half of the runs in a folder of its own. Two programs are what the machine itself
gives: what they lose against one is no business of the runner's. Of every turn:

    clock       seconds from start to end; depends on who else is at work on the machine
    CPU         user and system time of all threads
    busy        share of the time that the threads used of the time for which they were not waiting
                for a core, until each has nothing left to do: what disks and locks cost

Twice the ratio of the CPU times times that of the shares is by how much two are faster than one as
long as both have something to do ("on two cores"); it depends on other work far less than the clock
does. Medians over turns, with the quartiles.
"""
import argparse
import pathlib
import resource
import statistics
import subprocess
import tempfile
import time

SAMPLE = 0.02  # seconds between two looks at a program's threads


class Program:
    """A program at work, and the time that its threads have used and waited for a core."""

    def __init__(self, command):
        self.process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
        self.begin = time.monotonic()
        self.end, self.threads = None, {}

    def look(self):
        now = time.monotonic()
        for task in pathlib.Path(f"/proc/{self.process.pid}/task").glob("*"):
            try:
                used, waited, _ = map(int, (task / "schedstat").read_text().split())
            except (OSError, ValueError):
                continue  # it has ended just now
            before = self.threads.get(task.name, (0, 0, 0))
            if used / 1e9 > before[0] + SAMPLE / 100:
                self.threads[task.name] = (used / 1e9, waited / 1e9, now - self.begin)
        if self.process.poll() is not None:
            self.end = now
        return self.end is None

    def workers(self, count):
        """Those of most work, the others give signs of life: time used, waited for a core, and in
        all until there was nothing left to do."""
        return sorted(self.threads.values())[-count:]


def carry_out(commands, threads):
    """Clock, CPU and busy share of programs that run at once, of so many threads each."""
    before = time.monotonic(), sum(children())
    programs = [Program(command) for command in commands]
    while any([program.look() for program in programs if program.end is None]):
        time.sleep(SAMPLE)
    assert all(program.process.returncode == 0 for program in programs), commands
    elapsed = max(program.end for program in programs) - before[0]
    workers = [worker for program in programs for worker in program.workers(threads)]
    had = sum(until - waited for _, waited, until in workers)
    return elapsed, sum(children()) - before[1], sum(used for used, _, _ in workers) / had


def children():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime, usage.ru_stime


def ways(reckon, study, folder):
    def run(name, *more):
        return [str(reckon), "run", str(study), "-o", f"{folder}/{name}", "--quiet", *more]

    return [
        ("one thread", [run("one", "-j", "1")], 1),
        ("two threads", [run("two", "-j", "2")], 2),
        ("two programs", [run(f"half{i}", "-j", "1", "--shard", f"{i}/2") for i in (1, 2)], 1),
    ]


def quartiles(values):
    low, middle, high = statistics.quantiles(values, n=4) if len(values) > 1 else values * 3
    return f"{middle:.3f} ({low:.3f} to {high:.3f})"


def compare(turns, way):
    clock, cpu, cores = [], [], []
    for turn in turns:
        one, two = turn["one thread"], turn[way]
        clock.append(one[0] / two[0])
        cpu.append(two[1] / one[1])
        cores.append(2 * one[1] / two[1] * two[2] / one[2])
    print(f"{way} against one: {quartiles(clock)} times as fast by the clock, "
          f"{quartiles(cpu)} of the CPU time, on two cores {quartiles(cores)} times as fast")


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
            for way, commands, threads in these[k % 3:] + these[:k % 3]:
                turns[-1][way] = carry_out(commands, threads)
                print("turn {}, {:12}  clock {:6.2f} s  CPU {:6.2f} s  busy {:5.1%}".format(
                    k + 1, way, *turns[-1][way]), flush=True)
    compare(turns, "two threads")
    compare(turns, "two programs")


main()
