// Camera positions from which everything is in the picture.
import * as THREE from 'three';

export const kUp = new THREE.Vector3(0, 0, 1);
const kMargin = 0.03; // of the picture, on each side

/** Corners of the bounding boxes of all visible meshes under `root`, in the world. */
export function cornersOf(root: THREE.Object3D, out: THREE.Vector3[] = []): THREE.Vector3[] {
  root.updateWorldMatrix(true, true);
  const visit = (object: THREE.Object3D): void => {
    if (object instanceof THREE.Mesh && !(object instanceof THREE.InstancedMesh)) {
      const geometry = object.geometry as THREE.BufferGeometry;
      if (!geometry.boundingBox) geometry.computeBoundingBox();
      const {min, max} = geometry.boundingBox!;
      for (let i = 0; i < 8; ++i)
        out.push(
          new THREE.Vector3(
            i & 1 ? max.x : min.x,
            i & 2 ? max.y : min.y,
            i & 4 ? max.z : min.z
          ).applyMatrix4(object.matrixWorld)
        );
    }
    for (const child of object.children) if (child.visible) visit(child);
  };
  visit(root);
  return out;
}

export interface Picture {
  fov_deg: number;
  aspect: number;
  /** Share of the height that controls at the upper edge cover. */
  covered: number;
}

/**
 * The nearest eye in the direction `towards`, seen from the points, that has all points in the picture;
 * and the point in their middle at which it looks.
 */
export function fitted(
  points: THREE.Vector3[],
  towards: THREE.Vector3,
  {fov_deg, aspect, covered}: Picture
): {eye: THREE.Vector3; target: THREE.Vector3} {
  const z = towards.clone().normalize();
  const x = new THREE.Vector3().crossVectors(kUp, z).normalize();
  const y = new THREE.Vector3().crossVectors(z, x);
  // Half the extent of the picture at distance 1, to its sides, lower and upper edges.
  const half = Math.tan((fov_deg * Math.PI) / 360);
  const side = half * aspect * (1 - 2 * kMargin);
  const lower = half * (1 - 2 * kMargin),
    upper = half * (1 - 2 * (kMargin + covered));
  // The planes through the eye and the edges have all points on their inner side.
  let right = -Infinity,
    left = -Infinity,
    top = -Infinity,
    bottom = -Infinity,
    nearest = -Infinity,
    farthest = Infinity;
  for (const p of points) {
    const [px, py, pz] = [p.dot(x), p.dot(y), p.dot(z)];
    right = Math.max(right, px + side * pz);
    left = Math.max(left, -px + side * pz);
    top = Math.max(top, py + upper * pz);
    bottom = Math.max(bottom, -py + lower * pz);
    nearest = Math.max(nearest, pz);
    farthest = Math.min(farthest, pz);
  }
  const ez = Math.max((right + left) / (2 * side), (top + bottom) / (upper + lower), nearest + 0.1);
  const ex = (right - left) / 2;
  // In the middle of the range that the upper and the lower edge allow.
  const ey = (top - upper * ez + (lower * ez - bottom)) / 2;
  const at = (depth: number): THREE.Vector3 =>
    new THREE.Vector3().addScaledVector(x, ex).addScaledVector(y, ey).addScaledVector(z, depth);
  return {eye: at(ez), target: at(Math.min((nearest + farthest) / 2, ez - 0.1))};
}
