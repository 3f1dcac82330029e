"""Base classes of the environments: Gymnasium's `Env` and `Box` where it is installed, else own ones with
the same signatures."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

Vector = npt.NDArray[np.float32]
Image = npt.NDArray[np.uint8]
Numbers = type[np.float32] | type[np.uint8]


class OwnBox:
    """The arrays between two bounds, of floats or of bytes."""

    def __init__(
        self, low: npt.ArrayLike, high: npt.ArrayLike, dtype: Numbers = np.float32
    ) -> None:
        self.low: Vector | Image = np.asarray(low, dtype=dtype)
        self.high: Vector | Image = np.asarray(high, dtype=dtype)
        if self.low.shape != self.high.shape or not (self.low <= self.high).all():
            raise ValueError("low and high: bounds of the same shape, low <= high, are expected")
        self.shape = self.low.shape
        self.dtype = np.dtype(dtype)
        self._random = np.random.default_rng()

    def seed(self, seed: int | None = None) -> None:
        """Set the seed of `sample`."""
        self._random = np.random.default_rng(seed)

    def sample(self) -> Vector | Image:
        """A random array, uniformly distributed."""
        if self.dtype == np.uint8:
            low, high = self.low.astype(np.int64), self.high.astype(np.int64)
            return self._random.integers(low, high + 1).astype(np.uint8)
        return self._random.uniform(self.low, self.high).astype(np.float32)

    def contains(self, x: object) -> bool:
        """Whether `x` is an array of this shape and kind between the bounds."""
        if not isinstance(x, np.ndarray) or x.shape != self.shape:
            return False
        if not np.can_cast(x.dtype, self.dtype):
            return False
        return bool(((x >= self.low) & (x <= self.high)).all())

    def __contains__(self, x: object) -> bool:
        return self.contains(x)

    def __repr__(self) -> str:
        return f"Box({self.low}, {self.high}, {self.shape}, {self.dtype})"


class OwnEnv:
    """The random numbers of an environment, and the attributes that Gymnasium's wrappers need."""

    metadata: dict[str, Any] = {"render_modes": []}
    render_mode: str | None = None
    np_random: np.random.Generator = np.random.default_rng()

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> Any:
        """Restart the random numbers with a seed; without one they continue."""
        if seed is not None or "np_random" not in self.__dict__:
            self.np_random = np.random.default_rng(seed)

    @property
    def unwrapped(self) -> OwnEnv:
        """This environment."""
        return self

    def render(self) -> Any:
        """Draw nothing: the cell's web page shows the cell."""

    def close(self) -> None:
        """Release the resources of the environment."""


if TYPE_CHECKING:
    Box = OwnBox
    Env = OwnEnv
else:
    try:
        from gymnasium import Env
        from gymnasium.spaces import Box as _GymnasiumBox

        def Box(low, high, dtype=np.float32):
            """Gymnasium's `Box` with the arguments of this module."""
            return _GymnasiumBox(
                np.asarray(low, dtype=dtype), np.asarray(high, dtype=dtype), dtype=dtype
            )

    except ImportError:
        Box = OwnBox
        Env = OwnEnv
