"""Checks of arguments. Each error names the argument, its value, and the shape and unit expected."""

from __future__ import annotations

import math
from typing import Any, Sequence

import numpy as np
import numpy.typing as npt

from .errors import BadArgument

Array = npt.NDArray[np.float64]

_ORTHONORMAL = 1e-3  # largest deviation of R R^T from the identity: that of a pose with few digits
_LONGEST_VALUE = 200  # characters of a value in an error


def number(
    name: str,
    value: object,
    unit: str = "",
    *,
    low: float = -math.inf,
    high: float = math.inf,
    above: float | None = None,
) -> float:
    """A finite number within `low` and `high`, greater than `above`."""
    if above is not None:
        expected = f"a number above {above:g}{_of(unit)}"
    elif low > -math.inf and high < math.inf:
        expected = f"a number from {low:g} to {high:g}{_of(unit)}"
    elif low > -math.inf:
        expected = f"a number of at least {low:g}{_of(unit)}"
    else:
        expected = f"a finite number{_of(unit)}"
    if isinstance(value, (bool, str, bytes)):
        raise wrong(name, value, expected)
    try:
        out = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        raise wrong(name, value, expected) from None
    if not math.isfinite(out) or not low <= out <= high or (above is not None and out <= above):
        raise wrong(name, value, expected)
    return out


def whole(name: str, value: object, low: int, high: int, unit: str = "") -> int:
    """A whole number within `low` and `high`."""
    expected = f"a whole number from {low} to {high}{_of(unit)}"
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (int, np.integer)):
        raise wrong(name, value, expected)
    if not low <= value <= high:
        raise wrong(name, value, expected)
    return int(value)


def truth(name: str, value: object) -> bool:
    """True or False."""
    if not isinstance(value, (bool, np.bool_)):
        raise wrong(name, value, "True or False")
    return bool(value)


def text(name: str, value: object) -> str:
    """A text."""
    if not isinstance(value, str):
        raise wrong(name, value, "a text")
    return value


def texts(name: str, value: object) -> list[str]:
    """A sequence of texts. One text alone is an error: it would be a sequence of its characters."""
    expected = "a sequence of texts, as [\"robots\"]"
    if isinstance(value, (str, bytes)):
        raise wrong(name, value, expected)
    try:
        out: list[str] = list(value)  # type: ignore[call-overload]
    except TypeError:
        raise wrong(name, value, expected) from None
    if not all(isinstance(word, str) for word in out):
        raise wrong(name, value, expected)
    return out


def vector(name: str, value: object, count: int, unit: str) -> Array:
    """`count` finite numbers."""
    return _array(name, value, [(count,)], f"{count} finite numbers{_of(unit)}")


def pose(name: str, value: object) -> Array:
    """A finite 4 x 4 pose with an orthonormal rotation."""
    out = _array(name, value, [(4, 4)], POSE)
    check_pose(name, out)
    return out


def pose_or_point(name: str, value: object) -> Array:
    """A 4 x 4 pose, or a point of three coordinates in metres."""
    out = _array(name, value, [(3,), (4, 4)], f"a point of 3 finite numbers in m, or {POSE}")
    if out.shape == (4, 4):
        check_pose(name, out)
    return out


POSE = "a 4 x 4 pose (rotation in [:3, :3], position in m in [:3, 3], last row 0 0 0 1)"


def check_pose(name: str, value: Array) -> None:
    """The rotation is orthonormal and right-handed, the last row 0 0 0 1."""
    rotation = value[:3, :3]
    is_rotation = np.allclose(rotation @ rotation.T, np.eye(3), rtol=0, atol=_ORTHONORMAL)
    if not is_rotation or np.linalg.det(rotation) < 0:
        raise wrong(f"{name}[:3, :3]", rotation.tolist(), "a rotation (orthonormal, determinant 1)")
    if not np.allclose(value[3], [0, 0, 0, 1], rtol=0, atol=1e-9):
        raise wrong(f"{name}[3]", value[3].tolist(), "the last row 0 0 0 1 of a pose")


def wrong(name: str, value: object, expected: str) -> BadArgument:
    """The error for a value."""
    shown = " ".join(repr(value).split())
    if len(shown) > _LONGEST_VALUE:
        shown = shown[:_LONGEST_VALUE] + "..."
    return BadArgument(f"{name}: {shown}, where {expected} is expected")


def _array(name: str, value: object, shapes: Sequence[tuple[int, ...]], expected: str) -> Array:
    try:
        given: npt.NDArray[Any] = np.asarray(value)
        out = given.astype(np.float64)
    except (TypeError, ValueError):
        raise wrong(name, value, expected) from None
    if given.dtype.kind not in "iuf" or not np.isfinite(out).all():
        raise wrong(name, value, expected)
    if out.shape not in shapes:
        raise BadArgument(f"{name}: a value of shape {out.shape}, where {expected} is expected")
    return out


def _of(unit: str) -> str:
    return f" in {unit}" if unit else ""
