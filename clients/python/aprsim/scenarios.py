"""Whole jobs: `aprsim scenario run` runs a scenario in a daemon of its own, measures it, and compares the
measures with the expected ones. docs/scenarios.md describes scenarios; `scenarios()` lists shipped ones."""

from __future__ import annotations

import json
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Mapping

from .binaries import find_binary
from .child import Child
from .errors import ScenarioError


@dataclass(frozen=True)
class Verdict:
    """A measure and its expected bounds; None = no bound, or an unknown value."""

    measure: str
    value: float | None
    min: float | None
    max: float | None
    kept: bool


@dataclass(frozen=True)
class ScenarioReport:
    """The result of a run."""

    scenario: str
    seed: int
    end_reason: str
    as_expected: bool
    measures: Mapping[str, float]
    """Known measures by name."""
    verdicts: tuple[Verdict, ...]
    everything: Mapping[str, Any]
    """The whole report, as in `report.json`."""


def scenarios(folder: str | Path | None = None) -> dict[str, str]:
    """Names and descriptions of the shipped scenarios."""
    lines = _run([find_binary("aprsim", folder), "scenario", "list", "--json"], None)
    return {line["name"]: line["description"] for line in map(json.loads, lines)}


def run_scenario(
    name: str | Path,
    *,
    seed: int = 1,
    virtual: bool = True,
    speed: float | str | None = None,
    controller: str | None = None,
    report_directory: str | Path | None = None,
    timeout_s: float | None = None,
    folder: str | Path | None = None,
) -> ScenarioReport:
    """Run a scenario by name or file. In virtual time the controller's polls pass the time, and the same
    seed gives the same report; otherwise the cell runs at `speed`, a factor or "max". `controller` is a
    shell command that replaces the kitting controller. A report that misses expectations is a normal
    result. ScenarioError has the text of a program that fails or exceeds `timeout_s`. The run ends when
    this process ends. `folder` is the directory of the program (see `find_binary`)."""
    command = [find_binary("aprsim", folder), "scenario", "run", str(name), "--json"]
    command += ["--seed", str(seed)]
    if speed is not None:
        if virtual:
            raise ScenarioError("speed: a run in virtual time has none; virtual=False is expected")
        command += ["--speed", str(speed)]
    if virtual:
        command.append("--virtual")
    if controller is not None:
        command += ["--controller", controller]
    if report_directory is not None:
        command += ["--report", str(report_directory)]
    lines = _run(command, timeout_s)
    return read_report(json.loads(lines[-1]))


def read_report(report: Mapping[str, Any]) -> ScenarioReport:
    """The report of the object in `report.json`."""
    verdicts = tuple(
        Verdict(entry["measure"], entry["value"], entry["min"], entry["max"], entry["kept"])
        for entry in report["expected"]
    )
    return ScenarioReport(
        scenario=report["scenario"],
        seed=report["seed"],
        end_reason=report["end_reason"],
        as_expected=report["as_expected"],
        measures={name: value for name, value in report["measures"].items() if value is not None},
        verdicts=verdicts,
        everything=report,
    )


def _run(command: list[str], timeout_s: float | None) -> list[str]:
    child = Child(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    try:
        output, errors = (
            text.decode("utf-8", errors="replace")
            for text in child.process.communicate(timeout=timeout_s)
        )
    except subprocess.TimeoutExpired as error:
        raise ScenarioError(f"{' '.join(command)} has not ended within {timeout_s:g} s") from error
    finally:
        child.end()
    lines = [line for line in output.splitlines() if line.startswith("{")]
    code = child.process.returncode
    # The exit code is 1 also for a report that is not as expected.
    if code not in (0, 1) or not lines:
        raise ScenarioError(f"{' '.join(command)}: exit code {code}: {errors.strip()}")
    return lines
