from aprsim.crcl.v1 import commands_pb2 as _commands_pb2
from aprsim.crcl.v1 import status_pb2 as _status_pb2
from aprsim.crcl.v1 import values_pb2 as _values_pb2
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from typing import ClassVar as _ClassVar, Mapping as _Mapping, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class ConnectRequest(_message.Message):
    __slots__ = ["command", "options", "program"]
    COMMAND_FIELD_NUMBER: _ClassVar[int]
    OPTIONS_FIELD_NUMBER: _ClassVar[int]
    PROGRAM_FIELD_NUMBER: _ClassVar[int]
    command: _commands_pb2.CommandInstance
    options: SessionOptions
    program: _commands_pb2.Program
    def __init__(self, options: _Optional[_Union[SessionOptions, _Mapping]] = ..., command: _Optional[_Union[_commands_pb2.CommandInstance, _Mapping]] = ..., program: _Optional[_Union[_commands_pb2.Program, _Mapping]] = ...) -> None: ...

class ConnectResponse(_message.Message):
    __slots__ = ["status"]
    STATUS_FIELD_NUMBER: _ClassVar[int]
    status: _status_pb2.Status
    def __init__(self, status: _Optional[_Union[_status_pb2.Status, _Mapping]] = ...) -> None: ...

class ExecuteRequest(_message.Message):
    __slots__ = ["command", "options"]
    COMMAND_FIELD_NUMBER: _ClassVar[int]
    OPTIONS_FIELD_NUMBER: _ClassVar[int]
    command: _commands_pb2.CommandInstance
    options: SessionOptions
    def __init__(self, options: _Optional[_Union[SessionOptions, _Mapping]] = ..., command: _Optional[_Union[_commands_pb2.CommandInstance, _Mapping]] = ...) -> None: ...

class ExecuteResponse(_message.Message):
    __slots__ = ["replaced", "status"]
    REPLACED_FIELD_NUMBER: _ClassVar[int]
    STATUS_FIELD_NUMBER: _ClassVar[int]
    replaced: bool
    status: _status_pb2.Status
    def __init__(self, status: _Optional[_Union[_status_pb2.Status, _Mapping]] = ..., replaced: bool = ...) -> None: ...

class GetStatusRequest(_message.Message):
    __slots__ = ["options", "report"]
    OPTIONS_FIELD_NUMBER: _ClassVar[int]
    REPORT_FIELD_NUMBER: _ClassVar[int]
    options: SessionOptions
    report: _commands_pb2.ConfigureStatusReport
    def __init__(self, options: _Optional[_Union[SessionOptions, _Mapping]] = ..., report: _Optional[_Union[_commands_pb2.ConfigureStatusReport, _Mapping]] = ...) -> None: ...

class GetStatusResponse(_message.Message):
    __slots__ = ["status"]
    STATUS_FIELD_NUMBER: _ClassVar[int]
    status: _status_pb2.Status
    def __init__(self, status: _Optional[_Union[_status_pb2.Status, _Mapping]] = ...) -> None: ...

class SessionOptions(_message.Message):
    __slots__ = ["angle_unit", "force_unit", "length_unit", "robot", "torque_unit"]
    ANGLE_UNIT_FIELD_NUMBER: _ClassVar[int]
    FORCE_UNIT_FIELD_NUMBER: _ClassVar[int]
    LENGTH_UNIT_FIELD_NUMBER: _ClassVar[int]
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    TORQUE_UNIT_FIELD_NUMBER: _ClassVar[int]
    angle_unit: _values_pb2.AngleUnit
    force_unit: _values_pb2.ForceUnit
    length_unit: _values_pb2.LengthUnit
    robot: str
    torque_unit: _values_pb2.TorqueUnit
    def __init__(self, robot: _Optional[str] = ..., length_unit: _Optional[_Union[_values_pb2.LengthUnit, str]] = ..., angle_unit: _Optional[_Union[_values_pb2.AngleUnit, str]] = ..., force_unit: _Optional[_Union[_values_pb2.ForceUnit, str]] = ..., torque_unit: _Optional[_Union[_values_pb2.TorqueUnit, str]] = ...) -> None: ...

class StreamStatusRequest(_message.Message):
    __slots__ = ["options", "rate_hz", "report"]
    OPTIONS_FIELD_NUMBER: _ClassVar[int]
    RATE_HZ_FIELD_NUMBER: _ClassVar[int]
    REPORT_FIELD_NUMBER: _ClassVar[int]
    options: SessionOptions
    rate_hz: float
    report: _commands_pb2.ConfigureStatusReport
    def __init__(self, options: _Optional[_Union[SessionOptions, _Mapping]] = ..., report: _Optional[_Union[_commands_pb2.ConfigureStatusReport, _Mapping]] = ..., rate_hz: _Optional[float] = ...) -> None: ...

class StreamStatusResponse(_message.Message):
    __slots__ = ["dropped_count", "status"]
    DROPPED_COUNT_FIELD_NUMBER: _ClassVar[int]
    STATUS_FIELD_NUMBER: _ClassVar[int]
    dropped_count: int
    status: _status_pb2.Status
    def __init__(self, status: _Optional[_Union[_status_pb2.Status, _Mapping]] = ..., dropped_count: _Optional[int] = ...) -> None: ...
