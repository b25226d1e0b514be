"""Runs that are killed, stopped, damaged and resumed end with the bytes of an undisturbed run.

Usage: crash.py RECKON STUDY. The moments of the kills come from a fixed seed; where they fall in a
run depends on the machine, which is the point.
"""
import os
import pathlib
import random
import shutil
import signal
import subprocess
import tempfile
import time

from study_runs import STUDY, command, contents, expect_same, finished_are_whole, run, status

MOST_KILLS = 200


def killed_at_any_moment(work, reference):
    folder, draw = work / "killed", random.Random(2021)
    kills = resumed = 0
    for threads in draw.choices("12", k=MOST_KILLS):
        process = subprocess.Popen(
            command(folder, "--threads", threads, "--checkpoint", "0.01", "--quiet")
        )
        # Now and then early, to hit the making of the folder and the review of what is there; and
        # later and later, so that a slow machine gets there, too.
        time.sleep(draw.choice([0.02, 0.1, 0.2]) * draw.random() * 1.03**kills)
        process.kill()
        if process.wait() == 0:
            break
        kills += 1
        if (folder / "runs").exists():
            finished_are_whole(folder, reference)
        if (folder / "study.yaml").exists():
            resumed += status(folder)["started"] > 0
    else:
        raise AssertionError(f"not done after {kills} kills")
    expect_same(folder, reference)
    assert kills >= 5 and resumed >= 3, (kills, resumed)
    print(f"killed {kills} times, resumed from a checkpoint {resumed} times: the same bytes")


def stopped_on_request(work, reference):
    folder = work / "stopped"
    for stops in range(100):
        process = subprocess.Popen(
            command(folder, "--threads", "2", "--quiet"), stderr=subprocess.PIPE, text=True
        )
        time.sleep(0.05 + 0.03 * stops)
        process.send_signal((signal.SIGINT, signal.SIGTERM, signal.SIGHUP)[stops % 3])
        said = process.communicate()[1]
        if process.returncode == 0:
            break
        if process.returncode < 0:
            continue  # so early that nothing was to be kept yet
        assert process.returncode == 130 and "stopping" in said, (process.returncode, said)
    run(folder)
    expect_same(folder, reference)
    assert stops >= 2, stops
    print(f"stopped {stops} times with exit 130: the same bytes")


