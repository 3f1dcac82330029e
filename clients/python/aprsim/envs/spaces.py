"""Base classes of the environments: Gymnasium's `Env` and `Box` where it is installed, else own ones with
the same signatures."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..closing import Closing

if TYPE_CHECKING:
    from .registry import EnvSpec

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

    def seed(self, seed: int | None = None) -> int | None:
        """Set the seed of `sample`. Returns it."""
        self._random = np.random.default_rng(seed)
        return seed

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

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, OwnBox):
            return NotImplemented
        same = self.shape == other.shape and self.dtype == other.dtype
        return bool(same and (self.low == other.low).all() and (self.high == other.high).all())

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"Box({self.low}, {self.high}, {self.shape}, {self.dtype})"


class OwnEnv(Closing):
    """The random numbers of an environment, and the attributes that Gymnasium's wrappers need."""

    metadata: dict[str, Any] = {"render_modes": []}
    render_mode: str | None = None
    spec: EnvSpec | None = None
    """How `make` made it."""
    action_space: Box
    observation_space: Box
    _np_random: np.random.Generator | None = None
    _np_random_seed: int | None = None

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> Any:
        """Restart the random numbers with a seed; without one they continue."""
        if seed is not None:
            self._set_seed(seed)

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Perform an action. Returns observation, reward, terminated, truncated and info."""
        raise NotImplementedError

    @property
    def np_random(self) -> np.random.Generator:
        """The random numbers; before a seed is set, of a random seed."""
        if self._np_random is None:
            self._set_seed(None)
        assert self._np_random is not None
        return self._np_random

    @np_random.setter
    def np_random(self, value: np.random.Generator) -> None:
        self._np_random, self._np_random_seed = value, -1

    @property
    def np_random_seed(self) -> int:
        """Seed of the random numbers; -1 where they were set without one."""
        if self._np_random_seed is None:
            self._set_seed(None)
        assert self._np_random_seed is not None
        return self._np_random_seed

    def _set_seed(self, seed: int | None) -> None:
        sequence = np.random.SeedSequence(seed)
        self._np_random = np.random.Generator(np.random.PCG64(sequence))
        self._np_random_seed = int(sequence.entropy)  # type: ignore[arg-type]

    @property
    def unwrapped(self) -> OwnEnv:
        """This environment."""
        return self

    def has_wrapper_attr(self, name: str) -> bool:
        """Whether this environment has an attribute."""
        return hasattr(self, name)

    def get_wrapper_attr(self, name: str) -> Any:
        """An attribute of this environment."""
        return getattr(self, name)

    def set_wrapper_attr(self, name: str, value: Any, *, force: bool = True) -> bool:
        """Set an attribute; unless `force`, only one that exists. Returns whether it is set."""
        if not force and not hasattr(self, name):
            return False
        setattr(self, name, value)
        return True

    def render(self) -> Any:
        """Draw nothing: the cell's web page shows the cell."""

    def close(self) -> None:
        """Release the resources of the environment."""

    def __str__(self) -> str:
        name = type(self).__name__
        return f"<{name}>" if self.spec is None else f"<{name}<{self.spec.id}>>"


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
