"""A scene with estimated values, whose base is the scene that they were compared with."""

from __future__ import annotations

import re
from typing import Any, Sequence

import numpy as np
import yaml

from .estimates import Estimate
from .line_fit import Correction
from .scene_values import SceneValues

_INDEXED = re.compile(r"(.+)\[(\d)\]$")
_DIGITS = 6


def overlay_text(
    values: SceneValues, estimates: Sequence[Estimate], corrections: dict[str, Correction]
) -> str:
    """YAML of the scene. Only values that the data tell, and that differ from the scene's, are in it."""
    tree: dict[str, Any] = {"base": values.base()}
    for one in estimates:
        if one.is_told and one.key and not _is_known(one):
            _set(tree, values, one)
    for name, correction in corrections.items():
        told = [one for one in estimates if one.name.startswith(f"robots.{name}.vision.bias_")]
        if all(one.is_told for one in told) and any(one.low > 0 or one.high < 0 for one in told):
            vision = _named(tree, "robots", name).setdefault("vision", {})
            vision["calibration"] = _calibration(values, name, correction)
    _complete_relaxation(tree)
    head = "# Written by `aprsim calibrate`: values that recordings tell, over those of the base.\n"
    text: str = yaml.safe_dump(tree, sort_keys=False, default_flow_style=None, width=100)
    return head + text


def _is_known(one: Estimate) -> bool:
    # A relaxation has both of its values or none.
    if "palm_relaxation" in one.key:
        return False
    return one.scene_value is not None and one.contains(one.scene_value)


def _set(tree: dict[str, Any], values: SceneValues, one: Estimate) -> None:
    place, keys = _place(tree, values, one)
    for key in keys[:-1]:
        place = place.setdefault(key, {})
    indexed = _INDEXED.match(keys[-1])
    if indexed is None:
        place[keys[-1]] = _number(one.value)
        return
    name, index = indexed[1], int(indexed[2])
    place.setdefault(name, _vector(values, one, name))[index] = _number(one.value)


def _place(tree: dict[str, Any], values: SceneValues, one: Estimate) -> tuple[dict[str, Any], list[str]]:
    """The map that the keys of an estimate begin in, and the keys."""
    keys = one.key.split(".")
    robot = next((name for name in values.robots() if one.name.startswith(f"robots.{name}.")), None)
    if robot is None:
        return tree, keys
    if keys[0] == "limits":
        kind = str(values.robot(robot).get("type"))
        return tree.setdefault("robot_types", {}).setdefault(kind, {}), keys
    if keys[0] == "gripper":
        where, which = values.gripper_place(robot)
        if where == "tools":
            return _named(tree, "tools", which), keys
        return tree.setdefault("robot_types", {}).setdefault(which, {}), keys
    return _named(tree, "robots", robot), keys


def _named(tree: dict[str, Any], where: str, name: str) -> dict[str, Any]:
    """The entry of a list of named things."""
    entries: list[dict[str, Any]] = tree.setdefault(where, [])
    for entry in entries:
        if entry["name"] == name:
            return entry
    entries.append({"name": name})
    return entries[-1]


def _vector(values: SceneValues, one: Estimate, name: str) -> list[float]:
    """The scene's value of a vector, some elements of which the data may not tell."""
    robot = next(name for name in values.robots() if one.name.startswith(f"robots.{name}."))
    now = values.force(robot)
    return [now.get(f"{name}[{i}]", 0.0) for i in range(3)]


def _calibration(values: SceneValues, name: str, correction: Correction) -> list[dict[str, list[float]]]:
    """Four places within the camera's area and where the camera reports them: a bilinear map is exact."""
    low, high = values.vision_area(name)
    corners = np.array([low, [high[0], low[1]], high, [low[0], high[1]]])
    places = 0.5 * (low + high) + 0.8 * (corners - 0.5 * (low + high))
    reported = correction.reported(places)
    return [
        {"at_m": [_number(x) for x in at], "reported_m": [_number(x) for x in seen]}
        for at, seen in zip(places, reported)
    ]


def _complete_relaxation(tree: dict[str, Any]) -> None:
    """A relaxation needs both of its keys; one alone is left out."""
    places = [one for one in tree.get("tools", [])] + list(tree.get("robot_types", {}).values())
    for place in places:
        gripper = place.get("gripper")
        if gripper is None:
            continue
        if len(gripper.get("palm_relaxation", {"share": 0, "time_s": 1})) < 2:
            del gripper["palm_relaxation"]
        if not gripper:
            del place["gripper"]


def _number(value: float) -> float:
    return float(f"{float(value):.{_DIGITS}g}")
