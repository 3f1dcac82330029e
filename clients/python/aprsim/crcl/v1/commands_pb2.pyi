from aprsim.crcl.v1 import values_pb2 as _values_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from typing import ClassVar as _ClassVar, Iterable as _Iterable, Mapping as _Mapping, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor
STOP_CONDITION_FAST: StopCondition
STOP_CONDITION_IMMEDIATE: StopCondition
STOP_CONDITION_NORMAL: StopCondition
STOP_CONDITION_UNSPECIFIED: StopCondition

class ActuateJoint(_message.Message):
    __slots__ = ["joint_details", "joint_number", "joint_position", "name"]
    JOINT_DETAILS_FIELD_NUMBER: _ClassVar[int]
    JOINT_NUMBER_FIELD_NUMBER: _ClassVar[int]
    JOINT_POSITION_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    joint_details: JointDetails
    joint_number: int
    joint_position: float
    name: str
    def __init__(self, name: _Optional[str] = ..., joint_number: _Optional[int] = ..., joint_position: _Optional[float] = ..., joint_details: _Optional[_Union[JointDetails, _Mapping]] = ...) -> None: ...

class ActuateJoints(_message.Message):
    __slots__ = ["actuate_joints", "joint_tolerances"]
    ACTUATE_JOINTS_FIELD_NUMBER: _ClassVar[int]
    JOINT_TOLERANCES_FIELD_NUMBER: _ClassVar[int]
    actuate_joints: _containers.RepeatedCompositeFieldContainer[ActuateJoint]
    joint_tolerances: _values_pb2.JointTolerances
    def __init__(self, actuate_joints: _Optional[_Iterable[_Union[ActuateJoint, _Mapping]]] = ..., joint_tolerances: _Optional[_Union[_values_pb2.JointTolerances, _Mapping]] = ...) -> None: ...

class CloseToolChanger(_message.Message):
    __slots__ = []
    def __init__(self) -> None: ...

