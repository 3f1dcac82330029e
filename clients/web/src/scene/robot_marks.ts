// Marks on stopped robots: a colour, and a sign with the reason.
import * as THREE from 'three';
import type {CellDescription, Snapshot} from '../protocol';
import {statusOf} from '../robot_status';
import {cornersOf} from './framing';
import type {RobotModel} from './robot_model';

const kEdge_px = 6;

export class RobotMarks {
  private readonly signs: {element: HTMLElement; top: THREE.Vector3}[];

  constructor(
    container: HTMLElement,
    private readonly cell: CellDescription,
    private readonly models: RobotModel[]
  ) {
    this.signs = models.map((_, i) => {
      const element = document.createElement('div');
      element.className = 'robot-mark';
      element.dataset.testid = `mark-${cell.robots[i]!.name}`;
      element.hidden = true;
      container.append(element);
      return {element, top: new THREE.Vector3()};
    });
  }

  remove(): void {
    for (const {element} of this.signs) element.remove();
  }

  update(snapshot: Snapshot): void {
    this.signs.forEach(({element, top}, i) => {
      const robot = snapshot.robots[i],
        model = this.models[i]!;
      if (!robot) return;
      const status = statusOf(robot);
      model.mark(status.stopped);
      element.hidden = status.stopped === '';
      if (!status.stopped) return;
      element.dataset.stopped = status.stopped;
      element.textContent = `${this.cell.robots[i]!.name}: ${status.text}`;
      // Over the middle of the arm.
      const bounds = new THREE.Box3().setFromPoints(cornersOf(model.root));
      bounds.getCenter(top).setZ(bounds.max.z);
    });
  }

  /** Moves the signs over the robots in the picture, or to its nearest edge. */
  place(camera: THREE.Camera, width_px: number, height_px: number): void {
    for (const {element, top} of this.signs) {
      if (element.hidden) continue;
      const seen = top.clone().applyMatrix4(camera.matrixWorldInverse);
      const p = top.clone().project(camera);
      // Points behind the camera are projected to the wrong side.
      if (seen.z > 0) p.multiplyScalar(-10);
      const w = element.offsetWidth,
        h = element.offsetHeight;
      const clamp = (v: number, most: number): number =>
        Math.round(Math.max(kEdge_px, Math.min(v, most - kEdge_px)));
      const x = clamp(((p.x + 1) / 2) * width_px - w / 2, width_px - w);
      const y = clamp(((1 - p.y) / 2) * height_px - h - 8, height_px - h);
      element.style.transform = `translate(${x}px, ${y}px)`;
    }
  }
}
