"""Runs recorded episodes again and compares their states."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Iterator, Sequence

from ..envs import CellEnv
from .episode import Episode
from .errors import DatasetError
from .hdf5 import Reader
from .recording import make_cell_env


@dataclass(frozen=True)
class Replay:
    """The comparison of an episode with its record."""

    episode: int
    steps: int
    """Recorded steps."""
    first_difference: int | None
    """Steps before the first state with another hash, 0 = the begin; None = all states are the same."""

    @property
    def is_same(self) -> bool:
        """Whether every state is the same, to the last bit."""
        return self.first_difference is None


def replay(path: str | Path, episode: int = 0) -> Replay:
    """Run an episode again from its seed, and compare the hash of each state."""
    return next(replay_all(path, [episode]))


def replay_all(path: str | Path, episodes: Sequence[int] | None = None) -> Iterator[Replay]:
    """Run several episodes again, by default all of them, in one environment. DatasetError where the
    recorded scene is not the present one of its name."""
    with Reader(path) as reader:
        numbers = range(reader.episodes) if episodes is None else episodes
        recorded = [(number, reader.episode(number)) for number in numbers]
        # Pictures change no state, and take most of the time.
        without_pictures = {"observation": "state", "render_mode": None}
        env = make_cell_env(reader.env_id, {**reader.env_kwargs, **without_pictures})
        try:
            if env.cell.scene_text() != reader.scene:
                raise DatasetError(f"{path}: the scene has changed since the recording")
            for number, one in recorded:
                yield Replay(number, len(one), _first_difference(env, one))
        finally:
            env.close()


def _first_difference(env: CellEnv, episode: Episode) -> int | None:
    _, info = env.reset(seed=episode.seed, options=episode.options)
    for step, recorded in enumerate(episode.state_hashes):
        if int(info["state_hash"]) != recorded:
            return step
        if step < len(episode):
            info = env.step(episode.actions[step])[4]
    return None
