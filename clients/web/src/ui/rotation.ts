// Rotations as people enter them: roll, pitch and yaw about the fixed axes x, y and z.
import {Euler, Quaternion} from 'three';

export function toRollPitchYaw(
  q: {w: number; x: number; y: number; z: number} | undefined
): [number, number, number] {
  if (!q) return [0, 0, 0];
  const e = new Euler().setFromQuaternion(new Quaternion(q.x, q.y, q.z, q.w), 'ZYX');
  return [e.x, e.y, e.z];
}

export function fromRollPitchYaw(
  roll: number,
  pitch: number,
  yaw: number
): {w: number; x: number; y: number; z: number} {
  const q = new Quaternion().setFromEuler(new Euler(roll, pitch, yaw, 'ZYX'));
  return {w: q.w, x: q.x, y: q.y, z: q.z};
}
