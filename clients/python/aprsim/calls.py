"""The calls of the cell's gRPC services: requests from checked arguments, and results from answers.
The blocking and the asyncio cell share them and only perform them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Callable, Generic, Literal, Mapping, Sequence, TypeVar

import grpc
import numpy.typing as npt

from . import arguments, events, faults, previews
from .endpoints import Endpoints
from .errors import AprsimError, Refused, TimedOut, Unreachable
from .events import Event, Happens
from .poses import Array, pose_message
from .previews import Preview
from .snapshots import PLANNING_MODES, BodyState, Snapshot, seconds
from .v1 import control_service_pb2 as control
from .v1 import history_service_pb2 as past
from .v1 import journal_service_pb2 as journal
from .v1 import snapshot_pb2
from .v1 import telemetry_service_pb2 as telemetry
from .v1 import trajectory_service_pb2 as trajectory

if TYPE_CHECKING:
    from .v1 import cell_pb2, faults_pb2

T = TypeVar("T")
Service = Literal["Camera", "Control", "Telemetry", "History", "Journal", "Trajectory"]

_TIMEOUT_S = 60.0  # generous for a busy machine; a missing daemon is an error at once
_STEP_S = 0.01  # allowance for one step
_RUN_S = 3600.0  # allowance for a run
PAUSE_S = 5.0
"""Allowance for the pause after a cancelled run."""
_MOST = (1 << 64) - 1  # largest value of a uint64 field


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
    """The recorded part of one epoch: the time between two resets or loads."""

    epoch: int
    first_step: int
    last_step: int
    first_time_s: float
    last_time_s: float
    seed: int
    loaded_state: str | None
    """Name of the state that the epoch began with; None = a reset."""


@dataclass(frozen=True)
class Bookmark:
    """A marked moment."""

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
    """Name of the gRPC service without the word Service."""
    method: str
    request: Any
    read: Callable[[Any], T]
    timeout_s: float = _TIMEOUT_S


def metadata_of(endpoints: Endpoints) -> list[tuple[str, str]]:
    """The metadata of every call."""
    return [("authorization", f"Bearer {endpoints.token}")] if endpoints.token else []


def credentials_of(endpoints: Endpoints) -> Any:
    """The credentials of an encrypted channel; None = it is not encrypted."""
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


def _timeout(timeout_s: float | None, default: float) -> float:
    return default if timeout_s is None else arguments.number("timeout_s", timeout_s, "s", above=0)


def _identified(request: Callable[..., Any], identifier: int) -> Any:
    return request(id=arguments.whole("identifier", identifier, 0, _MOST))


def _receipt(answer: Any) -> Receipt:
    receipt = answer.receipt
    return Receipt(receipt.ticket, receipt.epoch, receipt.step, seconds(receipt.sim_time))


def _snapshot(answer: Any) -> Snapshot:
    return Snapshot(answer.snapshot)


def _paths(fields: Sequence[str]) -> list[str]:
    """The field `paused` is always requested."""
    paths = arguments.texts("fields", fields)
    return [*paths, "paused"] if paths else []


def robot_named(cell: cell_pb2.CellDescription, name: str) -> cell_pb2.RobotDescription:
    """Raises AprsimError with the names there are."""
    robots: dict[str, cell_pb2.RobotDescription] = {robot.name: robot for robot in cell.robots}
    if name not in robots:
        names = ", ".join(robots) or "none"
        raise AprsimError(f"the scene '{cell.scene}' has no robot '{name}'; there is {names}")
    return robots[name]


def robots_gone(before: cell_pb2.CellDescription, now: cell_pb2.CellDescription) -> set[str]:
    """The robots that the cell lacks now, or has with another model or at another place in the scene."""
    kept = {
        old.name
        for old, new in zip(before.robots, now.robots)
        if (old.name, old.model, len(old.joints)) == (new.name, new.model, len(new.joints))
    }
    return {robot.name for robot in before.robots} - kept


def get_snapshot(fields: Sequence[str], entities: Sequence[str] = ()) -> Call[Snapshot]:
    request = telemetry.GetSnapshotRequest(entities=arguments.texts("entities", entities))
    request.read_mask.paths.extend(_paths(fields))
    return Call("Telemetry", "GetSnapshot", request, _snapshot)


def stream_request(hz: float | None, fields: Sequence[str], entities: Sequence[str]) -> Any:
    request = telemetry.StreamSnapshotsRequest(entities=arguments.texts("entities", entities))
    if hz is None:
        request.every_step = True
    else:
        request.rate_hz = arguments.number("hz", hz, "Hz")
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
        kinds=events.kind_numbers(kinds),
        names=arguments.texts("names", names),
        allow_gap=arguments.truth("allow_gap", allow_gap),
        past_only=arguments.truth("past_only", past_only),
    )
    if after is not None or past_only:
        request.after = arguments.whole("after", after or 0, 0, _MOST)
    return request


def get_cell() -> Call[cell_pb2.CellDescription]:
    def read(answer: telemetry.GetCellResponse) -> cell_pb2.CellDescription:
        return answer.cell

    return Call("Telemetry", "GetCell", telemetry.GetCellRequest(), read)


def pause(timeout_s: float | None = None) -> Call[Receipt]:
    return _control("Pause", control.PauseRequest(), _receipt, timeout_s)


def resume() -> Call[Receipt]:
    return _control("Resume", control.ResumeRequest(), _receipt)


def step(steps: int, fields: Sequence[str], timeout_s: float | None) -> Call[Snapshot]:
    count = arguments.whole("steps", steps, 1, _MOST)
    request = control.StepRequest(steps=count)
    request.read_mask.paths.extend(arguments.texts("fields", fields))
    request.read_mask.SetInParent()
    limit = _timeout(timeout_s, _TIMEOUT_S + _STEP_S * count)
    return _control("Step", request, _snapshot, limit)


@dataclass(frozen=True)
class Run:
    """The end of a run."""

    met: bool
    """The condition holds; else all steps have been taken."""
    event: Event | None
    """The event that ended the run, if one did."""
    snapshot: Snapshot
    """The cell at the end of the run."""


def run_until(
    until: float | Happens | faults.Crossing | None,
    max_steps: int,
    fields: Sequence[str],
    timeout_s: float | None,
) -> Call[Run]:
    request = control.RunUntilRequest(max_steps=arguments.whole("max_steps", max_steps, 0, _MOST))
    request.read_mask.paths.extend(arguments.texts("fields", fields))
    request.read_mask.SetInParent()
    if isinstance(until, Happens):
        request.event.kinds.extend(events.kind_numbers(until.kinds))
        request.event.names.extend(arguments.texts("names", until.names))
        request.event.SetInParent()
    elif isinstance(until, faults.Crossing):
        faults.set_crossing(request.crossing, until)
    elif until is not None:
        if isinstance(until, str):
            raise arguments.wrong("until", until, "a time in s, Happens([...]) or faults.Crossing(...)")
        faults.set_duration(request.time, "until", until)

    def read(answer: Any) -> Run:
        happened = events.event(answer.event) if answer.HasField("event") else None
        met = answer.outcome == control.RUN_OUTCOME_MET
        return Run(met, happened, Snapshot(answer.snapshot))

    return _control("RunUntil", request, read, _timeout(timeout_s, _RUN_S))


def set_speed(factor: float) -> Call[Receipt]:
    if isinstance(factor, float) and factor == math.inf:
        return _control("SetSpeed", control.SetSpeedRequest(maximum=True), _receipt)
    value = arguments.number("factor", factor, "simulated seconds per second, or math.inf")
    return _control("SetSpeed", control.SetSpeedRequest(factor=value), _receipt)


def reset(seed: int | None, scene: str | None, scene_text: str | None) -> Call[Receipt]:
    if scene is not None and scene_text is not None:
        raise AprsimError("reset: one of scene and scene_text is expected, not both")
    request = control.ResetRequest(
        seed=None if seed is None else arguments.whole("seed", seed, 0, _MOST),
        scene_name=None if scene is None else arguments.text("scene", scene),
        scene_text=None if scene_text is None else arguments.text("scene_text", scene_text),
    )
    return _control("Reset", request, _receipt)


def get_scene() -> Call[str]:
    def read(answer: telemetry.GetSceneResponse) -> str:
        return answer.text

    return Call("Telemetry", "GetScene", telemetry.GetSceneRequest(), read)


def _named(request: Callable[..., Any], name: str) -> Any:
    return request(name=arguments.text("name", name))


def _body(answer: Any) -> BodyState:
    return BodyState(answer.body)


def spawn_body(type_name: str, name: str, X_WB: Array) -> Call[BodyState]:
    request = control.SpawnBodyRequest(
        type=arguments.text("type_name", type_name),
        name=arguments.text("name", name),
        body_in_world=pose_message(arguments.pose("X_WB", X_WB)),
    )
    return _control("SpawnBody", request, _body)


def move_body(name: str, X_WB: Array) -> Call[BodyState]:
    request = control.MoveBodyRequest(
        name=arguments.text("name", name),
        body_in_world=pose_message(arguments.pose("X_WB", X_WB)),
    )
    return _control("MoveBody", request, _body)


def remove_body(name: str) -> Call[Receipt]:
    return _control("RemoveBody", _named(control.RemoveBodyRequest, name), _receipt)


def set_scene_value(path: str, value: object) -> Call[Receipt]:
    text = str(value).lower() if isinstance(value, bool) else str(value)
    request = control.SetSceneValueRequest(path=arguments.text("path", path), value=text)
    return _control("SetSceneValue", request, _receipt)


def save_state(name: str) -> Call[Receipt]:
    return _control("SaveState", _named(control.SaveStateRequest, name), _receipt)


def load_state(name: str) -> Call[Receipt]:
    return _control("LoadState", _named(control.LoadStateRequest, name), _receipt)


def delete_state(name: str) -> Call[Receipt]:
    return _control("DeleteState", _named(control.DeleteStateRequest, name), _receipt)


def list_states() -> Call[list[SavedState]]:
    def read(answer: Any) -> list[SavedState]:
        return [
            SavedState(state.name, state.bytes, state.step, seconds(state.sim_time))
            for state in answer.states
        ]

    return _control("ListStates", control.ListStatesRequest(), read)


def set_planning(robot: str, mode: str) -> Call[Receipt]:
    if mode not in PLANNING_MODES:
        raise arguments.wrong("mode", mode, "one of " + ", ".join(PLANNING_MODES))
    number = snapshot_pb2.PlanningMode.Value("PLANNING_MODE_" + mode.upper())
    request = control.SetPlanningRequest(robot=arguments.text("robot", robot), mode=number)
    return _control("SetPlanning", request, _receipt)


def switch_gripper(robot: str, setting: float) -> Call[Receipt]:
    request = trajectory.SwitchGripperRequest(
        robot=arguments.text("robot", robot), setting=arguments.number("setting", setting, low=0, high=1)
    )
    return Call("Trajectory", "SwitchGripper", request, _receipt)


def append_points(request: Any) -> Call[Any]:
    return Call("Trajectory", "AppendPoints", request, lambda answer: answer)


def preview(
    robot: str,
    X_RT: npt.ArrayLike | None,
    positions_rad: npt.ArrayLike | None,
    speed_rad_s: float | None,
    straight: bool,
    mode: str | None,
) -> Call[Preview]:
    request = previews.request(robot, X_RT, positions_rad, speed_rad_s, straight, mode)
    return _control("PreviewMove", request, previews.read)


def set_conveyor(
    run: bool | None,
    forward: bool | None,
    speed_m_s: float | None,
    emergency_stop: bool | None,
    fault_reset: bool,
) -> Call[snapshot_pb2.ConveyorState]:
    request = control.SetConveyorRequest(fault_reset=arguments.truth("fault_reset", fault_reset))
    if run is not None:
        request.run = arguments.truth("run", run)
    if speed_m_s is not None:
        request.speed_m_s = arguments.number("speed_m_s", speed_m_s, "m/s")
    if emergency_stop is not None:
        request.emergency_stop = arguments.truth("emergency_stop", emergency_stop)
    if forward is not None:
        request.direction = (
            control.CONVEYOR_DIRECTION_FORWARD
            if arguments.truth("forward", forward)
            else control.CONVEYOR_DIRECTION_REVERSE
        )

    def read(answer: control.SetConveyorResponse) -> snapshot_pb2.ConveyorState:
        return answer.conveyor

    return _control("SetConveyor", request, read)


def set_signal(device: str, signal: str, value: float) -> Call[Receipt]:
    setting = control.SignalSetting(
        device=arguments.text("device", device),
        signal=arguments.text("signal", signal),
        value=arguments.number("value", value),
    )
    return _control("SetSignals", control.SetSignalsRequest(settings=[setting]), _receipt)


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
    return _control("EndFault", _identified(control.EndFaultRequest, identifier), _receipt)


def report_event(event: str) -> Call[Receipt]:
    request = control.ReportEventRequest(event=arguments.text("event", event))
    return _control("ReportEvent", request, _receipt)


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


def _moment(epoch: int, step: int, name: str = "step") -> past.Moment:
    return past.Moment(
        epoch=arguments.whole("epoch", epoch, 0, _MOST),
        step=arguments.whole(name, step, 0, _MOST),
    )


def get_past(epoch: int, step: int, fields: Sequence[str]) -> Call[Snapshot]:
    request = past.GetPastSnapshotRequest(moment=_moment(epoch, step))
    request.read_mask.paths.extend(arguments.texts("fields", fields))
    return Call("History", "GetPastSnapshot", request, _snapshot)


def past_request(epoch: int, begin: int, end: int, stride: int, fields: Sequence[str]) -> Any:
    request = past.StreamPastRequest(
        begin=_moment(epoch, begin, "begin"),
        end_step=arguments.whole("end", end, 0, _MOST),
        stride=arguments.whole("stride", stride, 1, _MOST),
    )
    request.read_mask.paths.extend(arguments.texts("fields", fields))
    return request


def incident_request(last_s: float) -> Any:
    request = journal.GetIncidentRequest()
    faults.set_duration(request.last, "last_s", last_s)
    return request


def resume_from(epoch: int, step: int) -> Call[Receipt]:
    request = past.ResumeFromRequest(moment=_moment(epoch, step))
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

    words = arguments.text("text", text)
    request = past.AddBookmarkRequest(moment=_moment(epoch, step), text=words)
    return Call("History", "AddBookmark", request, read)


def remove_bookmark(identifier: int) -> Call[None]:
    def read(_: Any) -> None:
        return None

    request = _identified(past.RemoveBookmarkRequest, identifier)
    return Call("History", "RemoveBookmark", request, read)
