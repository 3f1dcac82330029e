from aprsim.crcl.v1 import values_pb2 as _values_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from typing import ClassVar as _ClassVar, Iterable as _Iterable, Mapping as _Mapping, Optional as _Optional, Union as _Union

COMMAND_STATE_DONE: CommandState
COMMAND_STATE_ERROR: CommandState
COMMAND_STATE_READY: CommandState
COMMAND_STATE_UNSPECIFIED: CommandState
COMMAND_STATE_WORKING: CommandState
DESCRIPTOR: _descriptor.FileDescriptor

class CommandStatus(_message.Message):
    __slots__ = ["command_id", "command_state", "name", "override_percent", "program_file", "program_index", "program_length", "state_description", "status_id"]
    COMMAND_ID_FIELD_NUMBER: _ClassVar[int]
    COMMAND_STATE_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    OVERRIDE_PERCENT_FIELD_NUMBER: _ClassVar[int]
    PROGRAM_FILE_FIELD_NUMBER: _ClassVar[int]
    PROGRAM_INDEX_FIELD_NUMBER: _ClassVar[int]
    PROGRAM_LENGTH_FIELD_NUMBER: _ClassVar[int]
    STATE_DESCRIPTION_FIELD_NUMBER: _ClassVar[int]
    STATUS_ID_FIELD_NUMBER: _ClassVar[int]
    command_id: int
    command_state: CommandState
    name: str
    override_percent: int
    program_file: str
    program_index: int
    program_length: int
    state_description: str
    status_id: int
    def __init__(self, name: _Optional[str] = ..., command_id: _Optional[int] = ..., status_id: _Optional[int] = ..., command_state: _Optional[_Union[CommandState, str]] = ..., state_description: _Optional[str] = ..., program_file: _Optional[str] = ..., program_index: _Optional[int] = ..., program_length: _Optional[int] = ..., override_percent: _Optional[int] = ...) -> None: ...

class CountSensorStatus(_message.Message):
    __slots__ = ["count_value", "last_read_time_ms", "name", "read_count", "sensor_id", "sensor_parameter_settings"]
    COUNT_VALUE_FIELD_NUMBER: _ClassVar[int]
    LAST_READ_TIME_MS_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    READ_COUNT_FIELD_NUMBER: _ClassVar[int]
    SENSOR_ID_FIELD_NUMBER: _ClassVar[int]
    SENSOR_PARAMETER_SETTINGS_FIELD_NUMBER: _ClassVar[int]
    count_value: int
    last_read_time_ms: int
    name: str
    read_count: int
    sensor_id: str
    sensor_parameter_settings: _containers.RepeatedCompositeFieldContainer[_values_pb2.ParameterSetting]
    def __init__(self, name: _Optional[str] = ..., sensor_id: _Optional[str] = ..., read_count: _Optional[int] = ..., last_read_time_ms: _Optional[int] = ..., sensor_parameter_settings: _Optional[_Iterable[_Union[_values_pb2.ParameterSetting, _Mapping]]] = ..., count_value: _Optional[int] = ...) -> None: ...

class ForceTorqueSensorStatus(_message.Message):
    __slots__ = ["fx", "fy", "fz", "last_read_time_ms", "name", "read_count", "sensor_id", "sensor_parameter_settings", "tx", "ty", "tz"]
    FX_FIELD_NUMBER: _ClassVar[int]
    FY_FIELD_NUMBER: _ClassVar[int]
    FZ_FIELD_NUMBER: _ClassVar[int]
    LAST_READ_TIME_MS_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    READ_COUNT_FIELD_NUMBER: _ClassVar[int]
    SENSOR_ID_FIELD_NUMBER: _ClassVar[int]
    SENSOR_PARAMETER_SETTINGS_FIELD_NUMBER: _ClassVar[int]
    TX_FIELD_NUMBER: _ClassVar[int]
    TY_FIELD_NUMBER: _ClassVar[int]
    TZ_FIELD_NUMBER: _ClassVar[int]
    fx: float
    fy: float
    fz: float
    last_read_time_ms: int
    name: str
    read_count: int
    sensor_id: str
    sensor_parameter_settings: _containers.RepeatedCompositeFieldContainer[_values_pb2.ParameterSetting]
    tx: float
    ty: float
    tz: float
    def __init__(self, name: _Optional[str] = ..., sensor_id: _Optional[str] = ..., read_count: _Optional[int] = ..., last_read_time_ms: _Optional[int] = ..., sensor_parameter_settings: _Optional[_Iterable[_Union[_values_pb2.ParameterSetting, _Mapping]]] = ..., fx: _Optional[float] = ..., fy: _Optional[float] = ..., fz: _Optional[float] = ..., tx: _Optional[float] = ..., ty: _Optional[float] = ..., tz: _Optional[float] = ...) -> None: ...

