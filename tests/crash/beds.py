"""Beds that runs share: settled once whoever works, killed, damaged or lost; the bytes of points
that are run alone.

Usage: beds.py RECKON STUDY. The points of the study differ in what does not prepare.
"""
import os
import pathlib
import random
import shutil
import signal
import tempfile
import time

from study_runs import (STUDY, contents, expect_same, finished_are_whole,
                        other_machine, run, start, status, wait_for)

POINTS = ("slow", "fast", "fine")


def beds_of(folder, ending=".bed"):
    return sorted(folder.glob(f"beds/*{ending}"))


def only(work, points):
    """The study with some of its points."""
    study = work / f"{'-'.join(points)}.yaml"
    lines = STUDY.read_text().splitlines(keepends=True)
    study.write_text("".join(line for line in lines if "{name: " not in line
                             or any(f"{{name: {point}," in line for point in points)))
    return study


def alone(work, reference):
    """Every point in a folder of its own: the same runs from the same beds."""
    for point in POINTS:
        folder = work / f"alone-{point}"
        run(folder, study=only(work, [point]))
        for part in ("runs", "beds"):
            files = contents(folder / part)
            assert len(files) == 2
            assert all((reference / part / name).read_bytes() == files[name] for name in files)
    print("points that share beds have the bytes that they have alone")


def described(reference):
    """The file of a run says which bed it began from."""
    try:
        import h5py
    except ImportError as missing:
        print(f"not looked at from outside: {missing} (Debian: python3-h5py)")
        return
    names = {path.stem for path in beds_of(reference)}
    told = {}
    for path in sorted(reference.glob("runs/*.h5")):
        with h5py.File(path) as file:
            provenance = file["provenance"].attrs
            told.setdefault(provenance["bed"].decode(), set()).add(int(provenance["replica"]))
            assert file["provenance/preparation"].attrs["steps"] > 0
    assert told.keys() == names and all(len(replicas) == 1 for replicas in told.values()), told
    print(f"{len(names)} beds are named by the runs that begin from them")


def killed_while_settling(work, reference):
    folder, draw = work / "killed", random.Random(2031)
    halfway = 0
    for kills in range(100):
        process = start(folder, "--threads", "1", "--checkpoint", "0.01")
        if kills % 2:  # for sure while a bed settles, as long as one does
            wait_for(lambda: beds_of(folder, ".ckpt") or process.poll() is not None)
            time.sleep(0.02)
        else:
            time.sleep(0.1 * draw.random() * 1.2**kills)
        process.kill()
        process.communicate()
        if process.returncode == 0:
            break
        halfway += len(beds_of(folder, ".ckpt")) > 0
        for path in beds_of(folder):
            assert path.read_bytes() == (reference / "beds" / path.name).read_bytes(), path
        finished_are_whole(folder, reference)
    else:
        raise AssertionError("not done after 100 kills")
    expect_same(folder, reference)
    assert halfway >= 2, (kills, halfway)
    print(f"killed {kills} times, {halfway} times with a bed half settled: the same bytes")


def stopped_while_settling(work, reference):
    folder = work / "stopped"
    process = start(folder, "--threads", "1", "--checkpoint", "0.01")
    wait_for(lambda: beds_of(folder, ".ckpt"))
    process.send_signal(signal.SIGINT)
    asked = time.monotonic()
    process.communicate()
    assert process.returncode == 130 and time.monotonic() - asked < 2, process.returncode
    assert beds_of(folder, ".ckpt") and not beds_of(folder, ".claim")
    state = status(folder)
    assert (state["beds"], state["beds_settled"]) == (2, len(beds_of(folder))), state
    run(folder)
    expect_same(folder, reference)
    print("stopped while a bed settled: it is kept and goes on, the same bytes")


