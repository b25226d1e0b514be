"""A real Slurm on the loopback runs an array job into one folder: the bytes of an undisturbed run.

Usage: slurm.py RECKON STUDY SCRIPT. Nothing is installed. munged, slurmctld and slurmd are started
in a scratch folder, on ports that are free, and ended again. Where Slurm is not installed or does
not come up the test is skipped (77) and says why.
"""
import ctypes
import getpass
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "crash"))
from study_runs import STUDY, RECKON, expect_same, run, status

SCRIPT = pathlib.Path(sys.argv[3]).resolve()
SKIP = 77
TASKS = 4


def skip(why):
    print(f"skipped: {why}")
    sys.exit(SKIP)


def tool(name):
    found = shutil.which(name, path=os.environ["PATH"] + ":/usr/sbin:/sbin")
    if not found:
        skip(f"{name} is not installed (sh packages.sh slurm)")
    return found


def free_port():
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


CONF = """
ClusterName=scratch
SlurmctldHost={node}(127.0.0.1)
SlurmctldPort={control}
SlurmdPort={daemon}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={work}/munge.socket
CredType=cred/munge
StateSaveLocation={work}/state
SlurmdSpoolDir={work}/spool
SlurmctldPidFile={work}/slurmctld.pid
SlurmdPidFile={work}/slurmd.pid
ProctrackType=proctrack/pgid
TaskPlugin=task/none
SwitchType=switch/none
MpiDefault=none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=sched_interval=1,batch_sched_delay=0
ReturnToService=2
SlurmdParameters=config_overrides
NodeName={node} NodeHostname={node} NodeAddr=127.0.0.1 CPUs=2 RealMemory=1000 State=UNKNOWN
PartitionName=main Nodes={node} Default=YES MaxTime=INFINITE State=UP OverSubscribe=NO
"""


class Slurm:
    """The three daemons, in the foreground, as children."""

    def __init__(self, work):
        self.work, self.daemons = work, []
        self.env = dict(os.environ, SLURM_CONF=str(work / "slurm.conf"))
        for name in ("state", "spool"):
            (work / name).mkdir()
        work.chmod(0o755)

    def daemon(self, name, *arguments):
        log = (self.work / f"{name}.out").open("w")
        process = subprocess.Popen(
            [tool(name), *arguments], env=self.env, stdout=log, stderr=log, stdin=subprocess.DEVNULL
        )
        self.daemons.append((name, process))

    def start(self):
        key = self.work / "munge.key"
        key.write_bytes(os.urandom(128))
        key.chmod(0o400)
        self.daemon(
            "munged", "--foreground", "--force", "--num-threads=2",
            f"--socket={self.work}/munge.socket", f"--key-file={key}",
            f"--pid-file={self.work}/munge.pid", f"--log-file={self.work}/munge.log",
            f"--seed-file={self.work}/munge.seed",
        )
        self.wait("munged", lambda: (self.work / "munge.socket").exists())
        node = socket.gethostname().split(".")[0]
        (self.work / "slurm.conf").write_text(CONF.format(
            node=node, control=free_port(), daemon=free_port(), user=getpass.getuser(),
            work=self.work,
        ))
        self.daemon("slurmctld", "-D", "-c")
        self.daemon("slurmd", "-D", "-c", "-N", node)
        self.wait("a node", lambda: "idle" in self.ask("sinfo", "-h", "-o", "%t"))

    def ask(self, *command):
        done = subprocess.run([tool(command[0]), *command[1:]], env=self.env, capture_output=True,
                              text=True, timeout=60)
        return done.stdout if done.returncode == 0 else ""

    def wait(self, what, condition, seconds=40):
        end = time.monotonic() + seconds
        while not condition():
            dead = [name for name, process in self.daemons if process.poll() is not None]
            if dead or time.monotonic() > end:
                self.say_logs()
                skip(f"Slurm does not come up here: {dead or what}")
            time.sleep(0.2)

    def say_logs(self):
        for name, _ in self.daemons:
            text = (self.work / f"{name}.out").read_text().strip().splitlines()
            print("\n".join(f"{name}: {line}" for line in text[-5:]))

    def stop(self):
        for _, process in reversed(self.daemons):
            process.send_signal(signal.SIGTERM)
        for _, process in reversed(self.daemons):
            try:
                process.wait(10)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        try:  # what the daemons left behind, now children of ours
            while os.waitpid(-1, os.WNOHANG) != (0, 0):
                pass
        except ChildProcessError:
            pass


def array_job(slurm, work, name):
    """Submit the sample script as an array; returns the job's number."""
    environment = dict(slurm.env, RECKON=RECKON, STUDY=str(STUDY), OUT=str(work / name))
    done = subprocess.run(
        [tool("sbatch"), "--parsable", f"--array=1-{TASKS}", "--cpus-per-task=1", "--mem-per-cpu=100",
         "--time=5", f"--output={work}/%a.log", f"--chdir={work}", str(SCRIPT)],
        env=environment, capture_output=True, text=True,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def finish(slurm, job, seconds=240):
    end = time.monotonic() + seconds
    while slurm.ask("squeue", "-h", "-j", job).strip():
        assert time.monotonic() < end, slurm.ask("squeue")
        time.sleep(0.3)


def logs(work):
    return [(work / f"{task}.log").read_text() for task in range(1, TASKS + 1)]


def whole_array(slurm, work, reference):
    finish(slurm, array_job(slurm, work, "array"))
    assert (work / "array" / "study.h5").exists(), logs(work)
    assert status(work / "array")["done"] == 6, logs(work)
    expect_same(work / "array", reference)
    print(f"an array job of {TASKS} tasks into one folder: the same bytes")


def cancelled_array(slurm, work, reference):
    """scancel in the middle: the tasks end in good order, and a second job goes on."""
    job = array_job(slurm, work, "cancelled")
    end = time.monotonic() + 60
    while not list(work.glob("cancelled/runs/*")):
        assert time.monotonic() < end, "no task has begun"
        time.sleep(0.05)
    slurm.ask("scancel", "--signal=TERM", "--full", job)
    slurm.ask("scancel", job)
    finish(slurm, job)
    before = status(work / "cancelled")["done"]
    finish(slurm, array_job(slurm, work, "cancelled"))
    expect_same(work / "cancelled", reference)
    print(f"an array job cancelled with {before} of 6 done, and a second one: the same bytes")


def main():
    for name in ("munged", "slurmctld", "slurmd", "sbatch", "sinfo", "squeue", "scancel"):
        tool(name)
    ctypes.CDLL(None).prctl(36, 1, 0, 0, 0)  # PR_SET_CHILD_SUBREAPER
    with tempfile.TemporaryDirectory(prefix="rk-slurm-") as name:
        work = pathlib.Path(name)
        run(work / "reference", "--threads", "1")
        (work / "slurm").mkdir()
        slurm = Slurm(work / "slurm")
        try:
            slurm.start()
            whole_array(slurm, work, work / "reference")
            cancelled_array(slurm, work, work / "reference")
        finally:
            slurm.stop()


main()
