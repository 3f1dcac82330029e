"""What can go wrong on the way to a cell, and in it."""

from __future__ import annotations


class AprsimError(Exception):
    """Of every error of this package."""


class Unreachable(AprsimError):
    """Nobody answers at the address, or the connection has ended."""


class TimedOut(AprsimError):
    """There is no answer, or a command has not ended, in time."""


class Refused(AprsimError):
    """The cell has refused a call; its words name field, value and limit."""

    def __init__(self, code: str, message: str) -> None:
        super().__init__(message)
        self.code = code
        """Name of the gRPC status, as `NOT_FOUND`."""


class RobotError(AprsimError):
    """A robot's command has ended in CRCL_Error; its words are the robot's."""


class ScenarioError(AprsimError):
    """A scenario could not be run to its end."""