def settled_once(work, reference):
    """Three programs of two threads: a bed that is there is not replaced by another."""
    folder = work / "many"
    crew = [start(folder, "--threads", "2", "--checkpoint", "0.01") for _ in range(3)]
    seen = {}
    while any(process.poll() is None for process in crew):
        for path in beds_of(folder):
            seen.setdefault(path.name, path.stat().st_ino)
    for process in crew:
        said = process.communicate()[1]
        assert process.returncode == 0, (process.returncode, said)
    assert seen == {path.name: path.stat().st_ino for path in beds_of(folder)}, seen
    expect_same(folder, reference)
    print("three programs of two threads settle every bed once: the same bytes")


def two_shards(work, reference):
    folder = work / "shards"
    crew = [start(folder, "--threads", "1", "--shard", f"{i}/3") for i in (1, 2, 3)]
    for process in crew:
        said = process.communicate()[1]
        assert process.returncode == 0, (process.returncode, said)
    expect_same(folder, reference)
    print("three shards share beds: the same bytes")


def another_machine(work, reference):
    """A bed that a live program elsewhere settles is waited for; a silent one loses it."""
    folder = work / "machines"
    run(folder, study=only(work, ["slow"]))
    shutil.rmtree(folder / "runs")
    first = beds_of(folder)[0]
    first.unlink()
    record = other_machine(folder, f"beds/{first.stem}", silence=10)
    waiting = start(folder, "--threads", "1", study=only(work, ["slow"]))
    wait_for(lambda: list(folder.glob("runs/*.claim")))
    time.sleep(0.5)
    assert waiting.poll() is None and not first.exists() and not beds_of(folder, ".ckpt")
    then = time.time() - 600
    os.utime(record, (then, then))
    said = waiting.communicate()[1]
    assert waiting.returncode == 0 and not record.exists(), said
    expect_same(folder, work / "alone-slow")
    print("a bed that a program elsewhere settles is waited for until that falls silent")


def other_work_first(work, reference):
    """While a program elsewhere settles a bed the runs of other beds are done: nobody waits."""
    folder = work / "meanwhile"
    shutil.copytree(reference, folder)
    shutil.rmtree(folder / "runs")
    first = beds_of(folder)[0]
    first.unlink()
    record = other_machine(folder, f"beds/{first.stem}", silence=10)
    replica = first.stem[-4:]
    process = start(folder, "--threads", "1")
    wait_for(lambda: len(list(folder.glob("runs/*.h5"))) == len(POINTS))
    assert not list(folder.glob(f"runs/*-{replica}.h5")) and not first.exists()
    time.sleep(0.3)
    assert process.poll() is None and len(list(folder.glob("runs/*.h5"))) == len(POINTS)
    then = time.time() - 600
    os.utime(record, (then, then))
    said = process.communicate()[1]
    assert process.returncode == 0, said
    expect_same(folder, reference)
    print("runs whose bed is settled elsewhere come after those that need not wait")


def damage(work, reference):
    """Beds cut, with a bit flipped, of another name, empty: set aside, said, settled again."""
    folder = work / "damaged"
    draw = random.Random(2032)
    shutil.copytree(reference, folder)
    whole = {path.name: path.read_bytes() for path in beds_of(folder)}
    tried = 0
    for kind in ("cut", "bit", "bit", "bit", "swap", "empty"):
        shutil.rmtree(folder / "runs")
        for name, data in whole.items():
            if kind == "cut":
                data = data[:draw.randrange(1, len(data))]
            elif kind == "bit":
                at = draw.randrange(len(data))
                data = data[:at] + bytes([data[at] ^ 1 << draw.randrange(8)]) + data[at + 1:]
            elif kind == "swap":
                data = next(other for key, other in whole.items() if key != name)
            else:
                data = b""
            (folder / "beds" / name).write_bytes(data)
        said = run(folder).stderr
        for name, data in whole.items():
            aside = folder / "beds" / f"{name}.damaged"
            assert aside.exists() and aside.name in said, said
            aside.unlink()
            tried += 1
        assert said.count("\n") == len(whole), said
        expect_same(folder, reference)
    print(f"{tried} damaged beds were set aside and settled again: the same bytes")


