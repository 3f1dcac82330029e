"""NIST's controllers against the daemon, without a display. Each session starts the daemon and a controller, and checks
the result. Called by tests/clients/run."""

import argparse
import contextlib
import math
import os
import pathlib
import re
import shutil
import socket
import subprocess
import sys
import tempfile
import threading
import time

from equipment import (
    BINARIES,
    Cell,
    Driver,
    Failure,
    Framework,
    Gears,
    PHYSICAL,
    SIM,
    Setup,
    framework_home,
    lab_with_tools_as_saved,
)

# On the path that equipment sets.
import running_cell
import tap

# Sessions: name -> (settings, function).
SESSIONS = {}


def session(name, settings):
    def add(function):
        SESSIONS[name] = (settings, function)
        return function

    return add


def pendant(robot):
    """NIST's pendant client's own test of a server."""

    def run(setup):
        cell = Cell(setup, "aprs")
        driver = Driver(
            "crcl.ui.client.PendantDriver", setup,
            {"crcl4java.host": "localhost", "crcl4java.port": cell.ports[f"crcl.{robot}"]},
        )
        driver.require("connect", answer="true")
        driver.send("test")
        driver.ended("test", 300)
        driver.require("disconnect", answer="false")

    return run


for robot in ("fanuc", "motoman"):
    session(f"pendant self-test, {robot}", "default")(pendant(robot))


@session("conveyor panel", "default")
def conveyor(setup):
    """A tray forth and one back, twice."""
    cell = Cell(setup, "aprs")
    driver = Driver("aprsim.PanelDriver", setup)
    driver.require("connect", cell.ports["modbus"], answer="true")
    places = [belt_m(cell)]
    for step in ("next", "previous", "next", "previous"):
        driver.call(step, seconds=90)
        # The panel writes 0 and goes on; the belt needs its ramp.
        running_cell.eventually(lambda: cell.state()["conveyor"].get("speed_m_s", 0.0) == 0, 5, "belt stands")
        places.append(belt_m(cell))
    steps = [b - a for a, b in zip(places, places[1:])]
    if min(map(abs, steps)) < 0.05 or any(a * b > 0 for a, b in zip(steps, steps[1:])):
        raise Failure(f"the belt went {steps} m")


def belt_m(cell):
    return cell.state()["conveyor"].get("travel_m", 0.0)


@session("vision client", "default")
def vision(setup):
    """Both feeds: every line holds what the camera sees."""
    cell = Cell(setup, "aprs")
    for robot in ("fanuc", "motoman"):
        driver = Driver("aprsim.VisionDriver", setup)
        driver.require("connect", cell.ports[f"vision.{robot}"], answer="true")
        counts = [int(word) for word in driver.call("look", 20, seconds=60).split()]
        driver.close()
        if len(counts) != 20 or min(counts) < 8:
            raise Failure(f"lines of {counts} things")


def job(settings, robot, *steps):
    """Action lists one after the other, each with the number of gears in the kits after it."""

    def run(setup):
        framework = Framework(setup, settings, robot)
        for actions, gears in steps:
            framework.run(actions)
            Gears(framework.cell).require(gears)
        framework.cell.require_sound()

    return run


JOBS = {
    "fanuc": (
        ("fanuc_move_one_large_gear", ("fanuc_move_one_large_gear.txt", 1)),
        ("fanuc_demo_actions, reverse_fanuc_demo_actions",
         ("fanuc_demo_actions.txt", 6), ("reverse_fanuc_demo_actions.txt", 0)),
    ),
    "motoman": (
        ("motoman_move_one_large_gear", ("motoman_move_one_large_gear.txt", 1)),
        ("motoman_demo_actions, reverse_motoman_demo_actions",
         ("motoman_demo_actions.txt", 1), ("reverse_motoman_demo_actions.txt", 0)),
    ),
}
for settings, label in ((SIM, "simulated"), (PHYSICAL, "physical")):
    for robot, jobs in JOBS.items():
        for title, *steps in jobs:
            session(f"{title} ({label})", label)(job(settings, robot, *steps))


