import * as THREE from 'three';
import {OrbitControls} from 'three/examples/jsm/controls/OrbitControls.js';
import {RoomEnvironment} from 'three/examples/jsm/environments/RoomEnvironment.js';
import type {CellDescription, Snapshot} from '../protocol';
import type {State} from '../state';
import {looksDifferent} from './changes';
import {Contacts} from './contacts';
import {toVector} from './convert';
import {Goals} from './goals';
import {makeRenderer, type SurfaceMaterial} from './materials';
import {Cameras, LightCurtain, PhotoEyes, Trail} from './overlays';
import {Parts} from './parts';
import {adaptive, software} from './quality';
import {RobotModel} from './robot_model';
import {Belt, makeFixed, makeFloor} from './surroundings';

export const kRobotColors = [0xf5b82e, 0x3f8efc, 0x37d67a, 0xd64550];

export interface Layers {
  groups: boolean;
  contacts: boolean;
  trails: boolean;
  targets: boolean;
  cameras: boolean;
  curtain: boolean;
}
export type Pick =
  | {kind: 'body'; index: number}
  | {kind: 'robot'; index: number}
  | {kind: 'fixed'; name: string}
  | {kind: 'belt'};

const kBackground = {dark: 0x171c24, light: 0xe6eaef};
const kSlowFrame_ms = 45;
const kStill_ms = 700;

/** The cell in three dimensions. Draws when something has changed, and less finely on slow machines. */
export class View {
  readonly layers: Layers = {
    groups: false,
    contacts: false,
    trails: true,
    targets: true,
    cameras: false,
    curtain: true
  };
  onPick: (pick: Pick | null) => void = () => {};
  onProblem: (message: string) => void = () => {};

  private readonly renderer: THREE.WebGLRenderer;
  private readonly scene = new THREE.Scene();
  private readonly camera = new THREE.PerspectiveCamera(36, 1, 0.05, 60);
  private readonly controls: OrbitControls;
  private readonly sun = new THREE.DirectionalLight(0xfff4e2, 2.4);
  private readonly sky = new THREE.HemisphereLight(0xdfe9ff, 0x59534a, 1.1);
  private readonly floor = makeFloor();
  private content = new THREE.Group();
  private robots: RobotModel[] = [];
  private parts: Parts | null = null;
  private belt: Belt | null = null;
  private cameras: Cameras | null = null;
  private eyes: PhotoEyes | null = null;
  private curtain: LightCurtain | null = null;
  private trails: Trail[] = [];
  private goals: Goals | null = null;
  private readonly contacts = new Contacts();
  private readonly highlight = new THREE.BoxHelper(new THREE.Object3D(), 0xffffff);
  private selected: THREE.Object3D | null = null;
  private home = {eye: new THREE.Vector3(2, -3, 2), center: new THREE.Vector3()};
  private framed = '';
  private dirty = true;
  private frameTime_ms = 16;
  private pixelRatio = 1;
  private shadowDue = 0;
  private last = 0;
  private begun = 0;
  private refined = false;
  private settled = 4000;
  private drawn = false;
  private size = '';
  private taken: Snapshot | null = null;
  private loading = 0;

  constructor(
    private readonly container: HTMLElement,
    private readonly state: State
  ) {
    this.renderer = makeRenderer();
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = software ? THREE.BasicShadowMap : THREE.PCFSoftShadowMap;
    this.renderer.shadowMap.autoUpdate = false;
    this.renderer.toneMapping = THREE.NeutralToneMapping;
    this.renderer.toneMappingExposure = 1.0;
    this.renderer.domElement.setAttribute('role', 'img');
    this.renderer.domElement.setAttribute('aria-label', 'Three-dimensional view of the cell');
    container.append(this.renderer.domElement);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.enableDamping = false;
    this.controls.maxPolarAngle = 0.495 * Math.PI;
    this.controls.minDistance = 0.2;
    this.controls.maxDistance = 12;
    this.controls.addEventListener('change', () => (this.dirty = true));
    this.makeLights();
    this.highlight.visible = this.contacts.root.visible = false;
    this.scene.add(
      this.sky,
      this.sun,
      this.sun.target,
      this.floor,
      this.content,
      this.highlight,
      this.contacts.root
    );
    new ResizeObserver(() => this.resize()).observe(container);
    this.pixelRatio = software ? 0.8 : Math.min(devicePixelRatio, 2);
    this.setTheme(true);
    this.listenForPicks();
    state.cellChanged.on((cell) => this.build(cell));
    state.snapshotChanged.on((snapshot) => {
      const {taken} = this;
      if (!taken || looksDifferent(taken, snapshot, this.layers)) this.take(snapshot);
    });
    this.resize();
    requestAnimationFrame((now) => this.loop(now));
  }

