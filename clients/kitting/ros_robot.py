"""A robot behind the wires of the laboratory's ROS 2 controllers: Simple Message for motion and state, and
its gripper's port. The controller itself finds the joints for a place of the tool."""

from __future__ import annotations

import contextlib
import math
import struct
import threading
from typing import Callable, Sequence

import simple_message as wire
from cell import Robot, RosWires
from clock import Clock
from crcl_robot import Counters, Interrupted, RobotError, RobotLost, Status
from joint_path import TimedPoint, Unreachable, goal, line, timed

_ARRIVED_RAD, _STANDS_RAD = 0.002, 2e-5
_READY_S = 10.0
_SPEED_SHARE = 0.3  # of the joints' speeds, for motions that the controller times itself
_GRIPPER_WORDS = {True: 0, False: 1}
_ASK_STATE = 3


class RosRobot:
    """The connections to one robot, with the methods of CrclRobot. Used by one thread at a time;
    `interrupt` comes from any."""

    def __init__(
        self,
        robot: Robot,
        wires: RosWires,
        *,
        clock: Clock | None = None,
        answer_s: float = 5.0,
        move_limit_s: float = 95.0,
        log: Callable[[str, str], None] = lambda event, text: None,
    ) -> None:
        self.name, self.host, self.ports = robot.name, robot.host, wires.ports
        self.chain, self.rest = wires.chain, [math.radians(a) for a in robot.home_joints_deg]
        self.clock, self.answer_s = clock or Clock(0.025), answer_s
        self.move_limit_s, self.log = move_limit_s, log
        self.counters = Counters()
        self.last: Status | None = None
        self._links: dict[str, wire.Connection] = {}
        self._joints: list[float] = []  # measured, of the latest state
        # Measured before the latest poll with a state; states of one poll may be of one moment.
        self._before: list[float] = []
        self._status: tuple[int, ...] | None = None
        self._states = 0  # that have come on this connection
        self._at: list[float] | None = None  # where the last motion has ended
        self._closed = False  # the gripper, by command
        self._number = 0  # of commands, for the status
        self._speed_mm_s = 400.0
        self._kept = False
        self._interrupted = threading.Event()

    # -- connection ---------------------------------------------------------------------------

    def connect(self) -> Status:
        if not self._kept or not self._links:
            self.open()
        self._kept = False
        status = self.status()
        while self._status is None or not self._joints:
            if self._interrupted.is_set():
                raise Interrupted(self.name)
            self.clock.after_poll(self._interrupted)
            status = self.status()
        return status

    def open(self) -> None:
        self.close()
        try:
            for what in ("state", "motion", "gripper"):
                self._links[what] = wire.Connection(self.host, self.ports[what], self.answer_s)
        except wire.WireError as error:
            self.close()
            raise RobotLost(f"{self.name}: {error}") from error
        self._joints, self._before, self._status, self._at = [], [], None, None
        self._states = 0

    def begin(self, clock: Clock, log: Callable[[str, str], None]) -> None:
        """Begin a job in a cell that has been reset; open connections stay."""
        self.clock, self.log = clock, log
        self.counters, self.last = Counters(), None
        self._at, self._closed = None, False
        self._kept = bool(self._links)

    def initialise(self) -> None:
        """Make the robot ready for points, as far as its controller can be asked for that."""
        self._at = None
        deadline = self.clock.now() + _READY_S
        while not self.is_ready():
            if self.clock.now() > deadline:
                raise RobotError(f"{self.name} is not ready: {self.describe()}")
            self._poll()

    def is_ready(self) -> bool:
        raise NotImplementedError

    @property
    def connected(self) -> bool:
        return bool(self._links)

    def close(self) -> None:
        for link in self._links.values():
            link.close()
        self._links = {}

    def wait(self, seconds: float) -> None:
        self.clock.wait(seconds, self._interrupted, self.status)

    def hang_up(self) -> None:
        for link in list(self._links.values()):
            with contextlib.suppress(OSError):
                link.hang_up()

    def interrupt(self) -> None:
        self._interrupted.set()

    # -- commands -----------------------------------------------------------------------------

    def move(self, xyz_mm: Sequence[float], yaw: float, *, straight: bool) -> None:
        place = (xyz_mm[0] / 1e3, xyz_mm[1] / 1e3, xyz_mm[2] / 1e3)
        begin = self._here()
        try:
            if straight:
                path = line(self.chain, begin, place, yaw, self.rest)
            else:
                path = [goal(self.chain, begin, place, yaw, self.rest)]
        except Unreachable as problem:
            raise RobotError(str(problem)) from problem
        at, _ = self.chain.forward(begin)
        self._follow(begin, path, math.dist(at, place) if straight else 0.0)

    def move_joints(self, joints_deg: Sequence[float], speed_deg_s: float) -> None:
        del speed_deg_s  # the share of the joints' speeds is used
        self._follow(self._here(), [[math.radians(a) for a in joints_deg]], 0.0)

    def set_speed(self, mm_s: float, deg_s: float) -> None:
        del deg_s
        self._speed_mm_s = mm_s

    def set_gripper(self, opened: bool) -> None:
        self.counters.count("open" if opened else "close")
        self._number += 1
        self._actuate(opened)
        self._closed = not opened

    def dwell(self, seconds: float) -> None:
        self.wait(seconds)

    def enable_sensor(self, name: str) -> None:
        raise RobotError(f"no sensor {name} on these wires")

    def sees_person(self, status: Status) -> bool:
        return False

    def stop(self) -> None:
        raise NotImplementedError

    def status(self) -> Status:
        """Ask the gripper's port, which in virtual time is the clock, and take the states that have come."""
        try:
            self._ask_gripper()
            link = self._link("state")
            before, states = self._joints, self._states
            while link.readable():
                self._take_state(link.receive())
            if self._states != states:
                self._before = before
        except wire.WireError as error:
            self.close()
            raise RobotLost(f"{self.name}: {error}") from error
        self.clock.polled(self.name)
        tool_mm = tool_yaw = None
        if self._joints:
            at, axes = self.chain.forward(self._joints)
            tool_mm = (at[0] * 1e3, at[1] * 1e3, at[2] * 1e3)
            tool_yaw = math.atan2(axes[1][0], axes[0][0])
        self.last = Status(
            command_id=self._number,
            state="CRCL_Error" if self._fails() else "CRCL_Done",
            description=self.describe(),
            tool_mm=tool_mm,
            tool_yaw=tool_yaw,
            # No sensor tells; the gripper counts as it was commanded.
            holding=self._closed,
            separation_mm=None,
            force_n={},
            switches={},
        )
        return self.last

    def describe(self) -> str:
        if self._status is None:
            return "no status"
        _, e_stopped, code, in_error, _, _, possible = self._status
        if e_stopped:
            return "emergency stop"
        if in_error:
            return f"error {code}"
        return "" if possible else "motion is not possible"

    # -- parts of both robots -----------------------------------------------------------------

    def _fails(self) -> bool:
        return self._status is not None and bool(self._status[1] or self._status[3])

    def _link(self, what: str) -> wire.Connection:
        link = self._links.get(what)
        if link is None:
            raise RobotLost(f"{self.name}: not connected")
        return link

    def _take_state(self, message: bytes) -> None:
        if wire.kind_of(message) == wire.STATUS:
            self._status = wire.status_of(message)
            return
        self._joints = self.from_wire(wire.joints_of(message, len(self.chain.joints)))
        self._states += 1

    def from_wire(self, joints: list[float]) -> list[float]:
        return joints

    def to_wire(self, joints: Sequence[float]) -> list[float]:
        return list(joints)

    def _here(self) -> list[float]:
        """The joints at which the next motion begins: the commanded ones, if the robot stands there."""
        self._await(self._stands, "stand")
        if self._at is not None and self._is_at(self._at):
            return self._at
        return list(self._joints)

    def _is_at(self, joints: Sequence[float]) -> bool:
        return bool(self._joints) and all(
            abs(a - b) < _ARRIVED_RAD for a, b in zip(self._joints, joints)
        )

    def _stands(self) -> bool:
        return bool(self._before) and all(
            abs(a - b) < _STANDS_RAD for a, b in zip(self._joints, self._before)
        )

    def _follow(self, begin: list[float], path: list[list[float]], way_m: float) -> None:
        self._number += 1
        end = path[-1]
        if not self.chain.within_limits(end):
            raise RobotError("a joint would leave its limits")
        self._send_path(begin, path, way_m)
        self._at = end
        self._await(lambda: self._is_at(end) and self._stands(), "arrive")

    def _await(self, condition: Callable[[], bool], what: str) -> None:
        deadline = self.clock.now() + self.move_limit_s
        states = self._states
        # Two states that are newer than the request.
        while not (self._states >= states + 2 and condition()):
            if self.clock.now() > deadline:
                raise RobotLost(f"{self.name} does not {what} within {self.move_limit_s:g} s")
            self._poll()

    def _poll(self) -> None:
        if self._interrupted.is_set():
            raise Interrupted(self.name)
        self.status()
        if self._fails():
            raise RobotError(f"{self.name}: {self.describe()}")
        self.clock.after_poll(self._interrupted)

    def _ask(self, what: str, data: bytes, name: str) -> bytes:
        """A request that is answered at once."""
        self.counters.count(name)
        try:
            self._link(what).send(data)
            return self._link(what).receive()
        except wire.WireError as error:
            self.close()
            raise RobotLost(f"{self.name}: {error}") from error

    def _ask_gripper(self) -> None:
        raise NotImplementedError

    def _actuate(self, opened: bool) -> None:
        raise NotImplementedError

    def _send_path(self, begin: list[float], path: list[list[float]], way_m: float) -> None:
        raise NotImplementedError


