"""The cell for asyncio: `aprsim.Cell` and `aprsim.Robot` with methods to be awaited.

    cell = await aio.Cell.connect()
    fanuc, motoman = await cell.robot("fanuc"), await cell.robot("motoman")
    await asyncio.gather(fanuc.move_by([0, 0, -0.05]), motoman.move_by([0, 0, -0.05]))

Let the cell run while several robots move: each waiting command steps a paused cell."""

from __future__ import annotations

import asyncio
import contextlib
import time
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, AsyncGenerator, AsyncIterator, Callable, Mapping, Sequence, TypeVar

import grpc
import grpc.aio
import numpy as np
import numpy.typing as npt

from . import arguments, calls, cameras, crcl, faults, trajectories
from .calls import Bookmark, HistorySpan, Receipt, Run, SavedState
from .cameras import CameraBase, Content, Picture, SeenObject
from .channel import Channel, open_channel
from .endpoints import Endpoints, find_endpoints
from .errors import AprsimError, TimedOut, Unreachable
from .events import Event, Happens, event
from .hosts import with_port
from .motions import (
    INITIALISE_S,
    MOVE_TIMEOUT_S,
    TURN_SPEED_RAD_S,
    Frame,
    Motions,
    check_frame,
)
from .poses import Array
from .previews import Preview
from .robot import MOST_POLL_STEPS, POLL_S, POLL_STEPS
from .robot_wires import ANSWER_S
from .snapshots import BodyState, Snapshot, seconds
from .trajectories import Feedback, Followed, Trajectory

if TYPE_CHECKING:
    from .v1 import cell_pb2, control_service_pb2, faults_pb2, snapshot_pb2

T = TypeVar("T")


class Robot:
    """As `aprsim.Robot`, for one task at a time."""

    def __init__(
        self,
        cell: Cell,
        description: cell_pb2.RobotDescription,
        reader: asyncio.StreamReader,
        writer: asyncio.StreamWriter,
    ) -> None:
        self._cell, self._reader, self._writer = cell, reader, writer
        self._motions = Motions(description)
        self._session = crcl.Session(description.name)
        self.name = description.name
        self.description = description

    @classmethod
    async def connect(
        cls, cell: Cell, description: cell_pb2.RobotDescription, host: str, port: int
    ) -> Robot:
        """Connect to the robot's CRCL socket without commanding it."""
        try:
            async with asyncio.timeout(ANSWER_S):
                reader, writer = await asyncio.open_connection(host, port)
        except OSError as error:
            where = f"{description.name} by CRCL at {with_port(host, port)}"
            raise Unreachable(f"cannot reach {where}: {error}") from error
        return cls(cell, description, reader, writer)

    async def close(self) -> None:
        """Disconnect. The robot continues its commands. A task that waits for the robot gets
        Unreachable."""
        self._writer.close()
        with contextlib.suppress(OSError):
            await self._writer.wait_closed()

    async def take(self) -> None:
        """Initialise the robot unless this connection has done so. The first command calls this."""
        if not self._session.is_taken:
            await self.initialise()

    async def initialise(self) -> None:
        """Clear an error, stop all motion, begin a session, and set the units of this connection."""
        self._session.follow(await self.status())
        for command in (
            crcl.initialise(),
            *self._session.opening(),
            crcl.set_turn_speed(TURN_SPEED_RAD_S),
        ):
            await self._start(command)
            await self.wait(INITIALISE_S)
        self._session.is_taken = True

    def forget_session(self) -> None:
        """Let the next command take the robot again, as after a reset of the cell."""
        self._session.is_taken = False

    async def end(self) -> None:
        """End the program: motion ends, the robot stays initialised. The next command takes it again."""
        await self.run(crcl.end())
        self._session.is_taken = False

    async def stop(self) -> None:
        """Brake, and wait until the arm rests. Does not take the robot."""
        await self.run(crcl.stop())

    async def move_to(
        self,
        target: npt.ArrayLike,
        yaw: float | None = None,
        *,
        straight: bool = False,
        frame: Frame = "world",
        timeout_s: float = MOVE_TIMEOUT_S,
    ) -> None:
        """Move the tool to a 4 x 4 pose or a point [m], as `aprsim.Robot.move_to`."""
        self._motions.check(target, yaw, frame)
        await self.take()
        present = await self.tool("robot")
        command = self.move_command(target, yaw, straight=straight, frame=frame, present=present)
        await self.run(command, timeout_s)

    def move_command(
        self,
        target: npt.ArrayLike,
        yaw: float | None = None,
        *,
        straight: bool = False,
        frame: Frame = "world",
        present: Array | None = None,
    ) -> crcl.Command:
        """The command that `move_to` sends. A point without a yaw needs the `present` pose X_RT."""
        return crcl.move_to(self._motions.target(target, yaw, frame, present), straight=straight)

    async def move_by(
        self,
        offset_m: npt.ArrayLike,
        *,
        frame: Frame = "world",
        timeout_s: float = MOVE_TIMEOUT_S,
    ) -> None:
        """Move the tool by three coordinates [m] on a straight line, with its orientation kept."""
        offset = arguments.vector("offset_m", offset_m, 3, "m")
        check_frame(frame)
        await self.take()
        tool = await self.tool(frame)
        tool[:3, 3] += offset
        await self.move_to(tool, straight=True, frame=frame, timeout_s=timeout_s)

    async def move_joints(
        self,
        positions_rad: npt.ArrayLike,
        speed_rad_s: float = 1.0,
        *,
        timeout_s: float = MOVE_TIMEOUT_S,
    ) -> None:
        """Move all joints, from base to flange, to positions [rad]; of prismatic joints [m]."""
        await self.run(self._motions.joints(positions_rad, speed_rad_s), timeout_s)

    async def preview(
        self,
        target: npt.ArrayLike,
        yaw: float | None = None,
        *,
        straight: bool = False,
        frame: Frame = "world",
        mode: str | None = None,
    ) -> Preview:
        """Plan what `move_to` would do, without moving. Does not take the robot; one that is not ready
        refuses every move. `mode`: direct, check or avoid; None = as set by `Cell.set_planning`."""
        self._motions.check(target, yaw, frame)
        keeps = arguments.pose_or_point("target", target).shape == (3,) and yaw is None
        present = await self.tool("robot") if keeps else None
        X_RT = self._motions.target(target, yaw, frame, present)
        return await self._cell.preview(self.name, X_RT=X_RT, straight=straight, mode=mode)

    async def preview_joints(
        self, positions_rad: npt.ArrayLike, speed_rad_s: float = 1.0, *, mode: str | None = None
    ) -> Preview:
        """Plan what `move_joints` would do, without moving."""
        return await self._cell.preview(
            self.name, positions_rad=positions_rad, speed_rad_s=speed_rad_s, mode=mode
        )

    async def follow(
        self,
        trajectory: Trajectory,
        *,
        path_tolerance_rad: npt.ArrayLike | None = None,
        goal_tolerance_rad: npt.ArrayLike | None = None,
        goal_time_s: float = 1.0,
        start_s: float | None = None,
        reset: bool = False,
        on_feedback: Callable[[Feedback], None] | None = None,
        feedback_s: float = 0.1,
        timeout_s: float | None = None,
    ) -> Followed:
        """Follow a timed joint trajectory, as `aprsim.Robot.follow`. A cancelled task stops the robot."""
        goal = trajectories.goal(
            self.description,
            trajectory,
            path_tolerance_rad=path_tolerance_rad,
            goal_tolerance_rad=goal_tolerance_rad,
            goal_time_s=goal_time_s,
            start_s=start_s,
            reset=reset,
            on_feedback=on_feedback,
            feedback_s=feedback_s,
        )
        limit_s = MOVE_TIMEOUT_S + trajectory.duration_s if timeout_s is None else timeout_s
        return await self._cell.follow_trajectory(goal, limit_s)

    async def set_speed(self, m_s: float, rad_s: float = TURN_SPEED_RAD_S) -> None:
        """Set the tool's speeds [m/s, rad/s] for later moves."""
        for command in self._motions.speeds(m_s, rad_s):
            await self.run(command)

    async def open_gripper(self) -> None:
        """Open the gripper. Returns when the robot has accepted the command."""
        await self.run(crcl.set_gripper(1))

    async def close_gripper(self) -> None:
        """Close the gripper. Returns when the robot has accepted the command."""
        await self.run(crcl.set_gripper(0))

    async def dwell(self, seconds: float) -> None:
        """Make the robot wait, in simulated seconds."""
        await self.run(*self._motions.dwell(seconds))

    async def tool(self, frame: Frame = "world") -> Array:
        """The pose of the tool: X_WT in the frame "world", X_RT in the frame "robot"."""
        check_frame(frame)
        if not self._session.is_taken:
            state = (await self._cell.snapshot(["robots"], [self.name])).robot(self.name)
            return state.tool_in_world if frame == "world" else state.tool_in_reference
        pose = (await self.status()).tool_in_reference
        if pose is None:
            raise Unreachable(f"{self.name}: its status has no pose")
        return self._motions.reference_in_world @ pose if frame == "world" else pose

    async def status(self) -> crcl.Status:
        """The robot's CRCL status, as `aprsim.Robot.status`."""
        await self._send(self._session.ask())
        status = self._session.feed(b"")
        while status is None:
            status = self._session.feed(await self._receive())
        return status

    async def run(self, command: crcl.Command, timeout_s: float = 10.0) -> crcl.Status:
        """Send any command, and wait until it is done."""
        await self.start(command)
        return await self.wait(timeout_s)

    async def start(self, command: crcl.Command) -> crcl.Status:
        """Send any command. Returns when the robot has accepted it."""
        if command.kind not in crcl.NEED_NO_SESSION:
            await self.take()
        elif not self._session.is_taken:
            self._session.follow(await self.status())
        return await self._start(command)

    async def _start(self, command: crcl.Command) -> crcl.Status:
        await self._send(self._session.begin(command))
        return await self.status()

    async def wait(self, timeout_s: float = MOVE_TIMEOUT_S) -> crcl.Status:
        """Wait for the end of the latest command."""
        limit_s = arguments.number("timeout_s", timeout_s, "s", above=0)
        waited_s, steps = 0.0, POLL_STEPS
        while True:
            waited_s += await self._let_time_pass(steps)
            steps = min(2 * steps, MOST_POLL_STEPS)
            status = await self.status()
            if self._session.is_over(status):
                return status
            if waited_s > limit_s:
                raise TimedOut(self._session.too_late(timeout_s))

    async def _let_time_pass(self, steps: int) -> float:
        if self._cell.paused:
            await self._cell.step_without_snapshot(steps)
            return steps * self._cell.step_s
        began = time.monotonic()
        await asyncio.sleep(POLL_S)
        return time.monotonic() - began

    async def _send(self, document: bytes) -> None:
        try:
            self._writer.write(document)
            await self._writer.drain()
        except OSError as error:
            raise Unreachable(f"{self.name}: {error}") from error

    async def _receive(self) -> bytes:
        try:
            async with asyncio.timeout(ANSWER_S):
                data = await self._reader.read(1 << 16)
        except TimeoutError as error:
            raise TimedOut(f"{self.name}: no status within {ANSWER_S:g} s") from error
        except OSError as error:
            raise Unreachable(f"{self.name}: {error}") from error
        if not data:
            raise Unreachable(f"{self.name}: the robot has closed the connection")
        return data


class Camera(CameraBase):
    """As `aprsim.Camera`. Each call takes a picture of the latest state."""

    def __init__(self, cell: Cell, description: cell_pb2.CameraDescription) -> None:
        super().__init__(description)
        self._cell = cell

    async def rgb(self) -> npt.NDArray[np.uint8]:
        """Colours: (height, width, 3), red, green and blue."""
        return (await self.picture("rgb")).pixels

    async def depth(self) -> npt.NDArray[np.float32]:
        """Distance along the camera's z axis [m]; 0 = nothing there."""
        return (await self.picture("depth")).pixels

    async def segmentation(self) -> npt.NDArray[np.uint16]:
        """Numbers of the visible objects; `objects` has their names."""
        return (await self.picture("segmentation")).pixels

    async def normals(self) -> npt.NDArray[np.float32]:
        """Unit normals of the surfaces in the world: (height, width, 3); 0 = nothing there."""
        return (await self.picture("normals")).pixels

    async def objects(self) -> tuple[SeenObject, ...]:
        """The objects of the running scene by their numbers in segmented pictures."""
        return (await self.picture("segmentation")).objects

    async def jpeg(self) -> bytes:
        """Colours as a JPEG file of the camera's quality."""
        return await self._cell._run(cameras.get_file(self.name, "jpeg"))

    async def png(self) -> bytes:
        """Colours as a PNG file."""
        return await self._cell._run(cameras.get_file(self.name, "png"))

    async def picture(self, content: Content = "rgb") -> Picture:
        """A picture with its step and time."""
        return await self._cell._run(cameras.get_picture(self.name, content))

    async def stream(
        self, content: Content = "rgb", hz: float | None = None
    ) -> AsyncIterator[Picture]:
        """Pictures at `hz` per second of wall time, at most 60, or at the camera's rate, until the loop
        ends. A slow reader misses some and gets the latest. A paused cell repeats its picture."""
        request = cameras.stream_request(self.name, content, hz)
        async with contextlib.aclosing(
            self._cell._stream("Camera", "StreamImages", request)
        ) as answers:
            async for answer in answers:
                yield cameras.picture_of(answer.image, content)


