from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from typing import ClassVar as _ClassVar, Iterable as _Iterable, Mapping as _Mapping, Optional as _Optional, Union as _Union

ANGLE_UNIT_DEGREE: AngleUnit
ANGLE_UNIT_RADIAN: AngleUnit
ANGLE_UNIT_UNSPECIFIED: AngleUnit
DESCRIPTOR: _descriptor.FileDescriptor
FORCE_UNIT_NEWTON: ForceUnit
FORCE_UNIT_OUNCE: ForceUnit
FORCE_UNIT_POUND: ForceUnit
FORCE_UNIT_UNSPECIFIED: ForceUnit
GUARD_LIMIT_DECREASE_BEYOND_LIMIT: GuardLimit
GUARD_LIMIT_INCREASE_OVER_LIMIT: GuardLimit
GUARD_LIMIT_OVER_MAX: GuardLimit
GUARD_LIMIT_UNDER_MIN: GuardLimit
GUARD_LIMIT_UNSPECIFIED: GuardLimit
LENGTH_UNIT_INCH: LengthUnit
LENGTH_UNIT_METER: LengthUnit
LENGTH_UNIT_MILLIMETER: LengthUnit
LENGTH_UNIT_UNSPECIFIED: LengthUnit
TORQUE_UNIT_FOOT_POUND: TorqueUnit
TORQUE_UNIT_NEWTON_METER: TorqueUnit
TORQUE_UNIT_UNSPECIFIED: TorqueUnit

class Guard(_message.Message):
    __slots__ = ["check_count", "error_on_trigger", "last_check_time_ms", "last_check_value", "limit_type", "limit_value", "name", "recheck_time_us", "require_trigger", "sensor_id", "sub_field"]
    CHECK_COUNT_FIELD_NUMBER: _ClassVar[int]
    ERROR_ON_TRIGGER_FIELD_NUMBER: _ClassVar[int]
    LAST_CHECK_TIME_MS_FIELD_NUMBER: _ClassVar[int]
    LAST_CHECK_VALUE_FIELD_NUMBER: _ClassVar[int]
    LIMIT_TYPE_FIELD_NUMBER: _ClassVar[int]
    LIMIT_VALUE_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    RECHECK_TIME_US_FIELD_NUMBER: _ClassVar[int]
    REQUIRE_TRIGGER_FIELD_NUMBER: _ClassVar[int]
    SENSOR_ID_FIELD_NUMBER: _ClassVar[int]
    SUB_FIELD_FIELD_NUMBER: _ClassVar[int]
    check_count: int
    error_on_trigger: bool
    last_check_time_ms: int
    last_check_value: float
    limit_type: GuardLimit
    limit_value: float
    name: str
    recheck_time_us: int
    require_trigger: bool
    sensor_id: str
    sub_field: str
    def __init__(self, name: _Optional[str] = ..., sensor_id: _Optional[str] = ..., sub_field: _Optional[str] = ..., limit_type: _Optional[_Union[GuardLimit, str]] = ..., limit_value: _Optional[float] = ..., recheck_time_us: _Optional[int] = ..., check_count: _Optional[int] = ..., last_check_time_ms: _Optional[int] = ..., last_check_value: _Optional[float] = ..., require_trigger: bool = ..., error_on_trigger: bool = ...) -> None: ...

class JointTolerance(_message.Message):
    __slots__ = ["joint_number", "joint_position_tolerance", "name"]
    JOINT_NUMBER_FIELD_NUMBER: _ClassVar[int]
    JOINT_POSITION_TOLERANCE_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    joint_number: int
    joint_position_tolerance: float
    name: str
    def __init__(self, name: _Optional[str] = ..., joint_number: _Optional[int] = ..., joint_position_tolerance: _Optional[float] = ...) -> None: ...

class JointTolerances(_message.Message):
    __slots__ = ["name", "settings"]
    NAME_FIELD_NUMBER: _ClassVar[int]
    SETTINGS_FIELD_NUMBER: _ClassVar[int]
    name: str
    settings: _containers.RepeatedCompositeFieldContainer[JointTolerance]
    def __init__(self, name: _Optional[str] = ..., settings: _Optional[_Iterable[_Union[JointTolerance, _Mapping]]] = ...) -> None: ...

class ParameterSetting(_message.Message):
    __slots__ = ["name", "parameter_name", "parameter_value"]
    NAME_FIELD_NUMBER: _ClassVar[int]
    PARAMETER_NAME_FIELD_NUMBER: _ClassVar[int]
    PARAMETER_VALUE_FIELD_NUMBER: _ClassVar[int]
    name: str
    parameter_name: str
    parameter_value: str
    def __init__(self, name: _Optional[str] = ..., parameter_name: _Optional[str] = ..., parameter_value: _Optional[str] = ...) -> None: ...

