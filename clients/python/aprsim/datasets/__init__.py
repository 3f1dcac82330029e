"""Data sets of episodes: HDF5 files in the layout of robomimic, written with h5py, and their replay to the
last bit.

    record("pick.hdf5", "aprsim/Pick-v0", episodes=20)
    assert replay("pick.hdf5", 3).is_same

`python3 -m aprsim.datasets` is the same as a program."""

from .episode import Episode
from .errors import DatasetError
from .hdf5 import Reader, Writer
from .recording import record
from .replaying import Replay, replay, replay_all

__all__ = [
    "DatasetError",
    "Episode",
    "Reader",
    "Replay",
    "Writer",
    "record",
    "replay",
    "replay_all",
]
