"""The task of sorting gears from the moving belt into bins."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Sequence

import numpy as np
import numpy.typing as npt

from .. import arguments
from ..cell import Cell
from ..errors import AprsimError
from ..poses import Array, inverse, matrix, wrapped, yaw_of
from .cell_env import CellEnv
from .layout import Gear, Layout
from .scripted import APPROACH_M, tool_action
from .spaces import Vector

if TYPE_CHECKING:
    from ..v1 import cell_pb2

NAMES = (
    "gear_from_tool_x_m",
    "gear_from_tool_y_m",
    "gear_from_tool_z_m",
    "place_from_gear_x_m",
    "place_from_gear_y_m",
    "place_from_gear_z_m",
    "turn_to_belt_rad",
    "opening_m",
    "held",
    "gear_x_m_s",
    "gear_y_m_s",
    "along_belt_m",
    "sorted",
)
BIN = "bin_"
"""Begin of the name of a bin; the type of its gears follows."""
_FIRST_M = 0.3  # of the first gear upstream of the place before the robot
_AWAIT_M = 0.12  # at which the scripted policy awaits a gear upstream of that place
_PAST_M = 0.45  # place along the belt at which a gear is out of reach
_GAP_M = (0.24, 0.3)  # between gears along the belt
_ASIDE_M = 0.04  # largest offset of a gear across the belt
_LEAST_M_S = 0.6  # share of the highest speed
_CARRY_M = 0.08  # height over the bin's floor for sideways motions
_DROP_M = 0.02  # height over the bin's floor at the release
_HOVER_M = 0.04  # height at which the tool follows the gear before it comes down
_OVER_M, _AT_M = 0.003, 0.001  # tolerances of the scripted policy
_STEP_S, _S_PER_M = 0.25, 4.0  # time of a step: at least, and for its distance


@dataclass(frozen=True)
class Bin:
    """A bin, and the place in it for one gear."""

    low_m: Array
    high_m: Array
    place_m: Array
    """Origin of the gear on the bin's floor, in the world."""

    def contains(self, point: Array) -> bool:
        """Whether a point in the world is between the walls and below their top."""
        return bool(((self.low_m < point) & (point < self.high_m)).all())