  setTheme(dark: boolean): void {
    const color = new THREE.Color(dark ? kBackground.dark : kBackground.light);
    this.scene.background = color;
    this.scene.fog = new THREE.Fog(color, 6, 11.5);
    (this.floor.material as SurfaceMaterial).color.set(dark ? 0x4a5462 : 0xdfe4ea);
    this.sky.intensity = (dark ? 1.15 : 1.5) * (software ? 1.25 : 1);
    this.dirty = true;
  }

  setLayer(name: keyof Layers, on: boolean): void {
    this.layers[name] = on;
    this.applyLayers();
    if (this.state.snapshot) this.take(this.state.snapshot);
  }

  clearTrails(): void {
    for (const trail of this.trails) trail.clear();
    this.dirty = true;
  }

  goHome(): void {
    this.camera.position.copy(this.home.eye);
    this.controls.target.copy(this.home.center);
    this.controls.update();
    this.dirty = true;
  }

  /** Looks at one robot's tool from nearby. */
  focusRobot(index: number): void {
    const tool = this.state.snapshot?.robots[index]?.toolInWorld;
    if (!tool) return;
    toVector(tool.positionM, this.controls.target);
    const offset = this.camera.position.clone().sub(this.controls.target).normalize();
    this.camera.position.copy(this.controls.target).addScaledVector(offset, 1.1);
    this.controls.update();
  }

  select(pick: Pick | null): void {
    this.selected = pick === null ? null : this.find(pick);
    this.highlight.visible = this.selected !== null;
    if (this.selected) this.highlight.setFromObject(this.selected);
    this.dirty = true;
  }

  private makeLights(): void {
    this.sun.castShadow = true;
    this.sun.shadow.mapSize.setScalar(software ? 1024 : 2048);
    this.sun.shadow.bias = -2e-4;
    this.sun.shadow.normalBias = software ? 0.02 : 0.006;
    this.sun.shadow.radius = 3;
    Object.assign(this.sun.shadow.camera, {
      left: -2.2,
      right: 2.2,
      top: 2.2,
      bottom: -2.2,
      near: 1,
      far: 9
    });
  }

  /** Reflections cost a moment to prepare, so they come after the first picture. */
  private addReflections(): void {
    const generator = new THREE.PMREMGenerator(this.renderer);
    this.scene.environment = generator.fromScene(new RoomEnvironment(), 0.04).texture;
    this.scene.environmentIntensity = 0.42;
    generator.dispose();
    this.dirty = true;
  }

  private build(cell: CellDescription): void {
    this.taken = null;
    this.scene.remove(this.content);
    this.content.traverse((object) => (object as Partial<THREE.Mesh>).geometry?.dispose());
    this.content = new THREE.Group();
    this.robots = cell.robots.map(
      (robot, i) => new RobotModel(robot, this.state.looks?.robots[i], i)
    );
    for (const robot of this.robots) {
      this.content.add(robot.root);
      ++this.loading;
      robot
        .load()
        .catch((problem: Error) => this.onProblem(problem.message))
        .finally(() => {
          --this.loading;
          if (this.state.snapshot) this.take(this.state.snapshot);
          this.selected = null;
        });
    }
    this.parts = new Parts(cell, this.state.looks);
    this.belt = cell.conveyor ? new Belt(cell.conveyor) : null;
    this.cameras = new Cameras(cell, this.state.looks, kRobotColors);
    this.eyes = new PhotoEyes(cell);
    this.curtain = new LightCurtain(cell);
    this.goals = new Goals(cell, kRobotColors);
    this.trails = cell.robots.map((_, i) => new Trail(kRobotColors[i % kRobotColors.length]!));
    if (this.state.looks) this.content.add(makeFixed(this.state.looks));
    this.content.add(
      this.parts.root,
      this.cameras.root,
      this.eyes.root,
      this.curtain.root,
      this.goals.root,
      ...this.trails.map((trail) => trail.line)
    );
    if (this.belt) this.content.add(this.belt.root);
    this.scene.add(this.content);
    this.applyLayers();
    this.select(null);
    this.frame(cell);
  }

