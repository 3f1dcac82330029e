"""Daemons and runs that a Python program started end with it, however it ends."""

import contextlib
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import textwrap
import time
import unittest

from aprsim.binaries import find_binary
from running_cell import PATIENCE

LIMIT_S = 60 * PATIENCE
START = "import os, signal, sys\nfrom aprsim import Daemon\ndaemon = Daemon(speed=1)\n"
TELL = "print(daemon.process.pid, flush=True)\n"
KILL = "os.kill(os.getpid(), signal.{})\nsignal.pause()\n"

# The ways in which a program ends that holds a daemon and has printed its process number.
WAYS = {
    "its last line": "",
    "an exception": "raise RuntimeError('on purpose')\n",
    "sys.exit": "sys.exit(3)\n",
    "os._exit": "os._exit(3)\n",
    "SIGTERM": KILL.format("SIGTERM"),
    "SIGINT": KILL.format("SIGINT"),
    "SIGHUP": KILL.format("SIGHUP"),
    "SIGQUIT": KILL.format("SIGQUIT"),
    "SIGKILL": KILL.format("SIGKILL"),
    "another program in its place": "os.execv('/bin/sleep', ['sleep', '0'])\n",
    "a forked child that lives on": """
        read, write = os.pipe()
        if os.fork() == 0:
            os.close(1)
            os.write(write, b'x')
            signal.pause()
        os.read(read, 1)
        os.kill(os.getpid(), signal.SIGKILL)
        """,
}


def runs(pid):
    """Whether the process is there; one that waits for its parent to notice has ended."""
    try:
        stat = pathlib.Path(f"/proc/{pid}/stat").read_text(encoding="utf-8")
    except (FileNotFoundError, ProcessLookupError):
        return False
    return stat.rpartition(")")[2].split()[0] not in "ZX"


def children(pid):
    """Its children and their children."""
    out = []
    for folder in pathlib.Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            parent = int((folder / "stat").read_text(encoding="utf-8").rpartition(")")[2].split()[1])
            if parent == pid:
                out += [int(folder.name), *children(int(folder.name))]
    return out


class WithPrograms(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.pids = []

    def kill_all(self):
        for pid in self.pids:
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)

    def start(self, program):
        """A program in a session of its own, whose temporary files are in `self.folder`."""
        process = subprocess.Popen(
            [sys.executable, "-c", textwrap.dedent(program)], start_new_session=True,
            env={**os.environ, "TMPDIR": str(self.folder)}, text=True,
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
        )
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.wait)
        self.addCleanup(self.kill_all)
        self.pids.append(process.pid)
        return process

    def pid_from(self, process):
        line = process.stdout.readline()
        self.assertTrue(line, "the program has started nothing")
        self.pids.append(int(line))
        return int(line)

    def await_that(self, condition, words):
        deadline = time.monotonic() + LIMIT_S
        while not condition():
            self.assertLess(time.monotonic(), deadline, words)
            time.sleep(0.01)


