"""The cell, for programs that wait for each call."""

from __future__ import annotations

import math
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Iterator, Mapping, Sequence, TypeVar

import grpc

from . import calls, faults
from .calls import Bookmark, HistorySpan, Receipt, Run, SavedState
from .channel import Channel
from .endpoints import Endpoints, find_endpoints
from .events import Event, Happens, event
from .poses import Array
from .robot import Robot
from .snapshots import BodyState, Snapshot, seconds

if TYPE_CHECKING:
    from .v1 import cell_pb2, control_service_pb2, faults_pb2, snapshot_pb2

T = TypeVar("T")


class Cell(Channel):
    """A running cell. Robots are commanded by `robot(name)`, all else here. Errors: Unreachable,
    TimedOut, Refused with the cell's own words. Units are SI. Thread: any; a stream belongs to who
    reads it, a robot to one thread at a time."""

    def __init__(self, endpoints: Endpoints) -> None:
        super().__init__(endpoints, grpc)
        self._robots: dict[str, Robot] = {}
        self.description: cell_pb2.CellDescription = self._run(calls.get_cell())
        """What does not change between two resets."""
        size = self.description.step_size
        self.step_s: float = seconds(size)
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
        """To the cell of a ports file, else of the one that APRSIM_PORTS_FILE names, else at the
        default ports of this machine; single choices go over that. The token: the first line of
        `token_file`, else APRSIM_TOKEN. Encrypted gRPC: `ca`, and `certificate` with `key` where the
        daemon asks for them, name files in PEM (else APRSIM_CA, APRSIM_CERTIFICATE, APRSIM_KEY)."""
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

    def __enter__(self) -> Cell:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Hangs up, robots included. The cell goes on."""
        for robot in self._robots.values():
            robot.close()
        self._robots.clear()
        self._channel.close()

    # -- what is seen -------------------------------------------------------------------------

    def snapshot(self, fields: Sequence[str] = (), entities: Sequence[str] = ()) -> Snapshot:
        """The latest one. `fields`: paths of fields of `Snapshot` in the messages, as "robots" or
        "robots.joints.position_rad"; `entities`: names of robots, bodies and tools. All when empty."""
        return self._seen(self._run(calls.get_snapshot(fields, entities)))

    def stream(
        self, hz: float | None = 20.0, fields: Sequence[str] = (), entities: Sequence[str] = ()
    ) -> Iterator[Snapshot]:
        """Snapshots at a steady wall-clock rate, at most 1000 a second, until the loop ends. A reader
        that is too slow misses some and gets the latest. `hz=None`: every step, none left out; one
        that is too far behind is Refused."""
        call = self._stubs["Telemetry"].StreamSnapshots(
            calls.stream_request(hz, fields, entities), metadata=self._metadata
        )
        try:
            for answer in call:
                yield self._seen(Snapshot(answer.snapshot))
        except grpc.RpcError as error:
            raise self._error(error) from error
        finally:
            call.cancel()

    def events(
        self,
        after: int | None = None,
        *,
        kinds: Sequence[str] = (),
        names: Sequence[str] = (),
        allow_gap: bool = False,
        past_only: bool = False,
    ) -> Iterator[Event]:
        """What happens in the cell, in its order, until the loop ends. From now on, or all with
        greater numbers than `after`; only of some kinds (`events.KINDS`), or in which some things
        take part. Refused when what is asked for is not kept any more, unless `allow_gap`.
        `past_only`: those that are kept."""
        request = calls.events_request(after, kinds, names, allow_gap, past_only)
        call = self._stubs["Telemetry"].StreamEvents(request, metadata=self._metadata)
        try:
            for answer in call:
                yield event(answer.event, answer.lost)
        except grpc.RpcError as error:
            raise self._error(error) from error
        finally:
            call.cancel()

    # -- time ---------------------------------------------------------------------------------

    def pause(self) -> Receipt:
        """No step is taken until told."""
        receipt = self._run(calls.pause())
        self.paused = True
        return receipt

    def resume(self) -> Receipt:
        """Steps at the set speed."""
        receipt = self._run(calls.resume())
        self.paused = False
        return receipt

    def step(
        self, steps: int = 1, fields: Sequence[str] = (), *, timeout_s: float | None = None
    ) -> Snapshot:
        """Takes exactly so many steps of a paused cell; the snapshot after the last."""
        return self._run(calls.step(steps, fields, timeout_s))

    def advance(self, steps: int) -> None:
        """As `step`, without a snapshot of all."""
        self._run(calls.step(steps, ["step"], None))

    def run_until(
        self,
        until: float | Happens | faults.Crossing | None = None,
        *,
        max_steps: int = 0,
        fields: Sequence[str] = (),
        timeout_s: float | None = None,
    ) -> Run:
        """Takes steps at the set speed until a simulated time, an event or a quantity beyond a limit,
        or so many steps, and pauses. Refused (ABORTED) when something else pauses the cell."""
        run = self._run(calls.run_until(until, max_steps, fields, timeout_s))
        self.paused = True
        return run

    def set_speed(self, factor: float) -> Receipt:
        """Ratio of simulated to wall time; math.inf = as fast as possible."""
        return self._run(calls.set_speed(factor))

    def run_at_full_speed(self) -> Receipt:
        """As fast as possible."""
        return self.set_speed(math.inf)

    # -- states -------------------------------------------------------------------------------

    def reset(
        self,
        seed: int | None = None,
        *,
        scene: str | None = None,
        scene_text: str | None = None,
    ) -> Receipt:
        """Builds the cell anew from its scene as it was loaded, with another seed if one is given; or
        from another scene with the same robots: one that comes with the daemon, by name, or the text
        of one. Robots then have to be initialised."""
        receipt = self._run(calls.reset(seed, scene, scene_text))
        self.description = self._run(calls.get_cell())
        return receipt

    def save(self, name: str) -> Receipt:
        """Keeps the state of the cell in the daemon, in place of what had the name."""
        return self._run(calls.save_state(name))

    def load(self, name: str) -> Receipt:
        """Goes on from a saved state, bit for bit."""
        return self._run(calls.load_state(name))

    def forget(self, name: str) -> Receipt:
        """Deletes a saved state."""
        return self._run(calls.delete_state(name))

    def saved_states(self) -> list[SavedState]:
        """In alphabetical order."""
        return self._run(calls.list_states())

    # -- the past -----------------------------------------------------------------------------

    def history(self) -> list[HistorySpan]:
        """What is kept of the past, oldest first; the last span is of the present epoch."""
        return self._run(calls.get_history())

    def past(
        self, step: int, epoch: int | None = None, fields: Sequence[str] = ()
    ) -> Snapshot:
        """How the cell was after a step, bit for bit; of the present epoch unless another is said."""
        return self._run(calls.get_past(self._epoch(epoch), step, fields))

    def past_range(
        self,
        begin: int,
        end: int,
        stride: int = 20,
        epoch: int | None = None,
        fields: Sequence[str] = (),
    ) -> Iterator[Snapshot]:
        """How it was from one step to another, every so many."""
        request = calls.past_request(self._epoch(epoch), begin, end, stride, fields)
        call = self._stubs["History"].StreamPast(request, metadata=self._metadata)
        try:
            for answer in call:
                yield Snapshot(answer.snapshot)
        except grpc.RpcError as error:
            raise self._error(error) from error
        finally:
            call.cancel()

    def resume_from(self, step: int, epoch: int | None = None) -> Receipt:
        """Puts the cell back to a moment of the past, from which it goes on, bit for bit."""
        return self._run(calls.resume_from(self._epoch(epoch), step))

    def bookmarks(self) -> list[Bookmark]:
        """Moments worth finding again: set by somebody, or by the daemon at what happened."""
        return self._run(calls.list_bookmarks())

    def add_bookmark(self, step: int, text: str, epoch: int | None = None) -> Bookmark:
        """Sets one."""
        return self._run(calls.add_bookmark(self._epoch(epoch), step, text))

    def remove_bookmark(self, identifier: int) -> None:
        """Takes one away."""
        self._run(calls.remove_bookmark(identifier))

    def _epoch(self, epoch: int | None) -> int:
        if epoch is not None:
            return epoch
        return int((self._run(calls.get_snapshot(["epoch"]))).message.epoch)

    def incident(self, last_s: float = 60.0) -> bytes:
        """The latest of the run as one journal, which `aprsim replay` runs again anywhere: from the
        last checkpoint on before so much simulated time."""
        call = self._stubs["Journal"].GetIncident(
            calls.incident_request(last_s), metadata=self._metadata
        )
        try:
            return b"".join(piece.data for piece in call)
        except grpc.RpcError as error:
            raise self._error(error) from error

    # -- robots and belt ----------------------------------------------------------------------

    def robot(self, name: str, *, initialise: bool = True) -> Robot:
        """A connection to a robot, made once and kept. It is initialised, which ends what it does;
        `initialise=False` leaves that to the caller."""
        if name in self._robots:
            return self._robots[name]
        description = calls.robot_named(self.description, name)
        robot = Robot(self, description, self.endpoints.host, self.endpoints.crcl_port(name))
        self._robots[name] = robot
        if initialise:
            robot.initialise()
        return robot

    def set_conveyor(
        self,
        run: bool | None = None,
        *,
        forward: bool | None = None,
        speed_m_s: float | None = None,
        emergency_stop: bool | None = None,
        fault_reset: bool = False,
    ) -> snapshot_pb2.ConveyorState:
        """Sets any of the belt drive's inputs; the belt as it is then."""
        return self._run(
            calls.set_conveyor(run, forward, speed_m_s, emergency_stop, fault_reset)
        )

    # -- the scene ----------------------------------------------------------------------------

    def scene_text(self) -> str:
        """The scene as it is now, as a file has it (YAML); where bodies are is what they began with."""
        return self._run(calls.get_scene())

    def spawn(self, type_name: str, name: str, X_WB: Array) -> BodyState:
        """Puts down another gear or tray (`description.body_types`) at a pose in the world, or as much
        higher as it takes to be clear of all else. This and the following last until a reset."""
        body = self._run(calls.spawn_body(type_name, name, X_WB))
        self.description = self._run(calls.get_cell())
        return body

    def move_body(self, name: str, X_WB: Array) -> BodyState:
        """Puts a gear or tray down elsewhere, at rest, in the same way."""
        return self._run(calls.move_body(name, X_WB))

    def remove_body(self, name: str) -> Receipt:
        """Takes a gear or tray out of the cell."""
        return self._run(calls.remove_body(name))

    def set_scene_value(self, path: str, value: object) -> Receipt:
        """Sets a value of the scene by the path of its keys, as "physics.friction.gear_tray": of
        physics, types of gears and trays, and cameras. The cell goes on from where it is."""
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
        """At the next step, or when its trigger comes, for a while or until `end_fault`."""
        return self._run(calls.inject_fault(kind, target, parameters or {}, when, duration_s))

    def end_fault(self, identifier: int) -> Receipt:
        """Ends one at the next step, or gives up one that waits."""
        return self._run(calls.end_fault(identifier))

    def report_event(self, event: str) -> Receipt:
        """Tells the faults that wait for it (`faults.Reported`)."""
        return self._run(calls.report_event(event))

    def fault_kinds(self) -> control_service_pb2.ListFaultKindsResponse:
        """All kinds with their parameters, and the quantities that `faults.Crossing` knows."""
        return self._run(calls.fault_kinds())

    # -----------------------------------------------------------------------------------------

    def _run(self, call: calls.Call[T]) -> T:
        stub = self._stubs[call.service]
        try:
            answer = getattr(stub, call.method)(
                call.request, timeout=call.timeout_s, metadata=self._metadata
            )
        except grpc.RpcError as error:
            raise self._error(error) from error
        return call.read(answer)