def damage_is_repaired(work, reference):
    folder = work / "damaged"
    shutil.copytree(reference, folder)
    cut, flipped = folder / "runs" / "pbc-0001.h5", folder / "runs" / "walls-0002.h5"
    os.truncate(cut, cut.stat().st_size // 2)
    data = bytearray(flipped.read_bytes())
    data[len(data) // 3] ^= 4
    flipped.write_bytes(data)
    said = run(folder).stderr
    for path in (cut, flipped):
        aside = path.with_name(path.name + ".damaged")
        assert aside.exists() and aside.name in said, said
        aside.unlink()
    expect_same(folder, reference)
    print("damaged files are set aside and done again: the same bytes")


def failures_are_results(work):
    """A limit that a shaken bed does not keep: some runs fail, with exit 3, and stay failed."""
    study = work / "failing.yaml"
    study.write_text(STUDY.read_text().replace("base:\n", "base:\n  health.overlap: 0.02\n"))
    said = run(work / "failed", study=study, code=3).stderr
    state = status(work / "failed")
    assert state["failed"] > 0 and state["done"] + state["failed"] == 6, state
    assert len(state["failures"]) == state["failed"]
    assert all(f["run"] and "overlap" in f["reason"] for f in state["failures"]), state
    assert state["failures"][0]["reason"] in said, said
    before = contents(work / "failed")
    run(work / "failed", study=study, code=3)
    assert contents(work / "failed") == before
    for _ in range(60):
        process = subprocess.Popen(
            command(work / "failed-again", "--checkpoint", "0", "--quiet", study=study),
            stderr=subprocess.DEVNULL,
        )
        time.sleep(0.1)
        process.kill()
        if process.wait() == 3:
            break
    run(work / "failed-again", study=study, code=3)
    expect_same(work / "failed", work / "failed-again")
    print(f"{state['failed']} of 6 runs fail with exit 3, the same bytes after kills")


def retries_are_results(work):
    """A limit that some runs keep at half the time step only, asked for at once or afterwards."""
    study, plain = work / "retrying.yaml", work / "plain.yaml"
    plain.write_text(STUDY.read_text().replace("base:\n", "base:\n  health.travel: 0.0036\n"))
    study.write_text(plain.read_text() + "retry: {step: 0.5, times: 2}\n")
    straight = work / "retried"
    run(straight, "--threads", "1", study=study)
    state = status(straight)
    assert state["failed"] == 0 and 0 < state["retried"] < 6, state
    run(work / "afterwards", study=plain, code=3)
    run(work / "afterwards", study=study)
    expect_same(work / "afterwards", straight)
    folder, draw = work / "retry-killed", random.Random(2025)
    for kills in range(MOST_KILLS):
        process = subprocess.Popen(
            command(folder, "--checkpoint", "0", "--quiet", study=study), stderr=subprocess.DEVNULL
        )
        time.sleep(0.2 * draw.random() * 1.03**kills)
        process.kill()
        if process.wait() == 0:
            break
        if (folder / "study.yaml").exists():
            failed_before(folder, straight)
    expect_same(folder, straight)
    assert kills >= 3, kills
    print(f"{state['retried']} of 6 runs need a smaller step, asked for at once or afterwards, "
          f"killed {kills} times: the same bytes")


def targets_are_reached(work):
    """Killed as soon as the pilot is whole, and again while the replicas that it asks for are run."""
    study, straight, folder = work / "until.yaml", work / "until", work / "until-killed"
    text = STUDY.read_text().replace("replicas: 3", "replicas: 5")
    study.write_text(text + "analyses:\n  - rise\nuntil: {analysis: rise, quantity: rate, "
                     "half_width: 0.02, max_replicas: 12}\n")
    said = run(straight, "--threads", "1", study=study).stdout
    done = [line for line in said.splitlines() if "runs done" in line][-1]
    whole = int(done.split(" of ")[0].split()[-1])
    assert said.count("runs done") == 2 and 10 < whole <= 24, said
    found = []
    for wanted in (10, 11):
        process = subprocess.Popen(command(folder, "--checkpoint", "0", "--quiet", study=study))
        while len(list(folder.glob("runs/*.h5"))) < wanted and process.poll() is None:
            time.sleep(0.002)
        process.kill()
        process.wait()
        found.append(len(list(folder.glob("runs/*.h5"))))
    assert status(folder)["runs"] == whole
    run(folder, study=study)
    expect_same(folder, straight)
    print(f"of {whole} runs of a precision target killed with {found[0]} and {found[1]} there, the "
          "pilot's 10 among them: the same bytes")


def failed_before(folder, straight):
    """A file with its final name is the last one, or that of a try that failed."""
    state = status(folder)
    failed = {path for path in (folder / "runs").glob("*.h5")
              if path.read_bytes() != (straight / "runs" / path.name).read_bytes()}
    assert len(failed) <= 6 - state["done"], (failed, state)


def seeds(work, reference):
    study = work / "other.yaml"
    study.write_text(STUDY.read_text().replace("seed: 11", "seed: 12"))
    run(work / "other", study=study)
    first, second = contents(reference / "runs"), contents(work / "other" / "runs")
    assert first.keys() == second.keys() and all(first[n] != second[n] for n in first)
    refused = run(reference, study=study, code=2)
    assert "seed" in refused.stderr and refused.stderr.count("\n") == 1, refused.stderr
    run(work / "again", "--threads", "2")
    expect_same(work / "again", reference)
    print("another seed gives other bytes and is refused the folder; the same seed and 2 threads agree")


def main():
    with tempfile.TemporaryDirectory(prefix="rk-crash-") as name:
        work = pathlib.Path(name)
        reference = work / "reference"
        run(reference, "--threads", "1")
        seeds(work, reference)
        killed_at_any_moment(work, reference)
        stopped_on_request(work, reference)
        damage_is_repaired(work, reference)
        failures_are_results(work)
        retries_are_results(work)
        targets_are_reached(work)


main()