class Command(_message.Message):
    __slots__ = ["actuate_joints", "close_tool_changer", "command_id", "configure_joint_reports", "configure_status_report", "disable_gripper", "disable_robot_parameter_status", "disable_sensor", "dwell", "enable_gripper", "enable_robot_parameter_status", "enable_sensor", "end_canon", "get_status", "guards", "init_canon", "loop_block_end", "loop_block_start", "message", "move_screw", "move_through_to", "move_to", "name", "open_tool_changer", "run_program", "set_angle_units", "set_default_joint_tolerances", "set_end_effector", "set_end_effector_parameters", "set_end_pose_tolerance", "set_force_units", "set_intermediate_pose_tolerance", "set_length_units", "set_motion_coordination", "set_robot_parameters", "set_rot_accel", "set_rot_speed", "set_torque_units", "set_trans_accel", "set_trans_speed", "stop_motion"]
    ACTUATE_JOINTS_FIELD_NUMBER: _ClassVar[int]
    CLOSE_TOOL_CHANGER_FIELD_NUMBER: _ClassVar[int]
    COMMAND_ID_FIELD_NUMBER: _ClassVar[int]
    CONFIGURE_JOINT_REPORTS_FIELD_NUMBER: _ClassVar[int]
    CONFIGURE_STATUS_REPORT_FIELD_NUMBER: _ClassVar[int]
    DISABLE_GRIPPER_FIELD_NUMBER: _ClassVar[int]
    DISABLE_ROBOT_PARAMETER_STATUS_FIELD_NUMBER: _ClassVar[int]
    DISABLE_SENSOR_FIELD_NUMBER: _ClassVar[int]
    DWELL_FIELD_NUMBER: _ClassVar[int]
    ENABLE_GRIPPER_FIELD_NUMBER: _ClassVar[int]
    ENABLE_ROBOT_PARAMETER_STATUS_FIELD_NUMBER: _ClassVar[int]
    ENABLE_SENSOR_FIELD_NUMBER: _ClassVar[int]
    END_CANON_FIELD_NUMBER: _ClassVar[int]
    GET_STATUS_FIELD_NUMBER: _ClassVar[int]
    GUARDS_FIELD_NUMBER: _ClassVar[int]
    INIT_CANON_FIELD_NUMBER: _ClassVar[int]
    LOOP_BLOCK_END_FIELD_NUMBER: _ClassVar[int]
    LOOP_BLOCK_START_FIELD_NUMBER: _ClassVar[int]
    MESSAGE_FIELD_NUMBER: _ClassVar[int]
    MOVE_SCREW_FIELD_NUMBER: _ClassVar[int]
    MOVE_THROUGH_TO_FIELD_NUMBER: _ClassVar[int]
    MOVE_TO_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    OPEN_TOOL_CHANGER_FIELD_NUMBER: _ClassVar[int]
    RUN_PROGRAM_FIELD_NUMBER: _ClassVar[int]
    SET_ANGLE_UNITS_FIELD_NUMBER: _ClassVar[int]
    SET_DEFAULT_JOINT_TOLERANCES_FIELD_NUMBER: _ClassVar[int]
    SET_END_EFFECTOR_FIELD_NUMBER: _ClassVar[int]
    SET_END_EFFECTOR_PARAMETERS_FIELD_NUMBER: _ClassVar[int]
    SET_END_POSE_TOLERANCE_FIELD_NUMBER: _ClassVar[int]
    SET_FORCE_UNITS_FIELD_NUMBER: _ClassVar[int]
    SET_INTERMEDIATE_POSE_TOLERANCE_FIELD_NUMBER: _ClassVar[int]
    SET_LENGTH_UNITS_FIELD_NUMBER: _ClassVar[int]
    SET_MOTION_COORDINATION_FIELD_NUMBER: _ClassVar[int]
    SET_ROBOT_PARAMETERS_FIELD_NUMBER: _ClassVar[int]
    SET_ROT_ACCEL_FIELD_NUMBER: _ClassVar[int]
    SET_ROT_SPEED_FIELD_NUMBER: _ClassVar[int]
    SET_TORQUE_UNITS_FIELD_NUMBER: _ClassVar[int]
    SET_TRANS_ACCEL_FIELD_NUMBER: _ClassVar[int]
    SET_TRANS_SPEED_FIELD_NUMBER: _ClassVar[int]
    STOP_MOTION_FIELD_NUMBER: _ClassVar[int]
    actuate_joints: ActuateJoints
    close_tool_changer: CloseToolChanger
    command_id: int
    configure_joint_reports: ConfigureJointReports
    configure_status_report: ConfigureStatusReport
    disable_gripper: DisableGripper
    disable_robot_parameter_status: DisableRobotParameterStatus
    disable_sensor: DisableSensor
    dwell: Dwell
    enable_gripper: EnableGripper
    enable_robot_parameter_status: EnableRobotParameterStatus
    enable_sensor: EnableSensor
    end_canon: EndCanon
    get_status: GetStatus
    guards: _containers.RepeatedCompositeFieldContainer[_values_pb2.Guard]
    init_canon: InitCanon
    loop_block_end: LoopBlockEnd
    loop_block_start: LoopBlockStart
    message: Message
    move_screw: MoveScrew
    move_through_to: MoveThroughTo
    move_to: MoveTo
    name: str
    open_tool_changer: OpenToolChanger
    run_program: RunProgram
    set_angle_units: SetAngleUnits
    set_default_joint_tolerances: SetDefaultJointTolerances
    set_end_effector: SetEndEffector
    set_end_effector_parameters: SetEndEffectorParameters
    set_end_pose_tolerance: SetEndPoseTolerance
    set_force_units: SetForceUnits
    set_intermediate_pose_tolerance: SetIntermediatePoseTolerance
    set_length_units: SetLengthUnits
    set_motion_coordination: SetMotionCoordination
    set_robot_parameters: SetRobotParameters
    set_rot_accel: SetRotAccel
    set_rot_speed: SetRotSpeed
    set_torque_units: SetTorqueUnits
    set_trans_accel: SetTransAccel
    set_trans_speed: SetTransSpeed
    stop_motion: StopMotion
    def __init__(self, name: _Optional[str] = ..., command_id: _Optional[int] = ..., guards: _Optional[_Iterable[_Union[_values_pb2.Guard, _Mapping]]] = ..., init_canon: _Optional[_Union[InitCanon, _Mapping]] = ..., end_canon: _Optional[_Union[EndCanon, _Mapping]] = ..., get_status: _Optional[_Union[GetStatus, _Mapping]] = ..., stop_motion: _Optional[_Union[StopMotion, _Mapping]] = ..., move_to: _Optional[_Union[MoveTo, _Mapping]] = ..., move_through_to: _Optional[_Union[MoveThroughTo, _Mapping]] = ..., move_screw: _Optional[_Union[MoveScrew, _Mapping]] = ..., actuate_joints: _Optional[_Union[ActuateJoints, _Mapping]] = ..., set_end_effector: _Optional[_Union[SetEndEffector, _Mapping]] = ..., open_tool_changer: _Optional[_Union[OpenToolChanger, _Mapping]] = ..., close_tool_changer: _Optional[_Union[CloseToolChanger, _Mapping]] = ..., dwell: _Optional[_Union[Dwell, _Mapping]] = ..., message: _Optional[_Union[Message, _Mapping]] = ..., set_length_units: _Optional[_Union[SetLengthUnits, _Mapping]] = ..., set_angle_units: _Optional[_Union[SetAngleUnits, _Mapping]] = ..., set_force_units: _Optional[_Union[SetForceUnits, _Mapping]] = ..., set_torque_units: _Optional[_Union[SetTorqueUnits, _Mapping]] = ..., set_trans_speed: _Optional[_Union[SetTransSpeed, _Mapping]] = ..., set_trans_accel: _Optional[_Union[SetTransAccel, _Mapping]] = ..., set_rot_speed: _Optional[_Union[SetRotSpeed, _Mapping]] = ..., set_rot_accel: _Optional[_Union[SetRotAccel, _Mapping]] = ..., set_end_pose_tolerance: _Optional[_Union[SetEndPoseTolerance, _Mapping]] = ..., set_intermediate_pose_tolerance: _Optional[_Union[SetIntermediatePoseTolerance, _Mapping]] = ..., set_default_joint_tolerances: _Optional[_Union[SetDefaultJointTolerances, _Mapping]] = ..., configure_joint_reports: _Optional[_Union[ConfigureJointReports, _Mapping]] = ..., configure_status_report: _Optional[_Union[ConfigureStatusReport, _Mapping]] = ..., loop_block_start: _Optional[_Union[LoopBlockStart, _Mapping]] = ..., loop_block_end: _Optional[_Union[LoopBlockEnd, _Mapping]] = ..., set_end_effector_parameters: _Optional[_Union[SetEndEffectorParameters, _Mapping]] = ..., set_robot_parameters: _Optional[_Union[SetRobotParameters, _Mapping]] = ..., enable_gripper: _Optional[_Union[EnableGripper, _Mapping]] = ..., disable_gripper: _Optional[_Union[DisableGripper, _Mapping]] = ..., enable_sensor: _Optional[_Union[EnableSensor, _Mapping]] = ..., disable_sensor: _Optional[_Union[DisableSensor, _Mapping]] = ..., enable_robot_parameter_status: _Optional[_Union[EnableRobotParameterStatus, _Mapping]] = ..., disable_robot_parameter_status: _Optional[_Union[DisableRobotParameterStatus, _Mapping]] = ..., set_motion_coordination: _Optional[_Union[SetMotionCoordination, _Mapping]] = ..., run_program: _Optional[_Union[RunProgram, _Mapping]] = ...) -> None: ...

