"""Full, read-only and damaged: nothing finished is lost, what is wrong is said, and in the end the
bytes are those of an undisturbed run.

Usage: disk.py RECKON STUDY. The full disk is a small tmpfs where that can be mounted, and a limit
on the size of a file where not.
"""
import os
import pathlib
import random
import resource
import shutil
import signal
import subprocess
import tempfile
import time

from study_runs import STUDY, RECKON, command, contents, expect_same, finished_are_whole, run, start, status


class Mounted:
    """A tmpfs of some kilobytes; `self` is false where it cannot be mounted."""

    def __init__(self, folder, size):
        folder.mkdir()
        self.folder = folder
        done = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}k", "none", str(folder)],
                              capture_output=True)
        self.there = done.returncode == 0

    def remount(self, options):
        subprocess.run(["mount", "-o", f"remount,{options}", str(self.folder)], check=True)

    def end(self):
        if self.there:
            subprocess.run(["umount", "-l", str(self.folder)], check=True)


def full_disk(work, reference):
    """The disk is full after a while, then more room is made: once, twice, ..."""
    disk = Mounted(work / "disk", 64)
    if not disk.there:
        print("no tmpfs can be mounted here: the full disk is left to the limit of a file's size")
        return
    try:
        folder, stops = disk.folder / "out", 0
        for size in range(96, 4000, 160):
            done = subprocess.run(command(folder, "--checkpoint", "0.01"), capture_output=True,
                                  text=True)
            if done.returncode == 0:
                break
            assert done.returncode == 1 and "No space left" in done.stderr, done
            assert "Traceback" not in done.stderr and done.stderr.count("\n") < 12, done.stderr
            if (folder / "runs").exists():
                finished_are_whole(folder, reference)
            stops += 1
            disk.remount(f"size={size}k")
        disk.remount("size=8000k")  # it may have become full with the last byte that was needed
        run(folder)
        expect_same(folder, reference)
        assert stops >= 2, stops
        print(f"the disk was full {stops} times: said, nothing lost, the same bytes")
    finally:
        disk.end()


def file_limit(work, reference):
    """The same by a limit of the process, at every size from nothing up."""
    folder, stops = work / "limited", 0
    for size in [0, 1, 500, 3000, 9000, 20000, 40000, 80000, 160000, 10**7]:
        done = subprocess.run(
            command(folder, "--checkpoint", "0.01"), capture_output=True, text=True,
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size)),
        )
        assert done.returncode in (0, 1), (size, done)
        if done.returncode == 1:
            assert "File too large" in done.stderr, done.stderr
            stops += 1
        if (folder / "runs").exists():
            finished_are_whole(folder, reference)
    expect_same(folder, reference)
    assert stops >= 4, stops
    print(f"files could not grow {stops} times: said, nothing lost, the same bytes")


def read_only(work, reference):
    disk = Mounted(work / "ro", 4000)
    if not disk.there:
        print("no file system can be mounted read-only here")
        return
    try:
        folder = disk.folder / "out"
        shutil.copytree(reference, folder)
        (folder / "runs" / "pbc-0002.h5").unlink()
        disk.remount("ro")
        before = contents(folder)
        said = run(folder, code=1).stderr
        assert "Read-only file system" in said and said.count("\n") == 1, said
        assert contents(folder) == before
        assert status(folder)["done"] == 5
        disk.remount("rw")
        run(folder)
        expect_same(folder, reference)
        print("a read-only folder is said to be one, and can be looked at")
    finally:
        disk.end()


def damage_everywhere(work, reference):
    """Every kind of file, cut or with a bit flipped, while the study is half done."""
    draw = random.Random(2025)
    tried = 0
    for round_ in range(6):
        folder = work / f"damage-{round_}"
        process = start(folder, "--threads", "2", "--checkpoint", "0.01")
        while process.poll() is None and len(list(folder.glob("runs/*.h5"))) < 1 + round_ % 3:
            time.sleep(0.002)
        process.kill()
        process.communicate()
        files = [path for path in folder.rglob("*") if path.is_file() and path.suffix != ".tmp"]
        for path in draw.sample(files, min(3, len(files))):
            data = bytearray(path.read_bytes())
            if not data or path.name == "study.yaml":
                continue
            if draw.random() < 0.5:
                del data[draw.randrange(len(data)):]
            else:
                data[draw.randrange(len(data))] ^= 1 << draw.randrange(8)
            path.write_bytes(data)
            tried += 1
        run(folder)
        shutil.rmtree(folder / "runs")  # damaged beds are found out when they are needed
        run(folder)
        for aside in [*folder.glob("runs/*.damaged"), *folder.glob("beds/*.damaged")]:
            aside.unlink()
        expect_same(folder, reference)
    for name in ("plan.h5", "study.h5"):
        for cut in (0, 10, 1024, 5000):
            folder = work / f"{name}-{cut}"
            shutil.copytree(reference, folder)
            os.truncate(folder / name, cut)
            run(folder)
            expect_same(folder, reference)
            tried += 1
    folder = work / "plan.h5-alone"
    shutil.copytree(reference, folder)
    for path in folder.glob("runs/*"):
        path.unlink()
    os.truncate(folder / "plan.h5", 10)
    assert "was missing or damaged and is written again" in run(folder).stderr
    expect_same(folder, reference)
    assert tried >= 20, tried
    print(f"{tried} files of all kinds were cut or had a bit flipped: the same bytes")


def interrupted_twice(work, reference):
    """The second Ctrl-C ends the program at once; nothing that was finished suffers."""
    folder = work / "twice"
    for attempt in range(8):
        process = start(folder, "--threads", "2")
        time.sleep(0.1 + 0.1 * attempt)
        process.send_signal(signal.SIGINT)
        time.sleep(0.001 * attempt)
        process.send_signal(signal.SIGINT)
        process.communicate()
        assert process.returncode in (0, 130, -signal.SIGINT), process.returncode
        if (folder / "runs").exists():
            finished_are_whole(folder, reference)
    run(folder)
    expect_same(folder, reference)
    print("interrupted twice, eight times over: the same bytes")


def main():
    with tempfile.TemporaryDirectory(prefix="rk-disk-") as name:
        work = pathlib.Path(name)
        reference = work / "reference"
        run(reference, "--threads", "1")
        full_disk(work, reference)
        file_limit(work, reference)
        read_only(work, reference)
        damage_everywhere(work, reference)
        interrupted_twice(work, reference)


main()
