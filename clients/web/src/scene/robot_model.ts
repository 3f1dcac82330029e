import * as THREE from 'three';
import URDFLoader, {type URDFRobot} from 'urdf-loader';
import type {RobotDescription, RobotState} from '../protocol';
import type {RobotStatus} from '../robot_status';
import {boltsOf, hosesOf, platesOf} from './arm_details';
import {toMatrix} from './convert';
import {solid, stoppedSurface, surface} from './materials';
import {modelOf} from './model_source';
import {software} from './quality';
import {merged, softBox, softCylinder, tinted} from './shapes';
import type {ToolModel} from './tool_model';

const kFinish: Record<string, {roughness: number; metalness: number}> = {
  steel: {roughness: 0.32, metalness: 0.75},
  dark: {roughness: 0.6, metalness: 0.15},
  black: {roughness: 0.7, metalness: 0.05}
};
const kPaint = {roughness: 0.38, metalness: 0.02};
const kCastingRadius_m = 0.018; // of the edges of cast housings

/** One arm with its tool, from its URDF and its description. */
export class RobotModel {
  readonly root = new THREE.Group();
  private arm: URDFRobot | null = null;
  private readonly jointNames: string[];
  private stopped: RobotStatus['stopped'] = '';
  private readonly markedSurfaces = new Map<string, THREE.Material>();

  constructor(
    private readonly description: RobotDescription,
    readonly index: number
  ) {
    this.jointNames = description.joints.map((joint) => joint.name);
    this.root.userData.pick = {kind: 'robot', index};
  }

  async load(): Promise<void> {
    const model = await modelOf(this.description.name);
    const loader = new URDFLoader();
    loader.parseCollision = false;
    this.arm = loader.parse(model) as URDFRobot;
    dress(this.arm, this.description.model);
    toMatrix(this.description.baseInWorld).decompose(
      this.arm.position,
      this.arm.quaternion,
      this.arm.scale
    );
    this.root.add(this.arm);
    this.paint();
  }

  /** Shows that the robot has been stopped. */
  mark(stopped: RobotStatus['stopped']): void {
    if (stopped === this.stopped) return;
    this.stopped = stopped;
    this.paint();
  }

  private paint(): void {
    this.root.traverse((object) => {
      if (!(object instanceof THREE.Mesh)) return;
      const plain = (object.userData.plain ??= object.material) as THREE.Material;
      object.material = this.stopped ? this.marked(plain, this.stopped) : plain;
    });
  }

  update(state: RobotState): void {
    if (this.arm) {
      state.joints.forEach((joint, i) =>
        this.arm!.setJointValue(this.jointNames[i]!, joint.positionRad)
      );
    }
  }

  /** Shapes of the arm and its tool, each with its poses in the world at some postures. `state`: the
   * robot as it is drawn now. */
  sweep(
    postures: number[][],
    state: RobotState
  ): {geometry: THREE.BufferGeometry; poses: THREE.Matrix4[]}[] {
    const {arm} = this;
    const flange = arm?.joints[this.jointNames[this.jointNames.length - 1] ?? ''];
    if (!arm || !flange) return [];
    this.root.updateMatrixWorld(true);
    const X_WF = flange.matrixWorld.clone();
    const shapes: {mesh: THREE.Mesh; X_FM: THREE.Matrix4 | null; poses: THREE.Matrix4[]}[] = [];
    this.root.traverse((object) => {
      if (!(object instanceof THREE.Mesh)) return;
      let inArm = false;
      object.traverseAncestors((above) => (inArm ||= above === arm));
      const X_FM = inArm ? null : X_WF.clone().invert().multiply(object.matrixWorld);
      shapes.push({mesh: object, X_FM, poses: []});
    });
    for (const posture of postures) {
      posture.forEach((position, i) => arm.setJointValue(this.jointNames[i]!, position));
      this.root.updateMatrixWorld(true);
      for (const {mesh, X_FM, poses} of shapes)
        poses.push(X_FM ? flange.matrixWorld.clone().multiply(X_FM) : mesh.matrixWorld.clone());
    }
    this.update(state);
    this.root.updateMatrixWorld(true);
    return shapes.map(({mesh, poses}) => ({
      geometry: mesh.geometry as THREE.BufferGeometry,
      poses
    }));
  }

  /** Attaches a tool to the arm. */
  carry(tool: ToolModel): void {
    this.root.add(tool.root);
    this.paint();
  }

  /** Removes the robot's marks from a tool that it has released. */
  static plain(tool: ToolModel): void {
    tool.root.traverse((object) => {
      if (object instanceof THREE.Mesh && object.userData.plain)
        object.material = object.userData.plain as THREE.Material;
    });
  }

  private marked(plain: THREE.Material, stopped: 'fault' | 'drives off'): THREE.Material {
    const key = `${plain.uuid} ${stopped}`;
    const material = this.markedSurfaces.get(key) ?? stoppedSurface(plain, stopped);
    this.markedSurfaces.set(key, material);
    return material;
  }
}

/** Merges the primitives of each link, softened and with details, into one mesh a finish. */
function dress(arm: URDFRobot, model: string): void {
  arm.updateMatrixWorld(true);
  for (const [name, link] of Object.entries(arm.links)) {
    const toLink = link.matrixWorld.clone().invert();
    const pieces = new Map<string, THREE.BufferGeometry[]>();
    for (const visual of link.children.filter((child) => 'isURDFVisual' in child)) {
      visual.traverse((object) => {
        if (!(object instanceof THREE.Mesh)) return;
        const paint = object.material as THREE.MeshPhongMaterial;
        const finish = software ? '' : paint.name in kFinish ? paint.name : '';
        const list = pieces.get(finish) ?? [];
        pieces.set(finish, list);
        const {x: radius, y: length} = object.scale.clone();
        const shape = softened(object);
        const bolts =
          object.geometry.type === 'CylinderGeometry' ? boltsOf(visual.name, radius, length) : [];
        for (const part of [tinted(shape, paint.color), ...bolts])
          list.push(part.applyMatrix4(toLink.clone().multiply(object.matrixWorld)));
      });
      visual.removeFromParent();
    }
    const hoses = hosesOf(model, name);
    if (hoses.length > 0) {
      const finish = software ? '' : 'black';
      pieces.set(finish, [...(pieces.get(finish) ?? []), ...hoses]);
    }
    for (const plate of platesOf(model, name)) link.add(plate);
    for (const [finish, list] of pieces)
      link.add(solid(merged(list), surface({vertexColors: true, ...(kFinish[finish] ?? kPaint)})));
  }
}

/** Shape of a primitive with softened edges; moves its size from the matrix into the shape. */
function softened(mesh: THREE.Mesh): THREE.BufferGeometry {
  const {type} = mesh.geometry,
    s = mesh.scale.clone();
  const shape =
    type === 'BoxGeometry'
      ? softBox(s.x, s.y, s.z, kCastingRadius_m)
      : type === 'CylinderGeometry'
        ? softCylinder(s.x, s.y, 0.006)
        : null;
  if (!shape) return mesh.geometry.clone();
  mesh.scale.set(1, 1, 1);
  mesh.updateMatrixWorld();
  return shape;
}
