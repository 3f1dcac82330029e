// Geometry of the cell, from the sizes in its description.
import * as THREE from 'three';
import {RoundedBoxGeometry} from 'three/examples/jsm/geometries/RoundedBoxGeometry.js';
import {mergeGeometries} from 'three/examples/jsm/utils/BufferGeometryUtils.js';
import {segments, software} from './quality';

/** A box with softened edges. */
export function softBox(x: number, y: number, z: number, radius = 0.006): THREE.BufferGeometry {
  const r = Math.min(radius, 0.24 * Math.min(x, y, z));
  return r > 2e-4
    ? new RoundedBoxGeometry(x, y, z, software ? 1 : 2, r)
    : new THREE.BoxGeometry(x, y, z);
}

/** A cylinder about y, as three.js has it, with chamfered rims. */
export function softCylinder(
  radius: number,
  length: number,
  chamfer = 0.004,
  sides = 40
): THREE.BufferGeometry {
  const c = Math.min(chamfer, 0.3 * radius, 0.3 * length),
    h = length / 2;
  const profile = [
    [0, -h],
    [radius - c, -h],
    [radius - c, -h],
    [radius, -h + c],
    [radius, -h + c],
    [radius, h - c],
    [radius, h - c],
    [radius - c, h],
    [radius - c, h],
    [0, h]
  ];
  return new THREE.LatheGeometry(
    profile.map(([r, y]) => new THREE.Vector2(r, y)),
    segments(sides)
  );
}

/** A surface of revolution about z through points (radius, z) with sharp edges between them. */
export function turned(points: [number, number][], sides = 40): THREE.BufferGeometry {
  const sharp: THREE.Vector2[] = [];
  points.forEach(([r, z], i) => {
    sharp.push(new THREE.Vector2(r, z));
    if (i > 0 && i < points.length - 1) sharp.push(new THREE.Vector2(r, z));
  });
  return new THREE.LatheGeometry(sharp, segments(sides)).rotateX(Math.PI / 2);
}

/** Sets one colour for all vertices, so that pieces of several colours can become one mesh. */
export function tinted(
  geometry: THREE.BufferGeometry,
  color: THREE.ColorRepresentation
): THREE.BufferGeometry {
  const plain = geometry.index ? geometry.toNonIndexed() : geometry;
  const c = new THREE.Color(color);
  const colors = new Float32Array(plain.attributes.position!.count * 3);
  for (let i = 0; i < colors.length; i += 3) c.toArray(colors, i);
  plain.setAttribute('color', new THREE.BufferAttribute(colors, 3));
  plain.deleteAttribute('uv');
  return plain;
}

export function merged(parts: THREE.BufferGeometry[]): THREE.BufferGeometry {
  const geometry = mergeGeometries(parts);
  for (const part of parts) part.dispose();
  return geometry;
}

export interface GearSizes {
  discRadiusM: number;
  discHeightM: number;
  pegRadiusM: number;
  pegTopM: number;
  hubTopRadiusM: number;
  hubBottomRadiusM: number;
  hubHeightM: number;
  teethRadiusM: number;
}

const kToothPitch_m = 0.009; // along the rim
const kToothDepth_m = 0.005;
const kLabel = 0xf4f5f2;

function toothedOutline(tip: number): THREE.Shape {
  const teeth = Math.max(12, Math.round((2 * Math.PI * tip) / kToothPitch_m));
  const root = tip - kToothDepth_m;
  const shape = new THREE.Shape();
  const at = (r: number, turn: number): [number, number] => {
    const angle = (turn / teeth) * 2 * Math.PI;
    return [r * Math.cos(angle), r * Math.sin(angle)];
  };
  shape.moveTo(...at(root, -0.28));
  for (let i = 0; i < teeth; ++i) {
    shape.lineTo(...at(root, i - 0.28)).lineTo(...at(tip, i - 0.14));
    shape.lineTo(...at(tip, i + 0.14)).lineTo(...at(root, i + 0.28));
  }
  shape.closePath();
  return shape;
}

