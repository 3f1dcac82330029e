"""Base of vector environments: Gymnasium's where it is installed, else an own one with the same signatures;
and the batches of infos."""

from __future__ import annotations

from enum import Enum
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from .spaces import Box

Mask = npt.NDArray[np.bool_]


class OwnAutoresetMode(Enum):
    """When an environment begins its next episode."""

    NEXT_STEP = "NextStep"
    """In the step after the end, whose action is ignored."""
    SAME_STEP = "SameStep"
    """In the step of the end; `infos["final_obs"]` and `infos["final_info"]` belong to the end."""
    DISABLED = "Disabled"
    """Only `reset` with the option "reset_mask" begins one."""


class OwnVectorEnv:
    """The attributes of a vector environment that Gymnasium's wrappers need."""

    metadata: dict[str, Any] = {}
    spec: Any = None
    render_mode: str | None = None
    closed = False
    num_envs: int
    observation_space: Box
    action_space: Box
    single_observation_space: Box
    single_action_space: Box

    @property
    def unwrapped(self) -> OwnVectorEnv:
        """This environment."""
        return self

    def close_extras(self, **keywords: Any) -> None:
        """Release the resources."""

    def close(self, **keywords: Any) -> None:
        """Close all environments, once."""
        if not self.closed:
            self.close_extras(**keywords)
            self.closed = True


def add_info(infos: dict[str, Any], info: dict[str, Any], index: int, count: int) -> None:
    """Add the info of one environment to that of all. Each key has an array with one entry for each
    environment, and beside it, with an underscore before, the mask of those that have the key.
    Dictionaries are joined key by key; observations of ends stay separate objects."""
    for key, value in info.items():
        if isinstance(value, dict):
            add_info(infos.setdefault(key, {}), value, index, count)
        else:
            if key not in infos:
                infos[key] = _empty(key, value, count)
            infos[key][index] = value
        infos.setdefault(f"_{key}", np.zeros(count, dtype=np.bool_))[index] = True


def _empty(key: str, value: object, count: int) -> npt.NDArray[Any]:
    if key != "final_obs":
        if isinstance(value, (bool, int, float, np.number, np.bool_)):
            return np.zeros(count, dtype=type(value))
        if isinstance(value, np.ndarray):
            return np.zeros((count, *value.shape), dtype=value.dtype)
    return np.full(count, None, dtype=object)


if TYPE_CHECKING:
    AutoresetMode = OwnAutoresetMode
    VectorBase = OwnVectorEnv
else:
    try:
        from gymnasium.vector import AutoresetMode
        from gymnasium.vector import VectorEnv as VectorBase
    except ImportError:
        AutoresetMode = OwnAutoresetMode
        VectorBase = OwnVectorEnv