class SortEnv(CellEnv):
    """Sort the loose gears on the moving belt, each into the bin of its type: a fixture with the name
    `bin_TYPE`. The gears come in a random order, at random places across the belt, at a random speed of
    each episode. The task is lost when a gear has passed the robot. The number `along_belt_m` is the
    gear's place along the belt, 0 before the robot."""

    observation_names = NAMES

    def __init__(
        self,
        cell: Cell | None = None,
        *,
        robot: str = "fanuc",
        belt_m_s: float = 0.03,
        scene: str = "sorting",
        max_steps: int | None = 400,
        **arguments_of_cell: Any,
    ) -> None:
        """`belt_m_s` is the belt's highest speed. Other arguments are those of `CellEnv`."""
        self._highest_m_s = arguments.number("belt_m_s", belt_m_s, "m/s", above=0, high=0.1)
        super().__init__(
            cell, robots=(robot,), scene=scene, max_steps=max_steps, **arguments_of_cell
        )

    def scripted_action(self, state: npt.ArrayLike) -> Vector:
        """Wait for the gear, follow it, down, close and go along with it, up, above its bin, open."""
        values = arguments.vector("observation", state, len(NAMES), "").tolist()
        if values[12] >= 1.0:
            return tool_action(0.0, 0.0, 0.05, 0.0, opened=True)
        if values[8] > 0.5:
            return _carry(values[3:6])
        belt_x, belt_y = values[9:11]  # of a gear that is not held
        speed = math.hypot(belt_x, belt_y)
        # A gear that is still upstream is awaited.
        ahead = max(0.0, -_AWAIT_M - values[11]) / speed if speed > 0.0 else 0.0
        x, y, height = values[0] + ahead * belt_x, values[1] + ahead * belt_y, -values[2]
        over = math.hypot(x, y) < _OVER_M + 0.2 * speed and abs(values[6]) < 0.01 and not ahead
        if height < _AT_M:
            return tool_action(_STEP_S * belt_x, _STEP_S * belt_y, -height, 0.0, opened=False)
        down = -height if over else _HOVER_M - height
        way_m = max(abs(x), abs(y), abs(down))
        step_s = 0.0 if ahead else _STEP_S + _S_PER_M * min(way_m, 0.05)
        return tool_action(x + step_s * belt_x, y + step_s * belt_y, down, values[6], opened=True)

    # -- tasks --------------------------------------------------------------------------------

    def _bounds(self) -> tuple[Sequence[float], Sequence[float]]:
        low = (-3.0,) * 6 + (-math.pi, 0.0, 0.0, -1.0, -1.0, -3.0, 0.0)
        return low, (3.0,) * 6 + (math.pi, 0.2, 1.0, 1.0, 1.0, 3.0, 1.0)

    def _begin_task(self) -> None:
        description = self.cell.description
        if not description.HasField("conveyor"):
            raise AprsimError(f"the scene '{description.scene}' has no belt")
        self._belt: Array = matrix(description.conveyor.belt_in_world)
        base = matrix(self.robot.description.base_in_world)[:3, 3]
        self._before_m = float((inverse(self._belt) @ np.append(base, 1.0))[0])
        layout = Layout(description, self.cell.snapshot(["bodies"]))
        boxes = {each.name: _inside(each) for each in description.fixtures}
        self._gears = {
            name: gear
            for name, gear in layout.gears.items()
            if layout.over_belt(gear.position_m) and BIN + gear.type in boxes
        }
        if not self._gears:
            raise AprsimError("the scene has no gear on a belt with a fixture bin_TYPE for it")
        self._bins = {name: self._bin(gear, boxes) for name, gear in self._gears.items()}

    def _bin(self, gear: Gear, boxes: dict[str, tuple[Array, Array]]) -> Bin:
        """The bin of a gear. Gears of one type have places side by side along the bin's longer side."""
        low, high = boxes[BIN + gear.type]
        same = [each.name for each in self._gears.values() if each.type == gear.type]
        axis = int(np.argmax((high - low)[:2]))
        place = (low + high) / 2
        place[axis] += (high - low)[axis] * ((same.index(gear.name) + 0.5) / len(same) - 0.5)
        place[2] = low[2] + self._height_on_belt(gear)
        return Bin(low, high, place)

    def _height_on_belt(self, gear: Gear) -> float:
        return float((inverse(self._belt) @ gear.pose)[2, 3])

    def _prepare(self, options: dict[str, Any]) -> None:
        self._load("work")
        self._plan = [str(name) for name in self.np_random.permutation(list(self._gears))]
        self._count = len(self._plan)
        along = self._before_m - _FIRST_M
        for name in self._plan:
            place = np.eye(4)
            aside = float(self.np_random.uniform(-_ASIDE_M, _ASIDE_M))
            place[:3, 3] = [along, aside, self._height_on_belt(self._gears[name])]
            self.cell.move_body(name, self._belt @ place)
            along -= float(self.np_random.uniform(*_GAP_M))
        self._arms[0].opened = True
        self._current = self._plan[0]
        first = self._gears[self._current]
        point = (self._belt @ [self._before_m - _AWAIT_M, 0.0, 0.0, 1.0])[:3]
        point[2] += self._height_on_belt(first) + first.grasp_height_m
        yaw = yaw_of(self._belt) + math.pi / 2
        self._move_near(self.robot, point, self._nearest_turn(yaw), 0.02, 0.1, APPROACH_M)
        speed = float(self.np_random.uniform(_LEAST_M_S, 1.0)) * self._highest_m_s
        self.cell.set_conveyor(True, forward=True, speed_m_s=speed)

    def _nearest_turn(self, yaw: float) -> float:
        """The yaw or its half turn, which exchanges the fingers: the one nearer to the tool's."""
        return min((yaw, yaw + math.pi), key=lambda each: abs(wrapped(each - yaw_of(self.robot.tool()))))

    def _next_goal(self) -> bool:
        self._plan = self._plan[1:]
        if self._plan:
            self._current = self._plan[0]
        return bool(self._plan)

    def _gear_m(self, name: str) -> Array:
        return self._snapshot.body(name).position_m

    def _along_m(self, name: str) -> float:
        along = (inverse(self._belt) @ np.append(self._gear_m(name), 1.0))[0]
        return float(along) - self._before_m

    def _is_held(self) -> bool:
        return self._snapshot.robot(self.robot.name).held_body == self._current

    def _from_tool_m(self) -> Array:
        grasp = np.array([0.0, 0.0, self._gears[self._current].grasp_height_m])
        tool = self._snapshot.robot(self.robot.name).tool_in_world[:3, 3]
        out: Array = self._gear_m(self._current) + grasp - tool
        return out

    def _place_from_gear_m(self) -> Array:
        out: Array = self._bins[self._current].place_m - self._gear_m(self._current)
        return out

    def _potential(self) -> float:
        far = 2.0 * float(np.linalg.norm(self._place_from_gear_m()))
        if self._is_held():
            return 0.5 - far
        return -far - 2.0 * float(np.linalg.norm(self._from_tool_m()))

    def _is_done(self) -> bool:
        """Whether the gear rests in its bin and no gripper holds it."""
        inside = self._bins[self._current].contains(self._gear_m(self._current))
        return inside and self._snapshot.body(self._current).resting and not self._is_held()

    def _is_lost(self) -> bool:
        """Whether a gear has fallen out of the cell, or has passed the robot on the belt."""
        layout = Layout(self.cell.description, self._snapshot)
        return any(
            self._snapshot.body(name).lost
            or (self._along_m(name) > _PAST_M and layout.over_belt(self._gear_m(name)))
            for name in self._plan
        )

    def _values(self) -> Sequence[float]:
        robot = self._snapshot.robot(self.robot.name)
        # The fingers close along the belt. Half a turn exchanges them.
        turn = wrapped(yaw_of(self._belt) + math.pi / 2 - yaw_of(robot.tool_in_world))
        turn = (turn + math.pi / 2) % math.pi - math.pi / 2
        velocity = self._snapshot.body(self._current).velocity_m_s[:2]
        grip = (turn, robot.separation_m, float(self._is_held()))
        along, done = self._along_m(self._current), 1.0 - len(self._plan) / self._count
        return [*self._from_tool_m(), *self._place_from_gear_m(), *grip, *velocity, along, done]

    def _task_info(self) -> dict[str, Any]:
        return {"gear": self._current, "bin": BIN + self._gears[self._current].type}


def _carry(place: Sequence[float]) -> Vector:
    """Up, above the place, down, open."""
    height = -place[2]
    if math.hypot(place[0], place[1]) > 5 * _AT_M:
        if height < 0.8 * _CARRY_M:
            return tool_action(0.0, 0.0, _CARRY_M - height, 0.0, opened=False)
        return tool_action(place[0], place[1], 0.0, 0.0, opened=False)
    at = height < _DROP_M + _AT_M
    return tool_action(0.0, 0.0, _DROP_M - height, 0.0, opened=at)


def _inside(fixture: cell_pb2.FixtureDescription) -> tuple[Array, Array]:
    """Lowest and highest corner of the space in a bin of boxes along x and y of the world."""
    frame = matrix(fixture.fixture_in_world)
    boxes = []
    for piece in fixture.pieces:
        middle = (frame @ matrix(piece.piece_in_body))[:3, 3]
        size = piece.box.size_m
        half = np.array([size.x, size.y, size.z]) / 2
        boxes.append((middle - half, middle + half))
    low = np.min([box[0] for box in boxes], axis=0)
    high = np.max([box[1] for box in boxes], axis=0)
    return low, high
