"""A check that an environment keeps Gymnasium's rules, which needs no Gymnasium."""

from __future__ import annotations

import copy
import inspect
from typing import Any

import numpy as np

from ..errors import AprsimError
from .spaces import Env

_SEED, _OTHER_SEED = 123, 456
_STEPS = 3


class EnvCheckError(AprsimError):
    """An environment breaks a rule; the text names the method or attribute."""


def check_env(env: Env, *, skip_render: bool = False, skip_close: bool = False) -> None:
    """Check spaces, types, seeds, steps, pictures and the end of an environment. It begins and steps
    episodes and, unless `skip_close`, closes the environment. Raises EnvCheckError at the first rule that
    is broken."""
    _check_attributes(env)
    _check_reset_signature(env)
    _check_reset(env)
    _check_seeds(env)
    _check_steps(env)
    if not skip_render:
        _check_render(env)
    if not skip_close:
        _check_close(env)


def _require(holds: object, words: str) -> None:
    if not holds:
        raise EnvCheckError(f"check_env: {words}")


# -- attributes -------------------------------------------------------------------------------


def _check_attributes(env: Env) -> None:
    _require(isinstance(env, Env), f"{type(env).__name__} is no Env")
    for name in ("action_space", "observation_space"):
        space = getattr(env, name, None)
        _require(space is not None, f"{name} is missing")
        _check_space(name, space)
    modes = env.metadata.get("render_modes")
    is_list = isinstance(modes, (list, tuple)) and all(isinstance(mode, str) for mode in modes)
    _require(is_list, "metadata['render_modes'] is no list of texts")
    if modes:
        fps = env.metadata.get("render_fps")
        is_rate = isinstance(fps, (int, float, np.number)) and fps > 0
        _require(is_rate, f"metadata['render_fps'] is {fps!r}, not a number above 0")
    known = env.render_mode is None or env.render_mode in (modes or ())
    _require(known, f"render_mode {env.render_mode!r} is none of metadata['render_modes']")
    has_seed = callable(getattr(env, "seed", None))
    _require(not has_seed, "the method seed() has been replaced by reset(seed=...)")


def _check_space(name: str, space: Any) -> None:
    is_box = all(hasattr(space, part) for part in ("low", "high", "shape", "dtype", "contains"))
    _require(is_box, f"{name} is no Box, the only kind of space that is checked")
    shapes = space.low.shape == space.high.shape == space.shape
    _require(shapes, f"{name}: the bounds have other shapes than the space")
    below = bool((space.low < space.high).all())
    _require(below, f"{name}: a lower bound is not below the upper one")
    if len(space.shape) == 3 and name == "observation_space":
        is_picture = space.dtype == np.uint8 and not space.low.any() and (space.high == 255).all()
        _require(is_picture, f"{name}: pictures have bytes from 0 to 255")
    if name == "action_space":
        _check_limits(space)
    space.seed(_SEED)
    first = space.sample()
    space.seed(_SEED)
    _require(_equal(first, space.sample()), f"{name}: the same seed samples other arrays")
    _require(first in space, f"{name} does not contain its own sample")


def _check_limits(space: Any) -> None:
    finite = bool(np.isfinite(space.low).all() and np.isfinite(space.high).all())
    _require(finite, "action_space: a bound is infinite")
    normal = (space.low == -space.high) | (space.low == 0)
    within = bool((space.low >= -1).all() and (space.high <= 1).all())
    _require(within and bool(normal.all()), "action_space: bounds are not -1 or 0 to 1")


# -- reset ------------------------------------------------------------------------------------


def _check_reset_signature(env: Env) -> None:
    parameters = inspect.signature(env.reset).parameters
    takes_all = any(each.kind is inspect.Parameter.VAR_KEYWORD for each in parameters.values())
    for name in ("seed", "options"):
        _require(name in parameters or takes_all, f"reset() takes no {name}")
        default = parameters[name].default if name in parameters else None
        _require(default is None, f"reset(): the default of {name} is {default!r}, not None")
    _require("return_info" not in parameters, "reset() takes return_info; it always returns an info")


def _check_reset(env: Env) -> None:
    both: tuple[dict[str, Any] | None, ...] = (None, {})
    for options in both:
        result = env.reset(options=options)
        is_pair = isinstance(result, tuple) and len(result) == 2
        _require(is_pair, "reset() returns no tuple of observation and info")
        _check_observation(env, result[0], "reset()")
        _require(isinstance(result[1], dict), "reset(): the info is no dictionary")