def half_settled(folder):
    """A study killed while a bed settled that has both generations of its checkpoint."""
    for attempt in range(50):
        shutil.rmtree(folder, ignore_errors=True)
        process = start(folder, "--threads", "1", "--checkpoint", "0.01")
        wait_for(lambda: beds_of(folder, ".ckpt.old") or process.poll() is not None)
        process.kill()
        process.communicate()
        if beds_of(folder, ".ckpt.old") and beds_of(folder, ".ckpt"):
            return
    raise AssertionError("no bed was caught half settled")


def damaged_checkpoints(work, reference):
    """Of a bed half settled, one generation or both."""
    folder = work / "halves"
    for generations in ([".ckpt"], [".ckpt", ".ckpt.old"]):
        half_settled(folder)
        for ending in generations:
            for path in beds_of(folder, ending):
                data = bytearray(path.read_bytes())
                data[len(data) // 2] ^= 16
                path.write_bytes(data)
        said = run(folder).stderr
        assert said.count("checkpoint cannot be used") == len(generations), said
        expect_same(folder, reference)
    print("damaged checkpoints of a bed are said and done without: the same bytes")


def killed_while_writing(work, reference):
    """What stands beside a bed, or a bed that is not needed any more, half written."""
    folder = work / "writing"
    shutil.copytree(reference, folder)
    whole = beds_of(folder)[0]
    for name in (whole.name, "00000000000000000000000000000000-0000.bed"):
        for ending in (".new", ".old"):
            (folder / "beds" / (name + ending)).write_bytes(whole.read_bytes()[:100])
    run(folder)
    expect_same(folder, reference)
    print("beds that were half written when their program was killed are tidied away")


def extended(work, reference):
    """A point that comes later begins from the beds that are there, or from new ones if they are
    gone."""
    folder = work / "extended"
    run(folder, study=only(work, POINTS[:2]))
    before = {path.name: path.stat().st_ino for path in beds_of(folder)}
    run(folder)
    assert before == {path.name: path.stat().st_ino for path in beds_of(folder)}
    expect_same(folder, reference)
    folder = work / "swept"
    run(folder, study=only(work, POINTS[:2]))
    shutil.rmtree(folder / "beds")
    run(folder)
    expect_same(folder, reference)
    print("a study that grows uses the beds that are there: the same bytes")


def beds_that_fail(work):
    """That a bed cannot be settled is found out once, and is the reason of all its runs."""
    study = work / "restless.yaml"
    study.write_text(STUDY.read_text().replace("base:\n", "base:\n  settle.time: 3\n"))
    folder = work / "restless"
    run(folder, "--threads", "1", study=study, code=3)
    state = status(folder)
    assert state["failed"] == 6 and len(beds_of(folder)) == 2, state
    reasons = {failure["reason"] for failure in state["failures"]}
    assert len(reasons) == 2 and all("did not come to rest" in reason for reason in reasons)
    for attempt in range(30):
        process = start(work / "again", "--threads", "2", "--checkpoint", "0", study=study)
        time.sleep(0.02 + 0.01 * attempt)
        process.kill()
        process.communicate()
        if process.returncode == 3:
            break
    run(work / "again", study=study, code=3)
    expect_same(work / "again", folder)
    print("beds that do not come to rest fail all their runs, settled once: the same bytes")


def main():
    with tempfile.TemporaryDirectory(prefix="rk-beds-") as name:
        work = pathlib.Path(name)
        reference = work / "reference"
        run(reference, "--threads", "1")
        assert len(beds_of(reference)) == 2 and len(list(reference.glob("runs/*.h5"))) == 6
        described(reference)
        alone(work, reference)
        killed_while_settling(work, reference)
        stopped_while_settling(work, reference)
        settled_once(work, reference)
        two_shards(work, reference)
        another_machine(work, reference)
        other_work_first(work, reference)
        damage(work, reference)
        damaged_checkpoints(work, reference)
        killed_while_writing(work, reference)
        extended(work, reference)
        beds_that_fail(work)


main()