class GripperStatus(_message.Message):
    __slots__ = ["gripper_name", "gripper_options", "holding_object", "name", "parallel", "three_finger", "vacuum"]
    GRIPPER_NAME_FIELD_NUMBER: _ClassVar[int]
    GRIPPER_OPTIONS_FIELD_NUMBER: _ClassVar[int]
    HOLDING_OBJECT_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    PARALLEL_FIELD_NUMBER: _ClassVar[int]
    THREE_FINGER_FIELD_NUMBER: _ClassVar[int]
    VACUUM_FIELD_NUMBER: _ClassVar[int]
    gripper_name: str
    gripper_options: _containers.RepeatedCompositeFieldContainer[_values_pb2.ParameterSetting]
    holding_object: bool
    name: str
    parallel: ParallelGripperStatus
    three_finger: ThreeFingerGripperStatus
    vacuum: VacuumGripperStatus
    def __init__(self, name: _Optional[str] = ..., gripper_name: _Optional[str] = ..., gripper_options: _Optional[_Iterable[_Union[_values_pb2.ParameterSetting, _Mapping]]] = ..., holding_object: bool = ..., parallel: _Optional[_Union[ParallelGripperStatus, _Mapping]] = ..., three_finger: _Optional[_Union[ThreeFingerGripperStatus, _Mapping]] = ..., vacuum: _Optional[_Union[VacuumGripperStatus, _Mapping]] = ...) -> None: ...

class GuardsStatuses(_message.Message):
    __slots__ = ["guards", "name", "trigger_count", "trigger_pose", "trigger_stop_time_us", "trigger_value"]
    GUARDS_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    TRIGGER_COUNT_FIELD_NUMBER: _ClassVar[int]
    TRIGGER_POSE_FIELD_NUMBER: _ClassVar[int]
    TRIGGER_STOP_TIME_US_FIELD_NUMBER: _ClassVar[int]
    TRIGGER_VALUE_FIELD_NUMBER: _ClassVar[int]
    guards: _containers.RepeatedCompositeFieldContainer[_values_pb2.Guard]
    name: str
    trigger_count: int
    trigger_pose: _values_pb2.Pose
    trigger_stop_time_us: int
    trigger_value: float
    def __init__(self, name: _Optional[str] = ..., guards: _Optional[_Iterable[_Union[_values_pb2.Guard, _Mapping]]] = ..., trigger_count: _Optional[int] = ..., trigger_stop_time_us: _Optional[int] = ..., trigger_value: _Optional[float] = ..., trigger_pose: _Optional[_Union[_values_pb2.Pose, _Mapping]] = ...) -> None: ...

class JointLimit(_message.Message):
    __slots__ = ["joint_max_position", "joint_max_torque_or_force", "joint_max_velocity", "joint_min_position", "joint_number", "name"]
    JOINT_MAX_POSITION_FIELD_NUMBER: _ClassVar[int]
    JOINT_MAX_TORQUE_OR_FORCE_FIELD_NUMBER: _ClassVar[int]
    JOINT_MAX_VELOCITY_FIELD_NUMBER: _ClassVar[int]
    JOINT_MIN_POSITION_FIELD_NUMBER: _ClassVar[int]
    JOINT_NUMBER_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    joint_max_position: float
    joint_max_torque_or_force: float
    joint_max_velocity: float
    joint_min_position: float
    joint_number: int
    name: str
    def __init__(self, name: _Optional[str] = ..., joint_number: _Optional[int] = ..., joint_min_position: _Optional[float] = ..., joint_max_position: _Optional[float] = ..., joint_max_torque_or_force: _Optional[float] = ..., joint_max_velocity: _Optional[float] = ...) -> None: ...

