"""Measurements of a daemon for each interval of a soak: memory, handles, pace, placement errors."""

import json
import math
import os
import pathlib
import re
import subprocess
import sys
import time
import urllib.request
from dataclasses import dataclass

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests" / "integration" / "kitting"), str(ROOT / "clients" / "kitting")]

import cell as cells  # noqa: E402
from running_cell import filled_slots  # noqa: E402


@dataclass(frozen=True)
class Sample:
    """The resources of one daemon at one moment."""

    at_s: float  # by the wall clock
    memory_mb: float  # resident and swapped
    recorded_mb: float  # of it, what the daemon keeps of the past, within its shares
    beyond: tuple  # parts that keep more than their shares, in words
    handles: int
    threads: int
    simulated_s: float
    epoch: float
    missed: float
    faults: float  # of physics, and stops of the world
    steps: float


def metrics(daemon, timeout_s):
    """The daemon's metrics by name."""
    with urllib.request.urlopen(f"http://127.0.0.1:{daemon.ports['web']}/metrics", timeout=timeout_s) as answer:
        lines = answer.read().decode("utf-8").splitlines()
    return {name: float(value) for name, _, value in (
        line.rpartition(" ") for line in lines if line and not line.startswith("#"))}


def recordings(told):
    """Megabytes that the daemon keeps of the past, and the parts beyond their shares in words. How much the
    past takes depends on what happened in it, so it comes and goes with the work."""
    used = {name: value / 1e6 for name, value in told.items() if name.startswith("aprsim_memory_used_bytes")}
    beyond = []
    for name, megabytes in used.items():
        share = told.get(name.replace("used", "limit"), math.inf) / 1e6
        if megabytes > 1.01 * share:  # old parts go as soon as new ones exceed the share
            part = name.split('"')[1]
            beyond.append(f"{part} keeps {megabytes:.1f} MB, its share is {share:.1f} MB")
    return math.fsum(used.values()), tuple(beyond)


def take_sample(daemon, timeout_s):
    told = metrics(daemon, timeout_s)
    pid = daemon.process.pid
    status = pathlib.Path(f"/proc/{pid}/status").read_text(encoding="ascii")
    kilobytes = sum(int(re.search(rf"{field}:\s+(\d+)", status).group(1)) for field in ("VmRSS", "VmSwap"))
    return Sample(
        time.monotonic(), kilobytes / 1024, *recordings(told), len(os.listdir(f"/proc/{pid}/fd")),
        int(re.search(r"Threads:\s+(\d+)", status).group(1)), told["aprsim_simulated_seconds"],
        told["aprsim_epoch"], told["aprsim_steps_missed_total"],
        told["aprsim_penetration_faults"] + told["aprsim_world_stops_total"], told["aprsim_step_seconds_count"],
    )


def slope_mb_h(samples):
    """The growth of memory by least squares; None for fewer than three samples. All of it and what lies
    beside the recordings are looked at, and the lesser slope counts: a leak raises both. The one falls
    with recordings that shrink, and the other one with those that grow into memory freed before."""
    if len(samples) < 3:
        return None
    hours = [sample.at_s / 3600 for sample in samples]
    return min(_slope(hours, [sample.memory_mb for sample in samples]),
               _slope(hours, [sample.memory_mb - sample.recorded_mb for sample in samples]))


def _slope(x, y):
    mean_x, mean_y = math.fsum(x) / len(x), math.fsum(y) / len(y)
    spread = math.fsum((each - mean_x) ** 2 for each in x)
    return math.fsum((at - mean_x) * (value - mean_y) for at, value in zip(x, y)) / spread


def pace(before, after):
    """Simulated time by wall time between two samples; None where time began anew."""
    if before is None or before.epoch != after.epoch or after.simulated_s < before.simulated_s:
        return None
    return (after.simulated_s - before.simulated_s) / (after.at_s - before.at_s)


def placement_error_mm(daemon, cell_name, timeout_s):
    """The largest distance of a part at rest from the centre of its slot in a kit; None where no kit has
    a part."""
    done = subprocess.run(
        [os.path.join(daemon.binaries, "aprsim"), "--ports-file", daemon.ports_file, "status", "--json"],
        capture_output=True, text=True, timeout=timeout_s, check=False,
    )
    # 1: the pace is below the one asked for.
    if done.returncode not in (0, 1):
        raise RuntimeError(f"aprsim status: {done.stderr.strip()[-200:]}")
    state = json.loads(done.stdout)
    cell = cells.read_cell(cell_name)
    state["bodies"] = [body for body in state["bodies"] if body["resting"]]
    if not any(body["type"] in cell.gears for body in state["bodies"]):
        return None
    errors = [
        found[1] for kit in filled_slots(state, cell).values() for found in kit.values() if found is not None
    ]
    return max(errors, default=None)