class KarelRobot(RosRobot):
    """ROS-Industrial's Karel programs. Points are joint moves at a speed of the program's own; the answer
    to a point comes when the program has room for it."""

    def from_wire(self, joints: list[float]) -> list[float]:
        # The third joint is counted against the horizontal.
        return [*joints[:2], joints[2] + joints[1], *joints[3:]]

    def to_wire(self, joints: Sequence[float]) -> list[float]:
        return [*joints[:2], joints[2] - joints[1], *joints[3:]]

    def is_ready(self) -> bool:
        self.status()
        return self._status is not None and not self._fails()

    def stop(self) -> None:
        with contextlib.suppress(wire.WireError):
            self._link("motion").send(wire.fanuc_point(wire.STOP_SEQUENCE, [0.0] * 6))

    def _ask_gripper(self) -> None:
        link = self._link("gripper")
        link.send(struct.pack(">i", _ASK_STATE))
        link.take(4)

    def _actuate(self, opened: bool) -> None:
        link = self._link("gripper")
        try:
            link.send(struct.pack(">i", _GRIPPER_WORDS[opened]))
            link.take(4)
        except wire.WireError as error:
            self.close()
            raise RobotLost(f"{self.name}: {error}") from error

    def _send_path(self, begin: list[float], path: list[list[float]], way_m: float) -> None:
        del begin, way_m
        link = self._link("motion")
        deadline = self.clock.now() + self.move_limit_s
        try:
            for sequence, joints in enumerate(path):
                self.counters.count("point")
                link.send(wire.fanuc_point(sequence, self.to_wire(joints)))
                # Polls go on while the program makes room. The first one comes before any look, so that it does
                # not matter how fast the answer is.
                self.status()
                while not link.readable():
                    if self.clock.now() > deadline:
                        raise RobotLost(f"{self.name}: point {sequence} is not acknowledged")
                    self._poll()
                link.receive()
        except wire.WireError as error:
            self.close()
            raise RobotLost(f"{self.name}: {error}") from error