/** Gear in its frame: origin at the centre of the disc's underside, z along the peg. */
export function gearGeometry(g: GearSizes, color: THREE.Color): THREE.BufferGeometry {
  const tip = g.teethRadiusM || g.discRadiusM;
  const bevel = software ? 0 : 0.0006;
  const teeth = new THREE.ExtrudeGeometry(toothedOutline(tip - bevel), {
    depth: g.discHeightM - 2 * bevel,
    bevelEnabled: !software,
    bevelThickness: bevel,
    bevelSize: bevel,
    bevelSegments: 1
  }).translate(0, 0, bevel);
  const top = g.discHeightM,
    r = g.pegRadiusM,
    c = Math.min(0.001, r / 3);
  const rim = 0.72 * tip;
  const face = tip - kToothDepth_m - 0.0012;
  const parts = [
    // Teeth darker than the disc, so that they can be told apart from afar.
    tinted(teeth, color.clone().multiplyScalar(0.55)),
    tinted(
      turned([
        [face, top],
        [face - 0.0008, top + 0.0005],
        [0, top + 0.0005]
      ]),
      color
    ),
    // For looks: a raised ring on the disc and the boss at the foot of the peg.
    tinted(
      turned([
        [rim, top + 0.0005],
        [rim - 0.0006, top + 0.0012],
        [rim - 0.0022, top + 0.0012],
        [rim - 0.0028, top + 0.0005]
      ]),
      color.clone().multiplyScalar(0.82)
    ),
    tinted(
      turned([
        [2.2 * r, top],
        [1.7 * r, top + 0.0012],
        [r, top + 0.0012]
      ]),
      color.clone().multiplyScalar(0.82)
    ),
    tinted(
      turned(
        [
          [r, top],
          [r, g.pegTopM - c],
          [r - c, g.pegTopM],
          [0, g.pegTopM]
        ],
        24
      ),
      color.clone().lerp(new THREE.Color(0xffffff), 0.35)
    )
  ];
  if (g.hubHeightM > 0) {
    parts.push(
      tinted(
        turned([
          [0, -g.hubHeightM],
          [g.hubBottomRadiusM, -g.hubHeightM],
          [g.hubTopRadiusM, 0]
        ]),
        color.clone().multiplyScalar(0.7)
      )
    );
  }
  return merged(parts);
}

export interface Pocket {
  x: number;
  y: number;
  /** Radius at the top face, or of a circle around the outline. */
  top: number;
  floor: number;
  depth: number;
  /** Corners seen from above, counter-clockwise, in the tray's frame; empty if it is round. */
  outline: THREE.Vector2[];
}

/** A tray's slab in its frame. */
export interface Slab {
  min: THREE.Vector3;
  /** With the top face at its z. */
  max: THREE.Vector3;
  /** Corners seen from above, counter-clockwise; empty if the slab is the box. */
  outline: THREE.Vector2[];
  /** Square recess about the origin of the top face; size 0 if there is none. */
  labelSize: number;
  labelDepth: number;
}

/** Tray in its frame, with its pockets and the recess of its label, on which a white label lies. */
export function trayGeometry(
  slab: Slab,
  pockets: Pocket[],
  color: THREE.Color
): THREE.BufferGeometry {
  const {min, max, labelSize, labelDepth} = slab;
  const depth = pockets.reduce((most, p) => Math.max(most, p.depth), 0.4 * (max.z - min.z));
  const sheet = outlineOf(slab);
  if (labelSize > 0) sheet.holes.push(squareHole(labelSize / 2));
  for (const p of pockets) {
    const hole = new THREE.Path();
    if (p.outline.length > 0) hole.setFromPoints([...p.outline].reverse());
    else hole.absarc(p.x, p.y, p.top, 0, 2 * Math.PI, true);
    sheet.holes.push(hole);
  }
  const upper = new THREE.ExtrudeGeometry(sheet, {
    depth,
    bevelEnabled: false,
    curveSegments: segments(28)
  }).translate(0, 0, max.z - depth);
  const lower = new THREE.ExtrudeGeometry(outlineOf(slab), {
    depth: max.z - depth - min.z,
    bevelEnabled: false,
    curveSegments: 6
  }).translate(0, 0, min.z);
  const inside = color.clone().multiplyScalar(0.72);
  const parts = [tinted(upper, color), tinted(lower, color.clone().multiplyScalar(0.85))];
  if (labelSize > 0) {
    const label = new THREE.BoxGeometry(labelSize, labelSize, depth - labelDepth);
    label.translate(0, 0, max.z - (depth + labelDepth) / 2);
    parts.push(tinted(label, kLabel));
  }
  for (const p of pockets) {
    parts.push(tinted(p.outline.length > 0 ? recess(p, max.z) : roundRecess(p, max.z), inside));
  }
  return merged(parts);
}

