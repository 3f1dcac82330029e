"""Parts of sessions with NIST's controllers: drivers of the controllers, the daemon with a tap on its wires, the
framework with its settings, and the positions of the gears."""

import contextlib
import json
import math
import os
import pathlib
import queue
import re
import shutil
import subprocess
import sys
import threading
import time

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
BINARIES = os.environ.get("APRSIM_BIN_DIR", str(ROOT / "build" / "release" / "bin"))
for folder in (HERE, ROOT / "tests" / "integration" / "kitting", ROOT / "clients" / "kitting"):
    sys.path.insert(0, str(folder))

import cell as kitting_cell  # noqa: E402
import running_cell  # noqa: E402
import tap  # noqa: E402


class Failure(Exception):
    """An expectation of a session that was not met."""


class Driver:
    """One of the Java drivers of this folder: commands in, lines that begin with "@ " out."""

    def __init__(self, main, setup, properties=None, home=None):
        self.log = open(setup.folder / f"{main.split('.')[-1]}.log", "w", encoding="utf-8")
        temporary = setup.folder / "tmp"
        temporary.mkdir(exist_ok=True)
        options = {"java.awt.headless": "true", "user.home": str(home or setup.folder),
                   "java.io.tmpdir": str(temporary), **(properties or {})}
        self.process = subprocess.Popen(
            ["java", "-Xmx2g", *(f"-D{key}={value}" for key, value in options.items()),
             "-cp", setup.classpath, main],
            cwd=home or setup.folder,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
        )
        setup.open.callback(self.close)
        self.answers = queue.Queue()
        threading.Thread(target=self._read, daemon=True).start()
        self.expect("ready", 60)

    def _read(self):
        for line in self.process.stdout:
            self.log.write(f"{time.monotonic():.3f} {line}")
            self.log.flush()
            if line.startswith("@ "):
                self.answers.put(line[2:].strip())
        self.answers.put(None)

    def send(self, *words):
        self.process.stdin.write(" ".join(str(word) for word in words) + "\n")
        self.process.stdin.flush()

    def expect(self, start, seconds, meanwhile=None):
        """The next answer with this beginning; earlier ones are skipped. `meanwhile` is called about every second. The
        factor APRSIM_PATIENCE extends the time on a busy machine."""
        seconds *= running_cell.PATIENCE
        deadline = time.monotonic() + seconds
        while True:
            left = max(0.0, deadline - time.monotonic())
            try:
                answer = self.answers.get(timeout=min(left, 1.0) if meanwhile else left)
            except queue.Empty:
                if meanwhile and time.monotonic() < deadline:
                    meanwhile()
                    continue
                raise Failure(f"no answer '{start}' within {seconds:g} s") from None
            if answer is None:
                raise Failure(f"the controller ended before '{start}'")
            if answer.startswith(start):
                return answer[len(start):].strip()

    def call(self, *words, seconds=60):
        """Sends a command and returns its answer."""
        self.send(*words)
        got = self.expect(words[0], seconds)
        if got.startswith("failed"):
            raise Failure(f"{' '.join(map(str, words))}: {got}")
        return got

    def require(self, *words, answer, seconds=60):
        got = self.call(*words, seconds=seconds)
        if not got.startswith(answer):
            raise Failure(f"{' '.join(map(str, words))}: {got}")

    def ended(self, what, seconds=300, meanwhile=None):
        """Waits for the end of a started command; fails if it did not succeed."""
        got = self.expect(f"{what} ended", seconds, meanwhile)
        if not got.startswith("true"):
            raise Failure(got)

    def close(self):
        if self.process.poll() is None:
            try:
                self.send("quit")
                self.process.wait(10)
            except (OSError, subprocess.TimeoutExpired):
                self.process.kill()
                self.process.wait()
        self.log.close()


class Setup:
    """The framework's folder and the class path of all sessions; the folder, the cell, the edits and the open resources
    of the present session."""

    def __init__(self, framework, classpath):
        self.framework = pathlib.Path(framework).resolve()
        self.classpath = classpath

    def begin(self, folder):
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        self.folder = folder
        self.cell = None
        self.edits = []
        self.remark = ""
        self.open = contextlib.ExitStack()
        return self.open


