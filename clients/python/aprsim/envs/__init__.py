"""Tasks in the cell with Gymnasium's signatures: `reset(seed=, options=)` and `step(action)`, with own
spaces where gymnasium is not installed. The cell is paused between steps, so no clock matters.

    env = PickEnv()
    observation, info = env.reset(seed=1)
    observation, reward, terminated, truncated, info = env.step(env.action_space.sample())
"""

from .cell_env import MOVE_M, OBSERVATION_NAMES, TURN_RAD, CellEnv
from .scripted import scripted_action
from .tasks import KitEnv, PickEnv, PlaceEnv

__all__ = [
    "MOVE_M",
    "OBSERVATION_NAMES",
    "TURN_RAD",
    "CellEnv",
    "KitEnv",
    "PickEnv",
    "PlaceEnv",
    "scripted_action",
]