class Point(_message.Message):
    __slots__ = ["name", "x", "y", "z"]
    NAME_FIELD_NUMBER: _ClassVar[int]
    X_FIELD_NUMBER: _ClassVar[int]
    Y_FIELD_NUMBER: _ClassVar[int]
    Z_FIELD_NUMBER: _ClassVar[int]
    name: str
    x: float
    y: float
    z: float
    def __init__(self, name: _Optional[str] = ..., x: _Optional[float] = ..., y: _Optional[float] = ..., z: _Optional[float] = ...) -> None: ...

class Pose(_message.Message):
    __slots__ = ["name", "point", "settings", "x_axis", "z_axis"]
    NAME_FIELD_NUMBER: _ClassVar[int]
    POINT_FIELD_NUMBER: _ClassVar[int]
    SETTINGS_FIELD_NUMBER: _ClassVar[int]
    X_AXIS_FIELD_NUMBER: _ClassVar[int]
    Z_AXIS_FIELD_NUMBER: _ClassVar[int]
    name: str
    point: Point
    settings: PoseSettings
    x_axis: Vector
    z_axis: Vector
    def __init__(self, name: _Optional[str] = ..., point: _Optional[_Union[Point, _Mapping]] = ..., x_axis: _Optional[_Union[Vector, _Mapping]] = ..., z_axis: _Optional[_Union[Vector, _Mapping]] = ..., settings: _Optional[_Union[PoseSettings, _Mapping]] = ...) -> None: ...

class PoseSettings(_message.Message):
    __slots__ = ["coordinated", "rot_accel", "rot_speed", "tolerance", "trans_accel", "trans_speed"]
    COORDINATED_FIELD_NUMBER: _ClassVar[int]
    ROT_ACCEL_FIELD_NUMBER: _ClassVar[int]
    ROT_SPEED_FIELD_NUMBER: _ClassVar[int]
    TOLERANCE_FIELD_NUMBER: _ClassVar[int]
    TRANS_ACCEL_FIELD_NUMBER: _ClassVar[int]
    TRANS_SPEED_FIELD_NUMBER: _ClassVar[int]
    coordinated: bool
    rot_accel: RotAccel
    rot_speed: RotSpeed
    tolerance: PoseTolerance
    trans_accel: TransAccel
    trans_speed: TransSpeed
    def __init__(self, coordinated: bool = ..., trans_speed: _Optional[_Union[TransSpeed, _Mapping]] = ..., rot_speed: _Optional[_Union[RotSpeed, _Mapping]] = ..., trans_accel: _Optional[_Union[TransAccel, _Mapping]] = ..., rot_accel: _Optional[_Union[RotAccel, _Mapping]] = ..., tolerance: _Optional[_Union[PoseTolerance, _Mapping]] = ...) -> None: ...

class PoseTolerance(_message.Message):
    __slots__ = ["name", "x_axis", "x_point", "y_point", "z_axis", "z_point"]
    NAME_FIELD_NUMBER: _ClassVar[int]
    X_AXIS_FIELD_NUMBER: _ClassVar[int]
    X_POINT_FIELD_NUMBER: _ClassVar[int]
    Y_POINT_FIELD_NUMBER: _ClassVar[int]
    Z_AXIS_FIELD_NUMBER: _ClassVar[int]
    Z_POINT_FIELD_NUMBER: _ClassVar[int]
    name: str
    x_axis: float
    x_point: float
    y_point: float
    z_axis: float
    z_point: float
    def __init__(self, name: _Optional[str] = ..., x_point: _Optional[float] = ..., y_point: _Optional[float] = ..., z_point: _Optional[float] = ..., x_axis: _Optional[float] = ..., z_axis: _Optional[float] = ...) -> None: ...

class RotAccel(_message.Message):
    __slots__ = ["absolute", "relative"]
    ABSOLUTE_FIELD_NUMBER: _ClassVar[int]
    RELATIVE_FIELD_NUMBER: _ClassVar[int]
    absolute: RotAccelAbsolute
    relative: RotAccelRelative
    def __init__(self, absolute: _Optional[_Union[RotAccelAbsolute, _Mapping]] = ..., relative: _Optional[_Union[RotAccelRelative, _Mapping]] = ...) -> None: ...

class RotAccelAbsolute(_message.Message):
    __slots__ = ["name", "setting"]
    NAME_FIELD_NUMBER: _ClassVar[int]
    SETTING_FIELD_NUMBER: _ClassVar[int]
    name: str
    setting: float
    def __init__(self, name: _Optional[str] = ..., setting: _Optional[float] = ...) -> None: ...

class RotAccelRelative(_message.Message):
    __slots__ = ["fraction", "name"]
    FRACTION_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    fraction: float
    name: str
    def __init__(self, name: _Optional[str] = ..., fraction: _Optional[float] = ...) -> None: ...

