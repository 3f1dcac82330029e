"""Client of a running aprsim cell.

    from aprsim import Cell
    cell = Cell.connect()
    fanuc = cell.robot("fanuc")
    fanuc.move_by([0, 0, -0.05])
    print(cell.snapshot().robot("fanuc").tool_in_world[:3, 3])

`Cell` and `Robot` block until each call is done; `aprsim.aio` has the same classes for asyncio. `Daemon`
starts a private cell, `World` is a cell in this process, `run_scenario` runs a whole job, and `aprsim.envs` has tasks with Gymnasium's
signatures. Units are SI.

Poses are 4 x 4 matrices named after their frames: X_WT is the pose of the tool T in the world W, with the
rotation in X_WT[:3, :3] and the position in metres in X_WT[:3, 3]. `aprsim.poses` lists the frames."""

from . import aio, crcl, events, faults, poses
from .calls import Bookmark, HistorySpan, Receipt, Run, SavedState
from .cameras import Camera, Picture, SeenObject
from .cell import Cell
from .daemon import Daemon
from .endpoints import Endpoints
from .errors import AprsimError, BadArgument, Refused, RobotError, ScenarioError, TimedOut, Unreachable
from .events import Event, Happens
from .previews import Preview, Touch
from .robot import Robot
from .scenarios import ScenarioReport, run_scenario, scenarios
from .snapshots import BodyState, DeviceState, RobotState, Snapshot
from .tables import bodies_table, robots_table
from .trajectories import Feedback, Followed, Trajectory, TrajectoryError
from .world import World

__all__ = [
    "AprsimError",
    "BadArgument",
    "BodyState",
    "Bookmark",
    "Camera",
    "Cell",
    "Daemon",
    "DeviceState",
    "Endpoints",
    "Event",
    "Feedback",
    "Followed",
    "Happens",
    "HistorySpan",
    "Picture",
    "Preview",
    "Receipt",
    "Refused",
    "Robot",
    "RobotError",
    "RobotState",
    "Run",
    "SavedState",
    "ScenarioError",
    "ScenarioReport",
    "SeenObject",
    "Snapshot",
    "TimedOut",
    "Touch",
    "Trajectory",
    "TrajectoryError",
    "Unreachable",
    "World",
    "aio",
    "bodies_table",
    "crcl",
    "events",
    "faults",
    "poses",
    "robots_table",
    "run_scenario",
    "scenarios",
]
