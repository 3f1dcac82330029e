// Names of robots, tools and trays over them in the view.
import * as THREE from 'three';
import {BodyKind, type CellDescription} from '../protocol';
import {cornersOf} from './framing';

const kGap_px = 4;
const kMaxLifts = 8; // of a label over others

export interface Named {
  robots: THREE.Object3D[];
  tools: THREE.Object3D[];
  bodies: THREE.Object3D[];
}

interface Label {
  element: HTMLElement;
  object: THREE.Object3D;
  isRobot: boolean;
}

export class NameLabels {
  private readonly labels: Label[] = [];
  private shown = false;

  constructor(
    private readonly container: HTMLElement,
    cell: CellDescription,
    {robots, tools, bodies}: Named
  ) {
    cell.robots.forEach(({name}, i) => this.add(name, robots[i], true));
    cell.tools.forEach(({name}, i) => this.add(name, tools[i], false));
    cell.bodies.forEach(({name, kind}, i) => {
      if (kind !== BodyKind.GEAR && kind !== BodyKind.PART) this.add(name, bodies[i], false);
    });
  }

  private add(name: string, object: THREE.Object3D | undefined, isRobot: boolean): void {
    if (!object) return;
    const element = document.createElement('div');
    element.className = 'label';
    element.dataset.testid = `name-${name}`;
    element.textContent = name;
    element.hidden = true;
    this.container.append(element);
    this.labels.push({element, object, isRobot});
  }

  remove(): void {
    for (const {element} of this.labels) element.remove();
  }

  show(shown: boolean): void {
    this.shown = shown;
    for (const {element} of this.labels) element.hidden = !shown;
  }

  /** Moves each label over its object, above other labels; hides those outside the picture. */
  place(camera: THREE.Camera, width_px: number, height_px: number): void {
    if (!this.shown) return;
    const taken: {x: number; y: number; w: number; h: number}[] = [];
    for (const {element, object, isRobot} of this.labels) {
      const at = anchorOf(object, isRobot);
      const behind = at.clone().applyMatrix4(camera.matrixWorldInverse).z > 0;
      const p = at.project(camera);
      element.hidden = false;
      const w = element.offsetWidth,
        h = element.offsetHeight;
      const x = Math.round(((p.x + 1) / 2) * width_px - w / 2);
      let y = Math.round(((1 - p.y) / 2) * height_px - h - kGap_px);
      const covers = (o: {x: number; y: number; w: number; h: number}): boolean =>
        x < o.x + o.w && o.x < x + w && y < o.y + o.h && o.y < y + h;
      for (let lift = 0; lift < kMaxLifts && taken.some(covers); ++lift) y -= h + 1;
      const outside = x + w < 0 || x > width_px || y + h < 0 || y > height_px;
      element.hidden = behind || outside || taken.some(covers);
      if (element.hidden) continue;
      taken.push({x, y, w, h});
      element.style.transform = `translate(${x}px, ${y}px)`;
    }
  }
}

/** The top of an arm, the middle of a tool or tray. */
function anchorOf(object: THREE.Object3D, isTop: boolean): THREE.Vector3 {
  const bounds = new THREE.Box3().setFromPoints(cornersOf(object));
  const middle = bounds.getCenter(new THREE.Vector3());
  return isTop ? middle.setZ(bounds.max.z) : middle;
}