class CommandInstance(_message.Message):
    __slots__ = ["command", "name", "program_file", "program_index", "program_length"]
    COMMAND_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    PROGRAM_FILE_FIELD_NUMBER: _ClassVar[int]
    PROGRAM_INDEX_FIELD_NUMBER: _ClassVar[int]
    PROGRAM_LENGTH_FIELD_NUMBER: _ClassVar[int]
    command: Command
    name: str
    program_file: str
    program_index: int
    program_length: int
    def __init__(self, name: _Optional[str] = ..., command: _Optional[_Union[Command, _Mapping]] = ..., program_file: _Optional[str] = ..., program_index: _Optional[int] = ..., program_length: _Optional[int] = ...) -> None: ...

class ConfigureJointReports(_message.Message):
    __slots__ = ["joint_reports", "reset_all"]
    JOINT_REPORTS_FIELD_NUMBER: _ClassVar[int]
    RESET_ALL_FIELD_NUMBER: _ClassVar[int]
    joint_reports: _containers.RepeatedCompositeFieldContainer[JointReport]
    reset_all: bool
    def __init__(self, reset_all: bool = ..., joint_reports: _Optional[_Iterable[_Union[JointReport, _Mapping]]] = ...) -> None: ...

class ConfigureStatusReport(_message.Message):
    __slots__ = ["report_gripper_status", "report_guards_status", "report_joint_statuses", "report_pose_status", "report_sensors_status", "report_settings_status"]
    REPORT_GRIPPER_STATUS_FIELD_NUMBER: _ClassVar[int]
    REPORT_GUARDS_STATUS_FIELD_NUMBER: _ClassVar[int]
    REPORT_JOINT_STATUSES_FIELD_NUMBER: _ClassVar[int]
    REPORT_POSE_STATUS_FIELD_NUMBER: _ClassVar[int]
    REPORT_SENSORS_STATUS_FIELD_NUMBER: _ClassVar[int]
    REPORT_SETTINGS_STATUS_FIELD_NUMBER: _ClassVar[int]
    report_gripper_status: bool
    report_guards_status: bool
    report_joint_statuses: bool
    report_pose_status: bool
    report_sensors_status: bool
    report_settings_status: bool
    def __init__(self, report_joint_statuses: bool = ..., report_pose_status: bool = ..., report_gripper_status: bool = ..., report_settings_status: bool = ..., report_sensors_status: bool = ..., report_guards_status: bool = ...) -> None: ...

class DisableGripper(_message.Message):
    __slots__ = ["gripper_name"]
    GRIPPER_NAME_FIELD_NUMBER: _ClassVar[int]
    gripper_name: str
    def __init__(self, gripper_name: _Optional[str] = ...) -> None: ...

class DisableRobotParameterStatus(_message.Message):
    __slots__ = ["robot_parameter_name"]
    ROBOT_PARAMETER_NAME_FIELD_NUMBER: _ClassVar[int]
    robot_parameter_name: str
    def __init__(self, robot_parameter_name: _Optional[str] = ...) -> None: ...

class DisableSensor(_message.Message):
    __slots__ = ["sensor_id"]
    SENSOR_ID_FIELD_NUMBER: _ClassVar[int]
    sensor_id: str
    def __init__(self, sensor_id: _Optional[str] = ...) -> None: ...

class Dwell(_message.Message):
    __slots__ = ["dwell_time_s"]
    DWELL_TIME_S_FIELD_NUMBER: _ClassVar[int]
    dwell_time_s: float
    def __init__(self, dwell_time_s: _Optional[float] = ...) -> None: ...

class EnableGripper(_message.Message):
    __slots__ = ["gripper_name", "gripper_options"]
    GRIPPER_NAME_FIELD_NUMBER: _ClassVar[int]
    GRIPPER_OPTIONS_FIELD_NUMBER: _ClassVar[int]
    gripper_name: str
    gripper_options: _containers.RepeatedCompositeFieldContainer[_values_pb2.ParameterSetting]
    def __init__(self, gripper_name: _Optional[str] = ..., gripper_options: _Optional[_Iterable[_Union[_values_pb2.ParameterSetting, _Mapping]]] = ...) -> None: ...

class EnableRobotParameterStatus(_message.Message):
    __slots__ = ["robot_parameter_name"]
    ROBOT_PARAMETER_NAME_FIELD_NUMBER: _ClassVar[int]
    robot_parameter_name: str
    def __init__(self, robot_parameter_name: _Optional[str] = ...) -> None: ...

class EnableSensor(_message.Message):
    __slots__ = ["sensor_id", "sensor_options"]
    SENSOR_ID_FIELD_NUMBER: _ClassVar[int]
    SENSOR_OPTIONS_FIELD_NUMBER: _ClassVar[int]
    sensor_id: str
    sensor_options: _containers.RepeatedCompositeFieldContainer[_values_pb2.ParameterSetting]
    def __init__(self, sensor_id: _Optional[str] = ..., sensor_options: _Optional[_Iterable[_Union[_values_pb2.ParameterSetting, _Mapping]]] = ...) -> None: ...

class EndCanon(_message.Message):
    __slots__ = []
    def __init__(self) -> None: ...

class GetStatus(_message.Message):
    __slots__ = []
    def __init__(self) -> None: ...

class InitCanon(_message.Message):
    __slots__ = []
    def __init__(self) -> None: ...

class JointDetails(_message.Message):
    __slots__ = ["force_torque", "speed_accel"]
    FORCE_TORQUE_FIELD_NUMBER: _ClassVar[int]
    SPEED_ACCEL_FIELD_NUMBER: _ClassVar[int]
    force_torque: JointForceTorque
    speed_accel: JointSpeedAccel
    def __init__(self, speed_accel: _Optional[_Union[JointSpeedAccel, _Mapping]] = ..., force_torque: _Optional[_Union[JointForceTorque, _Mapping]] = ...) -> None: ...

class JointForceTorque(_message.Message):
    __slots__ = ["change_rate", "name", "setting"]
    CHANGE_RATE_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    SETTING_FIELD_NUMBER: _ClassVar[int]
    change_rate: float
    name: str
    setting: float
    def __init__(self, name: _Optional[str] = ..., setting: _Optional[float] = ..., change_rate: _Optional[float] = ...) -> None: ...

class JointReport(_message.Message):
    __slots__ = ["joint_number", "name", "report_position", "report_torque_or_force", "report_velocity"]
    JOINT_NUMBER_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    REPORT_POSITION_FIELD_NUMBER: _ClassVar[int]
    REPORT_TORQUE_OR_FORCE_FIELD_NUMBER: _ClassVar[int]
    REPORT_VELOCITY_FIELD_NUMBER: _ClassVar[int]
    joint_number: int
    name: str
    report_position: bool
    report_torque_or_force: bool
    report_velocity: bool
    def __init__(self, name: _Optional[str] = ..., joint_number: _Optional[int] = ..., report_position: bool = ..., report_torque_or_force: bool = ..., report_velocity: bool = ...) -> None: ...

class JointSpeedAccel(_message.Message):
    __slots__ = ["joint_accel", "joint_speed", "name"]
    JOINT_ACCEL_FIELD_NUMBER: _ClassVar[int]
    JOINT_SPEED_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    joint_accel: float
    joint_speed: float
    name: str
    def __init__(self, name: _Optional[str] = ..., joint_speed: _Optional[float] = ..., joint_accel: _Optional[float] = ...) -> None: ...

class LoopBlockEnd(_message.Message):
    __slots__ = ["loop_name", "max_count"]
    LOOP_NAME_FIELD_NUMBER: _ClassVar[int]
    MAX_COUNT_FIELD_NUMBER: _ClassVar[int]
    loop_name: str
    max_count: int
    def __init__(self, loop_name: _Optional[str] = ..., max_count: _Optional[int] = ...) -> None: ...

class LoopBlockStart(_message.Message):
    __slots__ = ["loop_name"]
    LOOP_NAME_FIELD_NUMBER: _ClassVar[int]
    loop_name: str
    def __init__(self, loop_name: _Optional[str] = ...) -> None: ...

class Message(_message.Message):
    __slots__ = ["message"]
    MESSAGE_FIELD_NUMBER: _ClassVar[int]
    message: str
    def __init__(self, message: _Optional[str] = ...) -> None: ...

class MoveScrew(_message.Message):
    __slots__ = ["axial_distance_free", "axial_distance_screw", "axis_point", "start_position", "turn"]
    AXIAL_DISTANCE_FREE_FIELD_NUMBER: _ClassVar[int]
    AXIAL_DISTANCE_SCREW_FIELD_NUMBER: _ClassVar[int]
    AXIS_POINT_FIELD_NUMBER: _ClassVar[int]
    START_POSITION_FIELD_NUMBER: _ClassVar[int]
    TURN_FIELD_NUMBER: _ClassVar[int]
    axial_distance_free: float
    axial_distance_screw: float
    axis_point: _values_pb2.Point
    start_position: _values_pb2.Pose
    turn: float
    def __init__(self, start_position: _Optional[_Union[_values_pb2.Pose, _Mapping]] = ..., axis_point: _Optional[_Union[_values_pb2.Point, _Mapping]] = ..., axial_distance_free: _Optional[float] = ..., axial_distance_screw: _Optional[float] = ..., turn: _Optional[float] = ...) -> None: ...

class MoveThroughTo(_message.Message):
    __slots__ = ["move_straight", "num_positions", "waypoints"]
    MOVE_STRAIGHT_FIELD_NUMBER: _ClassVar[int]
    NUM_POSITIONS_FIELD_NUMBER: _ClassVar[int]
    WAYPOINTS_FIELD_NUMBER: _ClassVar[int]
    move_straight: bool
    num_positions: int
    waypoints: _containers.RepeatedCompositeFieldContainer[_values_pb2.Pose]
    def __init__(self, move_straight: bool = ..., waypoints: _Optional[_Iterable[_Union[_values_pb2.Pose, _Mapping]]] = ..., num_positions: _Optional[int] = ...) -> None: ...

class MoveTo(_message.Message):
    __slots__ = ["end_position", "move_straight"]
    END_POSITION_FIELD_NUMBER: _ClassVar[int]
    MOVE_STRAIGHT_FIELD_NUMBER: _ClassVar[int]
    end_position: _values_pb2.Pose
    move_straight: bool
    def __init__(self, move_straight: bool = ..., end_position: _Optional[_Union[_values_pb2.Pose, _Mapping]] = ...) -> None: ...

class OpenToolChanger(_message.Message):
    __slots__ = []
    def __init__(self) -> None: ...

class Program(_message.Message):
    __slots__ = ["end_canon", "init_canon", "middle_commands", "name"]
    END_CANON_FIELD_NUMBER: _ClassVar[int]
    INIT_CANON_FIELD_NUMBER: _ClassVar[int]
    MIDDLE_COMMANDS_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    end_canon: SessionBound
    init_canon: SessionBound
    middle_commands: _containers.RepeatedCompositeFieldContainer[Command]
    name: str
    def __init__(self, name: _Optional[str] = ..., init_canon: _Optional[_Union[SessionBound, _Mapping]] = ..., middle_commands: _Optional[_Iterable[_Union[Command, _Mapping]]] = ..., end_canon: _Optional[_Union[SessionBound, _Mapping]] = ...) -> None: ...

class RunProgram(_message.Message):
    __slots__ = ["program_text"]
    PROGRAM_TEXT_FIELD_NUMBER: _ClassVar[int]
    program_text: str
    def __init__(self, program_text: _Optional[str] = ...) -> None: ...

class SessionBound(_message.Message):
    __slots__ = ["command_id", "guards", "name"]
    COMMAND_ID_FIELD_NUMBER: _ClassVar[int]
    GUARDS_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    command_id: int
    guards: _containers.RepeatedCompositeFieldContainer[_values_pb2.Guard]
    name: str
    def __init__(self, name: _Optional[str] = ..., command_id: _Optional[int] = ..., guards: _Optional[_Iterable[_Union[_values_pb2.Guard, _Mapping]]] = ...) -> None: ...

class SetAngleUnits(_message.Message):
    __slots__ = ["unit_name"]
    UNIT_NAME_FIELD_NUMBER: _ClassVar[int]
    unit_name: _values_pb2.AngleUnit
    def __init__(self, unit_name: _Optional[_Union[_values_pb2.AngleUnit, str]] = ...) -> None: ...

class SetDefaultJointTolerances(_message.Message):
    __slots__ = ["joint_tolerances"]
    JOINT_TOLERANCES_FIELD_NUMBER: _ClassVar[int]
    joint_tolerances: _values_pb2.JointTolerances
    def __init__(self, joint_tolerances: _Optional[_Union[_values_pb2.JointTolerances, _Mapping]] = ...) -> None: ...

class SetEndEffector(_message.Message):
    __slots__ = ["setting"]
    SETTING_FIELD_NUMBER: _ClassVar[int]
    setting: float
    def __init__(self, setting: _Optional[float] = ...) -> None: ...

class SetEndEffectorParameters(_message.Message):
    __slots__ = ["parameter_settings"]
    PARAMETER_SETTINGS_FIELD_NUMBER: _ClassVar[int]
    parameter_settings: _containers.RepeatedCompositeFieldContainer[_values_pb2.ParameterSetting]
    def __init__(self, parameter_settings: _Optional[_Iterable[_Union[_values_pb2.ParameterSetting, _Mapping]]] = ...) -> None: ...

class SetEndPoseTolerance(_message.Message):
    __slots__ = ["tolerance"]
    TOLERANCE_FIELD_NUMBER: _ClassVar[int]
    tolerance: _values_pb2.PoseTolerance
    def __init__(self, tolerance: _Optional[_Union[_values_pb2.PoseTolerance, _Mapping]] = ...) -> None: ...

class SetForceUnits(_message.Message):
    __slots__ = ["unit_name"]
    UNIT_NAME_FIELD_NUMBER: _ClassVar[int]
    unit_name: _values_pb2.ForceUnit
    def __init__(self, unit_name: _Optional[_Union[_values_pb2.ForceUnit, str]] = ...) -> None: ...

class SetIntermediatePoseTolerance(_message.Message):
    __slots__ = ["tolerance"]
    TOLERANCE_FIELD_NUMBER: _ClassVar[int]
    tolerance: _values_pb2.PoseTolerance
    def __init__(self, tolerance: _Optional[_Union[_values_pb2.PoseTolerance, _Mapping]] = ...) -> None: ...

class SetLengthUnits(_message.Message):
    __slots__ = ["unit_name"]
    UNIT_NAME_FIELD_NUMBER: _ClassVar[int]
    unit_name: _values_pb2.LengthUnit
    def __init__(self, unit_name: _Optional[_Union[_values_pb2.LengthUnit, str]] = ...) -> None: ...

class SetMotionCoordination(_message.Message):
    __slots__ = ["coordinated"]
    COORDINATED_FIELD_NUMBER: _ClassVar[int]
    coordinated: bool
    def __init__(self, coordinated: bool = ...) -> None: ...

class SetRobotParameters(_message.Message):
    __slots__ = ["parameter_settings"]
    PARAMETER_SETTINGS_FIELD_NUMBER: _ClassVar[int]
    parameter_settings: _containers.RepeatedCompositeFieldContainer[_values_pb2.ParameterSetting]
    def __init__(self, parameter_settings: _Optional[_Iterable[_Union[_values_pb2.ParameterSetting, _Mapping]]] = ...) -> None: ...

class SetRotAccel(_message.Message):
    __slots__ = ["rot_accel"]
    ROT_ACCEL_FIELD_NUMBER: _ClassVar[int]
    rot_accel: _values_pb2.RotAccel
    def __init__(self, rot_accel: _Optional[_Union[_values_pb2.RotAccel, _Mapping]] = ...) -> None: ...

class SetRotSpeed(_message.Message):
    __slots__ = ["rot_speed"]
    ROT_SPEED_FIELD_NUMBER: _ClassVar[int]
    rot_speed: _values_pb2.RotSpeed
    def __init__(self, rot_speed: _Optional[_Union[_values_pb2.RotSpeed, _Mapping]] = ...) -> None: ...

class SetTorqueUnits(_message.Message):
    __slots__ = ["unit_name"]
    UNIT_NAME_FIELD_NUMBER: _ClassVar[int]
    unit_name: _values_pb2.TorqueUnit
    def __init__(self, unit_name: _Optional[_Union[_values_pb2.TorqueUnit, str]] = ...) -> None: ...

class SetTransAccel(_message.Message):
    __slots__ = ["trans_accel"]
    TRANS_ACCEL_FIELD_NUMBER: _ClassVar[int]
    trans_accel: _values_pb2.TransAccel
    def __init__(self, trans_accel: _Optional[_Union[_values_pb2.TransAccel, _Mapping]] = ...) -> None: ...

class SetTransSpeed(_message.Message):
    __slots__ = ["trans_speed"]
    TRANS_SPEED_FIELD_NUMBER: _ClassVar[int]
    trans_speed: _values_pb2.TransSpeed
    def __init__(self, trans_speed: _Optional[_Union[_values_pb2.TransSpeed, _Mapping]] = ...) -> None: ...

class StopMotion(_message.Message):
    __slots__ = ["stop_condition"]
    STOP_CONDITION_FIELD_NUMBER: _ClassVar[int]
    stop_condition: StopCondition
    def __init__(self, stop_condition: _Optional[_Union[StopCondition, str]] = ...) -> None: ...

class StopCondition(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = []
