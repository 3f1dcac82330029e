"""For every kind of injected fault: the job that it disturbs, its time and its parameters. The
controller's reaction and the outcome of the job stand in clients/kitting/README.md."""

import json
from dataclasses import dataclass, field

from running_cell import CONTROLLER, ROOT

TABLE = {
    "scene": "aprs",
    "controller": ["--robots", "fanuc", "--no-belt"],
    "remove": ["kit_m2l1_vessel_2"],
    "orders": [{"name": "kit", "tray": "sku_kit_m2l1_vessel",
                "slots": {"lg_1": "sku_part_large_gear"}}],
}
BELT = {
    "scene": "aprs",
    "controller": ["--robots", "motoman"],
    "remove": ["small_gear_vessel_1", "small_gear_vessel_2", "kit_s2l2_vessel_2"],
    "supply": [{"name": "coming", "type": "sku_small_gear_vessel", "xy_m": [-0.42, -0.45],
                "gears": ["slot_1", "slot_2"]}],
    "orders": [{"name": "kit", "tray": "sku_kit_s2l2_vessel",
                "slots": {"sg_1": "sku_part_small_gear"}}],
}
# The belt stops when a tray has come into a photo-eye before the Motoman, and a little farther.
EYE = {**BELT, "scene": "eye.yaml", "cell": "eye.toml",
       "supply": [{**BELT["supply"][0], "xy_m": [-0.55, -0.45]}]}
# A belt that goes twice as far takes the kit along.
FAR_KIT = {**BELT, "remove": [*BELT["remove"][:2], "kit_s2l2_vessel_1"]}
ONE_GEAR = {**TABLE, "remove": ["kit_m2l1_vessel_2", "part_large_gear_2"]}
JOBS = {"table": TABLE, "one_gear": ONE_GEAR, "belt": BELT, "eye": EYE, "far_kit": FAR_KIT}


@dataclass(frozen=True)
class Fault:
    """When it strikes in which job, and the two runs: with all reactions, and blind."""

    target: str | None = None
    job: str = "table"
    when: str | None = None
    at_s: float | None = None
    for_s: float | None = None
    params: dict = field(default_factory=dict)
    limit_s: float = 70
    blind_limit_s: float = 30
    seed: int = 1
    expect: dict = field(default_factory=dict)
    options: tuple = ()  # of the controller, in both runs
    blind_options: tuple = ()
    wall: bool = False  # it delays by the wall's clock, so time is that


GRASP = "grasp:fanuc"
PLANNED_S = 2.3  # it has looked, and has not yet closed its gripper
PATIENT = ("--patience", "60")
BY_TIME, BY_EYE = ("--belt-by", "time"), ("--belt-by", "eye")