class Cell:
    """The daemon with a tap in front of it."""

    def __init__(self, setup, scene, *options):
        self.options = ["--scene", scene, *options]
        self.daemon = running_cell.Daemon(BINARIES, *self.options, "--no-web")
        setup.cell = self
        setup.open.callback(self.close)
        self.tap = tap.Tap({name: port for name, port in self.daemon.ports.items()
                            if name.split(".")[0] in ("crcl", "vision", "modbus")})
        self.ports = self.tap.ports
        self.began = running_cell.snapshot(self.daemon)
        self.setup = setup

    def state(self):
        return running_cell.snapshot(self.daemon)

    def require_sound(self):
        """Fails if anything fell, a robot has stopped, or physics has reported a fault."""
        state = self.state()
        before = {body["name"]: _mm(body["body_in_world"]) for body in self.began["bodies"]}
        wrong = [f"{robot['name']}: protective stop" for robot in state["robots"] if robot["protective_stop"]]
        wrong += [f"{body['name']} fell" for body in state["bodies"]
                  if _mm(body["body_in_world"])[2] < before[body["name"]][2] - 25]
        wrong += [text for text in (state["world_fault"],) if text]
        if int(state["physics_faults"]):
            wrong.append(f"{state['physics_faults']} physics faults")
        if wrong:
            raise Failure("; ".join(wrong))

    def keep(self, session):
        """Writes the input of record.py into the session's folder: the exchange, the daemon's options, and the positions of
        tools, moved gears and belt."""
        state = self.state()
        before = {body["name"]: body for body in self.began["bodies"]}
        end = {
            "session": session,
            "options": self.options,
            "tools_mm": {robot["name"]: _mm(robot["tool_in_reference"]) for robot in state["robots"]},
            "gears_mm": {
                body["name"]: _mm(body["body_in_world"])
                for body in state["bodies"]
                if body["type"].endswith("_gear")
                and math.dist(_mm(body["body_in_world"]), _mm(before[body["name"]]["body_in_world"])) > 1
            },
            "belt_m": state.get("conveyor", {}).get("travel_m"),
        }
        (self.setup.folder / "end.json").write_text(json.dumps(end, indent=1), encoding="utf-8")
        tap.save(self.tap, self.setup.folder / "exchange.jsonl")

    def slowest_pace(self):
        """The least share of the requested pace in the daemon's log; None if it kept the pace."""
        paces = re.findall(r"the pace is ([0-9.]+) instead of ([0-9.]+)", self.daemon.log_text())
        return min((float(pace) / float(wanted) for pace, wanted in paces), default=None)

    def close(self):
        log = self.daemon.log_text()
        (self.setup.folder / "daemon.log").write_text(log, encoding="utf-8")
        self.tap.close()
        self.daemon.stop()
        self.daemon.close()


def _mm(pose):
    """The position of a pose in a snapshot [mm]."""
    return [1e3 * pose["position_m"].get(axis, 0.0) for axis in "xyz"]


SIM = "multiple_simulated_systems_settings"
PHYSICAL = "fanuc_motoman_multi_system_settings"


def framework_home(setup, ports):
    """A copy of the framework's settings that points its clients at these ports. Nothing else is changed."""
    home = setup.folder / "home"
    for name in ("example_settings", "example_pddl", "netbeans_run_user_home", "linux_netbeans_run_user_home",
                 "CRCLPrograms"):
        shutil.copytree(setup.framework / name, home / name)
    off = {
        "startup.robotcrclsimserver": "false",
        "startup.robotcrclfanucserver": "false",
        "startup.robotcrclmotomanserver": "false",
        "startup.forceTorqueSim": "false",
    }
    for path in (home / "example_settings").rglob("*.txt"):
        robot = "motoman" if "motoman" in str(path.relative_to(home)).replace(PHYSICAL, "") else "fanuc"
        changes = dict(off)
        if path.name.endswith(("object2DViewProperties.txt", "visionToDBProperties.txt")):
            changes |= {"--visionhost": "localhost", "--visionport": str(ports[f"vision.{robot}"])}
            if path.name.endswith("object2DViewProperties.txt"):
                changes["simulated"] = "false"
        if path.name.endswith("crclSwingClientProperties.txt"):
            changes["int port"] = str(ports[f"crcl.{robot}"])
        _set(path, changes)
    return home


def _set(path, changes):
    """Changes the values of keys of a properties file, where it has them. All other bytes stay."""
    lines = path.read_bytes().splitlines(keepends=True)
    for i, line in enumerate(lines):
        key, equals, _ = line.partition(b"=")
        ending = line[len(line.rstrip(b"\r\n")):]
        if equals and key.decode("latin-1") in changes:
            lines[i] = key + b"=" + changes[key.decode("latin-1")].encode() + ending
    path.write_bytes(b"".join(lines))


