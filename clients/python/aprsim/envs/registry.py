"""Environments by name: `make("aprsim/Pick-v0")`. Where Gymnasium is installed, `gymnasium.make` knows the
same names."""

from __future__ import annotations

import dataclasses
import importlib
import importlib.util
from dataclasses import dataclass, field
from typing import Any

from .. import arguments
from ..errors import BadArgument
from .spaces import OwnEnv


@dataclass(frozen=True)
class EnvSpec:
    """How an environment is made; the fields have Gymnasium's names."""

    id: str
    """Namespace, name and version, as `aprsim/Pick-v0`."""
    entry_point: str
    """Module and class, as `aprsim.envs.tasks:PickEnv`."""
    max_episode_steps: int | None = None
    """Steps after which an episode is truncated; None = never."""
    kwargs: dict[str, Any] = field(default_factory=dict)
    """Arguments of the class."""
    nondeterministic: bool = False
    """Whether the same seed and actions may give other observations."""

    def make(self, **kwargs: Any) -> OwnEnv:
        """An environment of this kind; `kwargs` go before those of the specification."""
        module, name = self.entry_point.split(":")
        kind = getattr(importlib.import_module(module), name)
        given = {**self.kwargs, **kwargs}
        given.setdefault("max_steps", self.max_episode_steps)
        try:
            env: OwnEnv = kind(**given)
        except TypeError as error:
            raise BadArgument(f"{self.id}: {error}") from error
        if not is_gymnasium_installed():
            env.spec = dataclasses.replace(self, kwargs={**self.kwargs, **kwargs})
        return env


specs: dict[str, EnvSpec] = {}
"""The registered environments by name."""


def is_gymnasium_installed() -> bool:
    """Whether Gymnasium can be imported."""
    return importlib.util.find_spec("gymnasium") is not None


def register(spec: EnvSpec) -> None:
    """Register an environment, also with Gymnasium where it is installed. There the time limit is
    Gymnasium's wrapper, so the environment has none of its own."""
    if spec.id in specs:
        raise BadArgument(f"id: '{spec.id}' is registered already")
    specs[spec.id] = spec
    if is_gymnasium_installed():
        gymnasium = importlib.import_module("gymnasium")
        gymnasium.register(
            id=spec.id,
            entry_point=spec.entry_point,
            max_episode_steps=spec.max_episode_steps,
            nondeterministic=spec.nondeterministic,
            kwargs={**spec.kwargs, "max_steps": None},
        )


def spec(id: str) -> EnvSpec:
    """The specification of a name. BadArgument with the names there are."""
    found = specs.get(arguments.text("id", id))
    if found is None:
        raise arguments.wrong("id", id, f"one of {', '.join(sorted(specs))}")
    return found


def make(id: str, *, max_episode_steps: int | None = None, **kwargs: Any) -> OwnEnv:
    """A registered environment. `max_episode_steps` replaces its time limit; `kwargs` are arguments of its
    class. It has no wrappers: the class checks the order of calls and the time limit itself."""
    chosen = spec(id)
    if max_episode_steps is not None:
        limit = arguments.whole("max_episode_steps", max_episode_steps, 1, 1 << 62)
        chosen = dataclasses.replace(chosen, max_episode_steps=limit)
    return chosen.make(**kwargs)


def _register_tasks() -> None:
    for name, entry_point, steps in (
        ("Pick", "tasks:PickEnv", 200),
        ("Place", "tasks:PlaceEnv", 200),
        ("Kit", "tasks:KitEnv", 600),
        ("TwoArms", "two_arms:TwoArmsEnv", 300),
        ("BeltPick", "belt:BeltPickEnv", 200),
        ("Push", "push:PushEnv", 200),
        ("Insert", "insert:InsertEnv", 100),
        ("Sort", "sort:SortEnv", 400),
    ):
        register(EnvSpec(f"aprsim/{name}-v0", f"aprsim.envs.{entry_point}", steps))


_register_tasks()
