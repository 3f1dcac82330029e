// Outlines of objects of the view as seen from above, and the gaps between them.
import * as THREE from 'three';

type Point = readonly [number, number];

/** Convex outline in the world's x-y plane, anticlockwise, and the heights between which it is taken. */
export interface Footprint {
  outline: Point[];
  low_m: number;
  high_m: number;
}

const kTouch_m = 1e-4; // things that touch are not at the same height

/** One for each mesh. */
export function footprintsOf(object: THREE.Object3D): Footprint[] {
  const found: Footprint[] = [];
  object.updateWorldMatrix(true, true);
  object.traverseVisible((part) => {
    if (part instanceof THREE.Mesh) found.push(footprintOf(part));
  });
  return found;
}

function footprintOf(mesh: THREE.Mesh): Footprint {
  const corners = (mesh.geometry as THREE.BufferGeometry).getAttribute('position');
  const points: Point[] = [];
  let low_m = Infinity,
    high_m = -Infinity;
  const at = new THREE.Vector3();
  for (let i = 0; i < corners.count; ++i) {
    at.fromBufferAttribute(corners, i).applyMatrix4(mesh.matrixWorld);
    points.push([at.x, at.y]);
    low_m = Math.min(low_m, at.z);
    high_m = Math.max(high_m, at.z);
  }
  return {outline: convexHull(points), low_m, high_m};
}

const turn = (o: Point, a: Point, b: Point): number =>
  (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);

/** Andrew's monotone chain (1979). */
export function convexHull(points: Point[]): Point[] {
  const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const chain = (along: Point[]): Point[] => {
    const out: Point[] = [];
    for (const point of along) {
      while (out.length > 1 && turn(out[out.length - 2]!, out[out.length - 1]!, point) <= 0)
        out.pop();
      out.push(point);
    }
    return out.slice(0, -1);
  };
  return sorted.length < 3 ? sorted : [...chain(sorted), ...chain(sorted.reverse())];
}

function fromSegment([x, y]: Point, [ax, ay]: Point, [bx, by]: Point): number {
  const [dx, dy] = [bx - ax, by - ay];
  const length = dx * dx + dy * dy;
  const share = length > 0 ? ((x - ax) * dx + (y - ay) * dy) / length : 0;
  const t = Math.min(1, Math.max(0, share));
  return Math.hypot(x - ax - t * dx, y - ay - t * dy);
}

/** Whether all of `points` are beyond one edge of an outline. */
function isSeparate(outline: Point[], points: Point[]): boolean {
  return outline.some((from, i) => {
    const to = outline[(i + 1) % outline.length]!;
    return points.every((point) => turn(from, to, point) < 0);
  });
}

/** Distance of two outlines; 0 where they overlap. */
export function outlineGap_m(a: Point[], b: Point[]): number {
  if (!isSeparate(a, b) && !isSeparate(b, a)) return 0;
  let least = Infinity;
  for (const [outline, points] of [
    [a, b],
    [b, a]
  ] as const) {
    outline.forEach((from, i) => {
      const to = outline[(i + 1) % outline.length]!;
      for (const point of points) least = Math.min(least, fromSegment(point, from, to));
    });
  }
  return least;
}

/** Horizontal gap of things at the same height; infinite where one is above the other. */
export function gap_m(a: Footprint, b: Footprint): number {
  if (a.low_m > b.high_m - kTouch_m || b.low_m > a.high_m - kTouch_m) return Infinity;
  return outlineGap_m(a.outline, b.outline);
}

export function moved({outline, low_m, high_m}: Footprint, x_m: number, y_m: number): Footprint {
  return {outline: outline.map(([x, y]) => [x + x_m, y + y_m]), low_m, high_m};
}