class RotSpeed(_message.Message):
    __slots__ = ["absolute", "relative"]
    ABSOLUTE_FIELD_NUMBER: _ClassVar[int]
    RELATIVE_FIELD_NUMBER: _ClassVar[int]
    absolute: RotSpeedAbsolute
    relative: RotSpeedRelative
    def __init__(self, absolute: _Optional[_Union[RotSpeedAbsolute, _Mapping]] = ..., relative: _Optional[_Union[RotSpeedRelative, _Mapping]] = ...) -> None: ...

class RotSpeedAbsolute(_message.Message):
    __slots__ = ["name", "setting"]
    NAME_FIELD_NUMBER: _ClassVar[int]
    SETTING_FIELD_NUMBER: _ClassVar[int]
    name: str
    setting: float
    def __init__(self, name: _Optional[str] = ..., setting: _Optional[float] = ...) -> None: ...

class RotSpeedRelative(_message.Message):
    __slots__ = ["fraction", "name"]
    FRACTION_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    fraction: float
    name: str
    def __init__(self, name: _Optional[str] = ..., fraction: _Optional[float] = ...) -> None: ...

class TransAccel(_message.Message):
    __slots__ = ["absolute", "relative"]
    ABSOLUTE_FIELD_NUMBER: _ClassVar[int]
    RELATIVE_FIELD_NUMBER: _ClassVar[int]
    absolute: TransAccelAbsolute
    relative: TransAccelRelative
    def __init__(self, absolute: _Optional[_Union[TransAccelAbsolute, _Mapping]] = ..., relative: _Optional[_Union[TransAccelRelative, _Mapping]] = ...) -> None: ...

class TransAccelAbsolute(_message.Message):
    __slots__ = ["name", "setting"]
    NAME_FIELD_NUMBER: _ClassVar[int]
    SETTING_FIELD_NUMBER: _ClassVar[int]
    name: str
    setting: float
    def __init__(self, name: _Optional[str] = ..., setting: _Optional[float] = ...) -> None: ...

class TransAccelRelative(_message.Message):
    __slots__ = ["fraction", "name"]
    FRACTION_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    fraction: float
    name: str
    def __init__(self, name: _Optional[str] = ..., fraction: _Optional[float] = ...) -> None: ...

class TransSpeed(_message.Message):
    __slots__ = ["absolute", "relative"]
    ABSOLUTE_FIELD_NUMBER: _ClassVar[int]
    RELATIVE_FIELD_NUMBER: _ClassVar[int]
    absolute: TransSpeedAbsolute
    relative: TransSpeedRelative
    def __init__(self, absolute: _Optional[_Union[TransSpeedAbsolute, _Mapping]] = ..., relative: _Optional[_Union[TransSpeedRelative, _Mapping]] = ...) -> None: ...

class TransSpeedAbsolute(_message.Message):
    __slots__ = ["name", "setting"]
    NAME_FIELD_NUMBER: _ClassVar[int]
    SETTING_FIELD_NUMBER: _ClassVar[int]
    name: str
    setting: float
    def __init__(self, name: _Optional[str] = ..., setting: _Optional[float] = ...) -> None: ...

class TransSpeedRelative(_message.Message):
    __slots__ = ["fraction", "name"]
    FRACTION_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    fraction: float
    name: str
    def __init__(self, name: _Optional[str] = ..., fraction: _Optional[float] = ...) -> None: ...

class Twist(_message.Message):
    __slots__ = ["angular_velocity", "linear_velocity", "name"]
    ANGULAR_VELOCITY_FIELD_NUMBER: _ClassVar[int]
    LINEAR_VELOCITY_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    angular_velocity: Vector
    linear_velocity: Vector
    name: str
    def __init__(self, name: _Optional[str] = ..., linear_velocity: _Optional[_Union[Vector, _Mapping]] = ..., angular_velocity: _Optional[_Union[Vector, _Mapping]] = ...) -> None: ...

class Vector(_message.Message):
    __slots__ = ["i", "j", "k", "name"]
    I_FIELD_NUMBER: _ClassVar[int]
    J_FIELD_NUMBER: _ClassVar[int]
    K_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    i: float
    j: float
    k: float
    name: str
    def __init__(self, name: _Optional[str] = ..., i: _Optional[float] = ..., j: _Optional[float] = ..., k: _Optional[float] = ...) -> None: ...

class Wrench(_message.Message):
    __slots__ = ["force", "moment", "name"]
    FORCE_FIELD_NUMBER: _ClassVar[int]
    MOMENT_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    force: Vector
    moment: Vector
    name: str
    def __init__(self, name: _Optional[str] = ..., force: _Optional[_Union[Vector, _Mapping]] = ..., moment: _Optional[_Union[Vector, _Mapping]] = ...) -> None: ...

class GuardLimit(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = []

class LengthUnit(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = []

class AngleUnit(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = []

class ForceUnit(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = []

class TorqueUnit(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = []
