"""Environments side by side, as Gymnasium's `VectorEnv`: one after another, or each in a thread of its own."""

from __future__ import annotations

from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any, Callable, Sequence, TypeVar

import numpy as np
import numpy.typing as npt

from .. import arguments
from ..errors import AprsimError, BadArgument
from .registry import make as make_env
from .spaces import Box, OwnEnv
from .vector_base import AutoresetMode, Mask, VectorBase, add_info

T = TypeVar("T")
Steps = tuple[
    npt.NDArray[Any], npt.NDArray[np.float64], Mask, Mask, dict[str, Any]
]  # observations, rewards, terminations, truncations, infos


class SyncVectorEnv(VectorBase):
    """Any number of environments with equal spaces of boxes, one after another. Each that `make_vec` makes
    has a cell of its own. Thread: one at a time."""

    def __init__(
        self,
        env_fns: Sequence[Callable[[], OwnEnv]],
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
    ) -> None:
        """`env_fns` make the environments. `autoreset_mode` is "NextStep", "SameStep" or "Disabled"."""
        self.num_envs = len(env_fns)
        if not env_fns:
            raise arguments.wrong("env_fns", env_fns, "at least one function")
        try:
            self.autoreset_mode = AutoresetMode(autoreset_mode)
        except ValueError:
            modes = " or ".join(mode.value for mode in AutoresetMode)
            raise arguments.wrong("autoreset_mode", autoreset_mode, modes) from None
        self.envs: list[OwnEnv] = []
        try:
            self._make(env_fns)
            self._define_spaces()
        except BaseException:
            self.close()
            raise
        first = self.envs[0]
        self.metadata = {**first.metadata, "autoreset_mode": self.autoreset_mode}
        self.render_mode = first.render_mode
        self._observations = np.zeros(self.observation_space.shape, self.observation_space.dtype)
        self._over: Mask = np.zeros(self.num_envs, dtype=np.bool_)
        self._begun: Mask = np.zeros(self.num_envs, dtype=np.bool_)

    # -- Gymnasium ----------------------------------------------------------------------------

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[npt.NDArray[Any], dict[str, Any]]:
        """Begin episodes. A whole seed gives environment i the seed + i; a list has one for each. The option
        "reset_mask" selects environments; the other options go to each."""
        seeds = self._seeds(seed)
        chosen = dict(options or {})
        mask = self._mask(chosen.pop("reset_mask")) if "reset_mask" in chosen else None
        which = [i for i in range(self.num_envs) if mask is None or mask[i]]

        def reset(i: int) -> tuple[Any, dict[str, Any]]:
            out: tuple[Any, dict[str, Any]] = self.envs[i].reset(
                seed=seeds[i], options=chosen if options is not None else None
            )
            return out

        infos: dict[str, Any] = {}
        for i, (observation, info) in zip(which, self._each(reset, which)):
            self._observations[i] = observation
            self._over[i], self._begun[i] = False, True
            add_info(infos, info, i, self.num_envs)
        return self._observations.copy(), infos

    def step(self, actions: npt.ArrayLike) -> Steps:
        """Perform an action in each environment. Returns arrays of observations, rewards, terminations and
        truncations, and the infos. An error of one environment is raised after the steps of all."""
        shape = self.action_space.shape
        flat = arguments.vector("actions", np.ravel(actions), int(np.prod(shape)), "-1 to 1")
        if np.shape(actions) != shape:
            raise arguments.wrong("actions", actions, f"an array of shape {shape}")
        rows = flat.reshape(shape)
        if not self._begun.all():
            raise AprsimError("step: no episodes have begun; call reset() first")
        if self.autoreset_mode is AutoresetMode.DISABLED and self._over.any():
            ended = np.flatnonzero(self._over).tolist()
            raise AprsimError(f"step: the episodes of {ended} are over; call reset() with a reset_mask")
        rewards = np.zeros(self.num_envs)
        terminations, truncations = np.zeros((2, self.num_envs), dtype=np.bool_)
        infos: dict[str, Any] = {}
        results = self._each(lambda i: self._step_one(i, rows[i]), range(self.num_envs))
        for i, (observation, reward, terminated, truncated, parts) in enumerate(results):
            self._observations[i] = observation
            rewards[i], terminations[i], truncations[i] = reward, terminated, truncated
            for part in parts:
                add_info(infos, part, i, self.num_envs)
        self._over = terminations | truncations
        if self.autoreset_mode is AutoresetMode.SAME_STEP:
            self._over = np.zeros(self.num_envs, dtype=np.bool_)
        return self._observations.copy(), rewards, terminations, truncations, infos

    def render(self) -> tuple[Any, ...]:
        """A picture of each environment."""
        return tuple(self._each(lambda i: self.envs[i].render(), range(self.num_envs)))

    def call(self, name: str, *args: Any, **kwargs: Any) -> tuple[Any, ...]:
        """The results of a method of each environment, or the values of an attribute."""

        def call(i: int) -> Any:
            found = self.envs[i].get_wrapper_attr(name)
            return found(*args, **kwargs) if callable(found) else found

        return tuple(self._each(call, range(self.num_envs)))

    def get_attr(self, name: str) -> tuple[Any, ...]:
        """An attribute of each environment."""
        return self.call(name)

    def set_attr(self, name: str, values: Any) -> None:
        """Set an attribute of each environment: to an entry of a list or tuple, or to the one value."""
        each = values if isinstance(values, (list, tuple)) else [values] * self.num_envs
        if len(each) != self.num_envs:
            raise arguments.wrong("values", values, f"one value, or a list of {self.num_envs}")
        for env, value in zip(self.envs, each):
            env.set_wrapper_attr(name, value)

    @property
    def np_random(self) -> tuple[np.random.Generator, ...]:
        """The random numbers of each environment."""
        return self.get_attr("np_random")

    @property
    def np_random_seed(self) -> tuple[int, ...]:
        """The seed of each environment's random numbers."""
        return self.get_attr("np_random_seed")

    def close_extras(self, **keywords: Any) -> None:
        """Close each environment, also where one cannot be closed; its error is raised then."""
        self._each(lambda i: self.envs[i].close(), range(len(self.envs)))

    # -- parts --------------------------------------------------------------------------------

    def _each(self, function: Callable[[int], T], which: Sequence[int]) -> list[T]:
        """The results of a function of the environments' numbers. It is called for all of them; then the
        first error is raised."""
        return _results([_run_now(function, i) for i in which])

    def _make(self, env_fns: Sequence[Callable[[], OwnEnv]]) -> None:
        for make in env_fns:
            self.envs.append(make())

    def _define_spaces(self) -> None:
        first = self.envs[0]
        self.single_observation_space = first.observation_space
        self.single_action_space = first.action_space
        for env in self.envs:
            same = env.observation_space == first.observation_space
            if not same or env.action_space != first.action_space:
                raise AprsimError("the environments have different spaces")
        self.observation_space = _batch(first.observation_space, self.num_envs)
        self.action_space = _batch(first.action_space, self.num_envs)

    def _step_one(
        self, i: int, action: npt.NDArray[Any]
    ) -> tuple[Any, float, bool, bool, list[dict[str, Any]]]:
        env = self.envs[i]
        if self._over[i] and self.autoreset_mode is AutoresetMode.NEXT_STEP:
            observation, info = env.reset()
            return observation, 0.0, False, False, [info]
        observation, reward, terminated, truncated, info = env.step(action)
        parts = [info]
        if (terminated or truncated) and self.autoreset_mode is AutoresetMode.SAME_STEP:
            parts = [{"final_obs": observation, "final_info": info}]
            observation, info = env.reset()
            parts.append(info)
        return observation, float(reward), bool(terminated), bool(truncated), parts

    def _seeds(self, seed: int | Sequence[int | None] | None) -> list[int | None]:
        if seed is None:
            return [None] * self.num_envs
        if isinstance(seed, (int, np.integer)):
            return [int(seed) + i for i in range(self.num_envs)]
        seeds = list(seed)
        if len(seeds) != self.num_envs:
            raise arguments.wrong("seed", seed, f"a whole number, or a list of {self.num_envs}")
        return seeds

    def _mask(self, value: object) -> Mask:
        mask: Mask = value if isinstance(value, np.ndarray) else np.zeros(0, np.bool_)
        if mask.dtype != np.bool_ or mask.shape != (self.num_envs,) or not mask.any():
            expected = f"an array of {self.num_envs} truth values, at least one True,"
            raise arguments.wrong("options: reset_mask", value, expected)
        return mask


class ThreadedVectorEnv(SyncVectorEnv):
    """The same environments, each in a thread of its own: their cells step at the same time. The results
    are those of `SyncVectorEnv`, bit for bit."""

    def __init__(
        self,
        env_fns: Sequence[Callable[[], OwnEnv]],
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
    ) -> None:
        """As `SyncVectorEnv`. The functions are called in the threads."""
        self._threads = [ThreadPoolExecutor(1, "aprsim-env") for _ in env_fns]
        super().__init__(env_fns, autoreset_mode)

    def close_extras(self, **keywords: Any) -> None:
        """Close each environment, and end the threads."""
        try:
            super().close_extras(**keywords)
        finally:
            for thread in self._threads:
                thread.shutdown()

    def _each(self, function: Callable[[int], T], which: Sequence[int]) -> list[T]:
        return _results([self._threads[i].submit(function, i) for i in which])

    def _make(self, env_fns: Sequence[Callable[[], OwnEnv]]) -> None:
        made = [thread.submit(make) for thread, make in zip(self._threads, env_fns)]
        for future in made:
            if future.exception() is None:
                self.envs.append(future.result())
        _results(made)


def make_vec(
    id: str,
    num_envs: int = 1,
    *,
    vectorization_mode: str = "threaded",
    autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
    **kwargs: Any,
) -> SyncVectorEnv:
    """`num_envs` environments of a registered name; `vectorization_mode` is "sync" or "threaded". `kwargs`
    are those of `make`."""
    kinds = {"sync": SyncVectorEnv, "threaded": ThreadedVectorEnv}
    if vectorization_mode not in kinds:
        raise arguments.wrong("vectorization_mode", vectorization_mode, '"sync" or "threaded"')
    count = arguments.whole("num_envs", num_envs, 1, 4096)
    if kwargs.get("cell") is not None:
        raise BadArgument("cell: one cell cannot serve several environments")
    makes = [lambda: make_env(id, **kwargs)] * count
    vector = kinds[vectorization_mode](makes, autoreset_mode)
    vector.spec = getattr(vector.envs[0], "spec", None)
    return vector


def _run_now(function: Callable[[int], T], i: int) -> Future[T]:
    future: Future[T] = Future()
    try:
        future.set_result(function(i))
    except Exception as error:
        future.set_exception(error)
    return future


def _results(futures: Sequence[Future[T]]) -> list[T]:
    errors = [error for future in futures if (error := future.exception()) is not None]
    if errors:
        raise errors[0]
    return [future.result() for future in futures]


def _batch(space: Box, count: int) -> Box:
    low = np.repeat(space.low[np.newaxis], count, axis=0)
    high = np.repeat(space.high[np.newaxis], count, axis=0)
    return Box(low, high, dtype=np.uint8 if space.dtype == np.uint8 else np.float32)