/** From the floor outwards and up, so that the faces point into the pocket. */
function roundRecess(p: Pocket, top: number): THREE.BufferGeometry {
  return turned(
    [
      [p.top, top - 1e-5],
      [p.floor, top - p.depth],
      [0, top - p.depth]
    ],
    36
  ).translate(p.x, p.y, 0);
}

/** Walls along the outline and a floor, with the faces towards the inside. */
function recess(p: Pocket, top: number): THREE.BufferGeometry {
  const floor = top - p.depth,
    high = top - 1e-5;
  const points: number[] = [];
  const middle = p.outline.reduce((sum, corner) => sum.add(corner), new THREE.Vector2());
  middle.divideScalar(p.outline.length);
  p.outline.forEach((a, i) => {
    const b = p.outline[(i + 1) % p.outline.length] ?? a;
    points.push(a.x, a.y, high, b.x, b.y, high, a.x, a.y, floor);
    points.push(b.x, b.y, high, b.x, b.y, floor, a.x, a.y, floor);
    points.push(middle.x, middle.y, floor, a.x, a.y, floor, b.x, b.y, floor);
  });
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.Float32BufferAttribute(points, 3));
  geometry.computeVertexNormals();
  return geometry;
}

function outlineOf({min, max, outline}: Slab): THREE.Shape {
  return outline.length > 0 ? new THREE.Shape(outline) : roundedRectangle(min, max, 0.006);
}

function squareHole(half: number): THREE.Path {
  const hole = new THREE.Path();
  hole.moveTo(-half, -half).lineTo(-half, half).lineTo(half, half).lineTo(half, -half).closePath();
  return hole;
}

function roundedRectangle(min: THREE.Vector3, max: THREE.Vector3, r: number): THREE.Shape {
  const shape = new THREE.Shape();
  shape.moveTo(min.x + r, min.y);
  shape.lineTo(max.x - r, min.y).absarc(max.x - r, min.y + r, r, -Math.PI / 2, 0, false);
  shape.lineTo(max.x, max.y - r).absarc(max.x - r, max.y - r, r, 0, Math.PI / 2, false);
  shape.lineTo(min.x + r, max.y).absarc(min.x + r, max.y - r, r, Math.PI / 2, Math.PI, false);
  shape.lineTo(min.x, min.y + r).absarc(min.x + r, min.y + r, r, Math.PI, 1.5 * Math.PI, false);
  return shape;
}

/** Finger with its pad at y = 0 facing -y; from z = 0 up to -height. */
export function fingerGeometry(
  width: number,
  depth: number,
  height: number,
  vHalfAngle: number
): THREE.BufferGeometry {
  const w = width / 2;
  const notch = vHalfAngle > 0 ? Math.min(0.7 * depth, w / Math.tan(vHalfAngle)) : 0;
  const shape = new THREE.Shape();
  shape.moveTo(-w, 0);
  if (notch > 0) shape.lineTo(0, notch);
  shape.lineTo(w, 0).lineTo(w, depth).lineTo(-w, depth).closePath();
  const finger = new THREE.ExtrudeGeometry(shape, {depth: height, bevelEnabled: false}).translate(
    0,
    0,
    -height
  );
  const carriage = softBox(1.5 * width, 1.6 * depth, 0.016, 0.002).translate(
    0,
    0.8 * depth,
    -height + 0.008
  );
  return merged([tinted(finger, 0x3b4048), tinted(carriage, 0xb9c0c8)]);
}