  /** The first camera: the whole cell from the near side, a little from above. */
  private frame(cell: CellDescription): void {
    const bounds = new THREE.Box3();
    for (const robot of cell.robots) {
      const base = toVector(robot.baseInWorld?.positionM);
      bounds.expandByPoint(base).expandByPoint(base.clone().add(new THREE.Vector3(0, 0, 0.65)));
    }
    if (cell.conveyor) bounds.expandByPoint(toVector(cell.conveyor.beltInWorld?.positionM));
    for (const tray of this.state.snapshot?.bodies ?? [])
      bounds.expandByPoint(toVector(tray.bodyInWorld?.positionM));
    if (bounds.isEmpty()) bounds.expandByPoint(new THREE.Vector3(0, 0, 1));
    const center = bounds.getCenter(new THREE.Vector3());
    const size = Math.max(1.0, bounds.getSize(new THREE.Vector3()).length());
    this.home.center.copy(center).add(new THREE.Vector3(0.0, 0.02, -0.06));
    const wide = this.camera.aspect < 1 ? 1.35 / this.camera.aspect : 1;
    this.home.eye
      .copy(this.home.center)
      .addScaledVector(
        new THREE.Vector3(1.0, -1.02, 0.72).normalize(),
        2.15 * size * Math.min(wide, 2)
      );
    this.sun.position.copy(center).add(new THREE.Vector3(1.6, -1.9, 3.6));
    this.sun.target.position.copy(center).setZ(0.6);
    if (this.framed !== cell.scene) this.goHome();
    this.framed = cell.scene;
  }

  /** What explains the cell comes after the first picture of it. */
  private applyLayers(): void {
    const show = (object: THREE.Object3D | undefined, on: boolean): void => {
      if (object) object.visible = on && this.shown;
    };
    show(this.cameras?.root, this.layers.cameras);
    show(this.goals?.root, this.layers.targets);
    show(this.contacts.root, this.layers.contacts);
    show(this.eyes?.root, this.layers.curtain);
    show(this.curtain?.root, this.layers.curtain);
    for (const trail of this.trails) show(trail.line, this.layers.trails);
    this.dirty = true;
  }

  private take(snapshot: Snapshot): void {
    this.taken = snapshot;
    this.robots.forEach((robot, i) => snapshot.robots[i] && robot.update(snapshot.robots[i]!));
    this.parts?.update(snapshot.bodies, this.layers.groups);
    if (snapshot.conveyor) this.belt?.update(snapshot.conveyor.travelM);
    if (this.layers.cameras) this.cameras?.update(snapshot);
    if (this.layers.targets) this.goals?.update(snapshot);
    if (this.layers.contacts) this.contacts.update(snapshot);
    this.eyes?.update(snapshot);
    this.curtain?.update(snapshot);
    this.trails.forEach((trail, i) => trail.add(snapshot.robots[i]?.toolInWorld));
    if (this.selected) this.highlight.setFromObject(this.selected);
    this.dirty = true;
  }

  /** A first picture is on the screen. */
  private get shown(): boolean {
    return this.container.dataset.frames !== undefined;
  }

  private find(pick: Pick): THREE.Object3D | null {
    if (pick.kind === 'body') return this.parts?.meshes[pick.index] ?? null;
    if (pick.kind === 'robot') return this.robots[pick.index]?.root ?? null;
    if (pick.kind === 'belt') return this.belt?.root ?? null;
    let found: THREE.Object3D | null = null;
    this.content.traverse((o) => {
      if (o.userData.pick?.name === pick.name) found = o;
    });
    return found;
  }

