import * as THREE from 'three';
import type {RobotState, ToolDescription, ToolState} from '../protocol';
import {place, toVector} from './convert';
import {solid, surface} from './materials';
import {fingerGeometry, merged, softBox, softCylinder, tinted} from './shapes';

/** A gripper or vacuum cup, on a robot's flange or elsewhere. */
export class ToolModel {
  readonly root = new THREE.Group();
  private readonly fingers: THREE.Mesh[] = [];
  private readonly material = surface({vertexColors: true, roughness: 0.42, metalness: 0.35});

  constructor(private readonly tool: ToolDescription) {
    this.buildBody();
    if (tool.cup) this.buildCup();
    else this.buildFingers();
  }

  /** `robot`: the robot that carries it. */
  update(state: ToolState, robot: RobotState | undefined): void {
    place(this.root, state.toolInWorld);
    const open = this.tool.gripper?.gapOpenM ?? 0;
    this.fingers.forEach((finger, i) => {
      const travel = robot?.gripper?.travelM[i] ?? 0.5 * (open - state.separationM);
      finger.position.y = (i === 0 ? 1 : -1) * (0.5 * open - travel);
    });
  }

  private add(geometry: THREE.BufferGeometry): THREE.Mesh {
    const mesh = solid(geometry, this.material);
    this.root.add(mesh);
    return mesh;
  }

  /** Palm and mount between palm and coupling. */
  private buildBody(): void {
    const palm = toVector(this.tool.palm?.sizeM);
    const middle = toVector(this.tool.palm?.centreM).z;
    const low = middle + 0.5 * palm.z,
      top = middle - 0.5 * palm.z;
    const mount = Math.max(0.004, (this.tool.toolInCoupling?.positionM?.z ?? 0) + top);
    const along = (geometry: THREE.BufferGeometry) => geometry.rotateX(Math.PI / 2);
    const r = 0.46 * Math.min(palm.x, palm.y);
    this.add(
      merged([
        tinted(
          softBox(palm.x, palm.y, 0.62 * palm.z, 0.004).translate(0, 0, low - 0.31 * palm.z),
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
  }

  private buildFingers(): void {
    const size = toVector(this.tool.fingerSizeM);
    for (const side of [1, -1]) {
      const finger = this.add(fingerGeometry(size.x, size.y, size.z, this.tool.vHalfAngleRad));
      if (side < 0) finger.rotation.z = Math.PI;
      this.fingers.push(finger);
    }
  }

  /** A stem and a rubber lip. */
  private buildCup(): void {
    const size = toVector(this.tool.cup?.sizeM);
    const lip = Math.min(0.5 * size.z, 0.5 * size.x);
    const along = (geometry: THREE.BufferGeometry) => geometry.rotateX(Math.PI / 2);
    this.add(
      merged([
        tinted(
          along(softCylinder(0.3 * size.x, size.z - lip)).translate(0, 0, -0.5 * (size.z + lip)),
          0xc3c9cf
        ),
        tinted(along(softCylinder(0.5 * size.x, lip)).translate(0, 0, -0.5 * lip), 0x22262b)
      ])
    );
  }
}
