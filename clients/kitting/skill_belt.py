"""Step the belt: with no arm over it, and everybody looks again afterwards."""

from __future__ import annotations

from arm import Arm
from conveyor import Conveyor


def step_belt(arm: Arm, conveyor: Conveyor, way_mm: float) -> float | None:
    """Runs the belt once it is free; how far it went [mm], None when it did not get free. Raises
    ConveyorError."""
    arm.go_home()
    if not arm.space.acquire(
        arm.name,
        arm.corridor(),
        moves_belt=True,
        give_up=arm.interrupted.is_set,
        poll=arm.crcl.status,
    ):
        return None
    try:
        went = conveyor.step(way_mm, arm.interrupted, arm.crcl.clock.now, arm.crcl.wait)
        arm.tell("belt", f"has run the belt by {went:.0f} mm", way_mm=round(went, 1))
        return went
    finally:
        arm.space.hold(arm.name, arm.corridor())
