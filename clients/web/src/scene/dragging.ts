// Objects of the view that follow the pointer on a horizontal plane.
import * as THREE from 'three';
import type {OrbitControls} from 'three/examples/jsm/controls/OrbitControls.js';
import type {Pick} from './cell_view';

/** Decides which objects can be dragged, and to where. Distances in the world [m]. */
export interface Grabber {
  /** All that moves along with a picked object; null = it stays where it is. */
  grab(pick: Pick): Pick[] | null;
  /** The nearest permitted displacement. `free`: without snapping. */
  drag(x_m: number, y_m: number, free: boolean): [number, number];
  drop(x_m: number, y_m: number): void;
}

interface Held {
  pointer: number;
  objects: {object: THREE.Object3D; home: THREE.Vector3}[];
  plane: THREE.Plane;
  from: THREE.Vector3;
  moved: [number, number];
}

export class Dragging {
  grabber: Grabber | null = null;
  private held: Held | null = null;

  constructor(
    private readonly view: {
      canvas: HTMLCanvasElement;
      controls: OrbitControls;
      rayAt(event: PointerEvent): THREE.Raycaster;
      hit(ray: THREE.Raycaster): {pick: Pick; point: THREE.Vector3} | null;
      find(pick: Pick): THREE.Object3D | null;
      redraw(): void;
    }
  ) {
    const {canvas} = view;
    // Before the controls of the camera, which then leave the pointer alone.
    canvas.addEventListener('pointerdown', (event) => this.press(event), {capture: true});
    canvas.addEventListener('pointermove', (event) => this.move(event), {capture: true});
    canvas.addEventListener('pointerup', (event) => this.release(event, true), {capture: true});
    canvas.addEventListener('pointercancel', (event) => this.release(event, false));
  }

  private press(event: PointerEvent): void {
    if (!this.grabber || this.held || event.button !== 0) return;
    const hit = this.view.hit(this.view.rayAt(event));
    const picks = hit && this.grabber.grab(hit.pick);
    if (!hit || !picks) return;
    const objects = picks.flatMap((pick) => {
      const object = this.view.find(pick);
      return object ? [{object, home: object.position.clone()}] : [];
    });
    this.held = {
      pointer: event.pointerId,
      objects,
      plane: new THREE.Plane(new THREE.Vector3(0, 0, 1), -hit.point.z),
      from: hit.point,
      moved: [0, 0]
    };
    this.view.controls.enabled = false;
    this.view.canvas.setPointerCapture(event.pointerId);
  }

  private move(event: PointerEvent): void {
    const {held, grabber} = this;
    if (!held || !grabber || event.pointerId !== held.pointer) return;
    const at = this.view.rayAt(event).ray.intersectPlane(held.plane, new THREE.Vector3());
    if (!at) return;
    held.moved = grabber.drag(at.x - held.from.x, at.y - held.from.y, event.altKey);
    const [x, y] = held.moved;
    for (const {object, home} of held.objects) object.position.set(home.x + x, home.y + y, home.z);
    this.view.redraw();
  }

  private release(event: PointerEvent, drops: boolean): void {
    const {held} = this;
    if (!held || event.pointerId !== held.pointer) return;
    this.held = null;
    this.view.controls.enabled = true;
    const [x, y] = held.moved;
    if (drops && (x !== 0 || y !== 0)) return this.grabber?.drop(x, y);
    for (const {object, home} of held.objects) object.position.copy(home);
    this.view.redraw();
  }
}
