import * as THREE from 'three';
import {OrbitControls} from 'three/examples/jsm/controls/OrbitControls.js';
import {RoomEnvironment} from 'three/examples/jsm/environments/RoomEnvironment.js';
import type {CellDescription, MovePlan, Snapshot} from '../protocol';
import type {State} from '../state';
import type {CellView, Layers, Pick} from './cell_view';
import {looksDifferent} from './changes';
import {Contacts} from './contacts';
import {toQuaternion, toVector} from './convert';
import {Dragging, type Grabber} from './dragging';
import {footprintsOf, type Footprint} from './footprint';
import {Fineness} from './fineness';
import {cornersOf, fitted, kUp, type Picture} from './framing';
import {Goals} from './goals';
import {makeRenderer, type SurfaceMaterial} from './materials';
import {MoveGhosts} from './move_ghosts';
import {NameLabels} from './name_labels';
import {Cameras, LightCurtain, PhotoEyes, Trail} from './overlays';
import {Parts} from './parts';
import {adaptive, software} from './quality';
import {RobotMarks} from './robot_marks';
import {RobotModel} from './robot_model';
import {makeFixture} from './pieces';
import {Belt, makeFixed, makeFloor} from './surroundings';
import {ToolModel} from './tool_model';

export const kRobotColors = [0xf5b82e, 0x3f8efc, 0x37d67a, 0xd64550];

const kBackground = {dark: 0x171c24, light: 0xe6eaef};
const kStill_ms = 700;
const kFirstDirection = new THREE.Vector3(1.0, -1.02, 0.72);
/** Turns of that direction about the vertical [rad], to see past posts. */
const kFirstTurns = [0, 0.15, -0.15, 0.3, -0.3, 0.45, -0.45, 0.6, -0.6];
/** Directions from which a robot is viewed: aside of its front, above [rad]; the first clear one is used. */
const kLookFrom = [
  [0.55, 0.4],
  [-0.55, 0.4],
  [0.2, 0.55],
  [-0.2, 0.55],
  [0.9, 0.5],
  [-0.9, 0.5],
  [0, 0.95]
] as const;
const kStray_m = 1; // distance from which a body counts as lost

/** The cell in three dimensions. Draws after changes only, and less finely on slow machines. */
export class View implements CellView {
  readonly draws = true;
  readonly layers: Layers = {
    names: false,
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
  private tools: ToolModel[] = [];
  private parts: Parts | null = null;
  private belt: Belt | null = null;
  private cameras: Cameras | null = null;
  private eyes: PhotoEyes | null = null;
  private curtain: LightCurtain | null = null;
  private trails: Trail[] = [];
  private goals: Goals | null = null;
  private readonly contacts = new Contacts();
  private readonly ghosts = new MoveGhosts();
  private readonly highlight = new THREE.BoxHelper(new THREE.Object3D(), 0xffffff);
  private selected: THREE.Object3D | null = null;
  private marks: RobotMarks | null = null;
  private names: NameLabels | null = null;
  private fixed: THREE.Group | undefined;
  private unframed = false; // a new cell has not been placed and framed yet
  private fogFrom = 6;
  private framed = ''; // scene whose initial view has been shown
  private atHome = true;
  private dirty = true;
  private readonly fineness: Fineness;
  private shadowDue = 0;
  private last = 0;
  private begun = 0;
  private refined = false;
  private drawn = false;
  private size = '';
  private taken: Snapshot | null = null;
  private loading = 0;
  private readonly dragging: Dragging;
  private built: CellDescription | null = null; // whose robots are drawn
  private readonly lost = document.createElement('p');

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
    this.controls.addEventListener('start', () => (this.atHome = false));
    this.makeLights();
    this.highlight.visible = this.contacts.root.visible = false;
    this.scene.add(
      this.sky,
      this.sun,
      this.sun.target,
      this.floor,
      this.content,
      this.highlight,
      this.contacts.root,
      this.ghosts.root
    );
    new ResizeObserver(() => this.resize()).observe(container);
    this.fineness = new Fineness(software ? 0.8 : Math.min(devicePixelRatio, 2), adaptive);
    this.setTheme(true);
    this.listenForPicks();
    this.dragging = new Dragging({
      canvas: this.renderer.domElement,
      controls: this.controls,
      rayAt: (event) => this.rayAt(event),
      hit: (ray) => this.hit(ray),
      find: (pick) => this.find(pick),
      redraw: () => {
        if (this.selected) this.highlight.setFromObject(this.selected);
        this.dirty = true;
      }
    });
    this.listenForContextLoss();
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
    this.setFog();
    (this.floor.material as SurfaceMaterial).color.set(dark ? 0x4a5462 : 0xdfe4ea);
    this.sky.intensity = (dark ? 1.15 : 1.5) * (software ? 1.25 : 1);
    this.dirty = true;
  }

