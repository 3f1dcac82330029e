#!/usr/bin/env python3
"""Runs one experiment with --quick and checks what it leaves: results.json, CSV, SVG, summary.

usage: smoke.py PROGRAM NAME SCRATCH_FOLDER
"""
import csv
import json
import math
import pathlib
import shutil
import subprocess
import sys
import xml.etree.ElementTree

HERE = pathlib.Path(__file__).parent


def check(condition, message):
    if not condition:
        raise SystemExit(f"smoke: {message}")


def check_results(experiment, name):
    check(experiment["experiment"] == name and experiment["quick"] is True, "wrong header")
    for key in ("date", "processor", "versions"):
        check(experiment[key], f"no {key}")
    check(experiment["results"], "no results")
    for result in experiment["results"]:
        check(sorted(result) == ["against", "name", "ratio", "unit", "value"], f"keys of {result}")
        check(math.isfinite(result["value"]), f"{result['name']} is not finite")
        check((result["against"] is None) == (result["ratio"] is None), f"half a ratio: {result}")


def check_figures(experiment, name):
    """Every figure that names this experiment is there, unless a library it needs is not installed."""
    recorded = {result["name"]: result for result in experiment["results"]}
    for figure in json.loads((HERE / "figures.json").read_text()):
        absent = "needs" in figure and figure["needs"] not in experiment["versions"]
        if figure["experiment"] == name and not absent and not figure.get("full_run_only"):
            check(figure["name"] in recorded, f"{figure['name']} was not recorded")
            result = recorded[figure["name"]]
            if figure.get("of") == "ratio":
                check(result["ratio"] is not None, f"{figure['name']} has no ratio")
            else:
                check(result["unit"] == figure["unit"], f"unit of {figure['name']}")


def check_files(folder, experiment):
    tables = list(folder.glob("*.csv"))
    check(tables, "no CSV")
    for path in tables:
        rows = list(csv.reader(path.open()))
        check(len(rows) > 1, f"{path.name} is empty")
        check(len({len(row) for row in rows}) == 1, f"{path.name} is not rectangular")
    for plot in experiment["plots"]:
        root = xml.etree.ElementTree.parse(folder / plot).getroot()
        check(root.tag.endswith("svg"), f"{plot} is no SVG")
        lines = [line.get("points", "").split() for line in root.iter() if line.tag.endswith("polyline")]
        check(any(lines), f"{plot} shows nothing")


def main():
    if len(sys.argv) != 4:
        raise SystemExit(__doc__)
    program, name, scratch = sys.argv[1], sys.argv[2], pathlib.Path(sys.argv[3]) / sys.argv[2]
    shutil.rmtree(scratch, ignore_errors=True)
    scratch.mkdir(parents=True)
    subprocess.run([program, "--quick", "--out", str(scratch)], check=True)
    folder = scratch / name
    experiment = json.loads((folder / "results.json").read_text())
    check_results(experiment, name)
    check_figures(experiment, name)
    check_files(folder, experiment)
    subprocess.run([sys.executable, str(HERE / "summary.py"), str(scratch), str(scratch)], check=True)
    text = (scratch / "RESULTS.md").read_text()
    for result in experiment["results"]:
        check(result["name"] in text, f"RESULTS.md lacks {result['name']}")


if __name__ == "__main__":
    main()