  private listenForPicks(): void {
    const canvas = this.renderer.domElement;
    let down = {x: 0, y: 0};
    canvas.addEventListener('pointerdown', (e) => (down = {x: e.clientX, y: e.clientY}));
    canvas.addEventListener('pointerup', (e) => {
      if (Math.hypot(e.clientX - down.x, e.clientY - down.y) > 5) return;
      const area = canvas.getBoundingClientRect();
      const at = new THREE.Vector2(
        ((e.clientX - area.left) / area.width) * 2 - 1,
        1 - ((e.clientY - area.top) / area.height) * 2
      );
      const ray = new THREE.Raycaster();
      ray.setFromCamera(at, this.camera);
      let pick: Pick | null = null;
      for (const hit of ray.intersectObject(this.content, true)) {
        if (!(hit.object instanceof THREE.Mesh) || hit.object instanceof THREE.InstancedMesh)
          continue;
        for (let o: THREE.Object3D | null = hit.object; o && !pick; o = o.parent)
          pick = o.userData.pick ?? null;
        if (pick) break;
      }
      this.select(pick);
      this.onPick(pick);
    });
  }

  private resize(): void {
    const {clientWidth: w, clientHeight: h} = this.container;
    if (w === 0 || h === 0) return;
    const wasTall = this.camera.aspect < 1;
    this.setFineness(this.pixelRatio, false);
    this.camera.aspect = w / h;
    this.camera.updateProjectionMatrix();
    if (this.state.cell && wasTall !== this.camera.aspect < 1) {
      this.framed = '';
      this.frame(this.state.cell);
    }
    this.dirty = true;
  }

  private loop(now: number): void {
    requestAnimationFrame((next) => this.loop(next));
    // The browser calls again once it has room for another picture: that is what drawing takes.
    if (this.drawn && this.shown) this.adapt(now - this.last, now);
    else if (this.drawn) this.begunToShow();
    this.last = now;
    // Where drawing is slow, as much time again is left to others.
    const rested =
      now - this.begun >= (this.frameTime_ms > kSlowFrame_ms ? 2 * this.frameTime_ms : 0);
    this.drawn = this.dirty && rested && !document.hidden;
    if (!this.drawn) return void (!this.dirty && now - this.begun > kStill_ms && this.refine());
    if (this.refined) this.setFineness(this.pixelRatio, false);
    this.dirty = false;
    const first = !this.shown;
    if (!this.state.snapshot || (first && this.loading > 0)) return void (this.drawn = false);
    // Shadows come after the first picture, and are drawn anew less often where drawing takes long.
    this.renderer.shadowMap.needsUpdate = !first && now >= this.shadowDue;
    if (!first && now >= this.shadowDue)
      this.shadowDue = now + (this.frameTime_ms > kSlowFrame_ms ? 600 : 0);
    this.begun = now;
    this.renderer.render(this.scene, this.camera);
  }

  /** The first picture, robots and all, is on the screen. */
  private begunToShow(): void {
    this.container.dataset.frames = 'drawn';
    this.applyLayers();
    performance.mark('first-frame');
    if (!software) setTimeout(() => this.addReflections(), 250);
  }

  /** One finer picture of what has come to rest, where moving pictures are coarse. */
  private refine(): void {
    if (this.refined || !software || !this.shown) return;
    this.setFineness(1.5 * devicePixelRatio, true);
    this.renderer.shadowMap.needsUpdate = true;
    this.renderer.render(this.scene, this.camera);
  }

  private setFineness(ratio: number, refined: boolean): void {
    const {clientWidth: w, clientHeight: h} = this.container;
    const size = `${w} ${h} ${ratio}`;
    this.refined = refined;
    if (size === this.size) return;
    this.size = size;
    this.renderer.setDrawingBufferSize(w, h, ratio);
  }

  /** Draws at fewer points and asks for fewer states while drawing takes too long. */
  private adapt(took_ms: number, now: number): void {
    this.frameTime_ms += 0.1 * (took_ms - this.frameTime_ms);
    this.state.watch({rateHz: this.frameTime_ms > 60 ? 12 : this.frameTime_ms > 25 ? 20 : 30});
    if (
      adaptive &&
      this.frameTime_ms > kSlowFrame_ms &&
      this.pixelRatio > 0.5 &&
      now > this.settled
    ) {
      this.pixelRatio = Math.max(0.5, this.pixelRatio * 0.7);
      this.settled = now + 3000;
      this.resize();
    }
  }
}
