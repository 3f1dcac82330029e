"""Records episodes of an environment in a data set."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Callable

import numpy as np
import numpy.typing as npt

from .. import arguments
from ..envs import CellEnv, make
from ..errors import BadArgument
from .episode import Episode, Observations, state_names, state_numbers
from .hdf5 import Writer, check_is_new, load_h5py

Policy = Callable[[npt.NDArray[Any]], npt.ArrayLike]
_LARGEST_SEED = (1 << 62) - 1


def record(
    path: str | Path,
    env: str = "aprsim/Pick-v0",
    *,
    episodes: int = 10,
    seed: int = 0,
    policy: str | Policy = "scripted",
    options: dict[str, Any] | None = None,
    on_episode: Callable[[int, Episode], None] | None = None,
    **env_kwargs: Any,
) -> int:
    """Write `episodes` episodes of the environment `make(env, **env_kwargs)` to a new file; the seed of
    episode i is `seed` + i. `policy` is "scripted", "random", or a function from the numbers of
    `observation_names` to an action. `observation="rgb"` records pictures too. `on_episode` is called
    after each one. Returns how many were a success."""
    load_h5py()
    check_is_new(path)
    count = arguments.whole("episodes", episodes, 1, 1_000_000)
    if not callable(policy) and policy not in ("scripted", "random"):
        raise arguments.wrong("policy", policy, '"scripted", "random" or a function')
    first = arguments.whole("seed", seed, 0, _LARGEST_SEED)
    made = make_cell_env(env, env_kwargs)
    try:
        act = _policy(policy, made, first)
        scene = made.cell.scene_text()
        names = state_names(made.cell.snapshot(["robots", "bodies"]))
        successes = 0
        with Writer(
            path, env_id=env, env_kwargs=env_kwargs, scene=scene, state_names=names
        ) as writer:
            for number in range(count):
                episode = _record_one(made, first + number, options or {}, act)
                writer.add(episode)
                successes += episode.is_success
                if on_episode is not None:
                    on_episode(number, episode)
        return successes
    finally:
        made.close()


def make_cell_env(name: str, env_kwargs: dict[str, Any]) -> CellEnv:
    """An environment with a cell of its own. BadArgument for one without a cell."""
    if "cell" in env_kwargs:
        raise BadArgument("cell: a data set needs an environment with a cell of its own")
    made = make(name, **env_kwargs)
    if not isinstance(made, CellEnv):
        made.close()
        raise BadArgument(f"env: '{name}' is no task in a cell")
    return made


def _policy(policy: str | Policy, env: CellEnv, seed: int) -> Policy:
    if callable(policy):
        return policy
    if policy == "scripted":
        return env.scripted_action
    env.action_space.seed(seed)
    return lambda state: env.action_space.sample()


def _record_one(env: CellEnv, seed: int, options: dict[str, Any], act: Policy) -> Episode:
    episode = Episode(seed, options)
    observation, info = env.reset(seed=seed, options=options)
    over = False
    while True:
        seen = _observations(observation, info)
        episode.observations.append(seen)
        episode.state_hashes.append(int(info["state_hash"]))
        episode.sim_times_s.append(info["sim_time_s"])
        if over:
            return episode
        episode.states.append(state_numbers(env.snapshot()))
        action = np.asarray(act(seen["state"]), dtype=np.float32)
        observation, reward, terminated, truncated, info = env.step(action)
        over = terminated or truncated
        episode.actions.append(np.clip(action, -1.0, 1.0))
        episode.rewards.append(reward)
        episode.dones.append(over)
        episode.is_success = bool(info["is_success"])


def _observations(observation: npt.NDArray[Any], info: dict[str, Any]) -> Observations:
    if "state" in info:
        return {"state": info["state"], "image": observation}
    return {"state": observation}