  private setFog(): void {
    this.scene.fog = new THREE.Fog(
      this.scene.background as THREE.Color,
      this.fogFrom,
      1.9 * this.fogFrom
    );
  }

  setLayer(name: keyof Layers, on: boolean): void {
    this.layers[name] = on;
    this.applyLayers();
    if (this.state.snapshot) this.take(this.state.snapshot);
  }

  /** The current picture as PNG. */
  async picturePng(): Promise<Blob> {
    // The drawing buffer may have been cleared already.
    this.render();
    const canvas = this.renderer.domElement;
    const blob = await new Promise<Blob | null>((resolve) => canvas.toBlob(resolve, 'image/png'));
    if (!blob) throw new Error('the browser makes no PNG');
    return blob;
  }

  /** Stream of the following pictures, for a film. */
  film(rate_hz: number): MediaStream {
    this.dirty = true;
    return this.renderer.domElement.captureStream(rate_hz);
  }

  setGrabber(grabber: Grabber | null): void {
    this.dragging.grabber = grabber;
  }

  footprintsOf(pick: Pick): Footprint[] {
    const object = this.find(pick);
    return object ? footprintsOf(object) : [];
  }

  clearTrails(): void {
    for (const trail of this.trails) trail.clear();
    this.dirty = true;
  }

  /** The initial view: everything in the picture, from the near side, a little from above. */
  goHome(): void {
    this.atHome = true;
    const points = this.everything();
    let best = {hidden: Infinity, towards: kFirstDirection};
    for (const turn of kFirstTurns) {
      const towards = kFirstDirection.clone().applyAxisAngle(kUp, turn);
      const {eye, target} = fitted(points, towards, this.picture());
      const hidden = this.hiddenByPosts(eye, target);
      if (hidden < best.hidden) best = {hidden, towards};
      if (hidden === 0) break;
    }
    this.lookAt(points, best.towards);
  }

  /** Number of robots and bodies that a post of the light curtain covers in the picture from `eye`. */
  private hiddenByPosts(eye: THREE.Vector3, target: THREE.Vector3): number {
    const camera = this.camera.clone();
    camera.position.copy(eye);
    camera.lookAt(target);
    camera.updateMatrixWorld();
    const outline = (object: THREE.Object3D): {box: THREE.Box2; distance: number} => {
      const corners = cornersOf(object);
      const distance = Math.min(...corners.map((corner) => corner.distanceTo(eye)));
      const box = new THREE.Box2();
      for (const corner of corners) {
        const {x, y} = corner.project(camera);
        box.expandByPoint(new THREE.Vector2(x, y));
      }
      return {box, distance};
    };
    const posts = (this.curtain?.posts ?? []).map(outline);
    if (posts.length === 0) return 0;
    const work = [...this.robots.map((robot) => robot.root), ...(this.parts?.meshes ?? [])];
    return work
      .map(outline)
      .filter(({box, distance}) =>
        posts.some((post) => post.distance < distance && post.box.intersectsBox(box))
      ).length;
  }

  /** Turns the view to the front of a robot, from the side of its tool, past obstacles. */
  focusRobot(index: number): void {
    const robot = this.state.cell?.robots[index],
      model = this.robots[index],
      tool = this.state.snapshot?.robots[index]?.toolInWorld;
    if (!robot || !model || !tool) return;
    const base = toVector(robot.baseInWorld?.positionM);
    const front = toVector(tool.positionM).sub(base).setZ(0);
    // A tool above the base has no side: use the base's x axis.
    if (front.length() < 0.1)
      front.set(1, 0, 0).applyQuaternion(toQuaternion(robot.baseInWorld)).setZ(0);
    const points = cornersOf(model.root);
    const seen = [toVector(tool.positionM), ...points];
    let best = {hidden: Infinity, towards: kFirstDirection};
    for (const [aside, above] of kLookFrom) {
      const towards = front
        .clone()
        .normalize()
        .applyAxisAngle(kUp, aside)
        .multiplyScalar(Math.cos(above))
        .setZ(Math.sin(above));
      const {eye} = fitted(points, towards, this.picture());
      const hidden = this.hidden(eye, seen, model.root);
      if (hidden < best.hidden) best = {hidden, towards};
      if (hidden === 0) break;
    }
    this.atHome = false;
    this.lookAt(points, best.towards);
  }

