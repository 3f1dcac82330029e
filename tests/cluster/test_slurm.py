"""docker/slurm/batch.sbatch in a real Slurm of one node: an array of twenty tasks, one of which is killed
and put into the queue again. slurmctld and slurmd run as whoever runs this, without systemd and munge.
Exits with 77 where there is no Slurm."""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path
from typing import Callable

ROOT = Path(__file__).resolve().parents[2]
BINARIES = Path(os.environ.get("APRSIM_BIN_DIR", ROOT / "build/release/bin"))
PATIENCE = float(os.environ.get("APRSIM_PATIENCE", "1"))
SKIPPED = 77
TASKS = 20
NEEDED = ("slurmctld", "slurmd", "sbatch", "squeue", "scontrol", "sinfo")


def skip(why: str) -> None:
    print(f"SKIPPED: {why}", file=sys.stderr)
    sys.exit(SKIPPED)


def own_network() -> None:
    """Slurm finds no address where there is none but the loopback's: then in a network of our own that
    has one."""
    try:
        socket.getaddrinfo(None, 1, socket.AF_INET, flags=socket.AI_ADDRCONFIG | socket.AI_PASSIVE)
        return
    except socket.gaierror:
        pass
    if os.environ.get("APRSIM_OWN_NETWORK"):
        skip("no network in which Slurm finds an address")
    script = 'ip link set lo up && ip addr add 10.99.0.1/32 dev lo && exec "$@"'
    line = ["unshare", "--net", "sh", "-c", script, "sh", sys.executable, *sys.argv]
    try:
        os.execvpe("unshare", line, {**os.environ, "APRSIM_OWN_NETWORK": "1"})
    except OSError as error:
        skip(f"no network in which Slurm finds an address, and none of our own: {error}")


def free_ports(count: int) -> list[int]:
    sockets = [socket.socket() for _ in range(count)]
    for one in sockets:
        one.bind(("127.0.0.1", 0))
    ports = [one.getsockname()[1] for one in sockets]
    for one in sockets:
        one.close()
    return ports


def wait_for(what: str, condition: Callable[[], bool], seconds: float = 60) -> None:
    deadline = time.monotonic() + seconds * PATIENCE
    while not condition():
        if time.monotonic() > deadline:
            raise AssertionError(f"waited in vain for {what}")
        time.sleep(0.05)


class Cluster:
    def __init__(self, directory: Path) -> None:
        self.directory = directory
        host = socket.gethostname().partition(".")[0]
        user = subprocess.run(["id", "-un"], capture_output=True, text=True, check=True).stdout.strip()
        control_port, node_port = free_ports(2)
        for name in ("state", "spool"):
            (directory / name).mkdir()
        settings = {
            "ClusterName": "test",
            "SlurmctldHost": f"{host}(127.0.0.1)",
            "SlurmUser": user,
            "SlurmdUser": user,
            "AuthType": "auth/none",
            "CredType": "cred/none",
            "ProctrackType": "proctrack/pgid",
            "TaskPlugin": "task/none",
            "SwitchType": "switch/none",
            "MpiDefault": "none",
            "SelectType": "select/cons_tres",
            "SelectTypeParameters": "CR_CPU",
            "AccountingStorageType": "accounting_storage/none",
            "JobAcctGatherType": "jobacct_gather/none",
            "JobCompType": "jobcomp/none",
            "StateSaveLocation": directory / "state",
            "SlurmdSpoolDir": directory / "spool",
            "SlurmctldPidFile": directory / "slurmctld.pid",
            "SlurmdPidFile": directory / "slurmd.pid",
            "SlurmctldPort": control_port,
            "SlurmdPort": node_port,
            "SchedulerParameters": "sched_interval=1,bf_interval=1,sched_min_interval=0,default_queue_depth=1000",
            "ReturnToService": 2,
            "KillWait": 1,
            "MinJobAge": 600,
            "MailProg": "/bin/true",
        }
        cpus = max(2, os.cpu_count() or 1)
        lines = [f"{key}={value}" for key, value in settings.items()]
        lines += [
            # Slurm looks at the machine: a small one may have fewer processors than that.
            "SlurmdParameters=config_overrides",
            f"NodeName={host} NodeAddr=127.0.0.1 CPUs={cpus} State=UNKNOWN",
            "PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP",
        ]
        configuration = directory / "slurm.conf"
        configuration.write_text("\n".join(lines) + "\n")
        # No control groups are used, but slurmd does not start with those of version 2, its own choice,
        # where /sys/fs/cgroup is not mounted, as in a bare root.
        (directory / "cgroup.conf").write_text("CgroupPlugin=cgroup/v1\n")
        self.environment = {**os.environ, "SLURM_CONF": str(configuration)}
        self.daemons: list[subprocess.Popen[bytes]] = []
        for name in ("slurmctld", "slurmd"):
            with open(directory / f"{name}.out", "wb") as log:
                self.daemons.append(
                    subprocess.Popen(
                        [name, "-D"], env=self.environment, stdout=log, stderr=subprocess.STDOUT
                    )
                )
        try:
            wait_for("the node", lambda: "idle" in self.ask("sinfo", "-h", "-o", "%T", check=False))
        except AssertionError as error:
            logs = self.logs()
            self.end()
            raise AssertionError(f"{error}{logs}") from None

    def ask(self, *line: str, check: bool = True) -> str:
        done = subprocess.run(
            line, env=self.environment, capture_output=True, text=True, timeout=60 * PATIENCE
        )
        if check and done.returncode != 0:
            raise AssertionError(f"{' '.join(line)}: {done.stderr}{self.logs()}")
        return done.stdout

    def states(self, job: str) -> dict[int, str]:
        """The state of each unfinished task."""
        rows = self.ask("squeue", "-h", "-r", "-j", job, "-o", "%K %T", check=False).split("\n")
        return {int(row.split()[0]): row.split()[1] for row in rows if row}

    def logs(self) -> str:
        return "".join(
            f"\n--- {name}\n" + (self.directory / f"{name}.out").read_text()[-3000:]
            for name in ("slurmctld", "slurmd")
        )

    def end(self) -> None:
        self.ask("scancel", "--state=RUNNING,PENDING", "--user", str(os.getuid()), check=False)
        for daemon in reversed(self.daemons):
            daemon.terminate()
        for daemon in self.daemons:
            try:
                daemon.wait(20)
            except subprocess.TimeoutExpired:
                daemon.kill()
                daemon.wait()


