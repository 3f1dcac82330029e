"""Look for parts: the arm out of the camera's view, then steady frames."""

from __future__ import annotations

from arm import Arm
from geometry import XY
from trays import Scene, associate
from typing import Callable


def look_for_parts(arm: Arm, tools: Callable[[], list[XY]] = lambda: [], timeout_s: float = 30.0) -> Scene:
    """The scene as the robot's camera shows it. `tools`: where tools are that may hold a part.
    Raises LookError when the camera shows nothing steady."""
    arm.go_home()
    sightings = arm.camera.look(timeout_s, give_up=arm.interrupted.is_set)
    scene = associate(sightings, arm.cell, arm.robot.sees, [arm.tool_xy(), *tools()])
    arm.tell(
        "look",
        f"sees {sum(t.type.is_kit for t in scene.trays)} kit trays, "
        f"{sum(not t.type.is_kit for t in scene.trays)} part trays, {len(scene.parts)} parts",
    )
    return scene