  /** Number of the points that objects other than `self` hide. */
  private hidden(eye: THREE.Vector3, points: THREE.Vector3[], self: THREE.Object3D): number {
    const others: THREE.Object3D[] = [];
    for (const root of [...this.robots.map((robot) => robot.root), this.belt?.root, this.fixed])
      if (root && root !== self) others.push(root);
    const ray = new THREE.Raycaster();
    // Sample of the points.
    const every = Math.ceil(points.length / 24);
    return points.filter((point, i) => {
      if (i % every !== 0) return false;
      const way = point.clone().sub(eye);
      ray.set(eye, way.clone().normalize());
      ray.far = 0.98 * way.length();
      return ray.intersectObjects(others, true).length > 0;
    }).length;
  }

  showPlan(shown: {robot: number; plan: MovePlan} | null): void {
    this.ghosts.clear();
    this.dirty = true;
    if (!shown) return;
    const robot = this.state.cell?.robots[shown.robot],
      model = this.robots[shown.robot],
      now = this.state.snapshot?.robots[shown.robot];
    if (!robot || !model || !now) return;
    const color = kRobotColors[shown.robot % kRobotColors.length]!;
    this.ghosts.show(robot, model, now, shown.plan, color);
  }

  private picture(): Picture {
    const layers = this.container.querySelector<HTMLElement>('.layers');
    const covered = layers
      ? (layers.offsetTop + layers.offsetHeight) / this.container.clientHeight
      : 0;
    return {
      fov_deg: this.camera.fov,
      aspect: this.camera.aspect,
      covered: Math.min(covered, 0.25) || 0
    };
  }

  private lookAt(points: THREE.Vector3[], towards: THREE.Vector3): void {
    if (points.length === 0) return;
    const {eye, target} = fitted(points, towards, this.picture());
    const distance = eye.distanceTo(target);
    // Allow this distance, and start the fog behind it.
    this.controls.maxDistance = Math.max(12, 1.5 * distance);
    this.fogFrom = Math.max(6, 1.5 * distance);
    this.setFog();
    this.camera.far = Math.max(60, 4 * distance);
    this.camera.updateProjectionMatrix();
    this.camera.position.copy(eye);
    this.controls.target.copy(target);
    this.controls.update();
    // Picks and marks before the next picture need the new matrices.
    this.camera.updateMatrixWorld();
    this.dirty = true;
  }

  /** Corners of the whole cell, without bodies that have fallen out of it. */
  private everything(): THREE.Vector3[] {
    const points: THREE.Vector3[] = [];
    for (const root of [
      ...this.robots.map((robot) => robot.root),
      this.belt?.root,
      this.eyes?.root,
      this.curtain?.root,
      this.fixed
    ])
      if (root) cornersOf(root, points);
    const near = new THREE.Box3().setFromPoints(points).expandByScalar(kStray_m);
    for (const mesh of this.parts?.meshes ?? [])
      if (points.length === 0 || near.containsPoint(mesh.position)) cornersOf(mesh, points);
    return points;
  }

  select(pick: Pick | null): void {
    this.selected = pick === null ? null : this.find(pick);
    this.highlight.visible = this.selected !== null;
    if (this.selected) this.highlight.setFromObject(this.selected);
    this.dirty = true;
  }

