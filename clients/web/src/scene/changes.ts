// Comparison of two states of the cell as they look. Bodies at rest keep their exact poses, so that no
// new picture is needed.
import type {Pose, RobotState, Snapshot} from '../protocol';
import {statusOf} from '../robot_status';
import type {Layers} from './cell_view';

export function looksDifferent(a: Snapshot, b: Snapshot, layers: Layers): boolean {
  if (
    a.epoch !== b.epoch ||
    a.bodies.length !== b.bodies.length ||
    a.robots.length !== b.robots.length
  )
    return true;
  if (a.conveyor?.travelM !== b.conveyor?.travelM || Boolean(a.intruder) !== Boolean(b.intruder))
    return true;
  if (b.intruder && !samePose(a.intruder?.intruderInWorld, b.intruder.intruderInWorld)) return true;
  if (a.robots.some((robot, i) => robotDiffers(robot, b.robots[i]!, layers))) return true;
  if (a.bodies.some((body, i) => !samePose(body.bodyInWorld, b.bodies[i]!.bodyInWorld)))
    return true;
  if (
    a.tools.length !== b.tools.length ||
    a.tools.some(
      (tool, i) =>
        tool.robot !== b.tools[i]!.robot || !samePose(tool.toolInWorld, b.tools[i]!.toolInWorld)
    )
  )
    return true;
  if (
    layers.groups &&
    a.bodies.some(
      (body, i) => body.group !== b.bodies[i]!.group || body.groupKind !== b.bodies[i]!.groupKind
    )
  )
    return true;
  if (layers.contacts && (a.contacts.length > 0 || b.contacts.length > 0)) return true;
  return layers.curtain && barriersDiffer(a, b);
}

function robotDiffers(a: RobotState, b: RobotState, layers: Layers): boolean {
  return (
    a.joints.some((joint, i) => joint.positionRad !== b.joints[i]?.positionRad) ||
    a.gripper?.travelM[0] !== b.gripper?.travelM[0] ||
    a.gripper?.travelM[1] !== b.gripper?.travelM[1] ||
    !samePose(a.toolInWorld, b.toolInWorld) ||
    statusOf(a).stopped !== statusOf(b).stopped ||
    (layers.targets && !samePose(a.goalInReference, b.goalInReference)) ||
    (layers.cameras && a.vision?.number !== b.vision?.number)
  );
}

function barriersDiffer(a: Snapshot, b: Snapshot): boolean {
  return (
    Boolean(
      b.conveyor?.photoEyes.some((eye, i) => eye.broken !== a.conveyor?.photoEyes[i]?.broken)
    ) ||
    Boolean(
      b.lightCurtain?.distanceM.some((distance, i) => distance !== a.lightCurtain?.distanceM[i])
    )
  );
}

function samePose(a: Pose | undefined, b: Pose | undefined): boolean {
  if (!a || !b) return a === b;
  const p = a.positionM,
    o = b.positionM,
    q = a.orientation,
    r = b.orientation;
  return (
    p?.x === o?.x &&
    p?.y === o?.y &&
    p?.z === o?.z &&
    q?.w === r?.w &&
    q?.x === r?.x &&
    q?.y === r?.y &&
    q?.z === r?.z
  );
}
