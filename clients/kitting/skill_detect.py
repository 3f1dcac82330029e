"""Detect parts: move the arm out of the camera's view, then wait for steady frames."""

from __future__ import annotations

from typing import Sequence

from arm import Arm
from geometry import XY, hull, hull_distance
from trays import Scene, associate

SHADE_MM = 250.0  # an arm hides objects nearer than this to its space


def detect_parts(
    arm: Arm, others: Sequence[Arm] = (), *, clear: bool = False, timeout_s: float = 30.0
) -> Scene:
    """The scene in the robot's camera. An empty slot near another arm is unknown. `clear` waits until no
    arm is over the belt and keeps it clear during the detection. Raises DetectionError without steady
    frames."""
    arm.go_home()
    if clear:
        arm.space.acquire(
            arm.name,
            arm.corridor(),
            moves_belt=True,
            give_up=arm.interrupted.is_set,
            poll=arm.crcl.status,
        )
    try:
        # Arms that leave or arrive meanwhile may be in some of the frames.
        spaces = arm.space.others(arm.name)
        found = arm.camera.detect(timeout_s, give_up=arm.interrupted.is_set, poll=arm.crcl.status)
        seen_at = arm.crcl.clock.now()
        spaces += arm.space.others(arm.name)
    finally:
        if clear:
            arm.space.hold(arm.name, arm.corridor())

    def sees(xy: XY) -> bool:
        return arm.robot.sees(xy) and all(
            hull_distance(outline, [xy]) >= SHADE_MM for outline in spaces
        )

    tools = [a.tool_xy() for a in (arm, *others)]
    scene = associate(found.sightings, arm.cell, sees, tools, arm.robot.base_mm[:2])
    scene.seen_at = seen_at
    (left, low), (right, high) = arm.robot.view_mm
    view = hull([(left, low), (right, low), (right, high), (left, high)])
    scene.uncertain = found.moving > 0 or any(
        hull_distance(outline, view) < SHADE_MM for outline in spaces
    )
    flipping = sorted({s.name for s in found.sightings if s.flips and s.kind == "KT"})
    if flipping:
        arm.log("flips", f"sees {', '.join(flipping)} rotated by half a turn in some frames")
    arm.log(
        "detect",
        f"sees {sum(t.type.is_kit for t in scene.trays)} kit trays, "
        f"{sum(not t.type.is_kit for t in scene.trays)} part trays, {len(scene.parts)} parts",
    )
    return scene
