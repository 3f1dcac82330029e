import * as THREE from 'three';
import type {Pose, Vector3} from '../protocol';

export function toVector(v: Vector3 | undefined, out = new THREE.Vector3()): THREE.Vector3 {
  return v ? out.set(v.x, v.y, v.z) : out.set(0, 0, 0);
}

export function toQuaternion(
  pose: Pose | undefined,
  out = new THREE.Quaternion()
): THREE.Quaternion {
  const q = pose?.orientation;
  return q ? out.set(q.x, q.y, q.z, q.w) : out.identity();
}

const one = new THREE.Vector3(1, 1, 1);

export function toMatrix(pose: Pose | undefined): THREE.Matrix4 {
  return new THREE.Matrix4().compose(toVector(pose?.positionM), toQuaternion(pose), one);
}

/** Sets position and rotation of an object from a pose in the world. */
export function place(object: THREE.Object3D, pose: Pose | undefined): void {
  toVector(pose?.positionM, object.position);
  toQuaternion(pose, object.quaternion);
}