def tool_of(cell, robot):
    """The name of the tool that is on a robot, or None."""
    state = cell.state()
    number = [each["name"] for each in state["robots"]].index(robot)
    return next((tool["name"] for tool in state["tools"] if tool.get("robot") == number), None)


@session("motoman_demo_actions, reverse_motoman_demo_actions, tools as saved (physical)", "physical")
def motoman_changes_tools(setup):
    """The saved settings have the vacuum cup on the Motoman. For a large gear the framework itself puts the cup into the
    shared holder and takes the big gripper from its own."""
    framework = Framework(setup, PHYSICAL, "motoman", tools_as_saved=True)
    for actions, gears in JOBS["motoman"][1][1:]:
        framework.run(actions)
        Gears(framework.cell).require(gears)
    if tool_of(framework.cell, "motoman") != "big_gripper":
        raise Failure(f"the tool on it is {tool_of(framework.cell, 'motoman')}")
    framework.cell.require_sound()
    setup.remark = " (small_vacuum into its holder, big_gripper taken)"


@session("tool put into both holders and taken again, fanuc_move_one_large_gear (physical)", "physical")
def fanuc_changes_tools(setup):
    framework = Framework(setup, PHYSICAL, "fanuc")
    actions = "".join(f"(drop-tool-by-holder {holder})\n(pickup-tool-by-holder {holder})\n"
                      for holder in ("nearLeftHolder", "farLeftHolder"))
    (framework.home / "example_pddl" / "tool_round.txt").write_text(actions + "(end-program)\n", encoding="utf-8")
    framework.run("tool_round.txt")
    if tool_of(framework.cell, "fanuc") != "pincher":
        raise Failure(f"the tool on it is {tool_of(framework.cell, 'fanuc')}")
    framework.run("fanuc_move_one_large_gear.txt")
    Gears(framework.cell).require(1)
    framework.cell.require_sound()


# Recorded programs of the laboratory with a guard that must trigger on a touch. The touched stack of parts (at X -180 or
# -300, Y 810 of the Motoman) is in no published layout, and in none of our scenes.
NOTHING_TO_TOUCH = (
    *("motomanStackMoveBack2", "motomanStackMoveBackRepeat3", "motomanStackMoveRepeat3"),
    *("simMotomanStackMove", "simMotomanStackMove2"),
)
PROGRAMS = (
    *("fanucStackMoveBackRepeat3", "fanucStackMoveRepeat3", "fanucTestForceSensorProgram"),
    *("fanucTestForceSensorProgram2", "motomanStackMove", "motomanStackMoveBack", "motomanStackMoveBack2"),
    *("motomanStackMoveBackRepeat3", "motomanStackMoveRepeat3", "motomanTestForceSensorProgram"),
    *(f"motomanTestForceSensorProgram{number}" for number in (2, 3, 4)),
    *("simMotomanStackMove", "simMotomanStackMove2", "simMotomanStackMoveRepeat3"),
    *("simMotomanTestForceSensorProgram", "simMotomanTestForceSensorProgramSlow"),
)


def program(name):
    """A recorded program in the pendant client, in the laboratory's scene, at five times its pace. The client allows a move
    90 s; that of the slow program takes 900, 90 mm at 0.1 mm/s."""

    def run(setup):
        cell = Cell(setup, "aprs_lab", "--speed", "20" if name.endswith("Slow") else "5")
        robot = "fanuc" if name.startswith("fanuc") else "motoman"
        driver = Driver(
            "crcl.ui.client.PendantDriver", setup,
            {"crcl4java.host": "localhost", "crcl4java.port": cell.ports[f"crcl.{robot}"]},
        )
        driver.require("connect", answer="true")
        driver.send("program", setup.framework / "CRCLPrograms" / f"{name}.xml")
        end = driver.expect("program ended", 400)
        if name in NOTHING_TO_TOUCH:
            if "required trigger not seen" not in end:
                raise Failure(f"{end}, although there is nothing to touch")
            setup.remark = " (as far as where it must touch a stack that is not there)"
        elif not end.startswith("true"):
            raise Failure(end)

    return run


