// A planned move before it runs: the path of the tool, the swept volume, and where it would touch.
import * as THREE from 'three';
import type {MovePlan, RobotDescription, RobotState} from '../protocol';
import {toMatrix, toVector} from './convert';
import type {RobotModel} from './robot_model';

const kGhosts = 14;
const kBlocked = 0xff4d42;
const kMark_m = 0.022;

export class MoveGhosts {
  readonly root = new THREE.Group();
  private owned: {dispose(): void}[] = [];

  /** `state`: the robot as it is drawn now. */
  show(
    robot: RobotDescription,
    model: RobotModel,
    state: RobotState,
    plan: MovePlan,
    color: number
  ): void {
    this.clear();
    if (plan.points.length === 0) return;
    const tint = plan.possible && !plan.touch ? color : kBlocked;
    const X_WR = toMatrix(robot.baseInWorld).multiply(toMatrix(robot.referenceInBase));
    this.addPath(
      plan.points.map((point) => toVector(point.toolM).applyMatrix4(X_WR)),
      tint
    );
    this.addSweep(model, state, plan, tint);
    if (plan.touch) this.addMark(toVector(plan.touch.positionM).applyMatrix4(X_WR));
  }

  clear(): void {
    for (const each of this.owned) each.dispose();
    this.owned = [];
    this.root.clear();
  }

  private addPath(points: THREE.Vector3[], color: number): void {
    const line = new THREE.Line(
      new THREE.BufferGeometry().setFromPoints(points),
      new THREE.LineBasicMaterial({color, transparent: true, opacity: 0.95, depthTest: false})
    );
    line.frustumCulled = false;
    line.renderOrder = 9;
    this.owned.push(line.geometry, line.material);
    this.root.add(line);
  }

  private addSweep(model: RobotModel, state: RobotState, plan: MovePlan, color: number): void {
    const material = new THREE.MeshBasicMaterial({
      color,
      transparent: true,
      opacity: 0.09,
      depthWrite: false
    });
    this.owned.push(material);
    for (const {geometry, poses} of model.sweep(postures(plan), state)) {
      const ghosts = new THREE.InstancedMesh(geometry, material, poses.length);
      poses.forEach((pose, i) => ghosts.setMatrixAt(i, pose));
      ghosts.frustumCulled = false;
      this.owned.push(ghosts); // its matrices; the shape is the arm's
      this.root.add(ghosts);
    }
  }

  private addMark(place: THREE.Vector3): void {
    const mark = new THREE.Mesh(
      new THREE.SphereGeometry(kMark_m, 20, 12),
      new THREE.MeshBasicMaterial({
        color: kBlocked,
        transparent: true,
        opacity: 0.85,
        depthTest: false
      })
    );
    mark.position.copy(place);
    mark.renderOrder = 10;
    this.owned.push(mark.geometry, mark.material);
    this.root.add(mark);
  }
}

/** Postures apart by equal spans of time, up to the touch of a move that is refused. */
function postures(plan: MovePlan): number[][] {
  const {points, touch, possible} = plan;
  const seconds = (span: {seconds: bigint; nanos: number} | undefined): number =>
    span ? Number(span.seconds) + span.nanos * 1e-9 : 0;
  const spacing = seconds(plan.spacing);
  const end =
    !possible && touch && spacing > 0 ? Math.ceil(seconds(touch.time) / spacing) : Infinity;
  const last = Math.min(end, points.length - 1);
  const count = Math.min(kGhosts, last + 1);
  return Array.from(
    {length: count},
    (_, i) => points[Math.round((i * last) / Math.max(1, count - 1))]!.jointsRad
  );
}