class JointStatus(_message.Message):
    __slots__ = ["joint_number", "joint_position", "joint_torque_or_force", "joint_velocity", "name"]
    JOINT_NUMBER_FIELD_NUMBER: _ClassVar[int]
    JOINT_POSITION_FIELD_NUMBER: _ClassVar[int]
    JOINT_TORQUE_OR_FORCE_FIELD_NUMBER: _ClassVar[int]
    JOINT_VELOCITY_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    joint_number: int
    joint_position: float
    joint_torque_or_force: float
    joint_velocity: float
    name: str
    def __init__(self, name: _Optional[str] = ..., joint_number: _Optional[int] = ..., joint_position: _Optional[float] = ..., joint_torque_or_force: _Optional[float] = ..., joint_velocity: _Optional[float] = ...) -> None: ...

class JointStatuses(_message.Message):
    __slots__ = ["joint_statuses", "name"]
    JOINT_STATUSES_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    joint_statuses: _containers.RepeatedCompositeFieldContainer[JointStatus]
    name: str
    def __init__(self, name: _Optional[str] = ..., joint_statuses: _Optional[_Iterable[_Union[JointStatus, _Mapping]]] = ...) -> None: ...

class OnOffSensorStatus(_message.Message):
    __slots__ = ["last_read_time_ms", "name", "on", "read_count", "sensor_id", "sensor_parameter_settings"]
    LAST_READ_TIME_MS_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    ON_FIELD_NUMBER: _ClassVar[int]
    READ_COUNT_FIELD_NUMBER: _ClassVar[int]
    SENSOR_ID_FIELD_NUMBER: _ClassVar[int]
    SENSOR_PARAMETER_SETTINGS_FIELD_NUMBER: _ClassVar[int]
    last_read_time_ms: int
    name: str
    on: bool
    read_count: int
    sensor_id: str
    sensor_parameter_settings: _containers.RepeatedCompositeFieldContainer[_values_pb2.ParameterSetting]
    def __init__(self, name: _Optional[str] = ..., sensor_id: _Optional[str] = ..., read_count: _Optional[int] = ..., last_read_time_ms: _Optional[int] = ..., sensor_parameter_settings: _Optional[_Iterable[_Union[_values_pb2.ParameterSetting, _Mapping]]] = ..., on: bool = ...) -> None: ...

class ParallelGripperStatus(_message.Message):
    __slots__ = ["separation"]
    SEPARATION_FIELD_NUMBER: _ClassVar[int]
    separation: float
    def __init__(self, separation: _Optional[float] = ...) -> None: ...

class PoseStatus(_message.Message):
    __slots__ = ["configuration", "name", "pose", "twist", "wrench"]
    CONFIGURATION_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    POSE_FIELD_NUMBER: _ClassVar[int]
    TWIST_FIELD_NUMBER: _ClassVar[int]
    WRENCH_FIELD_NUMBER: _ClassVar[int]
    configuration: str
    name: str
    pose: _values_pb2.Pose
    twist: _values_pb2.Twist
    wrench: _values_pb2.Wrench
    def __init__(self, name: _Optional[str] = ..., pose: _Optional[_Union[_values_pb2.Pose, _Mapping]] = ..., twist: _Optional[_Union[_values_pb2.Twist, _Mapping]] = ..., wrench: _Optional[_Union[_values_pb2.Wrench, _Mapping]] = ..., configuration: _Optional[str] = ...) -> None: ...