for name in PROGRAMS:
    session(f"pendant program {name}", "aprs_lab")(program(name))


def at_move(cell, number):
    """An event that is set 0.15 s after the client has sent its MoveTo of that number."""
    event, sent = threading.Event(), 0

    def listen(chunk):
        nonlocal sent
        if chunk.from_client and chunk.data:
            for _ in range(tap.command_types(chunk.data).count("MoveTo")):
                sent += 1
                if sent == number:
                    threading.Timer(0.15, event.set).start()

    cell.tap.listeners.append(listen)
    return event


ONE_GEAR = "fanuc_move_one_large_gear.txt"
# Which MoveTo of that job it is; straight down to the gear, across with it, straight down with it.
TAKE, CARRY, PLACE = 3, 5, 6


def interrupted(what, move):
    """The job of one gear, interrupted in that move, then begun again: the gear is in a kit."""

    def run(setup):
        framework = Framework(setup, SIM, "fanuc")
        moment = at_move(framework.cell, move)
        framework.start(ONE_GEAR)
        if not moment.wait(60 * running_cell.PATIENCE):
            raise Failure(f"no move number {move} within {60 * running_cell.PATIENCE:g} s")
        if what(framework):
            framework.run(ONE_GEAR, 90)
        Gears(framework.cell).require(1)
        # A job that restarts with a gear in the gripper opens it high above the table: that gear falls.
        framework.cell.require_sound()

    return run


def pause(framework):
    """Pauses for a second and resumes. The newest published client counts its own StopMotion as a change of connection
    and gives up after it has sent the move again, with any server."""
    driver = framework.driver
    driver.require("pause", answer="done")
    before = framework.cell.state()["robots"][0]["tool_in_reference"]["position_m"]
    time.sleep(1)
    after = framework.cell.state()["robots"][0]["tool_in_reference"]["position_m"]
    if math.dist([*before.values()], [*after.values()]) > 0.02:
        raise Failure("it goes on while it is paused")
    driver.require("resume", answer="done")
    end = driver.expect("start ended", 60)
    if end.startswith("true"):
        return False
    if "connectChangeCount" not in end:
        raise Failure(end)
    begin_anew(driver)
    return True


def begin_anew(driver):
    """Resets and resumes after the framework has reported all its errors, which takes a while."""
    seen, since = None, time.monotonic()
    while time.monotonic() - since < 1.5:
        state = driver.call("state")
        if state != seen:
            seen, since = state, time.monotonic()
        time.sleep(0.1)
    driver.require("reset", answer="done")
    driver.require("resume", answer="done")


def abort(framework):
    driver = framework.driver
    driver.require("abort", answer="done")
    # The framework does not always end what it has given up.
    with contextlib.suppress(Failure):
        driver.expect("start ended", 8)
    begin_anew(driver)
    return True


def safe_abort(framework):
    """Ends the job where it can be left, with the gear in a slot or before it is taken, and disconnects, as the
    supervisor does before another robot takes over."""
    framework.driver.require("safe-abort", answer="done", seconds=90)
    framework.connect()
    return not any(Gears(framework.cell).kits.values())


def reconnect(framework):
    """Aborts, disconnects from the robot and connects again."""
    abort(framework)
    framework.driver.require("disconnect", answer="false")
    framework.connect()
    return True


def vanish(framework):
    """The whole framework dies and is started anew, with the robot in motion."""
    framework.driver.process.kill()
    framework.open()
    return True


for words, number in (("on the way to a gear", TAKE), ("with a gear", CARRY), ("while placing", PLACE)):
    session(f"paused {words}, then again", "simulated")(interrupted(pause, number))
    session(f"aborted {words}, then again", "simulated")(interrupted(abort, number))
session("gone and back on the way to a gear", "simulated")(interrupted(vanish, TAKE))
session("safely aborted on the way to a gear, then again", "simulated")(interrupted(safe_abort, TAKE))
session("safely aborted with a gear, then again", "simulated")(interrupted(safe_abort, CARRY))
session("disconnected on the way to a gear, then again", "simulated")(interrupted(reconnect, TAKE))


CYCLES = 10
KITS = {"motoman": "kit_s2l2", "fanuc": "kit_m2l1"}


def supervisor_driver(setup, settings, setup_file, maps):
    """The driver of the supervisor with both systems, and the folder of its settings."""
    home = framework_home(setup, setup.cell.ports)
    folder = home / "example_settings" / settings
    driver = Driver("aprsim.SupervisorDriver", setup, home=home / "netbeans_run_user_home")
    driver.require("open", folder / setup_file, folder / maps, folder / "teachProps.txt", answer="done", seconds=120)
    return driver, folder


class Fillings:
    """Counts how often the kits of each robot have been filled; update about every second."""

    def __init__(self, cell):
        self.cell = cell
        self.filled = dict.fromkeys(KITS, False)
        self.counts = dict.fromkeys(KITS, 0)

    def look(self):
        kits = Gears(self.cell).kits
        for robot, kit in KITS.items():
            filled = any(found for (tray, _), found in kits.items() if tray.startswith(kit))
            self.counts[robot] += filled and not self.filled[robot]
            self.filled[robot] = filled


class TeachTable:
    """The teach table's camera of the physical settings, at their port: sends the objects of a layout."""

    def __init__(self, setup, layout):
        rows = layout.read_text(encoding="utf-8").splitlines()[1:]
        self.line = (",".join(row.strip() for row in rows if row.strip()) + ",\n").encode()
        self.listener = socket.create_server(("127.0.0.1", 6000))
        self.closed = threading.Event()
        setup.open.callback(self.close)
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self):
        with contextlib.suppress(OSError):
            while True:
                threading.Thread(target=self._serve, args=(self.listener.accept()[0],), daemon=True).start()

    def _serve(self, client):
        with client, contextlib.suppress(OSError):
            while not self.closed.wait(0.5):
                client.sendall(self.line)

    def close(self):
        self.closed.set()
        self.listener.close()


def cycles(setup, driver):
    """Ten times kits filled and emptied, both robots at once. (The supervisor's test with robots disabled at random needs
    robots that have one frame with the simulated settings: see protocols/CONTROLLERS.md.)"""
    # It begins with emptying, and counts that.
    driver.send("cycles", CYCLES + 1)
    fillings = Fillings(setup.cell)
    driver.ended("cycles", 240 * CYCLES, meanwhile=fillings.look)
    setup.remark = f" (kits filled and emptied: {fillings.counts['fanuc']} and {fillings.counts['motoman']} times)"
    if min(fillings.counts.values()) < CYCLES:
        raise Failure(f"kits filled only {fillings.counts} times")
    Gears(setup.cell).require(0)
    setup.cell.require_sound()


LAYOUT = "teach_objects_one_gear_each.csv"


@session("supervisor, both robots (simulated)", "simulated")
def supervisor(setup):
    Cell(setup, "aprs")
    driver, folder = supervisor_driver(setup, SIM, "multisim9.csv", "posmaps.csv")
    # In the layout that comes up first the kits want nothing that is in the cell.
    driver.require("teach", folder / LAYOUT, answer="done")
    cycles(setup, driver)


@session("supervisor, both robots, tools as saved (physical)", "physical")
def supervisor_with_tools(setup):
    """The Motoman changes its tool while the supervisor keeps the Fanuc aside."""
    TeachTable(setup, setup.framework / "example_settings" / SIM / LAYOUT)
    cell = Cell(setup, lab_with_tools_as_saved(setup.folder), "--set", "vision.empty_slots=true")
    driver, _ = supervisor_driver(setup, PHYSICAL, "fanucmotoman.csv", "posmapfiles.csv")
    cycles(setup, driver)
    if tool_of(cell, "motoman") != "big_gripper":
        raise Failure(f"the tool on the Motoman is {tool_of(cell, 'motoman')}")


