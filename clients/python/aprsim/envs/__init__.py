"""Tasks in the cell with Gymnasium's signatures: `reset(seed=, options=)` and `step(action)`, with own
spaces where gymnasium is not installed. The cell is paused between steps, so no clock matters.

    env = PickEnv()
    observation, info = env.reset(seed=1)
    observation, reward, terminated, truncated, info = env.step(env.action_space.sample())
"""

from .actions import MOVE_M, TURN_RAD, VELOCITY_RAD_S
from .cell_env import CellEnv
from .scripted import scripted_action
from .tasks import KitEnv, PickEnv, PlaceEnv
from .transfer_env import TransferEnv
from .transfer_state import NAMES as OBSERVATION_NAMES

__all__ = [
    "MOVE_M",
    "OBSERVATION_NAMES",
    "TURN_RAD",
    "VELOCITY_RAD_S",
    "CellEnv",
    "KitEnv",
    "PickEnv",
    "PlaceEnv",
    "TransferEnv",
    "scripted_action",
]
