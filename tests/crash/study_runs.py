"""What the tests of this folder share: running a study, looking at it, comparing folders."""
import json
import os
import pathlib
import subprocess
import sys
import time

RECKON, STUDY = str(pathlib.Path(sys.argv[1]).resolve()), pathlib.Path(sys.argv[2]).resolve()


def command(folder, *more, study=STUDY):
    return [RECKON, "run", str(study), "-o", str(folder), *more]


def run(folder, *more, study=STUDY, code=0):
    done = subprocess.run(command(folder, *more, study=study), capture_output=True, text=True)
    assert done.returncode == code, (folder, done.returncode, done.stdout, done.stderr)
    return done


def start(folder, *more, study=STUDY):
    return subprocess.Popen(
        command(folder, "--quiet", *more, study=study), stderr=subprocess.PIPE, text=True
    )


def status(folder):
    done = subprocess.run([RECKON, "status", str(folder), "--json"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def wait_for(condition, seconds=60):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "it did not happen"
        time.sleep(0.005)


def other_machine(folder, thing, silence):
    """A claim on a run or bed, and a record, as a program on another machine would make them."""
    name = "elsewhere-0123456789ab-77-1234-00000000"
    (folder / "at_work").mkdir(exist_ok=True)
    record = folder / "at_work" / name
    record.write_text("process 77 on elsewhere\nrate 0\n")
    then = time.time() - silence
    os.utime(record, (then, then))
    (folder / f"{thing}.claim").symlink_to(name)
    return record


def contents(folder):
    """All that is to be the same: not what it cost."""
    return {
        str(path.relative_to(folder)): path.read_bytes() if path.is_file() else str(path.readlink())
        for path in sorted(folder.rglob("*"))
        if (path.is_file() or path.is_symlink()) and path.name != "effort.csv"
    }


def expect_same(first, second):
    a, b = contents(first), contents(second)
    assert a.keys() == b.keys(), (sorted(a), sorted(b))
    assert all(a[name] == b[name] for name in a), [name for name in a if a[name] != b[name]]


def finished_are_whole(folder, reference):
    """Whatever has its final name has its final bytes."""
    for path in (folder / "runs").glob("*.h5"):
        assert path.read_bytes() == (reference / "runs" / path.name).read_bytes(), path
