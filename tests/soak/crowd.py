"""The clients of a soak: processes that are started again when they end, and what they met."""

import json
import os
import pathlib
import signal
import subprocess
import sys
import threading
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
HERE = pathlib.Path(__file__).resolve().parent
WIRES = ("crcl", "simple-message", "fanuc=simple-message,motoman=crcl", "fanuc=crcl,motoman=simple-message")
# Ended by a signal of ours: Python's clients with 0, aprsim and kitting with 130.
ENDED = (0, 130, -signal.SIGTERM)
AGAIN_S = 1  # before a client that met a fault is started again


class Client:
    """A process that is started again when it ends. `faults`: what it met, each with its count."""

    def __init__(self, name, command, folder):
        self.name, self.command, self.folder = name, command, pathlib.Path(folder)
        self.process, self.faults, self.restarts = None, {}, 0
        self._killed, self._stalled_until, self._again_at = False, None, 0.0
        self._stalled = False  # in this life: the daemon may have ended what nobody read

    def start(self):
        with open(self.folder / f"{self.name}.log", "wb") as log:
            self.process = subprocess.Popen(self.command(), stdout=self._output(), stderr=log)
        self._killed = self._stalled = False

    def _output(self):
        return subprocess.DEVNULL

    def kill(self):
        """As a machine that loses its power."""
        self._killed = True
        self._stalled_until = None
        self.process.kill()

    def stall(self, seconds):
        """It reads and sends nothing for a while."""
        if self._stalled_until is None and self.process.poll() is None:
            self._stalled = True
            self._stalled_until = time.monotonic() + seconds
            self.process.send_signal(signal.SIGSTOP)

    def check(self):
        """Goes on after a stall, and starts it again when it has ended."""
        now = time.monotonic()
        if self._stalled_until is not None and now >= self._stalled_until:
            self._stalled_until = None
            self.process.send_signal(signal.SIGCONT)
        if self.process is not None and self.process.poll() is not None:
            if not self._killed:
                if not self._stalled:
                    self._note_end()
                self._again_at = now + AGAIN_S
            self.process = None
            self.restarts += 1
        if self.process is None and now >= self._again_at:
            self.start()

    def _note_end(self):
        text = (self.folder / f"{self.name}.log").read_text(encoding="utf-8", errors="replace").strip()
        last = text.splitlines()[-1][:160] if text else f"ended with {self.process.returncode}"
        self.faults[last] = self.faults.get(last, 0) + 1
        print(f"{time.strftime('%H:%M:%S')} {self.name}: {last}", file=sys.stderr, flush=True)

    def stop(self):
        """Asks it to end. A client that hangs is a fault."""
        if self.process is None:
            return
        if self._stalled_until is not None:
            self.process.send_signal(signal.SIGCONT)
        self.process.terminate()
        try:
            if self.process.wait(60) not in ENDED and not self._killed and not self._stalled:
                self._note_end()
        except subprocess.TimeoutExpired:
            self.faults["hangs"] = 1
            self.process.kill()
            self.process.wait()


class Controller(Client):
    """The kitting controller without end. Each life has the next of WIRES."""

    def __init__(self, cell, ports_file, folder):
        super().__init__("kitting", self._make, folder)
        self._cell, self._ports_file, self._reader = cell, ports_file, None
        self.placed, self.rounds, self.lives = 0, 0, 0
        self.has_placed = False  # in this life
        self.placed_at = time.monotonic()
        self.wires = ""

    def _make(self):
        self.wires = WIRES[self.lives % len(WIRES)]
        self.lives += 1
        return [
            sys.executable, str(ROOT / "clients" / "kitting" / "kitting"), "--cell", self._cell,
            "--ports-file", self._ports_file(), "--wires", self.wires, "--forever", "--json",
        ]

    def _output(self):
        return subprocess.PIPE

    def start(self):
        self.has_placed = False
        super().start()
        self._reader = threading.Thread(target=self._read, args=(self.process.stdout,), daemon=True)
        self._reader.start()

    def next_wires(self):
        """Ends this life in order; the next check begins another."""
        self._killed = True
        self.process.terminate()

    def _read(self, out):
        before = 0
        for line in out:
            try:
                told = json.loads(line)
            except ValueError:
                continue  # cut off by a kill
            placed = told.get("progress", {}).get("placed", before)
            if placed != before:
                self.placed += placed - before
                self.placed_at = time.monotonic()
                self.has_placed = True
                before = placed
            if "the kits are as" in told.get("text", ""):
                self.rounds += 1
        out.close()


class Crowd:
    """All clients of one daemon. `ports_file()` is that of the daemon that runs now."""

    def __init__(self, binaries, ports_file, folder, scene, hostile):
        def python(kind):
            return lambda: [sys.executable, str(HERE / "clients.py"), kind, ports_file(), binaries]

        def aprsim(*words):
            return lambda: [os.path.join(binaries, "aprsim"), "--ports-file", ports_file(), *words]

        self.controller = Controller(scene, ports_file, folder)
        self.observers = [
            Client("watch", aprsim("watch", "--json"), folder),
            Client("events", aprsim("events", "--json"), folder),
            *(Client(kind, python(kind), folder)
              for kind in ("web", "slow-web", "modbus", "vision", "cameras", "crcl")),
        ]
        self.hostile = [Client("hostile", python("hostile"), folder)] if hostile else []

    @property
    def all(self):
        return [self.controller, *self.observers, *self.hostile]

    def start(self):
        for client in self.all:
            client.start()

    def check(self):
        for client in self.all:
            client.check()

    def kill(self):
        """All of them, because their daemon has gone."""
        for client in self.all:
            if client.process is not None:
                client.kill()
                client.process.wait()

    def stop(self):
        for client in self.all:
            client.stop()

    def faults(self):
        """Each with its client and how often."""
        return [f"{one.name}: {text} ({count})" for one in self.all for text, count in one.faults.items()]

    def restarts(self):
        return sum(client.restarts for client in self.all)