class SlurmTest(unittest.TestCase):
    def setUp(self) -> None:
        directory = tempfile.TemporaryDirectory(prefix="aprsim-slurm-")
        self.addCleanup(directory.cleanup)
        self.directory = Path(directory.name)
        self.cluster = Cluster(self.directory)
        self.addCleanup(self.cluster.end)
        self.results = self.directory / "results"

    def aprsim(self, *arguments: str) -> str:
        done = subprocess.run(
            [BINARIES / "aprsim", *arguments], capture_output=True, text=True, timeout=250 * PATIENCE
        )
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def report(self, name: str) -> list[str]:
        return [
            (self.results / name / file).read_text()
            for file in ("report.json", "report.txt", "report.html")
        ]

    def test_an_array_with_a_killed_task_is_the_whole_batch(self) -> None:
        cluster, seeds = self.cluster, f"1..{TASKS}"
        output = str(self.directory / "task_%a.log")
        cluster.environment.update(
            APRSIM=str(BINARIES / "aprsim"), APRSIM_OPTIONS="--journals 0 --tries 1"
        )
        job = cluster.ask(
            "sbatch", "--parsable", f"--array=0-{TASKS - 1}", "--cpus-per-task=1", "--mem-per-cpu=0",
            f"--output={output}", str(ROOT / "docker/slurm/batch.sbatch"), "pick", seeds,
            str(self.results),
        ).strip()  # fmt: skip
        victim = 3
        wait_for(
            "a task at work",
            lambda: cluster.states(job).get(victim) == "RUNNING"
            and (self.results / f"shard_{victim}/stations/1/ports.json").exists(),
        )
        cluster.ask("scontrol", "requeue", f"{job}_{victim}")
        wait_for("it to be back in the queue", lambda: "PENDING" == cluster.states(job).get(victim))
        # Slurm lets it wait for a while.
        cluster.ask("scontrol", "update", f"JobId={job}_{victim}", "StartTime=now")
        try:
            wait_for("the end of the array", lambda: not cluster.states(job), 240)
        except AssertionError as error:
            raise AssertionError(f"{error}: {cluster.states(job)}{cluster.logs()}") from error
        for task in range(TASKS):
            log = (self.directory / f"task_{task}.log").read_text()
            self.assertIn(f"shard {task} of {TASKS}", log)
            self.assertIn("1 run, 1 as expected", log)
        again = (self.directory / f"task_{victim}.log").read_text()
        self.assertIn("start 1", again)
        self.assertIn("start 2", again)
        shards = [str(self.results / f"shard_{task}") for task in range(TASKS)]
        self.aprsim("merge", *shards, "--out", str(self.results / "all"))
        self.aprsim(
            "batch", "pick", "--seeds", seeds, "--jobs", "2", "--journals", "0",
            "--out", str(self.results / "whole"),
        )  # fmt: skip
        self.assertEqual(self.report("all"), self.report("whole"))

    def test_a_wrong_call_is_told(self) -> None:
        script = str(ROOT / "docker/slurm/batch.sbatch")
        done = subprocess.run(["bash", script, "pick"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 2)
        self.assertIn("usage: sbatch", done.stderr)


if __name__ == "__main__":
    missing = [name for name in NEEDED if shutil.which(name) is None]
    if missing:
        skip(f"{', '.join(missing)} not here: apt install slurmctld slurmd slurm-client")
    own_network()
    unittest.main()