SYSTEMS = {
    (SIM, "fanuc"): ("simulated_fanuc/simulated_fanuc_properties.txt", "Sim_Fanuc", "pincher"),
    (SIM, "motoman"): ("simulated_motoman/simulated_motoman_props.txt", "Sim_Motoman", "big_gripper"),
    (PHYSICAL, "fanuc"): ("fanuc/aprs_fanuc_settings.txt", "Fanuc", "pincher"),
    (PHYSICAL, "motoman"): ("motoman/motoman_aprs_settings.txt", "Motoman", "big_gripper"),
}


# Places of the tools of aprs_lab in the saved physical settings: see protocols/CONTROLLERS.md.
AS_SAVED = (
    ("    bar_m: [0.03, 0.1, 0.02]\n    tool: small_vacuum\n", "    bar_m: [0.03, 0.1, 0.02]\n"),
    ("    bars_yaw_deg: -127.28\n", "    bars_yaw_deg: -127.28\n    tool: big_gripper\n"),
    ("    tool: big_gripper\n    vision:\n", "    tool: small_vacuum\n    vision:\n"),
)


def lab_with_tools_as_saved(folder):
    """A copy of the scene aprs_lab with the vacuum cup on the Motoman."""
    scenes = ROOT / "world" / "scenes"
    text = (scenes / "aprs_lab.yaml").read_text(encoding="utf-8")
    for old, new in AS_SAVED:
        if text.count(old) != 1:
            raise RuntimeError(f"aprs_lab has changed: not one '{old}'")
        text = text.replace(old, new)
    path = folder / "aprs_lab_as_saved.yaml"
    path.write_text(text.replace("[types/", f"[{scenes}/types/").replace(", types/", f", {scenes}/types/"), encoding="utf-8")
    return str(path)


class Framework:
    """One system of the framework, with its robot connected."""

    def __init__(self, setup, settings, robot, tools_as_saved=False):
        self.robot = robot
        scene, options = "aprs", []
        if settings == PHYSICAL:
            scene = lab_with_tools_as_saved(setup.folder) if tools_as_saved else "aprs_lab"
            options = ["--set", "vision.empty_slots=true"]
        self.cell = Cell(setup, scene, *options)
        self.home = framework_home(setup, self.cell.ports)
        path, self.name, tool = SYSTEMS[settings, robot]
        self.file = self.home / "example_settings" / settings / path
        chosen = self.selected_tool(self.file)
        self.tool = None if chosen == tool or tools_as_saved else tool
        if self.tool:
            setup.remark = f" (tool {tool} chosen in its menu, was {chosen})"
        self.setup = setup
        self.open()

    def open(self):
        # Standalone: without a supervisor that clears the way to the tools' holders.
        self.driver = Driver("aprsim.FrameworkDriver", self.setup, {"aprs.standalone": "true"},
                             self.home / "netbeans_run_user_home")
        self.driver.call("open", self.file, seconds=120)
        if self.tool:
            self.driver.require("tool", self.tool, answer="done")
        self.connect()

    @staticmethod
    def selected_tool(properties):
        found = list(properties.parent.glob("*selectedToolName.txt"))
        return found[0].read_text(encoding="utf-8").strip() if found else None

    def connect(self):
        self.driver.require("connect", self.name, self.cell.ports["crcl." + self.robot], answer="true")

    def start(self, actions):
        self.driver.send("start", self.home / "example_pddl" / actions)

    def run(self, actions, seconds=300):
        self.start(actions)
        self.driver.ended("start", seconds)


KITTING_CELL = kitting_cell.read_cell("aprs")


class Gears:
    """The gears in the kits: {(tray, slot): (type, distance from the slot's centre [mm])}."""

    def __init__(self, cell):
        self.kits = {
            (tray, slot): found
            for tray, slots in running_cell.filled_slots(cell.state(), KITTING_CELL).items()
            for slot, found in slots.items()
        }

    def require(self, number):
        """Fails unless this number of the kits' slots has a gear of their type, and the others are empty."""
        wrong, right = [], 0
        for (tray, slot), found in self.kits.items():
            if found is None:
                continue
            kind = next(s.part for t in KITTING_CELL.trays.values() if t.name.endswith(tray.rsplit("_", 1)[0])
                        for s in t.slots if s.name == slot)
            right += found[0] == kind
            if found[0] != kind:
                wrong.append(f"{found[0]} in {slot} of {tray}")
        if wrong or right != number:
            raise Failure(f"{right} gears in their kits' slots, {number} expected {'; '.join(wrong)}")
