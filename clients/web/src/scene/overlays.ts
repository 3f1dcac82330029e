// Overlays that explain the cell: tool paths, cameras, light barriers.
import * as THREE from 'three';
import type {CellDescription, CellAppearance, Pose, Snapshot} from '../protocol';
import {toMatrix, toVector} from './convert';
import {painted} from './materials';

const kTrailPoints = 400;

/** Recent path of a tool point. */
export class Trail {
  readonly line: THREE.Line;
  private readonly points = new Float32Array(kTrailPoints * 3);
  private count = 0;
  private readonly last = new THREE.Vector3(Infinity, 0, 0);

  constructor(color: number) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute(
      'position',
      new THREE.BufferAttribute(this.points, 3).setUsage(THREE.DynamicDrawUsage)
    );
    geometry.setDrawRange(0, 0);
    this.line = new THREE.Line(
      geometry,
      new THREE.LineBasicMaterial({color, transparent: true, opacity: 0.9})
    );
    this.line.frustumCulled = false;
  }

  add(pose: Pose | undefined): void {
    const p = toVector(pose?.positionM);
    if (p.distanceTo(this.last) < 0.003) return;
    this.last.copy(p);
    if (this.count === kTrailPoints) {
      this.points.copyWithin(0, 3);
      --this.count;
    }
    p.toArray(this.points, 3 * this.count++);
    this.line.geometry.setDrawRange(0, this.count);
    this.line.geometry.attributes.position!.needsUpdate = true;
  }

  clear(): void {
    this.count = 0;
    this.line.geometry.setDrawRange(0, 0);
  }
}

/** Area of each robot's overhead camera, and its last detections. */
export class Cameras {
  readonly root = new THREE.Group();
  private readonly frames: {X_WV: THREE.Matrix4; marks: THREE.InstancedMesh}[] = [];

  constructor(cell: CellDescription, appearance: CellAppearance | null, colors: number[]) {
    cell.robots.forEach((robot, i) => {
      const X_WV = toMatrix(robot.baseInWorld)
        .multiply(toMatrix(robot.referenceInBase))
        .multiply(toMatrix(robot.visionInReference));
      const color = colors[i % colors.length]!;
      const marks = new THREE.InstancedMesh(
        ringWithPointer(),
        new THREE.MeshBasicMaterial({color, depthTest: false, transparent: true, opacity: 0.95}),
        128
      );
      marks.count = 0;
      marks.frustumCulled = false;
      marks.renderOrder = 9;
      this.root.add(marks);
      this.frames.push({X_WV, marks});
      const camera = appearance?.robots[i];
      if (!camera) return;
      const lens = toVector(camera.cameraM),
        min = toVector(camera.areaMinM),
        max = toVector(camera.areaMaxM);
      const corners = [
        [min.x, min.y],
        [max.x, min.y],
        [max.x, max.y],
        [min.x, max.y]
      ].map(([x, y]) => new THREE.Vector3(x, y, 0));
      const points: THREE.Vector3[] = [];
      corners.forEach((corner, c) => points.push(lens, corner, corner, corners[(c + 1) % 4]!));
      const lines = new THREE.LineSegments(
        new THREE.BufferGeometry().setFromPoints(points),
        new THREE.LineBasicMaterial({color, transparent: true, opacity: 0.55})
      );
      const body = painted(new THREE.BoxGeometry(0.08, 0.06, 0.05), 0x20242a, {
        roughness: 0.5,
        metalness: 0
      });
      body.position.copy(lens);
      const frame = new THREE.Group();
      frame.applyMatrix4(X_WV);
      frame.add(lines, body);
      this.root.add(frame);
    });
  }

  update(snapshot: Snapshot): void {
    const local = new THREE.Matrix4();
    this.frames.forEach(({X_WV, marks}, i) => {
      const detections = snapshot.robots[i]?.vision?.detections ?? [];
      marks.count = Math.min(detections.length, 128);
      detections.slice(0, 128).forEach((seen, d) => {
        local.makeRotationZ(seen.rotationRad).setPosition(seen.xM, seen.yM, 0.04);
        marks.setMatrixAt(d, local.premultiply(X_WV));
      });
      marks.instanceMatrix.needsUpdate = true;
    });
  }
}

function ringWithPointer(): THREE.BufferGeometry {
  const outline = new THREE.Shape().absarc(0, 0, 0.02, 0, 2 * Math.PI, false);
  outline.holes.push(new THREE.Path().absarc(0, 0, 0.0165, 0, 2 * Math.PI, true) as THREE.Path);
  const pointer = new THREE.Shape();
  pointer.moveTo(0.02, -0.002).lineTo(0.038, 0).lineTo(0.02, 0.002);
  return new THREE.ShapeGeometry([outline, pointer], 20);
}

