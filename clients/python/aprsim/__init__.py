"""Commands and reads a running aprsim cell.

    from aprsim import Cell
    cell = Cell.connect()
    fanuc = cell.robot("fanuc")
    fanuc.move_by([0, 0, -0.05])
    print(cell.snapshot().robot("fanuc").tool_in_world[:3, 3])

`Cell` and `Robot` wait for each call; `aprsim.aio` has the same for asyncio. `Daemon` runs a cell of
one's own, `run_scenario` a whole job; `aprsim.envs` has tasks with Gymnasium's signatures. Units are
SI, poses 4 x 4 arrays (`aprsim.poses`)."""

from . import aio, crcl, events, faults, poses
from .calls import Bookmark, HistorySpan, Receipt, Run, SavedState
from .cell import Cell
from .daemon import Daemon
from .endpoints import Endpoints
from .errors import AprsimError, Refused, RobotError, ScenarioError, TimedOut, Unreachable
from .events import Event, Happens
from .robot import Robot
from .scenarios import ScenarioReport, run_scenario, scenarios
from .snapshots import BodyState, RobotState, Snapshot
from .tables import bodies_table, robots_table

__all__ = [
    "AprsimError",
    "BodyState",
    "Bookmark",
    "Cell",
    "Daemon",
    "Endpoints",
    "Event",
    "Happens",
    "HistorySpan",
    "Receipt",
    "Refused",
    "Robot",
    "RobotError",
    "RobotState",
    "Run",
    "SavedState",
    "ScenarioError",
    "ScenarioReport",
    "Snapshot",
    "TimedOut",
    "Unreachable",
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
