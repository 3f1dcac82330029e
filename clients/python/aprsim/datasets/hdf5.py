"""Data sets as HDF5 files in the layout of robomimic, by h5py."""

from __future__ import annotations

import json
import os
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import arguments
from ..closing import Closing
from .episode import Episode
from .errors import DatasetError

FORMAT = 1
"""Version of the parts that robomimic does not have."""
_GYM_TYPE = 2  # robomimic's number for environments of Gym's kind
_LARGEST_SIZE = 10_000_000


def load_h5py() -> Any:
    """The module h5py. DatasetError with the package's name where it is missing."""
    try:
        import h5py
    except ImportError as error:
        raise DatasetError(
            "aprsim.datasets needs h5py, which is not installed (Debian: python3-h5py)"
        ) from error
    return h5py


def check_is_new(path: str | Path) -> None:
    """Raises DatasetError where the file exists."""
    if Path(path).exists():
        raise DatasetError(f"{path}: the file exists already")


class Writer(Closing):
    """A new file. It has its name only when it is complete: `close` renames it, an exception in a `with`
    block deletes it."""

    def __init__(
        self,
        path: str | Path,
        *,
        env_id: str,
        env_kwargs: dict[str, Any],
        scene: str,
        state_names: list[str],
    ) -> None:
        """`scene` is the text of the scene; the environment is `make(env_id, **env_kwargs)`."""
        h5py = load_h5py()
        check_is_new(path)
        self._path = Path(path)
        self._part = self._path.with_name(f"{self._path.name}.part")
        try:
            kwargs = json.dumps({"env_name": env_id, "type": _GYM_TYPE, "env_kwargs": env_kwargs})
            self._file = h5py.File(self._part, "w")
        except TypeError as error:
            raise DatasetError(f"env_kwargs: {error}") from error
        except OSError as error:
            raise DatasetError(f"{self._part}: {error}") from error
        self._file.attrs["aprsim_format"] = FORMAT
        self._file.create_dataset("scene", data=scene)
        self._file.create_dataset("state_names", data=state_names, dtype=h5py.string_dtype())
        self._data = self._file.create_group("data")
        self._data.attrs["env_args"] = kwargs
        self._data.attrs["total"] = 0
        self._count = 0

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if error is None:
            self.close()
        else:
            self._file.close()
            self._part.unlink(missing_ok=True)

    def add(self, episode: Episode) -> None:
        """Write an episode as the next one."""
        group = self._data.create_group(f"demo_{self._count}")
        group.attrs["num_samples"] = len(episode)
        group.attrs["seed"] = np.uint64(episode.seed)
        group.attrs["options"] = json.dumps(episode.options)
        group.attrs["is_success"] = episode.is_success
        group.create_dataset("states", data=np.array(episode.states, dtype=np.float64))
        group.create_dataset("actions", data=np.array(episode.actions, dtype=np.float32))
        group.create_dataset("rewards", data=np.array(episode.rewards, dtype=np.float64))
        group.create_dataset("dones", data=np.array(episode.dones, dtype=np.uint8))
        group.create_dataset("state_hashes", data=np.array(episode.state_hashes, dtype=np.uint64))
        group.create_dataset("sim_times_s", data=np.array(episode.sim_times_s, dtype=np.float64))
        for name in episode.observations[0]:
            values = np.array([seen[name] for seen in episode.observations])
            packing = {"compression": "gzip"} if values.dtype == np.uint8 else {}
            group.create_dataset(f"obs/{name}", data=values[:-1], **packing)
            group.create_dataset(f"next_obs/{name}", data=values[1:], **packing)
        self._count += 1
        self._data.attrs["total"] = int(self._data.attrs["total"]) + len(episode)

    def close(self) -> None:
        """Complete the file."""
        self._file.close()
        os.replace(self._part, self._path)