VIRTUAL_RUNS = 20
# Jobs of the pendant in virtual time: its self-test, or a program that ends.
VIRTUAL = {
    "fanuc": (("aprs", "test"), ("aprs_lab", "fanucStackMoveRepeat3")),
    "motoman": (("aprs", "test"), ("aprs_lab", "motomanStackMove")),
}


def in_virtual_time(robot, scene, job):
    """The pendant's polls are the clock. The same job runs repeatedly in a cell that is reset in between; every run ends in
    the same state, to the bit."""

    def run(setup):
        cell = Cell(setup, scene, "--time", "virtual", "--pacers", f"crcl.{robot}")
        ends = set()
        for _ in range(VIRTUAL_RUNS):
            wait_for_place(cell, robot)
            aprsim = [os.path.join(BINARIES, "aprsim"), "--ports-file", cell.daemon.ports_file]
            subprocess.run([*aprsim, "reset", "--seed", "1"], check=True, stdout=subprocess.DEVNULL)
            # The client must be used from the thread that used it first.
            driver = Driver(
                "crcl.ui.client.PendantDriver", setup,
                {"crcl4java.host": "localhost", "crcl4java.port": cell.ports[f"crcl.{robot}"]},
            )
            driver.require("connect", answer="true")
            if job == "test":
                driver.send("test")
            else:
                driver.send("program", setup.framework / "CRCLPrograms" / f"{job}.xml")
            driver.ended("test" if job == "test" else "program", 400)
            state = cell.state()
            ends.add((state["step"], state["state_hash"]))
            if not state["virtual_time"].get("reproducible"):
                raise Failure(f"the wall clock has decided something: {state['virtual_time']}")
            driver.require("disconnect", answer="false")
            driver.close()
        if len(ends) != 1:
            raise Failure(f"{VIRTUAL_RUNS} runs end in {len(ends)} states: {sorted(ends)}")
        setup.remark = f" ({VIRTUAL_RUNS} runs end in step {state['step']}, state {state['state_hash']})"

    return run


def wait_for_place(cell, robot, seconds=30):
    """Waits until the previous client has left."""
    deadline = time.monotonic() + seconds
    while f"crcl.{robot}" not in cell.state()["virtual_time"].get("awaited", []):
        if time.monotonic() > deadline:
            raise Failure("the connection that was closed has not ended")
        time.sleep(0.05)


for robot, jobs in VIRTUAL.items():
    for scene, job in jobs:
        what = "self-test" if job == "test" else f"program {job}"
        session(f"pendant {what} in virtual time, {robot}", scene)(in_virtual_time(robot, scene, job))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--framework", required=True)
    parser.add_argument("--classpath", required=True)
    parser.add_argument("--keep", help="folder for logs and recordings, instead of one that goes")
    parser.add_argument("--list", action="store_true")
    parser.add_argument("names", nargs="*", help="only sessions whose name has one of these words")
    options = parser.parse_args()
    chosen = [name for name in SESSIONS if not options.names or any(word in name for word in options.names)]
    if options.list or not chosen:
        print("\n".join(SESSIONS))
        return 0 if options.list else 2
    folder = pathlib.Path(options.keep or tempfile.mkdtemp(prefix="aprsim-clients-")).resolve()
    setup = Setup(options.framework, options.classpath)
    failed = 0
    print("| job | settings | result | time [s] | edits |\n|---|---|---|---|---|", flush=True)
    for name in chosen:
        settings, function = SESSIONS[name]
        with setup.begin(folder / re.sub(r"\W+", "-", name).strip("-")):
            began = time.monotonic()
            try:
                function(setup)
                setup.cell.keep(name)
                result = "done" + setup.remark
            except Failure as failure:
                result = f"failed: {failure}"
                failed += 1
                pace = setup.cell and setup.cell.slowest_pace()
                if pace is not None:
                    result += f" (on a busy machine, which reached {pace:.2f} of the pace)"
            seconds = time.monotonic() - began
        print(f"| {name} | {settings} | {result} | {seconds:.0f} | {'; '.join(setup.edits) or 'none'} |", flush=True)
    if failed or options.keep:
        print(f"logs: {folder}")
    else:
        shutil.rmtree(folder)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