FAULTS = {
    "robot-breakdown": Fault("fanuc", when=GRASP, for_s=5),
    "robot-slow": Fault("fanuc", at_s=PLANNED_S, for_s=25, params={"share": 0},
                        options=("--move-limit", "10")),
    "joint-weak": Fault("fanuc:2", when=GRASP, for_s=5, params={"share": 0.02}),
    "joint-backlash": Fault("fanuc:1", at_s=0, for_s=15, params={"width": 0.1}),
    "encoder-bias": Fault("fanuc:1", at_s=0, for_s=12, params={"angle": 0.05}),
    "drive-fault": Fault("fanuc:3", when=GRASP, for_s=3),
    "protective-stop": Fault("fanuc", when=GRASP),
    "robot-emergency-stop": Fault("fanuc", when=GRASP, for_s=3),
    "cell-emergency-stop": Fault(when=GRASP, for_s=3),
    "controller-reboot": Fault("fanuc", when=GRASP, for_s=3),
    "base-offset": Fault("fanuc", at_s=0, for_s=12, params={"x": 0.03}),
    "tool-offset": Fault("fanuc", at_s=0, for_s=12, params={"x": 0.03}),
    "gripper-pressure-loss": Fault("fanuc", at_s=0, for_s=12, params={"share": 0}),
    "gripper-leak": Fault("fanuc", when=GRASP, for_s=8, params={"over": 0.5}),
    "gripper-stuck-open": Fault("fanuc", at_s=0, for_s=12),
    "gripper-stuck-closed": Fault("fanuc", at_s=0, for_s=12),
    "gripper-slow-finger": Fault("fanuc", at_s=0, for_s=15, params={"share": 0.01}),
    "gripper-worn-pads": Fault("fanuc", at_s=0, for_s=12, params={"share": 0}),
    "gripper-drops": Fault("fanuc", when=GRASP, for_s=5, params={"after": 0.7},
                           expect={"parts_lost": {"max": 1}}),
    "belt-jam": Fault(job="belt", at_s=0, for_s=15, blind_options=BY_TIME),
    "belt-slip": Fault(job="belt", at_s=0, params={"share": 0.4}),
    "belt-wrong-speed": Fault(job="belt", at_s=0, params={"factor": 0.4}, blind_options=BY_TIME),
    "belt-wrong-direction": Fault(job="belt", at_s=0, for_s=12),
    "belt-encoder-frozen": Fault(job="belt", at_s=0),
    "photo-eye-stuck-on": Fault("upstream", job="eye", at_s=0, options=BY_EYE),
    "photo-eye-stuck-off": Fault("upstream", job="eye", at_s=0, options=BY_EYE),
    "part-missing": Fault("part_large_gear_2", at_s=PLANNED_S),
    "part-swapped": Fault("part_large_gear_2:part_medium_gear_1", at_s=PLANNED_S),
    "part-misplaced": Fault("part_large_gear_2", at_s=PLANNED_S, params={"x": -0.02}),
    "part-upside-down": Fault("part_large_gear_2", at_s=PLANNED_S),
    "part-stray": Fault("part_medium_gear_1", when=GRASP,
                        params={"x": 0.127, "y": -1.206, "z": 0.935}),
    "part-faulty": Fault("part_large_gear_2", when=GRASP),
    "tray-shifted": Fault("kit_m2l1_vessel_1", when=GRASP, params={"x": 0.012}),
    "tray-jammed": Fault("coming", job="belt", at_s=0, for_s=4.5, params={"distance": 1.87}),
    "foreign-object": Fault(at_s=0, for_s=15, params={"x": 0.135, "y": -1.245, "z": 1.2,
                                                      "width": 0.4, "depth": 0.4}),
    "camera-outage": Fault("fanuc", at_s=0, for_s=32, options=PATIENT, blind_limit_s=80),
    "camera-frozen": Fault("motoman", job="belt", at_s=1.5, for_s=40, options=PATIENT),
    "camera-late": Fault("motoman", job="belt", at_s=0, params={"delay": 4}),
    "camera-loses-part": Fault("fanuc:kit_m2l1_vessel_1", at_s=0, for_s=12),
    "camera-ghost": Fault("fanuc:part_large_gear_1", job="one_gear", at_s=0,
                          params={"x": 0.465, "y": -0.105}),
    "camera-bias": Fault("fanuc", at_s=0, for_s=12, params={"x": 0.03}),
    "camera-scale": Fault("fanuc", at_s=0, for_s=12, params={"factor": 1.1}),
    "camera-swaps-labels": Fault("part_large_gear_2:part_medium_gear_1", at_s=0),
    # A seed in which the first frame has it turned.
    "camera-flips-trays": Fault("fanuc", at_s=0, params={"rate": 0.3}, seed=5),
    "curtain-broken": Fault(when=GRASP, for_s=5, expect={"moved_in_curtain_s": {"max": 0.5}}),
    "crcl-drop": Fault("fanuc", when=GRASP),
    "crcl-half-document": Fault("fanuc", when=GRASP, for_s=1),
    "crcl-late-status": Fault("fanuc", when=GRASP, for_s=2, params={"delay": 6}, wall=True),
    "crcl-old-status": Fault("fanuc", at_s=1, for_s=8),
    "crcl-slow": Fault("fanuc", when=GRASP, for_s=2, params={"delay": 6}, wall=True),
    "modbus-exceptions": Fault(job="belt", at_s=0, for_s=12),
    "modbus-delay": Fault(job="belt", at_s=0, for_s=12, params={"delay": 4}, wall=True),
    "modbus-silent": Fault(job="belt", at_s=0, for_s=5),
    "modbus-stray": Fault(job="far_kit", at_s=0),
    "modbus-refused": Fault(job="belt", at_s=0, for_s=12),
}


def write_scenario(folder, kind, *, blind=False, struck=True):
    """Writes the job of a kind of fault as a scenario file, with the fault or without."""
    fault = FAULTS[kind]
    job = dict(JOBS[fault.job])
    job["controller"] = [*job["controller"], *fault.options]
    if blind:
        job["controller"] += ["--blind", *fault.blind_options]
    if job["scene"] == "eye.yaml":
        _write_eye(folder)
        job.update(scene=str(folder / "eye.yaml"), cell=str(folder / "eye.toml"))
    if struck:
        entry = {"name": "it", "kind": kind, "target": fault.target, "when": fault.when,
                 "at_s": fault.at_s, "for_s": fault.for_s, "with": fault.params}
        job["faults"] = [{key: value for key, value in entry.items() if value not in (None, {})}]
    path = folder / "fault.yaml"
    path.write_text(json.dumps({
        "description": f"{kind}, and how the controller takes it",
        **job,
        "stop": {"time_limit_s": fault.blind_limit_s if blind else fault.limit_s},
        "expect": {"kits_right": 1, "parts_lost": 0, **fault.expect},
    }))
    return path


def _write_eye(folder):
    """The scene aprs with its upstream photo-eye at the Motoman, and what the controller has to know
    of that."""
    scenes = ROOT / "world" / "scenes"
    text = (scenes / "aprs.yaml").read_text()
    for old, new in (("name: upstream, x_m: -1,", "name: upstream, x_m: -0.32,"),
                     ("[types/gears_2017.yaml, types/robots.yaml]",
                      f"[{scenes}/types/gears_2017.yaml, {scenes}/types/robots.yaml]")):
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    (folder / "eye.yaml").write_text(text)
    cells = CONTROLLER / "cells"
    text = (cells / "aprs.toml").read_text()
    for old, new in (('parts = "', f'parts = "{cells}/'),
                     ('calibration = "', f'calibration = "{cells}/'),
                     ("step_mm = 225\n", "step_mm = 225\neye = 1\neye_to_work_mm = 150\n")):
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    (folder / "eye.toml").write_text(text)