class Reader(Closing):
    """A file that `Writer` wrote. Each part is checked before its use."""

    def __init__(self, path: str | Path) -> None:
        """Raises DatasetError for a file that is no data set."""
        h5py = load_h5py()
        self._path = path
        try:
            self._file = h5py.File(path, "r")
        except OSError as error:
            raise DatasetError(f"{path}: {error}") from error
        try:
            self._read_head()
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def episode(self, number: int) -> Episode:
        """The seed, options, actions and hashes of an episode: all that a replay needs."""
        number = arguments.whole("episode", number, 0, self.episodes - 1)
        name = f"data/demo_{number}"
        group = self._part(self._file, name)
        actions = self._numbers(group, name, "actions", np.float32, 2)
        hashes = self._numbers(group, name, "state_hashes", np.uint64, 1)
        if len(hashes) != len(actions) + 1:
            raise self._wrong(f"{name}/state_hashes", f"{len(hashes)} for {len(actions)} actions")
        seed = self._attribute(group, name, "seed")
        options = self._json(group, name, "options")
        if not isinstance(seed, np.integer) or int(seed) < 0:
            raise self._wrong(f"{name}: seed", repr(seed))
        return Episode(
            int(seed), options, actions=list(actions), state_hashes=[int(each) for each in hashes]
        )

    def _read_head(self) -> None:
        version = self._attribute(self._file, "/", "aprsim_format")
        if version != FORMAT:
            raise self._wrong("aprsim_format", f"{version!r}, where {FORMAT} is known")
        data = self._part(self._file, "data")
        arguments_of_env = self._json(data, "data", "env_args")
        env_id, env_kwargs = arguments_of_env.get("env_name"), arguments_of_env.get("env_kwargs")
        if not isinstance(env_id, str) or not isinstance(env_kwargs, dict):
            raise self._wrong("data: env_args", repr(arguments_of_env)[:200])
        self.env_id: str = env_id
        """Name of the environment."""
        self.env_kwargs: dict[str, Any] = env_kwargs
        """Arguments of the environment."""
        self.episodes: int = len(data)
        """Number of episodes."""
        if not self.episodes:
            raise self._wrong("data", "no episodes")
        scene = self._part(self._file, "scene")
        try:
            self.scene: str = scene.asstr()[()]
            """Text of the scene."""
        except (AttributeError, TypeError, ValueError) as error:
            raise self._wrong("scene", str(error)) from error

    def _part(self, group: Any, name: str) -> Any:
        try:
            return group[name]
        except (KeyError, AttributeError, TypeError, ValueError) as error:
            raise self._wrong(name, "missing") from error

    def _attribute(self, group: Any, where: str, name: str) -> Any:
        try:
            return group.attrs[name]
        except (KeyError, OSError, TypeError) as error:
            raise self._wrong(f"{where}: {name}", "missing") from error

    def _json(self, group: Any, where: str, name: str) -> dict[str, Any]:
        text = self._attribute(group, where, name)
        try:
            out = json.loads(text)
        except (TypeError, ValueError) as error:
            raise self._wrong(f"{where}: {name}", str(error)) from error
        if not isinstance(out, dict):
            raise self._wrong(f"{where}: {name}", "no JSON object")
        return out

    def _numbers(
        self, group: Any, where: str, name: str, kind: type[np.generic], dimensions: int
    ) -> npt.NDArray[Any]:
        part = self._part(group, name)
        shape, dtype = getattr(part, "shape", None), getattr(part, "dtype", None)
        if shape is None or len(shape) != dimensions or dtype != kind:
            expected = f"{dtype} of shape {shape}, where {np.dtype(kind)} of {dimensions} axes"
            raise self._wrong(f"{where}/{name}", f"{expected} is expected")
        if part.size > _LARGEST_SIZE:
            raise self._wrong(f"{where}/{name}", f"{part.size} numbers, more than {_LARGEST_SIZE}")
        try:
            return np.array(part[()])
        except OSError as error:
            raise self._wrong(f"{where}/{name}", str(error)) from error

    def _wrong(self, part: str, words: str) -> DatasetError:
        return DatasetError(f"{self._path}: {part}: {words}")
