"""Step the belt while no arm is over it; all robots detect again afterwards."""

from __future__ import annotations

from arm import Arm
from conveyor import Conveyor


def step_belt(arm: Arm, conveyor: Conveyor, way_mm: float) -> float | None:
    """Run the belt once no arm is over it. Returns its travel [mm], None if it did not become free.
    Raises ConveyorError."""
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
        arm.log("belt", f"has run the belt by {went:.0f} mm", way_mm=round(went, 1))
        return went
    finally:
        arm.space.hold(arm.name, arm.corridor())
