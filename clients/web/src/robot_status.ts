// State of a robot, in words for all parts of the page.
import {
  ActionState,
  MotionSource,
  StreamPhase,
  type MotionState,
  type RobotState
} from './protocol';

export const kNotReady = 'The robot is not ready: make it ready first.';

export interface RobotStatus {
  text: string;
  look: '' | 'good' | 'busy' | 'held' | 'bad';
  /** The robot is stopped: by a fault, until it is made ready, or with its drives off. */
  stopped: '' | 'fault' | 'drives off';
}

export function statusOf(robot: RobotState): RobotStatus {
  const state = robot.action?.state ?? ActionState.UNSPECIFIED;
  if (robot.protectiveStop) return {text: 'protective stop', look: 'bad', stopped: 'fault'};
  if (state === ActionState.ERROR) return {text: 'error', look: 'bad', stopped: 'fault'};
  if (robot.motion?.alarm) return {text: 'alarm', look: 'bad', stopped: 'fault'};
  if (!robot.drivesOn) return {text: 'drives off', look: 'held', stopped: 'drives off'};
  if (state === ActionState.WORKING) return {text: 'working', look: 'busy', stopped: ''};
  if (robot.moving) return {text: 'moving', look: 'busy', stopped: ''};
  if (!robot.initialized) return {text: 'not ready', look: '', stopped: ''};
  if (state === ActionState.DONE) return {text: 'done', look: 'good', stopped: ''};
  return {text: 'ready', look: 'good', stopped: ''};
}

const kPhases: Record<number, string> = {
  [StreamPhase.READY]: 'ready for points',
  [StreamPhase.PAUSED]: 'paused',
  [StreamPhase.STOPPING]: 'stopping'
};

/** The commander of a robot and what its stream of motions does, in one line. */
export function commanderOf(motion: MotionState | undefined): string {
  if (motion?.source === MotionSource.COMMANDS) return 'a command';
  if (motion?.source !== MotionSource.STREAM) return 'none';
  const left = motion.pointsLeft;
  const phase = kPhases[motion.phase] ?? `${left} ${left === 1n ? 'point' : 'points'} left`;
  return `${motion.commander}: ${phase}`;
}
