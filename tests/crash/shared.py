"""Several programs at work in one folder: shared, killed, lost; the bytes of one undisturbed.

Usage: shared.py RECKON STUDY [KILLS]. The moments of the kills come from a fixed seed.
"""
import os
import pathlib
import random
import shutil
import signal
import sys
import tempfile
import time

from study_runs import STUDY, expect_same, finished_are_whole, other_machine, run, start, status, wait_for

KILLS = int(sys.argv[3]) if len(sys.argv) > 3 else 12


def two_share(work, reference):
    folder = work / "two"
    first = start(folder, "--threads", "1")
    wait_for((folder / "study.yaml").exists)
    second = start(folder, "--threads", "1")
    wait_for(lambda: len(status(folder)["workers"]) == 2)
    words = [w["who"] for w in status(folder)["workers"]]
    assert {f"process {p.pid} " in " ".join(words) + " " for p in (first, second)} == {True}, words
    said = second.communicate()[1]
    first.communicate()
    assert first.returncode == 0 and second.returncode == 0, said
    assert f"process {first.pid} " in said and "shared" in said, said
    expect_same(folder, reference)
    print("two programs share a folder, and the second says with whom: the same bytes")


def killed_while_sharing(work, reference):
    """Three programs, one of which is killed at a random moment and replaced, over and over."""
    folder, draw = work / "three", random.Random(2022)
    crew, kills, rounds = [], 0, 0
    while kills < KILLS:
        rounds += 1
        shutil.rmtree(folder, ignore_errors=True)
        crew = [start(folder, "--threads", "1", "--checkpoint", "0.01") for _ in range(3)]
        while kills < KILLS and any(p.poll() is None for p in crew):
            time.sleep(0.3 * draw.random())
            victim = draw.randrange(3)
            if crew[victim].poll() is not None:
                break
            crew[victim].kill()
            crew[victim].wait()
            kills += 1
            finished_are_whole(folder, reference)
            crew[victim] = start(folder, "--threads", "1", "--checkpoint", "0.01")
        for process in crew:
            said = process.communicate()[1]
            assert process.returncode == 0, (process.returncode, said)
        expect_same(folder, reference)
    print(f"of three programs in a folder one was killed {kills} times, in {rounds} rounds: "
          "the same bytes")


def everybody_dies(work, reference):
    """No live program is left to notice: the next one does."""
    folder, draw = work / "all", random.Random(2023)
    for deaths in range(100):
        crew = [start(folder, "--threads", "1", "--checkpoint", "0.01") for _ in range(2)]
        time.sleep(0.15 * draw.random() * 1.05**deaths)
        for process in crew:
            process.kill()
        if all(process.wait() == 0 for process in crew):
            break
    else:
        raise AssertionError("not done after 100 deaths of all")
    run(folder)
    expect_same(folder, reference)
    print(f"both programs in a folder were killed {deaths} times: the same bytes")


def another_machine(work, reference):
    """A live program elsewhere keeps its run; one that fell silent loses it."""
    folder = work / "machines"
    shutil.copytree(reference, folder)
    (folder / "runs" / "walls-0001.h5").unlink()
    record = other_machine(folder, "runs/walls-0001", silence=10)
    waiting = start(folder)
    line = waiting.stderr.readline()
    assert "process 77 on elsewhere" in line, line
    line = waiting.stderr.readline()
    assert "all that is left" in line and "elsewhere" in line, line
    time.sleep(0.5)
    assert waiting.poll() is None and not (folder / "runs" / "walls-0001.h5").exists()
    waiting.send_signal(signal.SIGINT)
    waiting.communicate()
    assert waiting.returncode == 130, waiting.returncode
    waiting = start(folder)
    waiting.stderr.readline()
    then = time.time() - 600
    os.utime(record, (then, then))
    said = waiting.communicate()[1]
    assert waiting.returncode == 0, said
    assert not record.exists()
    expect_same(folder, reference)
    print("a live program on another machine keeps its run, a silent one loses it: the same bytes")


def taken_for_dead(work, reference):
    """A program whose record is taken away has been given up by others: it stops, and says so."""
    folder = work / "lost"
    process = start(folder, "--threads", "1")
    wait_for(lambda: (folder / "at_work").exists() and list((folder / "at_work").glob("[!.]*")))
    for record in (folder / "at_work").glob("[!.]*"):  # not what it is writing at present
        record.unlink()
    said = process.communicate()[1]
    assert process.returncode == 0 or "no sign of life" in said or "taken over" in said, said
    run(folder)
    expect_same(folder, reference)
    print("a program that others took for dead stops: the same bytes")


def main():
    with tempfile.TemporaryDirectory(prefix="rk-shared-") as name:
        work = pathlib.Path(name)
        reference = work / "reference"
        run(reference, "--threads", "1")
        two_share(work, reference)
        killed_while_sharing(work, reference)
        everybody_dies(work, reference)
        another_machine(work, reference)
        taken_for_dead(work, reference)


main()
