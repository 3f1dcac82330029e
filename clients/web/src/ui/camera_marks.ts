// Detections of the vision lines, drawn over a camera's picture.
import * as THREE from 'three';
import type {CameraDescription, CellDescription, Snapshot} from '../protocol';
import {toMatrix} from '../scene/convert';

const kSvg = 'http://www.w3.org/2000/svg';
const kColors = ['#f5b82e', '#3f8efc', '#37d67a', '#d64550'];
const kPointer_m = 0.035;

/** Pixel of a point in the camera frame; null behind the camera. */
export function pixelOf(camera: CameraDescription, p: THREE.Vector3): [number, number] | null {
  if (p.z < 1e-3) return null;
  const [k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0] = camera.distortion;
  const x = p.x / p.z,
    y = p.y / p.z,
    r2 = x * x + y * y,
    radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  // Brown's distortion does not hold far outside of the picture.
  if (radial <= 0) return null;
  const u = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
    v = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y;
  return [camera.focalXPx * u + camera.centreXPx, camera.focalYPx * v + camera.centreYPx];
}

/** Pose of the header X-Pose: "x y z qx qy qz qw". */
export function poseOf(header: string | null): THREE.Matrix4 | null {
  const numbers = (header ?? '').split(' ').map(Number);
  if (numbers.length !== 7 || numbers.some((number) => !Number.isFinite(number))) return null;
  const [x, y, z, qx, qy, qz, qw] = numbers as [
    number,
    number,
    number,
    number,
    number,
    number,
    number
  ];
  return new THREE.Matrix4().compose(
    new THREE.Vector3(x, y, z),
    new THREE.Quaternion(qx, qy, qz, qw),
    new THREE.Vector3(1, 1, 1)
  );
}

interface Mark {
  at: [number, number];
  to: [number, number];
  text: string;
  color: string;
}

/** The detections of all robots' vision lines within a camera's picture. A line has no height: that of the
 * body is taken. */
export function marksOf(
  camera: CameraDescription,
  X_WC: THREE.Matrix4,
  cell: CellDescription,
  snapshot: Snapshot
): Mark[] {
  const X_CW = X_WC.clone().invert();
  const heights = new Map(
    cell.bodies.map(({name}, i) => [name, snapshot.bodies[i]?.bodyInWorld?.positionM?.z])
  );
  const marks: Mark[] = [];
  cell.robots.forEach((robot, i) => {
    const X_WV = toMatrix(robot.baseInWorld)
      .multiply(toMatrix(robot.referenceInBase))
      .multiply(toMatrix(robot.visionInReference));
    for (const seen of snapshot.robots[i]?.vision?.detections ?? []) {
      const pixels = [0, kPointer_m].map((ahead) => {
        const p = new THREE.Vector3(
          seen.xM + ahead * Math.cos(seen.rotationRad),
          seen.yM + ahead * Math.sin(seen.rotationRad),
          0
        ).applyMatrix4(X_WV);
        p.z = heights.get(seen.body) ?? p.z;
        return pixelOf(camera, p.applyMatrix4(X_CW));
      });
      const [at, to] = pixels;
      if (!at || !to || at[0] < 0 || at[1] < 0) continue;
      if (at[0] >= camera.widthPx || at[1] >= camera.heightPx) continue;
      const degrees = Math.round((seen.rotationRad * 180) / Math.PI);
      marks.push({
        at,
        to,
        text: `${robot.name}: ${seen.body} ${seen.xM.toFixed(3)} ${seen.yM.toFixed(3)} m, ${degrees}°`,
        color: kColors[i % kColors.length]!
      });
    }
  });
  return marks;
}

function element(name: string, attributes: Record<string, string | number>): SVGElement {
  const out = document.createElementNS(kSvg, name);
  for (const [key, value] of Object.entries(attributes)) out.setAttribute(key, String(value));
  return out;
}

/** The drawing that lies over a picture. */
export class CameraMarks {
  readonly element: SVGElement;

  constructor(private readonly camera: CameraDescription) {
    this.element = element('svg', {
      viewBox: `0 0 ${camera.widthPx} ${camera.heightPx}`,
      'data-testid': `marks-${camera.name}`
    });
  }

  show(marks: Mark[]): void {
    const radius = this.camera.widthPx / 90;
    this.element.replaceChildren(
      ...marks.map(({at, to, text, color}) => {
        const group = element('g', {stroke: color, fill: 'none', 'stroke-width': radius / 5});
        const name = element('title', {});
        name.textContent = text;
        const label = element('text', {
          x: at[0] + 1.3 * radius,
          y: at[1] - 0.6 * radius,
          fill: color,
          stroke: 'none',
          'font-size': 1.6 * radius
        });
        label.textContent = text.slice(
          text.indexOf(' ') + 1,
          text.indexOf(' ', text.indexOf(' ') + 1)
        );
        group.append(
          name,
          element('circle', {cx: at[0], cy: at[1], r: radius, 'pointer-events': 'all'}),
          element('line', {x1: at[0], y1: at[1], x2: to[0], y2: to[1]}),
          label
        );
        return group;
      })
    );
  }
}
