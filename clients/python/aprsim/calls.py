"""The calls of the cell's gRPC services: what is asked, and what of the answer is handed on. Shared by
the blocking and the asyncio cell, which only carry them out."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Callable, Generic, Literal, Mapping, Sequence, TypeVar

import grpc

from . import events, faults
from .endpoints import Endpoints
from .errors import AprsimError, Refused, TimedOut, Unreachable
from .events import Event, Happens
from .poses import Array, pose_message
from .snapshots import BodyState, Snapshot, seconds
from .v1 import control_service_pb2 as control
from .v1 import history_service_pb2 as past
from .v1 import journal_service_pb2 as journal
from .v1 import telemetry_service_pb2 as telemetry

if TYPE_CHECKING:
    from .v1 import cell_pb2, faults_pb2, snapshot_pb2

T = TypeVar("T")
Service = Literal["Control", "Telemetry", "History", "Journal"]

_TIMEOUT_S = 60.0  # a daemon that is gone is told at once; one on a busy machine is waited for
_STEP_S = 0.01  # that one step may take at most
_RUN_S = 3600.0  # that a run may take at most
_MAX_MESSAGE_BYTES = 64 << 20
CHANNEL_OPTIONS = [("grpc.max_receive_message_length", _MAX_MESSAGE_BYTES)]


@dataclass(frozen=True)
class Receipt:
    """When and where a command took effect."""

    ticket: int
    epoch: int
    step: int
    sim_time_s: float


@dataclass(frozen=True)
class SavedState:
    """A state that the daemon keeps under a name."""

    name: str
    bytes: int
    step: int
    sim_time_s: float


@dataclass(frozen=True)
class HistorySpan:
    """What is kept of the past between two resets or loads."""

    epoch: int
    first_step: int
    last_step: int
    first_time_s: float
    last_time_s: float
    seed: int
    loaded_state: str | None
    """That it began with; None = a reset."""


@dataclass(frozen=True)
class Bookmark:
    """A moment worth finding again."""

    identifier: int
    epoch: int
    step: int
    sim_time_s: float
    kind: str
    """As in `BookmarkKind`, without its prefix: `SET_BY_USER`, ..."""
    text: str


@dataclass(frozen=True)
class Call(Generic[T]):
    """One unary call."""

    service: Service
    """Of the package, without the word Service."""
    method: str
    request: Any
    read: Callable[[Any], T]
    timeout_s: float = _TIMEOUT_S


def metadata_of(endpoints: Endpoints) -> list[tuple[str, str]]:
    """What goes with every call."""
    return [("authorization", f"Bearer {endpoints.token}")] if endpoints.token else []


def credentials_of(endpoints: Endpoints) -> Any:
    """Of an encrypted channel; None = it is not encrypted."""
    encryption = endpoints.encryption
    if encryption is None:
        return None
    return grpc.ssl_channel_credentials(encryption.ca, encryption.key, encryption.certificate)


def error_of(code: str, details: str, address: str) -> AprsimError:
    """The exception for a gRPC status that is not OK."""
    if code == "UNAVAILABLE":
        return Unreachable(f"cannot reach the cell by gRPC at {address}: {details}")
    if code == "DEADLINE_EXCEEDED":
        return TimedOut(f"no answer by gRPC from {address} in time")
    if code == "UNAUTHENTICATED":
        return Refused(code, f"{details} (token_file, or the variable APRSIM_TOKEN)")
    return Refused(code, details)


def _control(
    method: str, request: Any, read: Callable[[Any], T], timeout_s: float | None = None
) -> Call[T]:
    return Call("Control", method, request, read, _TIMEOUT_S if timeout_s is None else timeout_s)


def _receipt(answer: Any) -> Receipt:
    receipt = answer.receipt
    return Receipt(receipt.ticket, receipt.epoch, receipt.step, seconds(receipt.sim_time))


def _snapshot(answer: Any) -> Snapshot:
    return Snapshot(answer.snapshot)


def _paths(fields: Sequence[str]) -> list[str]:
    """Whether the cell is paused is always asked for."""
    return [*fields, "paused"] if fields else []


def robot_named(cell: cell_pb2.CellDescription, name: str) -> cell_pb2.RobotDescription:
    """Raises AprsimError with the names there are."""
    robots: dict[str, cell_pb2.RobotDescription] = {robot.name: robot for robot in cell.robots}
    if name not in robots:
        names = ", ".join(robots) or "none"
        raise AprsimError(f"the scene '{cell.scene}' has no robot '{name}'; there is {names}")
    return robots[name]


def get_snapshot(fields: Sequence[str], entities: Sequence[str] = ()) -> Call[Snapshot]:
    request = telemetry.GetSnapshotRequest(entities=entities)
    request.read_mask.paths.extend(_paths(fields))
    return Call("Telemetry", "GetSnapshot", request, _snapshot)


def stream_request(hz: float | None, fields: Sequence[str], entities: Sequence[str]) -> Any:
    request = telemetry.StreamSnapshotsRequest(entities=entities)
    if hz is None:
        request.every_step = True
    else:
        request.rate_hz = hz
    request.read_mask.paths.extend(_paths(fields))
    return request


def events_request(
    after: int | None,
    kinds: Sequence[str],
    names: Sequence[str],
    allow_gap: bool,
    past_only: bool,
) -> Any:
    request = telemetry.StreamEventsRequest(
        kinds=events.kind_numbers(kinds), names=names, allow_gap=allow_gap, past_only=past_only
    )
    if after is not None or past_only:
        request.after = after or 0
    return request


def get_cell() -> Call[cell_pb2.CellDescription]:
    def read(answer: telemetry.GetCellResponse) -> cell_pb2.CellDescription:
        return answer.cell

    return Call("Telemetry", "GetCell", telemetry.GetCellRequest(), read)


def pause() -> Call[Receipt]:
    return _control("Pause", control.PauseRequest(), _receipt)


def resume() -> Call[Receipt]:
    return _control("Resume", control.ResumeRequest(), _receipt)


def step(steps: int, fields: Sequence[str], timeout_s: float | None) -> Call[Snapshot]:
    if steps < 1:
        raise AprsimError(f"steps: {steps}, where 1 or more is expected")
    request = control.StepRequest(steps=steps)
    request.read_mask.paths.extend(fields)
    request.read_mask.SetInParent()
    limit = _TIMEOUT_S + _STEP_S * steps if timeout_s is None else timeout_s
    return _control("Step", request, _snapshot, limit)


@dataclass(frozen=True)
class Run:
    """How a run has ended."""

    met: bool
    """Its condition holds; else all its steps have been taken."""
    event: Event | None
    """What it ended at, where that was an event."""
    snapshot: Snapshot
    """The cell there."""


def run_until(
    until: float | Happens | faults.Crossing | None,
    max_steps: int,
    fields: Sequence[str],
    timeout_s: float | None,
) -> Call[Run]:
    request = control.RunUntilRequest(max_steps=max_steps)
    request.read_mask.paths.extend(fields)
    request.read_mask.SetInParent()
    if isinstance(until, Happens):
        request.event.kinds.extend(events.kind_numbers(until.kinds))
        request.event.names.extend(until.names)
        request.event.SetInParent()
    elif isinstance(until, faults.Crossing):
        faults.set_crossing(request.crossing, until)
    elif until is not None:
        faults.set_duration(request.time, "until", until)

    def read(answer: Any) -> Run:
        happened = events.event(answer.event) if answer.HasField("event") else None
        met = answer.outcome == control.RUN_OUTCOME_MET
        return Run(met, happened, Snapshot(answer.snapshot))

    return _control("RunUntil", request, read, _RUN_S if timeout_s is None else timeout_s)


def set_speed(factor: float) -> Call[Receipt]:
    if math.isinf(factor) and factor > 0:
        return _control("SetSpeed", control.SetSpeedRequest(maximum=True), _receipt)
    return _control("SetSpeed", control.SetSpeedRequest(factor=factor), _receipt)


def reset(seed: int | None, scene: str | None, scene_text: str | None) -> Call[Receipt]:
    if scene is not None and scene_text is not None:
        raise AprsimError("reset: one of scene and scene_text is expected, not both")
    request = control.ResetRequest(seed=seed, scene_name=scene, scene_text=scene_text)
    return _control("Reset", request, _receipt)


def get_scene() -> Call[str]:
    def read(answer: telemetry.GetSceneResponse) -> str:
        return answer.text

    return Call("Telemetry", "GetScene", telemetry.GetSceneRequest(), read)


def _body(answer: Any) -> BodyState:
    return BodyState(answer.body)


def spawn_body(type_name: str, name: str, X_WB: Array) -> Call[BodyState]:
    request = control.SpawnBodyRequest(type=type_name, name=name, body_in_world=pose_message(X_WB))
    return _control("SpawnBody", request, _body)


def move_body(name: str, X_WB: Array) -> Call[BodyState]:
    request = control.MoveBodyRequest(name=name, body_in_world=pose_message(X_WB))
    return _control("MoveBody", request, _body)


def remove_body(name: str) -> Call[Receipt]:
    return _control("RemoveBody", control.RemoveBodyRequest(name=name), _receipt)


def set_scene_value(path: str, value: object) -> Call[Receipt]:
    text = str(value).lower() if isinstance(value, bool) else str(value)
    return _control("SetSceneValue", control.SetSceneValueRequest(path=path, value=text), _receipt)


def save_state(name: str) -> Call[Receipt]:
    return _control("SaveState", control.SaveStateRequest(name=name), _receipt)


def load_state(name: str) -> Call[Receipt]:
    return _control("LoadState", control.LoadStateRequest(name=name), _receipt)


def delete_state(name: str) -> Call[Receipt]:
    return _control("DeleteState", control.DeleteStateRequest(name=name), _receipt)


def list_states() -> Call[list[SavedState]]:
    def read(answer: Any) -> list[SavedState]:
        return [
            SavedState(state.name, state.bytes, state.step, seconds(state.sim_time))
            for state in answer.states
        ]

    return _control("ListStates", control.ListStatesRequest(), read)


def set_conveyor(
    run: bool | None,
    forward: bool | None,
    speed_m_s: float | None,
    emergency_stop: bool | None,
    fault_reset: bool,
) -> Call[snapshot_pb2.ConveyorState]:
    request = control.SetConveyorRequest(fault_reset=fault_reset)
    if run is not None:
        request.run = run
    if speed_m_s is not None:
        request.speed_m_s = speed_m_s
    if emergency_stop is not None:
        request.emergency_stop = emergency_stop
    if forward is not None:
        request.direction = (
            control.CONVEYOR_DIRECTION_FORWARD if forward else control.CONVEYOR_DIRECTION_REVERSE
        )

    def read(answer: control.SetConveyorResponse) -> snapshot_pb2.ConveyorState:
        return answer.conveyor

    return _control("SetConveyor", request, read)


def inject_fault(
    kind: str,
    target: str,
    parameters: Mapping[str, float],
    trigger: faults.Trigger | None,
    duration_s: float | None,
) -> Call[faults_pb2.InjectedFault]:
    request = faults.request(kind, target, parameters, trigger, duration_s)

    def read(answer: control.InjectFaultResponse) -> faults_pb2.InjectedFault:
        return answer.fault

    return _control("InjectFault", request, read)


def end_fault(identifier: int) -> Call[Receipt]:
    return _control("EndFault", control.EndFaultRequest(id=identifier), _receipt)


def report_event(event: str) -> Call[Receipt]:
    return _control("ReportEvent", control.ReportEventRequest(event=event), _receipt)


def fault_kinds() -> Call[control.ListFaultKindsResponse]:

    def read(answer: control.ListFaultKindsResponse) -> control.ListFaultKindsResponse:
        return answer

    return _control("ListFaultKinds", control.ListFaultKindsRequest(), read)


def get_history() -> Call[list[HistorySpan]]:
    def read(answer: past.GetHistoryResponse) -> list[HistorySpan]:
        return [
            HistorySpan(
                span.epoch,
                span.first_step,
                span.last_step,
                seconds(span.first_time),
                seconds(span.last_time),
                span.seed,
                span.loaded_state if span.HasField("loaded_state") else None,
            )
            for span in answer.spans
        ]

    return Call("History", "GetHistory", past.GetHistoryRequest(), read)


def get_past(epoch: int, step: int, fields: Sequence[str]) -> Call[Snapshot]:
    request = past.GetPastSnapshotRequest(moment=past.Moment(epoch=epoch, step=step))
    request.read_mask.paths.extend(fields)
    return Call("History", "GetPastSnapshot", request, _snapshot)


def past_request(epoch: int, begin: int, end: int, stride: int, fields: Sequence[str]) -> Any:
    request = past.StreamPastRequest(
        begin=past.Moment(epoch=epoch, step=begin), end_step=end, stride=stride
    )
    request.read_mask.paths.extend(fields)
    return request


def incident_request(last_s: float) -> Any:
    request = journal.GetIncidentRequest()
    faults.set_duration(request.last, "last_s", last_s)
    return request


def resume_from(epoch: int, step: int) -> Call[Receipt]:
    request = past.ResumeFromRequest(moment=past.Moment(epoch=epoch, step=step))
    return Call("History", "ResumeFrom", request, _receipt)


def _bookmark(bookmark: past.Bookmark) -> Bookmark:
    kind = past.BookmarkKind.Name(bookmark.kind).removeprefix("BOOKMARK_KIND_")
    moment, time_s = bookmark.moment, seconds(bookmark.sim_time)
    return Bookmark(bookmark.id, moment.epoch, moment.step, time_s, kind, bookmark.text)


def list_bookmarks() -> Call[list[Bookmark]]:
    def read(answer: past.ListBookmarksResponse) -> list[Bookmark]:
        return [_bookmark(bookmark) for bookmark in answer.bookmarks]

    return Call("History", "ListBookmarks", past.ListBookmarksRequest(), read)


def add_bookmark(epoch: int, step: int, text: str) -> Call[Bookmark]:
    def read(answer: past.AddBookmarkResponse) -> Bookmark:
        return _bookmark(answer.bookmark)

    request = past.AddBookmarkRequest(moment=past.Moment(epoch=epoch, step=step), text=text)
    return Call("History", "AddBookmark", request, read)


def remove_bookmark(identifier: int) -> Call[None]:
    def read(_: Any) -> None:
        return None

    return Call("History", "RemoveBookmark", past.RemoveBookmarkRequest(id=identifier), read)