class Daemons(WithPrograms):
    def test_a_daemon_ends_with_its_program(self):
        for way, ending in WAYS.items():
            with self.subTest(way):
                program = self.start(START + TELL + textwrap.dedent(ending))
                pid = self.pid_from(program)
                self.pids += children(program.pid)
                self.await_that(lambda: not runs(pid), f"after {way} the daemon runs on")
                self.await_that(lambda: not os.listdir(self.folder), f"after {way} files are left")
                self.kill_all()

    def test_a_daemon_that_only_starts_ends_as_well(self):
        program = self.start("from aprsim import Daemon\nDaemon(scene='aprs', speed=1)\n")
        self.await_that(lambda: children(program.pid), "no daemon starts")
        pids = children(program.pid)
        self.pids += pids
        program.kill()
        self.await_that(lambda: not any(map(runs, pids)), "the daemon runs on")
        self.await_that(lambda: not os.listdir(self.folder), "files are left")

    def test_a_daemon_that_nobody_refers_to_ends(self):
        program = self.start(START + TELL + "del daemon\nsignal.pause()\n")
        pid = self.pid_from(program)
        self.await_that(lambda: not runs(pid), "the daemon runs on")
        self.await_that(lambda: not os.listdir(self.folder), "files are left")
        self.assertTrue(runs(program.pid))

    def test_the_environment_of_a_terminated_worker_takes_its_daemon_along(self):
        for method in ("fork", "spawn", "forkserver"):
            with self.subTest(method):
                source = self.folder / f"{method}.py"
                source.write_text(textwrap.dedent(f"""
                    import multiprocessing, signal
                    from aprsim.envs import PickEnv

                    def work(pipe):
                        env = PickEnv(in_process=False)
                        env.reset(seed=1)
                        pipe.send(env._daemon.process.pid)
                        signal.pause()

                    if __name__ == "__main__":
                        context = multiprocessing.get_context("{method}")
                        ours, theirs = context.Pipe()
                        worker = context.Process(target=work, args=(theirs,))
                        worker.start()
                        print(ours.recv(), flush=True)
                        worker.terminate()
                        worker.join()
                        signal.pause()
                    """), encoding="utf-8")
                program = self.start(f"import runpy; runpy.run_path({str(source)!r}, run_name='__main__')")
                pid = self.pid_from(program)
                self.await_that(lambda: not runs(pid), "the daemon runs on")
                program.kill()

    def test_a_daemon_outlives_the_thread_that_started_it(self):
        program = self.start("""
            import threading
            from aprsim import Cell, Daemon
            made = []
            thread = threading.Thread(target=lambda: made.append(Daemon(speed="stepped")))
            thread.start()
            thread.join()
            with Cell.connect(made[0].ports_file) as cell:
                print(cell.step(5).step, flush=True)
            """)
        self.assertEqual(program.stdout.readline(), "5\n")

    def test_a_forked_child_leaves_its_parents_daemon_alone(self):
        program = self.start("""
            import os
            from aprsim import Cell, Daemon
            with Daemon(speed="stepped") as daemon:
                child = os.fork()
                if child == 0:
                    daemon.close()
                    raise SystemExit(7)
                assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7
                with Cell.connect(daemon.ports_file) as cell:
                    print(cell.step(5).step, flush=True)
            """)
        self.assertEqual(program.stdout.readline(), "5\n")

    def test_an_interrupt_of_the_terminal_is_the_programs(self):
        program = self.start("""
            import os, signal
            from aprsim import Cell, Daemon
            with Daemon(speed="stepped") as daemon, Cell.connect(daemon.ports_file) as cell:
                try:
                    os.killpg(0, signal.SIGINT)
                    signal.pause()
                except KeyboardInterrupt:
                    print(cell.step(5).step, flush=True)
            """)
        self.assertEqual(program.stdout.readline(), "5\n")


class Runs(WithPrograms):
    SCENARIO = """description: an order that nobody fills
scene: aprs
orders:
  - {name: kit, tray: sku_kit_m2l1_vessel, slots: {lg_1: sku_part_large_gear}}
stop: {time_limit_s: 3000}
expect: {kits_right: 1, drops: 0}
scoring: {baseline_s: 20, baseline_score: 5}
"""

    def start_run(self, before=""):
        """A program that runs a scenario, whose controller is at work."""
        (self.folder / "idle.yaml").write_text(self.SCENARIO, encoding="utf-8")
        controller = f"echo $$ > {self.folder}/controller; exec sleep 3000"
        program = self.start(
            f"{before}\nfrom aprsim import run_scenario\nrun_scenario({str(self.folder / 'idle.yaml')!r}, "
            f"virtual=False, speed=1, controller={controller!r})\n"
        )
        file = self.folder / "controller"
        self.await_that(lambda: file.exists() and file.read_text(encoding="utf-8").strip(), "no controller")
        pids = [*children(program.pid), int(file.read_text(encoding="utf-8"))]
        self.pids += pids
        self.assertGreaterEqual(len(pids), 3)
        return program, pids

    def test_a_run_ends_with_its_program(self):
        for way in (signal.SIGKILL, signal.SIGTERM, signal.SIGINT):
            with self.subTest(way.name):
                program, pids = self.start_run()
                program.send_signal(way)
                self.await_that(lambda: not any(map(runs, pids)), f"the run goes on after {way.name}")
                (self.folder / "controller").unlink()

    def test_a_run_that_takes_too_long_ends(self):
        program, pids = self.start_run(textwrap.dedent("""
            import functools, aprsim
            aprsim.run_scenario = functools.partial(aprsim.run_scenario, timeout_s=5)"""))
        self.await_that(lambda: not any(map(runs, pids)), "the run goes on after its time")


class Option(unittest.TestCase):
    def test_the_daemon_stops_in_order_when_its_input_ends(self):
        command = [find_binary("aprsimd"), "--any-port", "--no-web", "--exit-on-stdin-eof"]
        process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        self.addCleanup(process.kill)
        process.stdin.close()
        self.assertEqual(process.wait(LIMIT_S), 0)


if __name__ == "__main__":
    unittest.main()