class ScalarSensorStatus(_message.Message):
    __slots__ = ["last_read_time_ms", "name", "read_count", "scalar_value", "sensor_id", "sensor_parameter_settings"]
    LAST_READ_TIME_MS_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    READ_COUNT_FIELD_NUMBER: _ClassVar[int]
    SCALAR_VALUE_FIELD_NUMBER: _ClassVar[int]
    SENSOR_ID_FIELD_NUMBER: _ClassVar[int]
    SENSOR_PARAMETER_SETTINGS_FIELD_NUMBER: _ClassVar[int]
    last_read_time_ms: int
    name: str
    read_count: int
    scalar_value: float
    sensor_id: str
    sensor_parameter_settings: _containers.RepeatedCompositeFieldContainer[_values_pb2.ParameterSetting]
    def __init__(self, name: _Optional[str] = ..., sensor_id: _Optional[str] = ..., read_count: _Optional[int] = ..., last_read_time_ms: _Optional[int] = ..., sensor_parameter_settings: _Optional[_Iterable[_Union[_values_pb2.ParameterSetting, _Mapping]]] = ..., scalar_value: _Optional[float] = ...) -> None: ...

class SensorStatuses(_message.Message):
    __slots__ = ["count_sensor_statuses", "force_torque_sensor_statuses", "name", "on_off_sensor_statuses", "scalar_sensor_statuses"]
    COUNT_SENSOR_STATUSES_FIELD_NUMBER: _ClassVar[int]
    FORCE_TORQUE_SENSOR_STATUSES_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    ON_OFF_SENSOR_STATUSES_FIELD_NUMBER: _ClassVar[int]
    SCALAR_SENSOR_STATUSES_FIELD_NUMBER: _ClassVar[int]
    count_sensor_statuses: _containers.RepeatedCompositeFieldContainer[CountSensorStatus]
    force_torque_sensor_statuses: _containers.RepeatedCompositeFieldContainer[ForceTorqueSensorStatus]
    name: str
    on_off_sensor_statuses: _containers.RepeatedCompositeFieldContainer[OnOffSensorStatus]
    scalar_sensor_statuses: _containers.RepeatedCompositeFieldContainer[ScalarSensorStatus]
    def __init__(self, name: _Optional[str] = ..., on_off_sensor_statuses: _Optional[_Iterable[_Union[OnOffSensorStatus, _Mapping]]] = ..., scalar_sensor_statuses: _Optional[_Iterable[_Union[ScalarSensorStatus, _Mapping]]] = ..., count_sensor_statuses: _Optional[_Iterable[_Union[CountSensorStatus, _Mapping]]] = ..., force_torque_sensor_statuses: _Optional[_Iterable[_Union[ForceTorqueSensorStatus, _Mapping]]] = ...) -> None: ...

class SettingsStatus(_message.Message):
    __slots__ = ["angle_unit_name", "end_effector_parameter_settings", "end_effector_setting", "end_pose_tolerance", "force_unit_name", "intermediate_pose_tolerance", "joint_limits", "joint_tolerances", "length_unit_name", "max_cartesian_limit", "min_cartesian_limit", "motion_coordinated", "name", "robot_parameter_settings", "rot_accel_absolute", "rot_accel_relative", "rot_speed_absolute", "rot_speed_relative", "torque_unit_name", "trans_accel_absolute", "trans_accel_relative", "trans_speed_absolute", "trans_speed_relative"]
    ANGLE_UNIT_NAME_FIELD_NUMBER: _ClassVar[int]
    END_EFFECTOR_PARAMETER_SETTINGS_FIELD_NUMBER: _ClassVar[int]
    END_EFFECTOR_SETTING_FIELD_NUMBER: _ClassVar[int]
    END_POSE_TOLERANCE_FIELD_NUMBER: _ClassVar[int]
    FORCE_UNIT_NAME_FIELD_NUMBER: _ClassVar[int]
    INTERMEDIATE_POSE_TOLERANCE_FIELD_NUMBER: _ClassVar[int]
    JOINT_LIMITS_FIELD_NUMBER: _ClassVar[int]
    JOINT_TOLERANCES_FIELD_NUMBER: _ClassVar[int]
    LENGTH_UNIT_NAME_FIELD_NUMBER: _ClassVar[int]
    MAX_CARTESIAN_LIMIT_FIELD_NUMBER: _ClassVar[int]
    MIN_CARTESIAN_LIMIT_FIELD_NUMBER: _ClassVar[int]
    MOTION_COORDINATED_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    ROBOT_PARAMETER_SETTINGS_FIELD_NUMBER: _ClassVar[int]
    ROT_ACCEL_ABSOLUTE_FIELD_NUMBER: _ClassVar[int]
    ROT_ACCEL_RELATIVE_FIELD_NUMBER: _ClassVar[int]
    ROT_SPEED_ABSOLUTE_FIELD_NUMBER: _ClassVar[int]
    ROT_SPEED_RELATIVE_FIELD_NUMBER: _ClassVar[int]
    TORQUE_UNIT_NAME_FIELD_NUMBER: _ClassVar[int]
    TRANS_ACCEL_ABSOLUTE_FIELD_NUMBER: _ClassVar[int]
    TRANS_ACCEL_RELATIVE_FIELD_NUMBER: _ClassVar[int]
    TRANS_SPEED_ABSOLUTE_FIELD_NUMBER: _ClassVar[int]
    TRANS_SPEED_RELATIVE_FIELD_NUMBER: _ClassVar[int]
    angle_unit_name: _values_pb2.AngleUnit
    end_effector_parameter_settings: _containers.RepeatedCompositeFieldContainer[_values_pb2.ParameterSetting]
    end_effector_setting: float
    end_pose_tolerance: _values_pb2.PoseTolerance
    force_unit_name: _values_pb2.ForceUnit
    intermediate_pose_tolerance: _values_pb2.PoseTolerance
    joint_limits: _containers.RepeatedCompositeFieldContainer[JointLimit]
    joint_tolerances: _values_pb2.JointTolerances
    length_unit_name: _values_pb2.LengthUnit
    max_cartesian_limit: _values_pb2.Point
    min_cartesian_limit: _values_pb2.Point
    motion_coordinated: bool
    name: str
    robot_parameter_settings: _containers.RepeatedCompositeFieldContainer[_values_pb2.ParameterSetting]
    rot_accel_absolute: _values_pb2.RotAccelAbsolute
    rot_accel_relative: _values_pb2.RotAccelRelative
    rot_speed_absolute: _values_pb2.RotSpeedAbsolute
    rot_speed_relative: _values_pb2.RotSpeedRelative
    torque_unit_name: _values_pb2.TorqueUnit
    trans_accel_absolute: _values_pb2.TransAccelAbsolute
    trans_accel_relative: _values_pb2.TransAccelRelative
    trans_speed_absolute: _values_pb2.TransSpeedAbsolute
    trans_speed_relative: _values_pb2.TransSpeedRelative
    def __init__(self, name: _Optional[str] = ..., angle_unit_name: _Optional[_Union[_values_pb2.AngleUnit, str]] = ..., end_effector_parameter_settings: _Optional[_Iterable[_Union[_values_pb2.ParameterSetting, _Mapping]]] = ..., end_effector_setting: _Optional[float] = ..., force_unit_name: _Optional[_Union[_values_pb2.ForceUnit, str]] = ..., joint_limits: _Optional[_Iterable[_Union[JointLimit, _Mapping]]] = ..., intermediate_pose_tolerance: _Optional[_Union[_values_pb2.PoseTolerance, _Mapping]] = ..., length_unit_name: _Optional[_Union[_values_pb2.LengthUnit, str]] = ..., max_cartesian_limit: _Optional[_Union[_values_pb2.Point, _Mapping]] = ..., min_cartesian_limit: _Optional[_Union[_values_pb2.Point, _Mapping]] = ..., motion_coordinated: bool = ..., end_pose_tolerance: _Optional[_Union[_values_pb2.PoseTolerance, _Mapping]] = ..., robot_parameter_settings: _Optional[_Iterable[_Union[_values_pb2.ParameterSetting, _Mapping]]] = ..., rot_accel_absolute: _Optional[_Union[_values_pb2.RotAccelAbsolute, _Mapping]] = ..., rot_accel_relative: _Optional[_Union[_values_pb2.RotAccelRelative, _Mapping]] = ..., rot_speed_absolute: _Optional[_Union[_values_pb2.RotSpeedAbsolute, _Mapping]] = ..., rot_speed_relative: _Optional[_Union[_values_pb2.RotSpeedRelative, _Mapping]] = ..., torque_unit_name: _Optional[_Union[_values_pb2.TorqueUnit, str]] = ..., trans_accel_absolute: _Optional[_Union[_values_pb2.TransAccelAbsolute, _Mapping]] = ..., trans_accel_relative: _Optional[_Union[_values_pb2.TransAccelRelative, _Mapping]] = ..., trans_speed_absolute: _Optional[_Union[_values_pb2.TransSpeedAbsolute, _Mapping]] = ..., trans_speed_relative: _Optional[_Union[_values_pb2.TransSpeedRelative, _Mapping]] = ..., joint_tolerances: _Optional[_Union[_values_pb2.JointTolerances, _Mapping]] = ...) -> None: ...

class Status(_message.Message):
    __slots__ = ["command_status", "gripper_status", "guards_statuses", "joint_statuses", "name", "pose_status", "sensor_statuses", "settings_status"]
    COMMAND_STATUS_FIELD_NUMBER: _ClassVar[int]
    GRIPPER_STATUS_FIELD_NUMBER: _ClassVar[int]
    GUARDS_STATUSES_FIELD_NUMBER: _ClassVar[int]
    JOINT_STATUSES_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    POSE_STATUS_FIELD_NUMBER: _ClassVar[int]
    SENSOR_STATUSES_FIELD_NUMBER: _ClassVar[int]
    SETTINGS_STATUS_FIELD_NUMBER: _ClassVar[int]
    command_status: CommandStatus
    gripper_status: GripperStatus
    guards_statuses: GuardsStatuses
    joint_statuses: JointStatuses
    name: str
    pose_status: PoseStatus
    sensor_statuses: SensorStatuses
    settings_status: SettingsStatus
    def __init__(self, name: _Optional[str] = ..., command_status: _Optional[_Union[CommandStatus, _Mapping]] = ..., joint_statuses: _Optional[_Union[JointStatuses, _Mapping]] = ..., pose_status: _Optional[_Union[PoseStatus, _Mapping]] = ..., gripper_status: _Optional[_Union[GripperStatus, _Mapping]] = ..., settings_status: _Optional[_Union[SettingsStatus, _Mapping]] = ..., sensor_statuses: _Optional[_Union[SensorStatuses, _Mapping]] = ..., guards_statuses: _Optional[_Union[GuardsStatuses, _Mapping]] = ...) -> None: ...

class ThreeFingerGripperStatus(_message.Message):
    __slots__ = ["finger1_force", "finger1_position", "finger2_force", "finger2_position", "finger3_force", "finger3_position"]
    FINGER1_FORCE_FIELD_NUMBER: _ClassVar[int]
    FINGER1_POSITION_FIELD_NUMBER: _ClassVar[int]
    FINGER2_FORCE_FIELD_NUMBER: _ClassVar[int]
    FINGER2_POSITION_FIELD_NUMBER: _ClassVar[int]
    FINGER3_FORCE_FIELD_NUMBER: _ClassVar[int]
    FINGER3_POSITION_FIELD_NUMBER: _ClassVar[int]
    finger1_force: float
    finger1_position: float
    finger2_force: float
    finger2_position: float
    finger3_force: float
    finger3_position: float
    def __init__(self, finger1_position: _Optional[float] = ..., finger2_position: _Optional[float] = ..., finger3_position: _Optional[float] = ..., finger1_force: _Optional[float] = ..., finger2_force: _Optional[float] = ..., finger3_force: _Optional[float] = ...) -> None: ...

class VacuumGripperStatus(_message.Message):
    __slots__ = ["is_powered"]
    IS_POWERED_FIELD_NUMBER: _ClassVar[int]
    is_powered: bool
    def __init__(self, is_powered: bool = ...) -> None: ...

class CommandState(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = []
