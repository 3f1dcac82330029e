// Messages between page and daemon, under short names.
export type {
  CellDescription,
  BodyDescription,
  CameraDescription,
  RobotDescription,
  ToolDescription,
  TrayGeometry,
  Piece,
  FixtureDescription,
  ConveyorDescription,
  ModbusServer
} from '../generated/aprsim/v1/cell_pb';
export {BodyKind, RegisterArea, RegisterEncoding, WordOrder} from '../generated/aprsim/v1/cell_pb';
export type {
  Snapshot,
  RobotState,
  BodyState,
  ToolState,
  Contact,
  ContactSide,
  ConveyorState,
  Intruder
} from '../generated/aprsim/v1/snapshot_pb';
export {
  ActionKind,
  ActionState,
  DriveFault,
  GroupKind,
  PlanningMode
} from '../generated/aprsim/v1/snapshot_pb';
export type {
  ListFaultKindsResponse,
  PreviewMoveResponse as MovePlan
} from '../generated/aprsim/v1/control_service_pb';
export {ConveyorDirection} from '../generated/aprsim/v1/control_service_pb';
export type {
  FaultKind,
  FaultParameter,
  FaultQuantity,
  InjectedFault
} from '../generated/aprsim/v1/faults_pb';
export {InjectFaultRequestSchema, InjectedFaultState} from '../generated/aprsim/v1/faults_pb';
export type {MotionState} from '../generated/aprsim/v1/trajectory_pb';
export {MotionSource, StreamPhase} from '../generated/aprsim/v1/trajectory_pb';
export type {Bookmark, HistorySpan, Moment} from '../generated/aprsim/v1/history_service_pb';
export {BookmarkKind} from '../generated/aprsim/v1/history_service_pb';
export type {Pose, Vector3, Quaternion} from '../generated/aprsim/v1/geometry_pb';
export type {
  CellAppearance,
  Fault,
  FaultList,
  ListenerStatus,
  MovePreview,
  MoveTool,
  OrderProgress,
  PastSnapshot,
  ProgramStatus,
  RobotAppearance,
  Outcome,
  Permission,
  RegisterInfo,
  ScenarioCheck,
  ScenarioSource,
  SceneDraft,
  SceneSource,
  ServerStatus,
  ViewerUpdate,
  Welcome,
  WireEvent,
  WireEvents
} from '../generated/aprsim/v1/web_pb';
export {
  FaultSeverity,
  MoveToolSchema,
  ViewerRequestSchema,
  ViewerUpdateSchema
} from '../generated/aprsim/v1/web_pb';
