"""The cell for blocking programs."""

from __future__ import annotations

import contextlib
import math
import queue
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any, Iterator, Mapping, Sequence, TypeVar

import grpc
import numpy.typing as npt

from . import arguments, calls, cameras, faults, trajectories
from .calls import Bookmark, HistorySpan, Receipt, Run, SavedState
from .cameras import Camera
from .channel import Channel, open_channel
from .closing import Closing
from .endpoints import Endpoints, find_endpoints
from .errors import AprsimError, TimedOut
from .events import Event, Happens, event
from .joint_stream import JointStream
from .poses import Array
from .previews import Preview
from .robot import MOST_POLL_STEPS, POLL_S, POLL_STEPS, Robot
from .robot_wires import RobotSocket, RobotWire
from .snapshots import BodyState, Snapshot, seconds
from .trajectory_call import TrajectoryCall

if TYPE_CHECKING:
    from .v1 import cell_pb2, control_service_pb2, faults_pb2, snapshot_pb2

T = TypeVar("T")


class Cell(Channel, Closing):
    """A running cell. `robot(name)` commands a robot; the methods here do everything else. Errors:
    BadArgument, Unreachable, TimedOut, and Refused with the cell's text. Units are SI. A pose X_WB is a
    4 x 4 matrix: the body's frame B in the world's frame W (`aprsim.poses`). Thread: any; a stream
    belongs to its reader, a robot to one thread at a time."""

    def __init__(self, endpoints: Endpoints) -> None:
        super().__init__(endpoints, *open_channel(endpoints, grpc))
        self._begin()

    def _begin(self) -> None:
        self._robots: dict[str, Robot] = {}
        self.description: cell_pb2.CellDescription = self._run(calls.get_cell())
        """Robots, bodies, belt and cameras: the part that is constant between two resets."""
        self.step_s: float = seconds(self.description.step_size)
        """Simulated time of one step."""
        self.snapshot(["paused"])

    @classmethod
    def connect(
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
        """Connect to the cell of a ports file, else of the file in APRSIM_PORTS_FILE, else to the
        default ports of this machine. `host` and the ports override these; an IPv6 host may have
        brackets. `token_file` is a file whose first line is the token (default: APRSIM_TOKEN). `ca`,
        `certificate` and `key` are PEM files for encrypted gRPC (default: APRSIM_CA, APRSIM_CERTIFICATE,
        APRSIM_KEY). A cell on this machine is reached without the proxy of the environment."""
        return cls(
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

    def close(self) -> None:
        """Disconnect, robots included. The cell continues. Waiting calls and streams in other threads
        end with Unreachable."""
        self._cancel_open_calls()
        for robot in self._robots.values():
            robot.close()
        self._robots.clear()
        self._channel.close()

    # -- snapshots and events -----------------------------------------------------------------

    def snapshot(self, fields: Sequence[str] = (), entities: Sequence[str] = ()) -> Snapshot:
        """The latest snapshot. `fields` selects paths of the message `Snapshot`, as "robots" or
        "robots.joints.position_rad"; `entities` selects robots, bodies and tools by name. Empty means
        all."""
        return self._seen(self._run(calls.get_snapshot(fields, entities)))

    def stream(
        self, hz: float | None = 20.0, fields: Sequence[str] = (), entities: Sequence[str] = ()
    ) -> Iterator[Snapshot]:
        """Snapshots at `hz` per second of wall time, at most 1000, until the loop ends. A slow reader
        misses some and gets the latest. `hz=None` sends every step; a reader that falls too far behind
        gets Refused."""
        request = calls.stream_request(hz, fields, entities)
        for answer in self._stream("Telemetry", "StreamSnapshots", request):
            yield self._seen(Snapshot(answer.snapshot))

    def events(
        self,
        after: int | None = None,
        *,
        kinds: Sequence[str] = (),
        names: Sequence[str] = (),
        allow_gap: bool = False,
        past_only: bool = False,
    ) -> Iterator[Event]:
        """Events of the cell in their order, until the loop ends: new ones, or those with a sequence
        number above `after`. `kinds` (see `events.KINDS`) and `names` of participants select events.
        `past_only` ends after the recorded events. Refused when requested events are not recorded any
        more, unless `allow_gap`."""
        request = calls.events_request(after, kinds, names, allow_gap, past_only)
        for answer in self._stream("Telemetry", "StreamEvents", request):
            yield event(answer.event, answer.lost)

    def cameras(self) -> list[Camera]:
        """The cameras of the scene that the daemon has begun with."""
        return [
            Camera(camera, self._run, self._stream) for camera in self._run(cameras.list_cameras())
        ]

    def camera(self, name: str) -> Camera:
        """A camera, whose pictures are numpy arrays: `cell.camera("fanuc_table").rgb()`. AprsimError
        with the names there are."""
        description = cameras.camera_named(self._run(cameras.list_cameras()), name)
        return Camera(description, self._run, self._stream)

    # -- time ---------------------------------------------------------------------------------

    def pause(self) -> Receipt:
        """Stop stepping."""
        receipt = self._run(calls.pause())
        self.paused = True
        return receipt

    def resume(self) -> Receipt:
        """Continue at the set speed."""
        receipt = self._run(calls.resume())
        self.paused = False
        return receipt

    def step(
        self, steps: int = 1, fields: Sequence[str] = (), *, timeout_s: float | None = None
    ) -> Snapshot:
        """Step a paused cell `steps` times. Returns the snapshot after the last step."""
        return self._run(calls.step(steps, fields, timeout_s))

    def step_without_snapshot(self, steps: int) -> None:
        """Step a paused cell `steps` times without a snapshot."""
        self._run(calls.step(steps, ["step"], None))

    def run_until(
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
            run = self._run_interruptible(call)
        except (TimedOut, KeyboardInterrupt):
            with contextlib.suppress(AprsimError):
                self._run(calls.pause(calls.PAUSE_S))
            self.paused = True
            raise
        self.paused = True
        return run

    def set_speed(self, factor: float) -> Receipt:
        """Set the ratio of simulated to wall time; math.inf means as fast as possible."""
        return self._run(calls.set_speed(factor))

    def run_at_full_speed(self) -> Receipt:
        """Run as fast as possible."""
        return self.set_speed(math.inf)

    # -- states -------------------------------------------------------------------------------

    def reset(
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
        receipt = self._run(calls.reset(seed, scene, scene_text))
        self._follow_robots()
        for robot in self._robots.values():
            robot.forget_session()
        return receipt

    def _follow_robots(self) -> None:
        """Read the description again. If its robots are others, disconnect from those that have gone;
        the next command of the rest initialises them."""
        before, self.description = self.description, self._run(calls.get_cell())
        gone = calls.robots_gone(before, self.description)
        if not gone and len(before.robots) == len(self.description.robots):
            return
        self.endpoints = self.endpoints.renewed()
        for name in gone & self._robots.keys():
            self._robots.pop(name).close()
        for robot in self._robots.values():
            robot.forget_session()

    def save(self, name: str) -> Receipt:
        """Save the state of the cell in the daemon, replacing a state of that name."""
        return self._run(calls.save_state(name))

    def load(self, name: str) -> Receipt:
        """Continue from a saved state, bit for bit."""
        receipt = self._run(calls.load_state(name))
        self._follow_robots()
        return receipt

    def delete_state(self, name: str) -> Receipt:
        """Delete a saved state."""
        return self._run(calls.delete_state(name))

    def saved_states(self) -> list[SavedState]:
        """The saved states in alphabetical order."""
        return self._run(calls.list_states())

    # -- the past -----------------------------------------------------------------------------

    def history(self) -> list[HistorySpan]:
        """The recorded spans of the past, oldest first; the last one belongs to the present epoch."""
        return self._run(calls.get_history())

    def past(
        self, step: int, epoch: int | None = None, fields: Sequence[str] = ()
    ) -> Snapshot:
        """The snapshot after a past step, bit for bit, of the present epoch or of `epoch`."""
        return self._run(calls.get_past(self._epoch(epoch), step, fields))

    def past_range(
        self,
        begin: int,
        end: int,
        stride: int = 20,
        epoch: int | None = None,
        fields: Sequence[str] = (),
    ) -> Iterator[Snapshot]:
        """The snapshots from step `begin` to step `end`, one every `stride` steps."""
        request = calls.past_request(self._epoch(epoch), begin, end, stride, fields)
        for answer in self._stream("History", "StreamPast", request):
            yield Snapshot(answer.snapshot)

    def resume_from(self, step: int, epoch: int | None = None) -> Receipt:
        """Return the cell to a past step. It continues from there, bit for bit."""
        return self._run(calls.resume_from(self._epoch(epoch), step))

    def bookmarks(self) -> list[Bookmark]:
        """Marked moments of the past: set by clients, or by the daemon at events."""
        return self._run(calls.list_bookmarks())

    def add_bookmark(self, step: int, text: str, epoch: int | None = None) -> Bookmark:
        """Mark a past step with a text."""
        return self._run(calls.add_bookmark(self._epoch(epoch), step, text))

    def remove_bookmark(self, identifier: int) -> None:
        """Remove a bookmark."""
        self._run(calls.remove_bookmark(identifier))

    def _epoch(self, epoch: int | None) -> int:
        if epoch is not None:
            return epoch
        return int((self._run(calls.get_snapshot(["epoch"]))).message.epoch)

    def incident(self, last_s: float = 60.0) -> bytes:
        """The last simulated seconds of the run as a journal for `aprsim replay`. It begins at the
        latest checkpoint before them."""
        request = calls.incident_request(last_s)
        return b"".join(piece.data for piece in self._stream("Journal", "GetIncident", request))

    # -- robots and belt ----------------------------------------------------------------------

    def robot(self, name: str) -> Robot:
        """The connection to a robot, made once and kept. Connecting commands nothing: the robot goes on
        with its work. Its first command, or `Robot.take`, initialises it, which ends that work."""
        if name in self._robots:
            return self._robots[name]
        if self._closed:
            raise self._closed_error()
        description = calls.robot_named(self.description, name)
        robot = Robot(self, description, self._connect_robot(name))
        self._robots[name] = robot
        return robot

    def _connect_robot(self, name: str) -> RobotWire:
        return RobotSocket(name, self.endpoints.host, self.endpoints.crcl_port(name))

    def follow_trajectory(
        self, goal: trajectories.Goal, timeout_s: float
    ) -> trajectories.Followed:
        """Follow a trajectory to its end, as `Robot.follow`. Steps a paused cell."""
        limit_s = arguments.number("timeout_s", timeout_s, "s", above=0)
        with self.call_trajectory(goal.request) as call:
            self._accept_answers(goal, call, limit_s)
        return goal.followed()

    def open_joint_stream(self, robot: str, *, commander: str = "", reset: bool = False) -> JointStream:
        """Let a robot follow postures as they come, as those of another robot. `commander` is the name
        that others see, by default this program's address. `reset` clears an alarm, a protective stop or
        an error before. Raises Refused while another commander has the robot."""
        joints = len(calls.robot_named(self.description, robot).joints)
        name = arguments.text("commander", commander) if commander else ""
        return JointStream(self, robot, joints, name, arguments.truth("reset", reset))

    def switch_gripper(self, robot: str, setting: float) -> Receipt:
        """Switch the valves of a gripper, 0 closed to 1 open, beside any motion."""
        return self._run(calls.switch_gripper(robot, setting))

    def call_trajectory(self, request: Any) -> TrajectoryCall:
        """An open call of FollowJointTrajectory."""
        call = self._stub("Trajectory", "FollowJointTrajectory")(request, metadata=self._metadata)
        self._open_calls.add(call)
        return TrajectoryCall(call, self._error, self._open_calls.discard)

    def append_points(self, request: Any) -> Any:
        """The answer to a request for AppendPoints."""
        return self._run(calls.append_points(request))

    def _accept_answers(
        self, goal: trajectories.Goal, call: TrajectoryCall, limit_s: float
    ) -> None:
        waited_s, steps, is_over = 0.0, POLL_STEPS, False
        while goal.end is None:
            if self.paused and goal.stream and not is_over:
                snapshot = self.step(steps, trajectories.FIELDS)
                waited_s += steps * self.step_s
                steps = min(2 * steps, MOST_POLL_STEPS)
                is_over = goal.is_over(snapshot)
            began = time.monotonic()
            steps_on = self.paused and goal.stream and not is_over
            with contextlib.suppress(queue.Empty):
                answer = call.next(None if steps_on else POLL_S)
                if answer is None:
                    return
                goal.accept(answer)
            if not self.paused:
                waited_s += time.monotonic() - began
            if waited_s > limit_s:
                raise goal.too_late(limit_s)

    def set_planning(self, robot: str, mode: str) -> Receipt:
        """Set how a robot's later moves regard obstacles: `direct` ignores them, `check` refuses moves
        that would touch something, `avoid` also leads free moves round."""
        return self._run(calls.set_planning(robot, mode))

    def preview(
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
        return self._run(
            calls.preview(robot, X_RT, positions_rad, speed_rad_s, straight, mode)
        )

    def set_conveyor(
        self,
        run: bool | None = None,
        *,
        forward: bool | None = None,
        speed_m_s: float | None = None,
        emergency_stop: bool | None = None,
        fault_reset: bool = False,
    ) -> snapshot_pb2.ConveyorState:
        """Set inputs of the belt drive; None leaves an input unchanged. Returns the state of the belt."""
        return self._run(
            calls.set_conveyor(run, forward, speed_m_s, emergency_stop, fault_reset)
        )

    def set_signal(self, device: str, signal: str, value: float) -> Receipt:
        """Set an input of a device that an extension makes. Raises AprsimError with the name, the value and
        the range where the device does not take it."""
        return self._run(calls.set_signal(device, signal, value))

    # -- the scene ----------------------------------------------------------------------------

    def scene_text(self) -> str:
        """The present scene as YAML. Bodies have their initial poses."""
        return self._run(calls.get_scene())

    def spawn(self, type_name: str, name: str, X_WB: Array) -> BodyState:
        """Add a gear, tray or part of a type of `description.body_types` at X_WB: the 4 x 4 pose of the body's
        frame B in the world's frame W, with the position in metres in X_WB[:3, 3] (`aprsim.poses`).
        An occupied place moves it up until it is free. Scene edits last until a reset."""
        body = self._run(calls.spawn_body(type_name, name, X_WB))
        self.description = self._run(calls.get_cell())
        return body

    def move_body(self, name: str, X_WB: Array) -> BodyState:
        """Move a body to the pose X_WB, at rest, as `spawn` does."""
        return self._run(calls.move_body(name, X_WB))

    def remove_body(self, name: str) -> Receipt:
        """Remove a body from the cell."""
        return self._run(calls.remove_body(name))

    def set_scene_value(self, path: str, value: object) -> Receipt:
        """Set a value of the scene by the path of its keys, as "physics.friction.gear_tray". Physics,
        types of gears and trays, and cameras have such values. The cell's state is unchanged."""
        receipt = self._run(calls.set_scene_value(path, value))
        self.description = self._run(calls.get_cell())
        return receipt

    # -- injected faults ----------------------------------------------------------------------

    def inject_fault(
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
        return self._run(calls.inject_fault(kind, target, parameters or {}, when, duration_s))

    def end_fault(self, identifier: int) -> Receipt:
        """End an active fault at the next step, or cancel a pending one."""
        return self._run(calls.end_fault(identifier))

    def report_event(self, event: str) -> Receipt:
        """Report an event by name: the trigger of faults with `faults.Reported`."""
        return self._run(calls.report_event(event))

    def fault_kinds(self) -> control_service_pb2.ListFaultKindsResponse:
        """All kinds with their parameters, and the quantities for `faults.Crossing` with their units."""
        return self._run(calls.fault_kinds())

    # -- calls --------------------------------------------------------------------------------

    def _run(self, call: calls.Call[T]) -> T:
        try:
            answer = self._stub(call.service, call.method)(
                call.request, timeout=call.timeout_s, metadata=self._metadata
            )
        except grpc.RpcError as error:
            raise self._error(error) from error
        return call.read(answer)

    def _run_interruptible(self, call: calls.Call[T]) -> T:
        """The same for a long call, which an interrupt of the wait cancels at the daemon."""
        open_call = self._stub(call.service, call.method).future(
            call.request, timeout=call.timeout_s, metadata=self._metadata
        )
        self._open_calls.add(open_call)
        try:
            return call.read(open_call.result())
        except grpc.FutureCancelledError as error:
            raise self._closed_error() from error
        except grpc.RpcError as error:
            raise self._error(error) from error
        finally:
            open_call.cancel()
            self._open_calls.discard(open_call)

    def _stream(self, service: calls.Service, method: str, request: Any) -> Iterator[Any]:
        call = self._stub(service, method)(request, metadata=self._metadata)
        self._open_calls.add(call)
        try:
            for answer in call:
                yield answer
        except grpc.RpcError as error:
            raise self._error(error) from error
        finally:
            call.cancel()
            self._open_calls.discard(call)
