import * as THREE from 'three';
import URDFLoader, {type URDFRobot} from 'urdf-loader';
import type {RobotDescription, RobotLooks, RobotState} from '../protocol';
import type {RobotStatus} from '../robot_status';
import {place, toMatrix, toVector} from './convert';
import {solid, stoppedSurface, surface} from './materials';
import {software} from './quality';
import {fingerGeometry, merged, softBox, softCylinder, tinted} from './shapes';

const kFinish: Record<string, {roughness: number; metalness: number}> = {
  steel: {roughness: 0.32, metalness: 0.75},
  dark: {roughness: 0.6, metalness: 0.15},
  black: {roughness: 0.7, metalness: 0.05}
};
const kPaint = {roughness: 0.38, metalness: 0.02};

/** One arm with its gripper, from its URDF and its description. */
export class RobotModel {
  readonly root = new THREE.Group();
  private arm: URDFRobot | null = null;
  private readonly tool = new THREE.Group();
  /** The tool frame at the point whose pose the robot tells; null where that is the tool frame. */
  private readonly toolAtPoint: THREE.Matrix4 | null;
  private readonly fingers: THREE.Mesh[] = [];
  private readonly jointNames: string[];
  private stopped: RobotStatus['stopped'] = '';
  private readonly markedSurfaces = new Map<string, THREE.Material>();

  constructor(
    private readonly description: RobotDescription,
    looks: RobotLooks | undefined,
    readonly index: number
  ) {
    this.jointNames = description.joints.map((joint) => joint.name);
    const {toolPointInFlange, toolInFlange} = description;
    this.toolAtPoint =
      toolPointInFlange && toolInFlange
        ? toMatrix(toolPointInFlange).invert().multiply(toMatrix(toolInFlange))
        : null;
    if (looks) this.buildGripper(looks);
    this.root.add(this.tool);
    this.root.userData.pick = {kind: 'robot', index};
  }

  async load(): Promise<void> {
    const answer = await fetch(`models/${encodeURIComponent(this.description.name)}.urdf`);
    if (!answer.ok) throw new Error(`no model of ${this.description.name}`);
    const loader = new URDFLoader();
    loader.parseCollision = false;
    this.arm = loader.parse(await answer.text()) as URDFRobot;
    soften(this.arm);
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
    if (this.toolAtPoint) {
      const {position, quaternion, scale} = this.tool;
      toMatrix(state.toolInWorld).multiply(this.toolAtPoint).decompose(position, quaternion, scale);
    } else {
      place(this.tool, state.toolInWorld);
    }
    const g = this.description.gripper;
    if (!g || !state.gripper) return;
    this.fingers.forEach((finger, i) => {
      const side = i === 0 ? 1 : -1;
      finger.position.y = side * (0.5 * g.gapOpenM - (state.gripper!.travelM[i] ?? 0));
    });
  }

  private marked(plain: THREE.Material, stopped: 'fault' | 'drives off'): THREE.Material {
    const key = `${plain.uuid} ${stopped}`;
    const material = this.markedSurfaces.get(key) ?? stoppedSurface(plain, stopped);
    this.markedSurfaces.set(key, material);
    return material;
  }

  private buildGripper(g: RobotLooks): void {
    const material = surface({vertexColors: true, roughness: 0.42, metalness: 0.35});
    const add = (geometry: THREE.BufferGeometry): THREE.Mesh => {
      const mesh = solid(geometry, material);
      this.tool.add(mesh);
      return mesh;
    };
    const palm = toVector(g.palmSizeM);
    const reach = toVector(this.description.toolInFlange?.positionM).length();
    const top = -g.padHeightM - palm.z;
    const mount = Math.max(0.004, reach + top);
    const along = (geometry: THREE.BufferGeometry) => geometry.rotateX(Math.PI / 2);
    const r = 0.46 * Math.min(palm.x, palm.y);
    add(
      merged([
        tinted(
          softBox(palm.x, palm.y, 0.62 * palm.z, 0.004).translate(
            0,
            0,
            -g.padHeightM - 0.31 * palm.z
          ),
          0xaeb6bf
        ),
        tinted(
          softBox(0.86 * palm.x, 0.86 * palm.y, 0.38 * palm.z, 0.004).translate(
            0,
            0,
            top + 0.19 * palm.z
          ),
          0x4a515b
        ),
        tinted(along(softCylinder(r, 0.3 * mount)).translate(0, 0, top - 0.15 * mount), 0x2b3037),
        tinted(
          along(softCylinder(0.8 * r, 0.7 * mount)).translate(0, 0, top - 0.65 * mount),
          0xc3c9cf
        ),
        // The two air fittings.
        ...[-1, 1].map((side) =>
          tinted(
            softCylinder(0.005, 0.016, 0.001, 16)
              .rotateZ(Math.PI / 2)
              .translate(0.5 * palm.x + 0.008, side * 0.28 * palm.y, top + 0.3 * palm.z),
            0x2f6fb3
          )
        )
      ])
    );
    for (const side of [1, -1]) {
      const finger = add(fingerGeometry(g.padWidthM, g.padDepthM, g.padHeightM, g.vHalfAngleRad));
      if (side < 0) finger.rotation.z = Math.PI;
      this.fingers.push(finger);
    }
  }
}

/** Makes one softened mesh of each link's primitives, or one of each finish where meshes are cheap. */
function soften(arm: URDFRobot): void {
  arm.updateMatrixWorld(true);
  for (const link of Object.values(arm.links)) {
    const toLink = link.matrixWorld.clone().invert();
    const pieces = new Map<string, THREE.BufferGeometry[]>();
    for (const visual of link.children.filter((child) => 'isURDFVisual' in child)) {
      visual.traverse((object) => {
        if (!(object instanceof THREE.Mesh)) return;
        const paint = object.material as THREE.MeshPhongMaterial;
        const finish = software ? '' : paint.name in kFinish ? paint.name : '';
        const list = pieces.get(finish) ?? [];
        pieces.set(finish, list);
        const shape = softened(object);
        list.push(
          tinted(shape.applyMatrix4(toLink.clone().multiply(object.matrixWorld)), paint.color)
        );
      });
      visual.removeFromParent();
    }
    for (const [finish, list] of pieces)
      link.add(solid(merged(list), surface({vertexColors: true, ...(kFinish[finish] ?? kPaint)})));
  }
}

/** The shape of a primitive with softened edges; takes its size out of its matrix. */
function softened(mesh: THREE.Mesh): THREE.BufferGeometry {
  const {type} = mesh.geometry,
    s = mesh.scale.clone();
  const shape =
    type === 'BoxGeometry'
      ? softBox(s.x, s.y, s.z)
      : type === 'CylinderGeometry'
        ? softCylinder(s.x, s.y)
        : null;
  if (!shape) return mesh.geometry.clone();
  mesh.scale.set(1, 1, 1);
  mesh.updateMatrixWorld();
  return shape;
}