  /** three.js restores its own state, but not what was rendered once: reflections and shadows. */
  private listenForContextLoss(): void {
    const canvas = this.renderer.domElement;
    this.lost.className = 'blank';
    this.lost.hidden = true;
    this.lost.textContent =
      'The browser has lost the graphics context of the 3D view and will restore it when it can.';
    this.container.append(this.lost);
    canvas.addEventListener('webglcontextlost', () => (this.lost.hidden = false));
    canvas.addEventListener('webglcontextrestored', () => {
      this.lost.hidden = true;
      this.shadowDue = 0;
      this.refined = false;
      if (this.scene.environment) this.addReflections();
      this.dirty = true;
    });
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

  /** Reflections take time to prepare, so they follow after the first picture. */
  private addReflections(): void {
    const generator = new THREE.PMREMGenerator(this.renderer);
    this.scene.environment = generator.fromScene(new RoomEnvironment(), 0.04).texture;
    this.scene.environmentIntensity = 0.42;
    generator.dispose();
    this.dirty = true;
  }

  private build(cell: CellDescription): void {
    this.taken = null;
    this.ghosts.clear();
    this.scene.remove(this.content);
    for (const tool of this.tools) tool.root.removeFromParent();
    const kept = this.keptRobots(cell);
    for (const robot of kept) robot?.root.removeFromParent().position.set(0, 0, 0);
    this.content.traverse((object) => (object as Partial<THREE.Mesh>).geometry?.dispose());
    this.content = new THREE.Group();
    this.robots = cell.robots.map((robot, i) => kept[i] ?? new RobotModel(robot, i));
    this.tools = cell.tools.map((tool) => new ToolModel(tool));
    for (const tool of this.tools) this.content.add(tool.root);
    this.robots.forEach((robot, i) => {
      this.content.add(robot.root);
      if (!kept[i]) this.load(robot);
    });
    this.built = cell;
    this.parts = new Parts(cell, this.state.appearance);
    this.belt = cell.conveyor ? new Belt(cell.conveyor) : null;
    this.cameras = new Cameras(cell, this.state.appearance, kRobotColors);
    this.eyes = new PhotoEyes(cell);
    this.curtain = new LightCurtain(cell);
    this.goals = new Goals(cell, kRobotColors);
    this.trails = cell.robots.map((_, i) => new Trail(kRobotColors[i % kRobotColors.length]!));
    this.fixed = this.state.appearance ? makeFixed(this.state.appearance) : undefined;
    if (this.fixed) this.content.add(this.fixed);
    this.content.add(
      ...cell.fixtures.map(makeFixture),
      this.parts.root,
      this.cameras.root,
      this.eyes.root,
      this.curtain.root,
      this.goals.root,
      ...this.trails.map((trail) => trail.line)
    );
    if (this.belt) this.content.add(this.belt.root);
    this.scene.add(this.content);
    this.marks?.remove();
    this.marks = new RobotMarks(this.container, cell, this.robots);
    this.names?.remove();
    this.names = new NameLabels(this.container, cell, {
      robots: this.robots.map((robot) => robot.root),
      tools: this.tools.map((tool) => tool.root),
      bodies: this.parts.meshes
    });
    this.applyLayers();
    this.select(null);
    this.unframed = true;
  }

  private load(robot: RobotModel): void {
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

  /** The present robots that a cell has too, by its indices: while a scene is edited, most of them. */
  private keptRobots(cell: CellDescription): (RobotModel | undefined)[] {
    if (this.loading > 0 || !this.state.draft) return [];
    const text = (value: unknown): string =>
      JSON.stringify(value, (_, inner: unknown) =>
        typeof inner === 'bigint' ? String(inner) : inner
      );
    return cell.robots.map((robot, i) =>
      text(robot) === text(this.built?.robots[i]) ? this.robots[i] : undefined
    );
  }

  /** Sets the light, and the initial view of a new scene. */
  private frame(cell: CellDescription): void {
    const bounds = new THREE.Box3().setFromPoints(this.everything());
    if (bounds.isEmpty()) bounds.expandByPoint(new THREE.Vector3(0, 0, 1));
    const center = bounds.getCenter(new THREE.Vector3());
    const reach = Math.max(2.2, 0.5 * bounds.getSize(new THREE.Vector3()).setZ(0).length());
    this.sun.position.copy(center).add(new THREE.Vector3(1.6, -1.9, 3.6));
    this.sun.target.position.copy(center).setZ(0.6);
    Object.assign(this.sun.shadow.camera, {left: -reach, right: reach, top: reach, bottom: -reach});
    this.sun.shadow.camera.updateProjectionMatrix();
    if (this.framed !== cell.scene) this.goHome();
    this.framed = cell.scene;
    this.unframed = false;
  }

  /** Overlays follow after the first picture. */
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
    this.names?.show(this.layers.names && this.shown);
    this.dirty = true;
  }

  private take(snapshot: Snapshot): void {
    this.taken = snapshot;
    this.robots.forEach((robot, i) => snapshot.robots[i] && robot.update(snapshot.robots[i]!));
    this.marks?.update(snapshot);
    this.placeTools(snapshot);
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

  /** Moves each tool, attached to the robot that carries it. */
  private placeTools(snapshot: Snapshot): void {
    snapshot.tools.forEach((state, i) => {
      const tool = this.tools[i];
      if (!tool) return;
      const robot = state.robot === undefined ? undefined : this.robots[state.robot];
      const parent = robot?.root ?? this.content;
      if (tool.root.parent !== parent) {
        RobotModel.plain(tool);
        this.content.add(tool.root);
        robot?.carry(tool);
      }
      tool.update(state, state.robot === undefined ? undefined : snapshot.robots[state.robot]);
    });
  }

  /** Whether the first picture is on the screen. */
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
      const pick = this.hit(this.rayAt(e))?.pick ?? null;
      this.select(pick);
      this.onPick(pick);
    });
  }

  private rayAt(event: PointerEvent): THREE.Raycaster {
    const area = this.renderer.domElement.getBoundingClientRect();
    const at = new THREE.Vector2(
      ((event.clientX - area.left) / area.width) * 2 - 1,
      1 - ((event.clientY - area.top) / area.height) * 2
    );
    const ray = new THREE.Raycaster();
    ray.setFromCamera(at, this.camera);
    return ray;
  }

  /** The nearest object on a ray. */
  private hit(ray: THREE.Raycaster): {pick: Pick; point: THREE.Vector3} | null {
    for (const {object, point} of ray.intersectObject(this.content, true)) {
      if (!(object instanceof THREE.Mesh) || object instanceof THREE.InstancedMesh) continue;
      for (let o: THREE.Object3D | null = object; o; o = o.parent)
        if (o.userData.pick) return {pick: o.userData.pick as Pick, point};
    }
    return null;
  }

  private resize(): void {
    const {clientWidth: w, clientHeight: h} = this.container;
    if (w === 0 || h === 0) return;
    this.setFineness(this.fineness.ratio, false);
    this.camera.aspect = w / h;
    this.camera.updateProjectionMatrix();
    if (this.framed && this.atHome) this.goHome();
    this.dirty = true;
  }

  private loop(now: number): void {
    requestAnimationFrame((next) => this.loop(next));
    // The browser calls again when the picture is done: this interval is the drawing time.
    if (this.drawn && this.shown) this.adapt(now - this.last, now);
    else if (this.drawn) this.begunToShow();
    this.last = now;
    // Where drawing is slow, pause as long as a picture takes.
    const rested = now - this.begun >= (this.fineness.slow ? 2 * this.fineness.frame_ms : 0);
    this.drawn = this.dirty && rested && !document.hidden;
    if (!this.drawn) return void (!this.dirty && now - this.begun > kStill_ms && this.refine());
    if (this.refined) this.setFineness(this.fineness.ratio, false);
    this.dirty = false;
    const first = !this.shown;
    if (!this.taken || (first && this.loading > 0)) return void (this.drawn = false);
    if (this.unframed && this.loading === 0 && this.state.cell) this.frame(this.state.cell);
    // Shadows follow after the first picture, and less often where drawing is slow.
    this.renderer.shadowMap.needsUpdate = !first && now >= this.shadowDue;
    if (!first && now >= this.shadowDue) this.shadowDue = now + (this.fineness.slow ? 600 : 0);
    this.begun = now;
    this.render();
  }

  private render(): void {
    this.renderer.render(this.scene, this.camera);
    const {clientWidth: w, clientHeight: h} = this.container;
    this.marks?.place(this.camera, w, h);
    this.names?.place(this.camera, w, h);
  }

  /** Called once the first picture, with the robots, is on the screen. */
  private begunToShow(): void {
    this.container.dataset.frames = 'drawn';
    this.applyLayers();
    performance.mark('first-frame');
    if (!software) setTimeout(() => this.addReflections(), 250);
  }

  /** Draws one finer picture once nothing moves, where moving pictures are coarse. */
  private refine(): void {
    const {finest, ratio} = this.fineness;
    if (this.refined || !(software || ratio < finest) || !this.shown) return;
    this.setFineness(software ? 1.5 * devicePixelRatio : finest, true);
    this.renderer.shadowMap.needsUpdate = true;
    this.render();
  }

  private setFineness(ratio: number, refined: boolean): void {
    const {clientWidth: w, clientHeight: h} = this.container;
    const size = `${w} ${h} ${ratio}`;
    this.refined = refined;
    if (size === this.size) return;
    this.size = size;
    this.renderer.setDrawingBufferSize(w, h, ratio);
  }

  /** Adapts the resolution, and the rate of requested states, to the drawing time. */
  private adapt(took_ms: number, now: number): void {
    if (this.fineness.took(took_ms, now)) this.setFineness(this.fineness.ratio, false);
    const {frame_ms} = this.fineness;
    this.state.watch({rateHz: frame_ms > 60 ? 12 : frame_ms > 25 ? 20 : 30});
  }
}
