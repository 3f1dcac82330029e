"""Errors of the package."""

from __future__ import annotations


class AprsimError(Exception):
    """Base of all errors of this package."""


class BadArgument(AprsimError, ValueError):
    """An argument has the wrong type, shape or range. The text names it, its value and its unit."""


class Unreachable(AprsimError):
    """Nothing answers at the address, or the connection has ended."""


class TimedOut(AprsimError):
    """There is no answer, or a command has not ended, in time."""


class Refused(AprsimError):
    """The cell has refused a call; its text names field, value and limit."""

    def __init__(self, code: str, message: str) -> None:
        super().__init__(message)
        self.code = code
        """Name of the gRPC status, as `NOT_FOUND`."""


class RobotError(AprsimError):
    """A robot's command has ended in CRCL_Error; the text is the robot's."""


class ScenarioError(AprsimError):
    """A scenario could not be run to its end."""
