// Detections of the vision lines, drawn over a camera's picture.
import * as THREE from 'three';
import type {CameraDescription, CellDescription, Snapshot} from '../protocol';
import {toMatrix} from '../scene/convert';

const kSvg = 'http://www.w3.org/2000/svg';
const kColors = ['#ffcb4d', '#9cc8ff', '#7ff0ab', '#ffaaa5']; // light ones, over pictures
const kPointer_m = 0.035;
const kName_px = 10.5; // height of a name on screen
const kCharacter = 0.62; // mean width of a character, in heights

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
  name: string;
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
        name: seen.body,
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

interface Box {
  left: number;
  right: number;
  top: number;
  bottom: number;
}

/** The first place beside a mark where its name is inside the picture and over no other name; null where
 * none is free. */
function placeOfName(
  mark: Mark,
  radius: number,
  font: number,
  size: Box,
  taken: Box[]
): Box | null {
  const [u, v] = mark.at;
  const width = kCharacter * font * mark.name.length;
  const gap = 1.3 * radius;
  for (const up of [0.5, 1.2, -0.2, 2, -1]) {
    for (const left of [u + gap, u - gap - width]) {
      const bottom = v + (0.5 - up + 0.5) * font;
      const box = {left, right: left + width, top: bottom - font, bottom};
      const isInside =
        box.left >= size.left &&
        box.right <= size.right &&
        box.top >= size.top &&
        box.bottom <= size.bottom;
      const isFree = taken.every(
        (other) =>
          box.left >= other.right ||
          box.right <= other.left ||
          box.top >= other.bottom ||
          box.bottom <= other.top
      );
      if (isInside && isFree) return box;
    }
  }
  return null;
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

  /** Names have the same size on screen for any size of the picture. A mark without room for its name
   * shows it on hover. */
  show(marks: Mark[]): void {
    const {widthPx, heightPx} = this.camera;
    const radius = widthPx / 90;
    const shown_px = this.element.getBoundingClientRect().width;
    if (shown_px === 0) return this.element.replaceChildren(); // the panel was closed meanwhile
    const font = (kName_px * widthPx) / shown_px;
    const size = {left: 0, right: widthPx, top: 0, bottom: heightPx};
    const taken: Box[] = [];
    this.element.replaceChildren(
      ...marks.map((mark) => {
        const {at, to, text, color} = mark;
        const group = element('g', {stroke: color, fill: 'none', 'stroke-width': radius / 5});
        const title = element('title', {});
        title.textContent = text;
        group.append(
          title,
          element('circle', {cx: at[0], cy: at[1], r: radius, 'pointer-events': 'all'}),
          element('line', {x1: at[0], y1: at[1], x2: to[0], y2: to[1]})
        );
        const place = placeOfName(mark, radius, font, size, taken);
        if (!place) return group;
        taken.push(place);
        const name = element('text', {
          x: place.left,
          y: place.bottom - 0.2 * font,
          fill: color,
          stroke: '#000b',
          'stroke-width': 0.2 * font,
          'paint-order': 'stroke',
          'font-size': font
        });
        name.textContent = mark.name;
        group.append(name);
        return group;
      })
    );
  }
}
