"""Settings of the devices beside the cell, from the words of a command or a file."""

from __future__ import annotations

import math
from dataclasses import dataclass

Address = tuple[str, int]

ANY: Address = ("127.0.0.1", 0)
"""A free port of this machine."""


@dataclass(frozen=True, kw_only=True)
class Common:
    """The part that all devices have."""

    source: str
    """mirror, proxy or shadow."""
    address: Address
    """The real one's port with its states."""
    listen: Address = ANY
    """For controllers."""
    rate: float = 50
    """Questions a second."""
    patience_s: float = 1.0
    """Longest wait for an answer."""
    most_mm: float = 1.5
    """Between the places (shadow)."""
    most_ms: float = 40.0
    """Between their times (shadow)."""
    allow_commands: bool = False
    """Pass commands to the real one."""


@dataclass(frozen=True, kw_only=True)
class RobotSettings(Common):
    """A robot. The keys from `motion` on are for Simple Message."""

    name: str
    wire: str = "crcl"
    """crcl, or a controller of Simple Message."""
    motion: Address | None = None
    gripper: Address | None = None
    """A mirror asks it for the gripper; None = the gripper is neither asked nor relayed."""
    listen_state: Address = ANY
    listen_gripper: Address = ANY
    copy_motion: Address | None = None
    """The simulated robot's; None = as the scene has it."""
    copy_gripper: Address | None = None


@dataclass(frozen=True, kw_only=True)
class BeltSettings(Common):
    """The conveyor."""

    forward: int = 1
    """Value of the direction register for a belt that runs forward."""
    count_m_s: float = 1e-5
    """Unit of the speed register [m/s] and of the encoder [m]."""
    copy: Address | None = None
    """The simulated PLC's; None = the daemon's."""


@dataclass(frozen=True, kw_only=True)
class CameraSettings(Common):
    """The vision lines of a robot's camera."""

    name: str
    """The robot's."""
    pictures: Address | None = None
    """The real camera's HTTP port; relayed at `listen_pictures`."""
    listen_pictures: Address = ANY


LISTENS = ("listen", "listen_state", "listen_gripper", "listen_pictures")
"""Addresses of ours, where port 0 is any free one."""
ADDRESSES = ("address", "motion", "gripper", "copy_motion", "copy_gripper", "copy", "pictures")
"""Addresses of others."""
SIMPLE_MESSAGE_ONLY = ("motion", "gripper", "listen_state", "listen_gripper", "copy_motion", "copy_gripper")
"""Keys that a robot by CRCL has not."""
LIMITS = {
    "rate": (1.0, 250.0, "Hz"), "patience_s": (0.05, 60.0, "s"), "most_mm": (0.01, 1e3, "mm"),
    "most_ms": (1.0, 200.0, "ms"), "count_m_s": (1e-9, 1.0, "m/s"),
}  # fmt: skip
"""Lowest and highest value of a number, and its unit."""


def is_number(value: object) -> bool:
    """Whether a value is a finite number."""
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