def _check_seeds(env: Env) -> None:
    """The same seed gives the same random numbers and observations, also without a seed afterwards."""
    begins = []
    for _ in range(2):
        first, first_info = env.reset(seed=_SEED)
        state = copy.deepcopy(env.unwrapped.np_random.bit_generator.state)
        second, _ = env.reset()
        begins.append((first, first_info, state, second))
    (first, info, state, second), (again, again_info, again_state, second_again) = begins
    _require(_equal(first, again), "reset(seed=...): the same seed gives another observation")
    _require(_equal(info, again_info), "reset(seed=...): the same seed gives another info")
    _require(state == again_state, "reset(seed=...) does not set the seed of np_random")
    _require(_equal(second, second_again), "reset() after the same seed gives another observation")
    env.reset(seed=_OTHER_SEED)
    other = env.unwrapped.np_random.bit_generator.state
    _require(other != state, "reset(seed=...): another seed leaves the random numbers as they were")


# -- step -------------------------------------------------------------------------------------


def _check_steps(env: Env) -> None:
    """The same seed and actions give the same steps."""
    env.action_space.seed(_SEED)
    actions = [env.action_space.sample() for _ in range(_STEPS)]
    runs = []
    for _ in range(2):
        env.reset(seed=_SEED)
        run = []
        for action in actions:
            result = env.step(action)
            _check_step(env, result)
            run.append(copy.deepcopy(result))
            if result[2] or result[3]:
                break
        runs.append(run)
    _require(not runs[0][0][3], "step(): the episode is truncated after one step")
    _require(len(runs[0]) == len(runs[1]), "step(): the same actions end the episode at another step")
    names = ("observation", "reward", "terminated", "truncated", "info")
    for one, other in zip(*runs):
        for name, value, again in zip(names, one, other):
            _require(_equal(value, again), f"step(): the same seed and actions give another {name}")


def _check_step(env: Env, result: Any) -> None:
    is_five = isinstance(result, tuple) and len(result) == 5
    _require(is_five, "step() returns no tuple of five")
    observation, reward, terminated, truncated, info = result
    _check_observation(env, observation, "step()")
    is_number = isinstance(reward, (int, float, np.number)) and not isinstance(reward, bool)
    _require(is_number and bool(np.isfinite(reward)), f"step(): the reward {reward!r} is no finite number")
    for name, value in (("terminated", terminated), ("truncated", truncated)):
        _require(isinstance(value, (bool, np.bool_)), f"step(): {name} is {value!r}, not True or False")
    _require(isinstance(info, dict), "step(): the info is no dictionary")


def _check_observation(env: Env, observation: Any, method: str) -> None:
    space = env.observation_space
    _require(isinstance(observation, np.ndarray), f"{method}: the observation is no numpy array")
    same = observation.dtype == space.dtype
    _require(same, f"{method}: the observation has {observation.dtype}, its space {space.dtype}")
    _require(observation in space, f"{method}: the observation is outside its space")


# -- pictures and the end ---------------------------------------------------------------------


def _check_render(env: Env) -> None:
    picture = env.render()
    if env.render_mode is None:
        return
    if env.render_mode == "human":
        _require(picture is None, "render(): the mode human returns something")
    if env.render_mode != "rgb_array":
        return
    is_picture = isinstance(picture, np.ndarray) and picture.dtype == np.uint8
    _require(is_picture, "render(): the mode rgb_array returns no array of bytes")
    shaped = picture.ndim == 3 and picture.shape[2] == 3
    _require(shaped, f"render(): the picture's shape is {picture.shape}, not height x width x 3")


def _check_close(env: Env) -> None:
    env.close()
    try:
        env.close()
    except Exception as error:
        raise EnvCheckError(f"check_env: the second close() raises {error!r}") from error


def _equal(one: Any, other: Any) -> bool:
    """Equal to the last bit, through dictionaries and sequences."""
    if type(one) is not type(other):
        return False
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(_equal(one[key], other[key]) for key in one)
    if isinstance(one, (list, tuple)):
        return len(one) == len(other) and all(map(_equal, one, other))
    if isinstance(one, np.ndarray):
        return one.dtype == other.dtype and np.array_equal(one, other)
    return bool(one == other)