/** Light barriers across the belt. */
export class PhotoEyes {
  readonly root = new THREE.Group();
  private readonly beams: THREE.LineBasicMaterial[] = [];

  constructor(cell: CellDescription) {
    const belt = cell.conveyor;
    if (!belt) return;
    toMatrix(belt.beltInWorld).decompose(this.root.position, this.root.quaternion, this.root.scale);
    const y = belt.widthM / 2 + 0.03;
    for (const eye of belt.photoEyes) {
      for (const side of [1, -1]) {
        const post = painted(new THREE.BoxGeometry(0.03, 0.022, 0.075), 0x22272e, {
          roughness: 0.5,
          metalness: 0
        });
        post.position.set(eye.xM, side * y, eye.heightM + 0.005);
        this.root.add(post);
      }
      const material = new THREE.LineBasicMaterial({color: 0x37d67a});
      this.root.add(
        new THREE.Line(
          new THREE.BufferGeometry().setFromPoints([
            new THREE.Vector3(eye.xM, -y, eye.heightM),
            new THREE.Vector3(eye.xM, y, eye.heightM)
          ]),
          material
        )
      );
      this.beams.push(material);
    }
  }

  update(snapshot: Snapshot): void {
    snapshot.conveyor?.photoEyes.forEach((eye, i) =>
      this.beams[i]?.color.set(eye.broken ? 0xff3b30 : 0x37d67a)
    );
  }
}

/** The light curtain: its posts, its beams up to the first obstacle, and the box that breaks them. */
export class LightCurtain {
  readonly root = new THREE.Group();
  readonly posts: THREE.Mesh[] = [];
  private readonly lines: THREE.LineSegments | null = null;
  private readonly ends: Float32Array;
  private readonly colors: Float32Array;
  private readonly intruder = new THREE.Mesh(
    new THREE.BoxGeometry(1, 1, 1),
    new THREE.MeshBasicMaterial({color: 0xff8c42, transparent: true, opacity: 0.5})
  );

  constructor(private readonly cell: CellDescription) {
    const curtain = cell.lightCurtain,
      beams = curtain?.beams ?? 0;
    this.ends = new Float32Array(beams * 6);
    this.colors = new Float32Array(beams * 6);
    this.intruder.visible = false;
    this.root.add(this.intruder);
    if (!curtain) return;
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute(
      'position',
      new THREE.BufferAttribute(this.ends, 3).setUsage(THREE.DynamicDrawUsage)
    );
    geometry.setAttribute(
      'color',
      new THREE.BufferAttribute(this.colors, 3).setUsage(THREE.DynamicDrawUsage)
    );
    this.lines = new THREE.LineSegments(
      geometry,
      new THREE.LineBasicMaterial({vertexColors: true, transparent: true, opacity: 0.35})
    );
    this.lines.frustumCulled = false;
    const frame = new THREE.Group();
    frame.applyMatrix4(toMatrix(curtain.curtainInWorld));
    frame.add(this.lines);
    const height = beams * curtain.pitchM;
    for (const x of [0, curtain.rangeM]) {
      const post = painted(new THREE.BoxGeometry(0.04, 0.05, height), 0xe2b007, {
        roughness: 0.5,
        metalness: 0
      });
      post.position.set(x, 0, height / 2 - curtain.pitchM / 2);
      frame.add(post);
      this.posts.push(post);
    }
    this.root.add(frame);
  }

  update(snapshot: Snapshot): void {
    const curtain = this.cell.lightCurtain,
      now = snapshot.lightCurtain;
    if (curtain && now && this.lines) {
      now.distanceM.slice(0, curtain.beams).forEach((distance, i) => {
        const z = i * curtain.pitchM,
          color = distance < curtain.rangeM ? [1, 0.2, 0.15] : [0.95, 0.25, 0.3];
        this.ends.set([0, 0, z, distance, 0, z], 6 * i);
        this.colors.set([...color, ...color], 6 * i);
      });
      this.lines.geometry.attributes.position!.needsUpdate =
        this.lines.geometry.attributes.color!.needsUpdate = true;
      (this.lines.material as THREE.LineBasicMaterial).opacity = now.broken ? 0.85 : 0.3;
    }
    const {intruder} = snapshot;
    this.intruder.visible = intruder !== undefined;
    if (!intruder) return;
    toMatrix(intruder.intruderInWorld).decompose(
      this.intruder.position,
      this.intruder.quaternion,
      this.intruder.scale
    );
    toVector(intruder.sizeM, this.intruder.scale);
  }
}
