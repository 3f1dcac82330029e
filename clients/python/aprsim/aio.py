"""The cell, for asyncio: as `aprsim.Cell` and `aprsim.Robot`, each call to be awaited.

    cell = await aio.Cell.connect()
    fanuc, motoman = await cell.robot("fanuc"), await cell.robot("motoman")
    await asyncio.gather(fanuc.move_by([0, 0, -0.05]), motoman.move_by([0, 0, -0.05]))

Whose robots move at the same time lets the cell run: of a paused cell each waiting command steps it."""

from __future__ import annotations

import asyncio
import contextlib
import time
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, AsyncIterator, Mapping, Sequence, TypeVar

import grpc
import grpc.aio
import numpy as np
import numpy.typing as npt

from . import calls, crcl, faults
from .calls import Bookmark, HistorySpan, Receipt, Run, SavedState
from .channel import Channel
from .endpoints import Endpoints, find_endpoints
from .errors import TimedOut, Unreachable
from .events import Event, Happens, event
from .motions import MOVE_TIMEOUT_S, TURN_SPEED_RAD_S, Frame, Motions
from .poses import Array
from .robot import ANSWER_S, MOST_POLL_STEPS, POLL_S, POLL_STEPS
from .snapshots import BodyState, Snapshot, seconds

if TYPE_CHECKING:
    from .v1 import cell_pb2, control_service_pb2, faults_pb2, snapshot_pb2

T = TypeVar("T")


class Robot:
    """As `aprsim.Robot`. Used by one task at a time."""

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
        """Without initialising it."""
        try:
            async with asyncio.timeout(ANSWER_S):
                reader, writer = await asyncio.open_connection(host, port)
        except OSError as error:
            where = f"{description.name} by CRCL at {host}:{port}"
            raise Unreachable(f"cannot reach {where}: {error}") from error
        robot = cls(cell, description, reader, writer)
        robot._session.follow(await robot.status())
        return robot

    async def close(self) -> None:
        """Hangs up. What the robot has been told goes on."""
        self._writer.close()
        with contextlib.suppress(OSError):
            await self._writer.wait_closed()

    async def initialise(self) -> None:
        """Clears an error, ends all motion, makes ready, and sets the units of this connection."""
        await self.run(crcl.initialise(), 35)
        for command in self._session.opening():
            await self.run(command)
        await self.run(crcl.set_turn_speed(TURN_SPEED_RAD_S))

    async def end(self) -> None:
        """Sends `EndCanon`: motion ends, and the robot stays initialised."""
        await self.run(crcl.end())

    async def stop(self) -> None:
        """Brakes, and waits until the arm rests."""
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
        """The tool to a 4 x 4 pose or a point."""
        present = (await self.status()).tool_in_reference
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
        """What `move_to` tells the robot; a point without a yaw needs the `present` pose X_RT."""
        return crcl.move_to(self._motions.target(target, yaw, frame, present), straight=straight)

    async def move_by(
        self,
        offset_m: npt.ArrayLike,
        *,
        frame: Frame = "world",
        timeout_s: float = MOVE_TIMEOUT_S,
    ) -> None:
        """The tool on a straight line, as it is turned."""
        tool = await self.tool(frame)
        tool[:3, 3] += np.asarray(offset_m, dtype=np.float64)
        await self.move_to(tool, straight=True, frame=frame, timeout_s=timeout_s)

    async def move_joints(
        self,
        positions_rad: npt.ArrayLike,
        speed_rad_s: float = 1.0,
        *,
        timeout_s: float = MOVE_TIMEOUT_S,
    ) -> None:
        """All joints, from base to flange."""
        await self.run(self._motions.joints(positions_rad, speed_rad_s), timeout_s)

    async def set_speed(self, m_s: float, rad_s: float = TURN_SPEED_RAD_S) -> None:
        """Of the tool, from now on."""
        await self.run(crcl.set_speed(m_s))
        await self.run(crcl.set_turn_speed(rad_s))

    async def open_gripper(self) -> None:
        """Returns when the fingers have been told to."""
        await self.run(crcl.set_gripper(1))

    async def close_gripper(self) -> None:
        """Returns when the fingers have been told to."""
        await self.run(crcl.set_gripper(0))

    async def dwell(self, seconds: float) -> None:
        """Lets the robot wait, in simulated time."""
        await self.run(crcl.dwell(seconds), 10 + seconds)

    async def tool(self, frame: Frame = "world") -> Array:
        """X_WT or X_RT."""
        pose = (await self.status()).tool_in_reference
        if pose is None:
            raise Unreachable(f"{self.name}: its status has no pose")
        return self._motions.reference_in_world @ pose if frame == "world" else pose

    async def status(self) -> crcl.Status:
        """As the robot reports it."""
        await self._send(self._session.ask())
        status = self._session.feed(b"")
        while status is None:
            status = self._session.feed(await self._receive())
        return status

    async def run(self, command: crcl.Command, timeout_s: float = 10.0) -> crcl.Status:
        """Any command, until it is done."""
        await self.start(command)
        return await self.wait(timeout_s)

    async def start(self, command: crcl.Command) -> crcl.Status:
        """Any command; returns when the robot has it."""
        await self._send(self._session.begin(command))
        return await self.status()

    async def wait(self, timeout_s: float = MOVE_TIMEOUT_S) -> crcl.Status:
        """For the end of the command that was started last."""
        waited_s, steps = 0.0, POLL_STEPS
        while True:
            waited_s += await self._let_time_pass(steps)
            steps = min(2 * steps, MOST_POLL_STEPS)
            status = await self.status()
            if self._session.is_over(status):
                return status
            if waited_s > timeout_s:
                raise TimedOut(self._session.too_late(timeout_s))

    async def _let_time_pass(self, steps: int) -> float:
        if self._cell.paused:
            await self._cell.advance(steps)
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


class Cell(Channel):
    """As `aprsim.Cell`. Belongs to the loop that it was connected in."""

    def __init__(self, endpoints: Endpoints) -> None:
        """Use `connect`."""
        super().__init__(endpoints, grpc.aio)
        self._robots: dict[str, Robot] = {}
        self.description: cell_pb2.CellDescription
        """What does not change between two resets."""
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
            size = cell.description.step_size
            cell.step_s = seconds(size)
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
        """Hangs up, robots included. The cell goes on."""
        for robot in self._robots.values():
            await robot.close()
        self._robots.clear()
        await self._channel.close()

    async def snapshot(self, fields: Sequence[str] = (), entities: Sequence[str] = ()) -> Snapshot:
        """The latest one. `fields`: paths of fields of `Snapshot` in the messages, as "robots" or
        "robots.joints.position_rad"; `entities`: names of robots, bodies and tools. All when empty."""
        return self._seen(await self._run(calls.get_snapshot(fields, entities)))

    async def stream(
        self, hz: float | None = 20.0, fields: Sequence[str] = (), entities: Sequence[str] = ()
    ) -> AsyncIterator[Snapshot]:
        """Snapshots at a steady wall-clock rate, at most 1000 a second, until the loop ends. A reader
        that is too slow misses some and gets the latest. `hz=None`: every step, none left out; one
        that is too far behind is Refused."""
        call = self._stubs["Telemetry"].StreamSnapshots(
            calls.stream_request(hz, fields, entities), metadata=self._metadata
        )
        try:
            async for answer in call:
                yield self._seen(Snapshot(answer.snapshot))
        except grpc.RpcError as error:
            raise self._error(error) from error
        finally:
            call.cancel()

    async def events(
        self,
        after: int | None = None,
        *,
        kinds: Sequence[str] = (),
        names: Sequence[str] = (),
        allow_gap: bool = False,
        past_only: bool = False,
    ) -> AsyncIterator[Event]:
        """What happens in the cell, in its order, until the loop ends. From now on, or all with
        greater numbers than `after`; only of some kinds (`events.KINDS`), or in which some things
        take part. Refused when what is asked for is not kept any more, unless `allow_gap`.
        `past_only`: those that are kept."""
        request = calls.events_request(after, kinds, names, allow_gap, past_only)
        call = self._stubs["Telemetry"].StreamEvents(request, metadata=self._metadata)
        try:
            async for answer in call:
                yield event(answer.event, answer.lost)
        except grpc.RpcError as error:
            raise self._error(error) from error
        finally:
            call.cancel()

    async def pause(self) -> Receipt:
        """No step is taken until told."""
        receipt = await self._run(calls.pause())
        self.paused = True
        return receipt

    async def resume(self) -> Receipt:
        """Steps at the set speed."""
        receipt = await self._run(calls.resume())
        self.paused = False
        return receipt

    async def step(
        self, steps: int = 1, fields: Sequence[str] = (), *, timeout_s: float | None = None
    ) -> Snapshot:
        """Takes exactly so many steps of a paused cell; the snapshot after the last."""
        return await self._run(calls.step(steps, fields, timeout_s))

    async def advance(self, steps: int) -> None:
        """As `step`, without a snapshot of all."""
        await self._run(calls.step(steps, ["step"], None))

    async def run_until(
        self,
        until: float | Happens | faults.Crossing | None = None,
        *,
        max_steps: int = 0,
        fields: Sequence[str] = (),
        timeout_s: float | None = None,
    ) -> Run:
        """Takes steps at the set speed until a simulated time, an event or a quantity beyond a limit,
        or so many steps, and pauses. Refused (ABORTED) when something else pauses the cell."""
        run = await self._run(calls.run_until(until, max_steps, fields, timeout_s))
        self.paused = True
        return run

    async def set_speed(self, factor: float) -> Receipt:
        """Ratio of simulated to wall time; math.inf = as fast as possible."""
        return await self._run(calls.set_speed(factor))

    async def reset(
        self,
        seed: int | None = None,
        *,
        scene: str | None = None,
        scene_text: str | None = None,
    ) -> Receipt:
        """Builds the cell anew from its scene as it was loaded, with another seed if one is given; or
        from another scene with the same robots: one that comes with the daemon, by name, or the text
        of one. Robots then have to be initialised."""
        receipt = await self._run(calls.reset(seed, scene, scene_text))
        self.description = await self._run(calls.get_cell())
        return receipt

    async def save(self, name: str) -> Receipt:
        """Keeps the state of the cell in the daemon."""
        return await self._run(calls.save_state(name))

    async def load(self, name: str) -> Receipt:
        """Goes on from a saved state, bit for bit."""
        return await self._run(calls.load_state(name))

    async def forget(self, name: str) -> Receipt:
        """Deletes a saved state."""
        return await self._run(calls.delete_state(name))

    async def saved_states(self) -> list[SavedState]:
        """In alphabetical order."""
        return await self._run(calls.list_states())

    async def robot(self, name: str, *, initialise: bool = True) -> Robot:
        """A connection to a robot, made once and kept."""
        if name in self._robots:
            return self._robots[name]
        description = calls.robot_named(self.description, name)
        port = self.endpoints.crcl_port(name)
        robot = await Robot.connect(self, description, self.endpoints.host, port)
        self._robots[name] = robot
        if initialise:
            await robot.initialise()
        return robot

    async def set_conveyor(
        self,
        run: bool | None = None,
        *,
        forward: bool | None = None,
        speed_m_s: float | None = None,
        emergency_stop: bool | None = None,
        fault_reset: bool = False,
    ) -> snapshot_pb2.ConveyorState:
        """Sets any of the belt drive's inputs."""
        return await self._run(
            calls.set_conveyor(run, forward, speed_m_s, emergency_stop, fault_reset)
        )

    async def scene_text(self) -> str:
        """The scene as it is now, as a file has it (YAML); where bodies are is what they began with."""
        return await self._run(calls.get_scene())

    async def spawn(self, type_name: str, name: str, X_WB: Array) -> BodyState:
        """Puts down another gear or tray (`description.body_types`) at a pose in the world, or as much
        higher as it takes to be clear of all else. This and the following last until a reset."""
        body = await self._run(calls.spawn_body(type_name, name, X_WB))
        self.description = await self._run(calls.get_cell())
        return body

    async def move_body(self, name: str, X_WB: Array) -> BodyState:
        """Puts a gear or tray down elsewhere, at rest, in the same way."""
        return await self._run(calls.move_body(name, X_WB))

    async def remove_body(self, name: str) -> Receipt:
        """Takes a gear or tray out of the cell."""
        return await self._run(calls.remove_body(name))

    async def set_scene_value(self, path: str, value: object) -> Receipt:
        """Sets a value of the scene by the path of its keys, as "physics.friction.gear_tray": of
        physics, types of gears and trays, and cameras. The cell goes on from where it is."""
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
        """At the next step, or when its trigger comes."""
        return await self._run(
            calls.inject_fault(kind, target, parameters or {}, when, duration_s)
        )

    async def end_fault(self, identifier: int) -> Receipt:
        """Ends one at the next step, or gives up one that waits."""
        return await self._run(calls.end_fault(identifier))

    async def report_event(self, event: str) -> Receipt:
        """Tells the faults that wait for it."""
        return await self._run(calls.report_event(event))

    async def fault_kinds(self) -> control_service_pb2.ListFaultKindsResponse:
        """All kinds with their parameters."""
        return await self._run(calls.fault_kinds())

    # -- the past -----------------------------------------------------------------------------

    async def history(self) -> list[HistorySpan]:
        """What is kept of the past, oldest first; the last span is of the present epoch."""
        return await self._run(calls.get_history())

    async def past(
        self, step: int, epoch: int | None = None, fields: Sequence[str] = ()
    ) -> Snapshot:
        """How the cell was after a step, bit for bit; of the present epoch unless another is said."""
        return await self._run(calls.get_past(await self._epoch(epoch), step, fields))

    async def past_range(
        self,
        begin: int,
        end: int,
        stride: int = 20,
        epoch: int | None = None,
        fields: Sequence[str] = (),
    ) -> AsyncIterator[Snapshot]:
        """How it was from one step to another, every so many."""
        request = calls.past_request(await self._epoch(epoch), begin, end, stride, fields)
        call = self._stubs["History"].StreamPast(request, metadata=self._metadata)
        try:
            async for answer in call:
                yield Snapshot(answer.snapshot)
        except grpc.RpcError as error:
            raise self._error(error) from error
        finally:
            call.cancel()

    async def resume_from(self, step: int, epoch: int | None = None) -> Receipt:
        """Puts the cell back to a moment of the past, from which it goes on, bit for bit."""
        return await self._run(calls.resume_from(await self._epoch(epoch), step))

    async def bookmarks(self) -> list[Bookmark]:
        """Moments worth finding again: set by somebody, or by the daemon at what happened."""
        return await self._run(calls.list_bookmarks())

    async def add_bookmark(self, step: int, text: str, epoch: int | None = None) -> Bookmark:
        """Sets one."""
        return await self._run(calls.add_bookmark(await self._epoch(epoch), step, text))

    async def remove_bookmark(self, identifier: int) -> None:
        """Takes one away."""
        await self._run(calls.remove_bookmark(identifier))

    async def incident(self, last_s: float = 60.0) -> bytes:
        """The latest of the run as one journal, as `aprsim.Cell.incident`."""
        call = self._stubs["Journal"].GetIncident(
            calls.incident_request(last_s), metadata=self._metadata
        )
        try:
            return b"".join([piece.data async for piece in call])
        except grpc.RpcError as error:
            raise self._error(error) from error

    async def _epoch(self, epoch: int | None) -> int:
        if epoch is not None:
            return epoch
        return int((await self._run(calls.get_snapshot(["epoch"]))).message.epoch)

    async def _run(self, call: calls.Call[T]) -> T:
        stub = self._stubs[call.service]
        try:
            answer = await getattr(stub, call.method)(
                call.request, timeout=call.timeout_s, metadata=self._metadata
            )
        except grpc.RpcError as error:
            raise self._error(error) from error
        return call.read(answer)