class Cell(Channel):
    """As `aprsim.Cell`, for the event loop that it was connected in."""

    def __init__(self, endpoints: Endpoints) -> None:
        """Call `connect` instead."""
        super().__init__(endpoints, *open_channel(endpoints, grpc.aio))
        self._robots: dict[str, Robot] = {}
        self.description: cell_pb2.CellDescription
        """Robots, bodies, belt and cameras: the part that is constant between two resets."""
        self.step_s = 0.001
        """Simulated time of one step."""

    @classmethod
    async def connect(
        cls,
        ports_file: str | Path | None = None,
        *,
        host: str | None = None,
        grpc_port: int | None = None,
        crcl_ports: dict[str, int] | None = None,
        token_file: str | Path | None = None,
        tls: bool = False,
        ca: str | Path | None = None,
        certificate: str | Path | None = None,
        key: str | Path | None = None,
    ) -> Cell:
        """As `aprsim.Cell.connect`."""
        cell = cls(
            find_endpoints(
                ports_file,
                host=host,
                grpc=grpc_port,
                crcl=crcl_ports,
                token_file=token_file,
                tls=tls,
                ca=ca,
                certificate=certificate,
                key=key,
            )
        )
        try:
            cell.description = await cell._run(calls.get_cell())
            cell.step_s = seconds(cell.description.step_size)
            await cell.snapshot(["paused"])
        except BaseException:
            await cell.close()
            raise
        return cell

    async def __aenter__(self) -> Cell:
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        await self.close()

    async def close(self) -> None:
        """Disconnect, robots included. The cell continues. Waiting calls and streams in other threads
        end with Unreachable."""
        self._cancel_open_calls()
        for robot in self._robots.values():
            await robot.close()
        self._robots.clear()
        await self._channel.close()

    async def snapshot(self, fields: Sequence[str] = (), entities: Sequence[str] = ()) -> Snapshot:
        """The latest snapshot. `fields` selects paths of the message `Snapshot`, as "robots" or
        "robots.joints.position_rad"; `entities` selects robots, bodies and tools by name. Empty means
        all."""
        return self._seen(await self._run(calls.get_snapshot(fields, entities)))

    async def stream(
        self, hz: float | None = 20.0, fields: Sequence[str] = (), entities: Sequence[str] = ()
    ) -> AsyncIterator[Snapshot]:
        """Snapshots at `hz` per second of wall time, at most 1000, until the loop ends. A slow reader
        misses some and gets the latest. `hz=None` sends every step; a reader that falls too far behind
        gets Refused."""
        request = calls.stream_request(hz, fields, entities)
        async with contextlib.aclosing(
            self._stream("Telemetry", "StreamSnapshots", request)
        ) as answers:
            async for answer in answers:
                yield self._seen(Snapshot(answer.snapshot))

    async def events(
        self,
        after: int | None = None,
        *,
        kinds: Sequence[str] = (),
        names: Sequence[str] = (),
        allow_gap: bool = False,
        past_only: bool = False,
    ) -> AsyncIterator[Event]:
        """Events of the cell in their order, until the loop ends: new ones, or those with a sequence
        number above `after`. `kinds` (see `events.KINDS`) and `names` of participants select events.
        `past_only` ends after the recorded events. Refused when requested events are not recorded any
        more, unless `allow_gap`."""
        request = calls.events_request(after, kinds, names, allow_gap, past_only)
        async with contextlib.aclosing(
            self._stream("Telemetry", "StreamEvents", request)
        ) as answers:
            async for answer in answers:
                yield event(answer.event, answer.lost)

    async def cameras(self) -> list[Camera]:
        """The cameras of the scene that the daemon has begun with."""
        return [Camera(self, camera) for camera in await self._run(cameras.list_cameras())]

    async def camera(self, name: str) -> Camera:
        """A camera, whose pictures are numpy arrays. AprsimError with the names there are."""
        return Camera(self, cameras.camera_named(await self._run(cameras.list_cameras()), name))

    async def pause(self) -> Receipt:
        """Stop stepping."""
        receipt = await self._run(calls.pause())
        self.paused = True
        return receipt

    async def resume(self) -> Receipt:
        """Continue at the set speed."""
        receipt = await self._run(calls.resume())
        self.paused = False
        return receipt

    async def step(
        self, steps: int = 1, fields: Sequence[str] = (), *, timeout_s: float | None = None
    ) -> Snapshot:
        """Step a paused cell `steps` times. Returns the snapshot after the last step."""
        return await self._run(calls.step(steps, fields, timeout_s))

    async def step_without_snapshot(self, steps: int) -> None:
        """Step a paused cell `steps` times without a snapshot."""
        await self._run(calls.step(steps, ["step"], None))

    async def run_until(
        self,
        until: float | Happens | faults.Crossing | None = None,
        *,
        max_steps: int = 0,
        fields: Sequence[str] = (),
        timeout_s: float | None = None,
    ) -> Run:
        """Run at the set speed until a simulated time [s], an event, a quantity's limit or `max_steps`
        steps, then pause. Refused (ABORTED) when another client pauses the cell. A run that is
        interrupted or exceeds `timeout_s` leaves the cell paused, as `paused` then says."""
        call = calls.run_until(until, max_steps, fields, timeout_s)
        try:
            run = await self._run(call)
        except (TimedOut, asyncio.CancelledError):
            with contextlib.suppress(AprsimError):
                await self._run(calls.pause(calls.PAUSE_S))
            self.paused = True
            raise
        self.paused = True
        return run

    async def set_speed(self, factor: float) -> Receipt:
        """Set the ratio of simulated to wall time; math.inf means as fast as possible."""
        return await self._run(calls.set_speed(factor))

    async def reset(
        self,
        seed: int | None = None,
        *,
        scene: str | None = None,
        scene_text: str | None = None,
    ) -> Receipt:
        """Build the cell again from its scene as it was loaded, with another `seed` if one is given; or
        from another scene: a shipped one by name, or the text of one. The next command of a robot
        initialises it again. Connections to robots that the other scene lacks, or has with another model
        or at another place, end; `robot` connects to the new ones."""
        receipt = await self._run(calls.reset(seed, scene, scene_text))
        await self._follow_robots()
        for robot in self._robots.values():
            robot.forget_session()
        return receipt

    async def _follow_robots(self) -> None:
        """Read the description again. If its robots are others, disconnect from those that have gone;
        the next command of the rest initialises them."""
        before, self.description = self.description, await self._run(calls.get_cell())
        gone = calls.robots_gone(before, self.description)
        if not gone and len(before.robots) == len(self.description.robots):
            return
        self.endpoints = self.endpoints.renewed()
        for name in gone & self._robots.keys():
            await self._robots.pop(name).close()
        for robot in self._robots.values():
            robot.forget_session()

    async def save(self, name: str) -> Receipt:
        """Save the state of the cell in the daemon, replacing a state of that name."""
        return await self._run(calls.save_state(name))

    async def load(self, name: str) -> Receipt:
        """Continue from a saved state, bit for bit."""
        receipt = await self._run(calls.load_state(name))
        await self._follow_robots()
        return receipt

    async def delete_state(self, name: str) -> Receipt:
        """Delete a saved state."""
        return await self._run(calls.delete_state(name))

    async def saved_states(self) -> list[SavedState]:
        """The saved states in alphabetical order."""
        return await self._run(calls.list_states())

    async def robot(self, name: str) -> Robot:
        """The connection to a robot, made once and kept. Connecting commands nothing: the robot goes on
        with its work. Its first command, or `Robot.take`, initialises it, which ends that work."""
        if name in self._robots:
            return self._robots[name]
        if self._closed:
            raise self._closed_error()
        description = calls.robot_named(self.description, name)
        port = self.endpoints.crcl_port(name)
        robot = await Robot.connect(self, description, self.endpoints.host, port)
        # Another task may have connected meanwhile.
        if name in self._robots:
            await robot.close()
            return self._robots[name]
        self._robots[name] = robot
        return robot

    async def follow_trajectory(
        self, goal: trajectories.Goal, timeout_s: float
    ) -> trajectories.Followed:
        """Follow a trajectory to its end, as `Robot.follow`. Steps a paused cell."""
        limit_s = arguments.number("timeout_s", timeout_s, "s", above=0)
        reader = asyncio.create_task(self._accept_answers(goal))
        try:
            waited_s, steps, is_over = 0.0, POLL_STEPS, False
            while not reader.done():
                if waited_s > limit_s:
                    raise goal.too_late(limit_s)
                if self.paused and goal.stream and not is_over:
                    is_over = goal.is_over(await self.step(steps, trajectories.FIELDS))
                    waited_s += steps * self.step_s
                    steps = min(2 * steps, MOST_POLL_STEPS)
                    continue
                began = time.monotonic()
                await asyncio.wait([reader], timeout=POLL_S)
                if not self.paused:
                    waited_s += time.monotonic() - began
            await reader
        finally:
            # The robot stops unless it has reached the goal.
            reader.cancel()
            await asyncio.gather(reader, return_exceptions=True)
        return goal.followed()

    async def _accept_answers(self, goal: trajectories.Goal) -> None:
        answers = self._stream("Trajectory", "FollowJointTrajectory", goal.request)
        async with contextlib.aclosing(answers):
            async for answer in answers:
                goal.accept(answer)

    async def set_planning(self, robot: str, mode: str) -> Receipt:
        """Set how a robot's later moves regard obstacles: `direct` ignores them, `check` refuses moves
        that would touch something, `avoid` also leads free moves round."""
        return await self._run(calls.set_planning(robot, mode))

    async def switch_gripper(self, robot: str, setting: float) -> Receipt:
        """Switch the valves of a gripper, 0 closed to 1 open, beside any motion."""
        return await self._run(calls.switch_gripper(robot, setting))

    async def preview(
        self,
        robot: str,
        *,
        X_RT: npt.ArrayLike | None = None,
        positions_rad: npt.ArrayLike | None = None,
        speed_rad_s: float | None = None,
        straight: bool = False,
        mode: str | None = None,
    ) -> Preview:
        """Plan a move of a robot without making it: of its tool to a pose X_RT in the robot's reference
        frame, or of all joints to positions [rad], at most at a speed [rad/s]. `mode` takes the place of
        the one that `set_planning` has set. A move that would be refused is no error."""
        return await self._run(
            calls.preview(robot, X_RT, positions_rad, speed_rad_s, straight, mode)
        )

    async def set_conveyor(
        self,
        run: bool | None = None,
        *,
        forward: bool | None = None,
        speed_m_s: float | None = None,
        emergency_stop: bool | None = None,
        fault_reset: bool = False,
    ) -> snapshot_pb2.ConveyorState:
        """Set inputs of the belt drive; None leaves an input unchanged. Returns the state of the belt."""
        return await self._run(
            calls.set_conveyor(run, forward, speed_m_s, emergency_stop, fault_reset)
        )

    async def set_signal(self, device: str, signal: str, value: float) -> Receipt:
        """Set an input of a device that an extension makes. Raises AprsimError with the name, the value and
        the range where the device does not take it."""
        return await self._run(calls.set_signal(device, signal, value))

    async def scene_text(self) -> str:
        """The present scene as YAML. Bodies have their initial poses."""
        return await self._run(calls.get_scene())

    async def spawn(self, type_name: str, name: str, X_WB: Array) -> BodyState:
        """Add a gear, tray or part of a type of `description.body_types` at X_WB: the 4 x 4 pose of the body's
        frame B in the world's frame W, with the position in metres in X_WB[:3, 3] (`aprsim.poses`).
        An occupied place moves it up until it is free. Scene edits last until a reset."""
        body = await self._run(calls.spawn_body(type_name, name, X_WB))
        self.description = await self._run(calls.get_cell())
        return body

    async def move_body(self, name: str, X_WB: Array) -> BodyState:
        """Move a body to the pose X_WB, at rest, as `spawn` does."""
        return await self._run(calls.move_body(name, X_WB))

    async def remove_body(self, name: str) -> Receipt:
        """Remove a body from the cell."""
        return await self._run(calls.remove_body(name))

    async def set_scene_value(self, path: str, value: object) -> Receipt:
        """Set a value of the scene by the path of its keys, as "physics.friction.gear_tray". Physics,
        types of gears and trays, and cameras have such values. The cell's state is unchanged."""
        receipt = await self._run(calls.set_scene_value(path, value))
        self.description = await self._run(calls.get_cell())
        return receipt

    async def inject_fault(
        self,
        kind: str,
        target: str = "",
        parameters: Mapping[str, float] | None = None,
        *,
        when: faults.Trigger | None = None,
        duration_s: float | None = None,
    ) -> faults_pb2.InjectedFault:
        """Inject a fault at the next step, or at the trigger `when` (`aprsim.faults`). It lasts
        `duration_s` of simulated time, or until `end_fault`."""
        return await self._run(
            calls.inject_fault(kind, target, parameters or {}, when, duration_s)
        )

    async def end_fault(self, identifier: int) -> Receipt:
        """End an active fault at the next step, or cancel a pending one."""
        return await self._run(calls.end_fault(identifier))

    async def report_event(self, event: str) -> Receipt:
        """Report an event by name: the trigger of faults with `faults.Reported`."""
        return await self._run(calls.report_event(event))

    async def fault_kinds(self) -> control_service_pb2.ListFaultKindsResponse:
        """All kinds with their parameters, and the quantities for `faults.Crossing` with their units."""
        return await self._run(calls.fault_kinds())

    # -- the past -----------------------------------------------------------------------------

    async def history(self) -> list[HistorySpan]:
        """The recorded spans of the past, oldest first; the last one belongs to the present epoch."""
        return await self._run(calls.get_history())

    async def past(
        self, step: int, epoch: int | None = None, fields: Sequence[str] = ()
    ) -> Snapshot:
        """The snapshot after a past step, bit for bit, of the present epoch or of `epoch`."""
        return await self._run(calls.get_past(await self._epoch(epoch), step, fields))

    async def past_range(
        self,
        begin: int,
        end: int,
        stride: int = 20,
        epoch: int | None = None,
        fields: Sequence[str] = (),
    ) -> AsyncIterator[Snapshot]:
        """The snapshots from step `begin` to step `end`, one every `stride` steps."""
        request = calls.past_request(await self._epoch(epoch), begin, end, stride, fields)
        async with contextlib.aclosing(self._stream("History", "StreamPast", request)) as answers:
            async for answer in answers:
                yield Snapshot(answer.snapshot)

    async def resume_from(self, step: int, epoch: int | None = None) -> Receipt:
        """Return the cell to a past step. It continues from there, bit for bit."""
        return await self._run(calls.resume_from(await self._epoch(epoch), step))

    async def bookmarks(self) -> list[Bookmark]:
        """Marked moments of the past: set by clients, or by the daemon at events."""
        return await self._run(calls.list_bookmarks())

    async def add_bookmark(self, step: int, text: str, epoch: int | None = None) -> Bookmark:
        """Mark a past step with a text."""
        return await self._run(calls.add_bookmark(await self._epoch(epoch), step, text))

    async def remove_bookmark(self, identifier: int) -> None:
        """Remove a bookmark."""
        await self._run(calls.remove_bookmark(identifier))

    async def incident(self, last_s: float = 60.0) -> bytes:
        """The last simulated seconds of the run as a journal for `aprsim replay`. It begins at the
        latest checkpoint before them."""
        request = calls.incident_request(last_s)
        async with contextlib.aclosing(
            self._stream("Journal", "GetIncident", request)
        ) as answers:
            return b"".join([piece.data async for piece in answers])

    async def _epoch(self, epoch: int | None) -> int:
        if epoch is not None:
            return epoch
        return int((await self._run(calls.get_snapshot(["epoch"]))).message.epoch)

    async def _run(self, call: calls.Call[T]) -> T:
        open_call = self._stub(call.service, call.method)(
            call.request, timeout=call.timeout_s, metadata=self._metadata
        )
        self._open_calls.add(open_call)
        try:
            return call.read(await open_call)
        except grpc.RpcError as error:
            raise self._error(error) from error
        except asyncio.CancelledError as error:
            self._raise_if_closed(error)
            raise
        finally:
            self._open_calls.discard(open_call)

    async def _stream(
        self, service: calls.Service, method: str, request: Any
    ) -> AsyncGenerator[Any, None]:
        call = self._stub(service, method)(request, metadata=self._metadata)
        self._open_calls.add(call)
        try:
            async for answer in call:
                yield answer
        except grpc.RpcError as error:
            raise self._error(error) from error
        except asyncio.CancelledError as error:
            self._raise_if_closed(error)
            raise
        finally:
            call.cancel()
            self._open_calls.discard(call)

    def _raise_if_closed(self, error: BaseException) -> None:
        """gRPC reports a call that `close` has cancelled as a cancelled task."""
        task = asyncio.current_task()
        if self._closed and (task is None or not task.cancelling()):
            raise self._closed_error() from error
