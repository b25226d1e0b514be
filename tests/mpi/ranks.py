"""mpirun, threads, shards and any mix of them; ranks that are killed: always the same bytes.

Usage: ranks.py RECKON STUDY MPIRUN KILLS.
"""
import os
import pathlib
import random
import re
import signal
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "crash"))
from study_runs import RECKON, STUDY, command, expect_same, finished_are_whole, run, status

MPIRUN, KILLS = sys.argv[3], int(sys.argv[4])
# More ranks than cores, by root in a container, and no network: the tests' case, not a cluster's.
ENVIRONMENT = dict(
    os.environ,
    OMPI_ALLOW_RUN_AS_ROOT="1",
    OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1",
    OMPI_MCA_rmaps_base_oversubscribe="1",
    OMPI_MCA_mpi_yield_when_idle="1",
    OMPI_MCA_btl="self,vader,tcp",
    OMPI_MCA_btl_vader_single_copy_mechanism="none",
    OMPI_MCA_hwloc_base_binding_policy="none",
)


def start(ranks, folder, *more, study=STUDY):
    return subprocess.Popen(
        [MPIRUN, "-n", str(ranks), *command(folder, *more, study=study)],
        env=ENVIRONMENT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    )


def mpirun(ranks, folder, *more, study=STUDY, code=0):
    process = start(ranks, folder, *more, study=study)
    said = process.communicate(timeout=300)[0]
    assert process.returncode == code, (process.returncode, said)
    return said


def starts_at_all():
    try:
        done = subprocess.run([MPIRUN, "-n", "2", "true"], env=ENVIRONMENT, capture_output=True,
                              text=True, timeout=60)
    except (OSError, subprocess.TimeoutExpired) as why:
        return str(why)
    return "" if done.returncode == 0 else done.stderr.strip().splitlines()[0]


def ranks_of(process):
    """The processes that mpirun started, by their numbers."""
    found = {}
    for folder in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            parent = int(re.search(r"\) \S (\d+)", (folder / "stat").read_text())[1])
            words = (folder / "environ").read_bytes().split(b"\0")
        except (OSError, TypeError):
            continue
        if parent == process.pid:
            for word in words:
                if word.startswith(b"OMPI_COMM_WORLD_RANK="):
                    found[int(word.split(b"=")[1])] = int(folder.name)
    return found


def end(process):
    """Wait for mpirun, which was seen to wait for ever after a rank died while it started others."""
    try:
        process.communicate(timeout=60)
    except subprocess.TimeoutExpired:
        for rank in ranks_of(process).values():
            os.kill(rank, signal.SIGKILL)
        process.kill()
        process.communicate()


def ranks_share(work, reference):
    said = mpirun(3, work / "three")
    assert said.count("6 of 6 runs done") == 1, said
    expect_same(work / "three", reference)
    mpirun(2, work / "threads", "--threads", "2")
    expect_same(work / "threads", reference)
    said = mpirun(2, work / "threads")  # nothing to do
    assert "6 of 6 runs done" in said, said
    print("three ranks, and two of two threads: the same bytes")


def ranks_die(work, reference):
    folder, draw, kills = work / "killed", random.Random(2024), {0: 0, 1: 0}
    for attempt in range(10 * KILLS):
        process = start(2, folder, "--checkpoint", "0.01", "--quiet")
        time.sleep(0.2 + draw.random())
        victim = draw.randrange(2)
        ranks = ranks_of(process)
        if len(ranks) == 2:
            os.kill(ranks[victim], signal.SIGKILL)
            kills[victim] += 1
        end(process)
        if (folder / "runs").exists():
            finished_are_whole(folder, reference)
        if process.returncode == 0:
            expect_same(folder, reference)
            folder = work / f"killed-{attempt}"
        if sum(kills.values()) >= KILLS:
            break
    assert sum(kills.values()) >= KILLS, kills
    mpirun(2, folder)
    expect_same(folder, reference)
    print(f"rank 0 was killed {kills[0]} times, rank 1 {kills[1]} times: the same bytes")


def stopped_on_request(work, reference):
    process = start(2, work / "stopped", "--quiet", "--checkpoint", "0.01")
    end = time.monotonic() + 60
    while not list((work / "stopped").glob("runs/*.ckpt")) and time.monotonic() < end:
        time.sleep(0.005)
    process.send_signal(signal.SIGTERM)
    process.communicate(timeout=60)
    before = status(work / "stopped")
    mpirun(2, work / "stopped")
    expect_same(work / "stopped", reference)
    print(f"mpirun was stopped with {before['done']} of 6 done: the same bytes")


ANALYSES = "analyses:\n  - rise: {from: 1}\n  - ldf: {window: 1, from: 1}\n"


def analyze(folder):
    done = subprocess.run([RECKON, "analyze", str(folder)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout.replace(str(folder), "FOLDER")


def any_mix(work):
    """Started on threads, killed, continued under mpirun, finished by shards, extended; with some
    runs that fail and are tried again with smaller steps."""
    study, more = work / "mix.yaml", work / "more.yaml"
    text = STUDY.read_text().replace("base:\n", "base:\n  health.travel: 0.0036\n") + ANALYSES
    text += "retry: {step: 0.5, times: 2}\n"
    study.write_text(re.sub(r"replicas: \d+", "replicas: 6", text))
    more.write_text(re.sub(r"replicas: \d+", "replicas: 8", text))
    folder = work / "mix"
    process = subprocess.Popen(command(folder, "--threads", "2", "--checkpoint", "0.01", "-q",
                                       study=study))
    done = []

    def note():
        done.append(status(folder)["done"] if (folder / "study.yaml").exists() else 0)

    while not list(folder.glob("runs/*.h5")) and process.poll() is None:
        time.sleep(0.005)
    process.kill()
    process.wait()
    note()
    process = start(2, folder, "--checkpoint", "0.01", "-q", study=study)
    while len(list(folder.glob("runs/*.h5"))) < 6 and process.poll() is None:
        time.sleep(0.005)
    victim = ranks_of(process).get(1)
    if victim:
        os.kill(victim, signal.SIGKILL)
    end(process)
    note()
    shards = [
        subprocess.Popen(command(folder, "--shard", f"{i}/2", "-q", "--threads", "1", study=study))
        for i in (1, 2)
    ]
    assert [p.wait() for p in shards] == [0, 0]
    note()
    mpirun(2, folder, study=more)
    note()
    run(work / "plain", "--threads", "1", study=more)
    expect_same(folder, work / "plain")
    assert analyze(folder) == analyze(work / "plain")
    expect_same(folder, work / "plain")
    points = STUDY.read_text().count("name: ")
    assert done[2] == 6 * points and done[3] == 8 * points, done
    assert 0 < status(folder)["retried"] < 8 * points, status(folder)
    print(f"threads, killed with {done[0]} done; mpirun, a rank killed with {done[1]}; two shards, "
          f"{done[2]}; extended under mpirun, {done[3]}: the same bytes, analyses too")


def main():
    why = starts_at_all()
    if why:
        print(f"skipped: mpirun does not start here: {why}")
        sys.exit(77)
    with tempfile.TemporaryDirectory(prefix="rk-mpi-") as name:
        work = pathlib.Path(name)
        reference = work / "reference"
        run(reference, "--threads", "1")
        ranks_share(work, reference)
        stopped_on_request(work, reference)
        ranks_die(work, reference)
        any_mix(work)


main()
