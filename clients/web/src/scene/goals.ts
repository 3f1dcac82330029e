// Targets of the running motions.
import * as THREE from 'three';
import type {CellDescription, Snapshot} from '../protocol';
import {toMatrix, toVector} from './convert';

/**
 * For each robot: the tool frame at the end of the running motion, and the straight line to it, or
 * the path of the tool where the motion was planned round what stands there.
 */
export class Goals {
  readonly root = new THREE.Group();
  private readonly marks: {
    X_WR: THREE.Matrix4;
    frame: THREE.Group;
    way: THREE.Line;
    path: THREE.Line;
  }[];

  constructor(cell: CellDescription, colors: number[]) {
    this.marks = cell.robots.map((robot, i) => {
      const color = colors[i % colors.length]!;
      const frame = new THREE.Group();
      const ring = new THREE.Mesh(new THREE.RingGeometry(0.026, 0.031, 40), overlay(color));
      ring.renderOrder = 9;
      frame.add(
        ring,
        axis(new THREE.Vector3(1, 0, 0), 0xff5a4d),
        axis(new THREE.Vector3(0, 1, 0), 0x59d97b),
        axis(new THREE.Vector3(0, 0, 1), 0x5aa9ff)
      );
      const way = new THREE.Line(
        new THREE.BufferGeometry().setFromPoints([new THREE.Vector3(), new THREE.Vector3()]),
        new THREE.LineDashedMaterial({
          color,
          dashSize: 0.016,
          gapSize: 0.012,
          transparent: true,
          opacity: 0.85
        })
      );
      const path = new THREE.Line(
        new THREE.BufferGeometry(),
        new THREE.LineBasicMaterial({color, transparent: true, opacity: 0.95, depthTest: false})
      );
      way.frustumCulled = path.frustumCulled = false;
      path.renderOrder = 9;
      this.root.add(frame, way, path);
      return {
        X_WR: toMatrix(robot.baseInWorld).multiply(toMatrix(robot.referenceInBase)),
        frame,
        way,
        path
      };
    });
  }

  update(snapshot: Snapshot): void {
    this.marks.forEach(({X_WR, frame, way, path}, i) => {
      const robot = snapshot.robots[i],
        goal = robot?.goalInReference;
      const planned = robot?.plannedPathM ?? [];
      frame.visible = goal !== undefined;
      path.visible = goal !== undefined && planned.length > 0;
      way.visible = goal !== undefined && planned.length === 0;
      if (!goal) return;
      if (path.visible) {
        path.geometry.setFromPoints(planned.map((p) => toVector(p).applyMatrix4(X_WR)));
      }
      X_WR.clone()
        .multiply(toMatrix(goal))
        .decompose(frame.position, frame.quaternion, frame.scale);
      const ends = way.geometry.attributes.position as THREE.BufferAttribute;
      const tool = toVector(robot?.toolInWorld?.positionM);
      ends.setXYZ(0, tool.x, tool.y, tool.z);
      ends.setXYZ(1, frame.position.x, frame.position.y, frame.position.z);
      ends.needsUpdate = true;
      way.computeLineDistances();
    });
  }
}

function overlay(color: number): THREE.MeshBasicMaterial {
  return new THREE.MeshBasicMaterial({
    color,
    side: THREE.DoubleSide,
    transparent: true,
    opacity: 0.95,
    depthTest: false
  });
}

function axis(direction: THREE.Vector3, color: number): THREE.Mesh {
  const rod = new THREE.Mesh(
    new THREE.CylinderGeometry(0.0016, 0.0016, 0.07, 6).translate(0, 0.035, 0),
    overlay(color)
  );
  rod.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), direction);
  rod.renderOrder = 9;
  return rod;
}
