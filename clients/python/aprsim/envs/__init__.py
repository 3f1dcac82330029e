"""Tasks in the cell with Gymnasium's signatures: `reset(seed=, options=)` and `step(action)`, with own
spaces where gymnasium is not installed. The cell is paused between steps, so no clock matters.

    env = make("aprsim/Pick-v0")
    observation, info = env.reset(seed=1)
    observation, reward, terminated, truncated, info = env.step(env.action_space.sample())

`make_vec` makes any number of environments side by side; `check_env` checks that one keeps Gymnasium's
rules."""

from .actions import MOVE_M, TURN_RAD, VELOCITY_RAD_S
from .belt import BeltPickEnv
from .cell_env import CellEnv
from .checker import EnvCheckError, check_env
from .insert import InsertEnv
from .push import PushEnv
from .registry import EnvSpec, make, register, spec, specs
from .scripted import scripted_action
from .sort import SortEnv
from .tasks import KitEnv, PickEnv, PlaceEnv
from .transfer_env import TransferEnv
from .transfer_state import NAMES as OBSERVATION_NAMES
from .two_arms import TwoArmsEnv
from .vector import SyncVectorEnv, ThreadedVectorEnv, make_vec
from .vector_base import AutoresetMode

__all__ = [
    "MOVE_M",
    "OBSERVATION_NAMES",
    "TURN_RAD",
    "VELOCITY_RAD_S",
    "AutoresetMode",
    "BeltPickEnv",
    "CellEnv",
    "EnvCheckError",
    "EnvSpec",
    "InsertEnv",
    "KitEnv",
    "PickEnv",
    "PlaceEnv",
    "PushEnv",
    "SortEnv",
    "SyncVectorEnv",
    "ThreadedVectorEnv",
    "TransferEnv",
    "TwoArmsEnv",
    "check_env",
    "make",
    "make_vec",
    "register",
    "scripted_action",
    "spec",
    "specs",
]