class MotoRosRobot(RosRobot):
    """MotoROS on the Motoman: timed points after START_TRAJ_MODE, valves and air as outputs."""

    OPEN_VALVE, CLOSE_VALVE, AIR = 10010, 10011, 10012

    def is_ready(self) -> bool:
        reply = self._start()
        self._set_output(self.AIR, True)
        self.status()
        return wire.result_of(reply)[0] == wire.SUCCESS and not self._fails()

    def _start(self) -> bytes:
        """Polls go on meanwhile: the reply comes once the drives are on."""
        self.counters.count("start")
        link = self._link("motion")
        deadline = self.clock.now() + _READY_S
        try:
            link.send(wire.motion_control(wire.START_TRAJECTORY_MODE))
            self.status()
            while not link.readable():
                if self.clock.now() > deadline:
                    raise RobotLost(f"{self.name}: START_TRAJ_MODE is not answered")
                if self._interrupted.is_set():
                    raise Interrupted(self.name)
                self.status()
                self.clock.after_poll(self._interrupted)
            return link.receive()
        except wire.WireError as error:
            self.close()
            raise RobotLost(f"{self.name}: {error}") from error

    def stop(self) -> None:
        self._ask("motion", wire.motion_control(wire.STOP_MOTION), "stop")

    def _ask_gripper(self) -> None:
        link = self._link("gripper")
        link.send(wire.read_bit(self.OPEN_VALVE))
        link.receive()

    def _actuate(self, opened: bool) -> None:
        # Never both at once.
        self._set_output(self.OPEN_VALVE if not opened else self.CLOSE_VALVE, False)
        self._set_output(self.OPEN_VALVE if opened else self.CLOSE_VALVE, True)

    def _set_output(self, address: int, on: bool) -> None:
        self._ask("gripper", wire.write_bit(address, on), "output")

    def _send_path(self, begin: list[float], path: list[list[float]], way_m: float) -> None:
        least_s = 2.0 * way_m * 1e3 / self._speed_mm_s
        points = timed(self.chain, [begin, *path], _SPEED_SHARE, least_s)
        for sequence, point in enumerate(points):
            self._send_point(sequence, point)

    def _send_point(self, sequence: int, point: TimedPoint) -> None:
        deadline = self.clock.now() + self.move_limit_s
        data = wire.motoman_point(sequence, point.time_s, self.to_wire(point.joints), point.speeds)
        while True:
            result, subcode = wire.result_of(self._ask("motion", data, "point"))
            if result == wire.SUCCESS:
                return
            if result != wire.BUSY:
                raise RobotError(f"{self.name} refuses point {sequence}: {result} {subcode}")
            if self.clock.now() > deadline:
                raise RobotLost(f"{self.name} is busy for ever")
            self._poll()


ROBOTS: dict[str, type[RosRobot]] = {"fanuc_karel": KarelRobot, "motoman_fs100": MotoRosRobot}
