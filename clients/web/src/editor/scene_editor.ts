// The scene editor without its looks: a draft, what is chosen in it, and the daemon's answers to it.
import {BodyKind, type SceneDraft} from '../protocol';
import {setDraftModels} from '../scene/model_source';
import type {Pick} from '../scene/cell_view';
import {Signal, type State} from '../state';
import {Draft} from './draft';
import {kEmptyScene, Library, spotsNear, withCopy, withNew, without, type Offer} from './library';
import {SceneText, type Path, type Value} from './scene_text';
import {findByName, placeOf, thingsOf, withPlace, type Place, type Thing} from './things';

const kOverlap = / deep in /;

export class SceneEditor {
  readonly changed = new Signal<void>();
  library = new Library([]);
  /** Reason why the last change was refused; empty if it was not. */
  problem = '';
  /** The thing that the last refused change concerned. */
  refused: string | null = null;
  busy = false;
  asWritten = false;
  /** The text that the cell was last reset to, or that it had. */
  applied = '';
  private draft: Draft | null = null;
  private parsed = new SceneText('');
  private shown: SceneDraft | null = null;
  private id: string | null = null;
  private queue: Promise<unknown> = Promise.resolve();

  constructor(private readonly state: State) {
    state.draftChanged.on(() => this.changed.emit());
  }

  get open(): boolean {
    return this.state.draft && this.draft !== null;
  }
  get name(): string {
    return this.draft?.name ?? '';
  }
  get text(): string {
    return this.draft?.text ?? '';
  }
  get scene(): SceneText {
    if (this.parsed.text !== this.text) this.parsed = new SceneText(this.text);
    return this.parsed;
  }
  get things(): Thing[] {
    return thingsOf(this.scene);
  }
  get chosen(): Thing | null {
    return this.things.find(({id}) => id === this.id) ?? null;
  }
  get canUndo(): boolean {
    return this.draft?.undoable != null;
  }
  get canRedo(): boolean {
    return this.draft?.redoable != null;
  }
  get isApplied(): boolean {
    return this.text === this.applied;
  }

  // ---- beginning and end

  /** Begins with the scene of the cell, or goes on with the last draft if the cell is still its. */
  async begin(): Promise<void> {
    await this.run(async () => {
      const {connection} = this.state;
      if (!this.state.live?.paused) await connection.request({case: 'pause', value: {}});
      const source = await connection.sceneSource();
      this.library = new Library(source.types);
      if (!this.draft || (source.text !== this.applied && this.isApplied)) {
        this.draft = new Draft(source.name, source.text);
        this.asWritten = source.asWritten;
        this.applied = source.text;
      }
      this.show(await connection.draftScene(this.text));
    });
  }

  /** Shows the cell again. The draft is kept. */
  leave(): void {
    this.state.showDraft(null);
  }

  /** Goes on with another text, from a file or an empty one. Undo returns to the present one. */
  async replace(name: string, text: string): Promise<boolean> {
    return this.run(async () => {
      const draft = await this.check(text);
      this.draft!.change(text);
      this.draft!.name = name;
      this.asWritten = true;
      this.id = null;
      this.show(draft);
    });
  }
  clear(): Promise<boolean> {
    return this.replace('scene', kEmptyScene);
  }

  /** Resets the cell to the draft. */
  async apply(): Promise<boolean> {
    return this.run(async () => {
      await this.state.connection.request(
        {case: 'reset', value: {scene: {case: 'sceneText', value: this.text}}},
        120000
      );
      this.applied = this.text;
    });
  }

  // ---- changes

  choose(thing: Thing | null): void {
    if (thing?.id === this.id) return;
    this.id = thing?.id ?? null;
    this.changed.emit();
  }

  /** Chooses what was picked in the view. */
  pick(pick: Pick | null): Thing | null {
    const name = pick && this.nameOf(pick);
    const found =
      pick?.kind === 'belt'
        ? this.things.find(({kind}) => kind.key === 'conveyor')
        : name && findByName(this.things, name);
    this.choose(found || null);
    return found || null;
  }

  private nameOf(pick: Pick): string {
    const {cell} = this.state;
    if (pick.kind === 'body') return cell?.bodies[pick.index]?.name ?? '';
    if (pick.kind === 'robot') return cell?.robots[pick.index]?.name ?? '';
    return pick.kind === 'fixed' ? pick.name : '';
  }

  /** The objects of the view that belong to a thing. */
  picksOf(thing: Thing): Pick[] {
    const {cell} = this.state;
    const {key} = thing.kind;
    if (key === 'conveyor') return [{kind: 'belt'}];
    if (key === 'robots') {
      const index = cell?.robots.findIndex(({name}) => name === thing.name) ?? -1;
      return index < 0 ? [] : [{kind: 'robot', index}];
    }
    if (key === 'fixed' || key === 'fixtures') return [{kind: 'fixed', name: thing.name}];
    const picks: Pick[] = [];
    cell?.bodies.forEach(({name, kind}, index) => {
      const own = findByName([thing], name) !== undefined;
      if (own && kind !== BodyKind.UNSPECIFIED) picks.push({kind: 'body', index});
    });
    return picks;
  }

  /** How many slots of a tray each robot reaches from above; none for anything else. */
  reachOf(thing: Thing): {robot: string; reached: number; slots: number}[] {
    const cell = this.shown?.cell;
    const body = cell?.bodies.findIndex(({name}) => name === thing.name) ?? -1;
    const geometry = cell?.bodies[body]?.geometry;
    if (geometry?.case !== 'tray') return [];
    const slots = geometry.value.slots.length;
    return this.shown!.reaches.filter((reach) => reach.body === body).map((reach) => ({
      robot: cell!.robots[reach.robot]?.name ?? '',
      reached: reach.slots.length,
      slots
    }));
  }

  move(thing: Thing, to: Place): Promise<boolean> {
    return this.change(thing.id, () => {
      const now = this.things.find(({id}) => id === thing.id);
      return now ? withPlace(this.scene, now, to) : this.text;
    });
  }
  /** Moves the chosen thing by a distance, and turns it. */
  shift(dx_m: number, dy_m: number, turn_deg: number): Promise<boolean> {
    const {chosen} = this;
    if (!chosen || !placeOf(chosen)) return Promise.resolve(false);
    return this.change(chosen.id, () => {
      const now = this.chosen!;
      const {x, y, yaw_deg} = placeOf(now)!;
      return withPlace(this.scene, now, {x: x + dx_m, y: y + dy_m, yaw_deg: yaw_deg + turn_deg});
    });
  }
  set(thing: Thing, path: Path, value: Value): Promise<boolean> {
    return this.change(thing.id, () => {
      const text = this.scene.set([...thing.path, ...path], value);
      if (path.length === 1 && path[0] === 'name') this.id = `${thing.kind.key}/${String(value)}`;
      return text;
    });
  }
  remove(thing: Thing): Promise<boolean> {
    return this.change(thing.id, () => without(this.scene, thing));
  }
  /** Takes a whole text. */
  rewrite(text: string): Promise<boolean> {
    return this.change(null, () => text);
  }

  add(offer: Offer): Promise<boolean> {
    const {chosen} = this;
    return this.place(spotsNear(this.scene, chosen), (spot) =>
      withNew(this.scene, this.library, offer, chosen, spot)
    );
  }
  copy(thing: Thing): Promise<boolean> {
    const [, ...beside] = spotsNear(this.scene, thing);
    return this.place(beside, (spot) => withCopy(this.scene, thing, spot));
  }

  undo(): Promise<boolean> {
    return this.step(this.draft?.undoable, () => this.draft!.undo());
  }
  redo(): Promise<boolean> {
    return this.step(this.draft?.redoable, () => this.draft!.redo());
  }

  // ---- the daemon

  private async check(text: string): Promise<SceneDraft> {
    const {problem} = new SceneText(text);
    if (problem) throw new Error(problem);
    return this.state.connection.draftScene(text);
  }

  /** Changes the draft if the daemon accepts the new text. */
  private change(id: string | null, next: () => string): Promise<boolean> {
    return this.run(async () => {
      const before = this.id;
      const text = next();
      if (text === this.text) return;
      try {
        const draft = await this.check(text);
        this.draft!.change(text);
        this.show(draft);
      } catch (problem) {
        this.id = before;
        this.refused = id;
        throw problem;
      }
    });
  }

  /** Puts something at the first spot where it overlaps nothing. */
  private place(
    spots: {x: number; y: number}[],
    make: (spot: {x: number; y: number}) => {text: string; id: string}
  ): Promise<boolean> {
    return this.run(async () => {
      let first: unknown = null;
      for (const spot of spots) {
        const {text, id} = make(spot);
        try {
          const draft = await this.check(text);
          this.draft!.change(text);
          this.id = id;
          return this.show(draft);
        } catch (problem) {
          first ??= problem;
          if (!kOverlap.test((problem as Error).message)) throw problem;
        }
      }
      throw first;
    });
  }

  private step(text: string | null | undefined, take: () => void): Promise<boolean> {
    if (text === null || text === undefined) return Promise.resolve(false);
    return this.run(async () => {
      const draft = await this.check(text);
      take();
      this.show(draft);
    });
  }

  private show(draft: SceneDraft): void {
    this.shown = draft;
    setDraftModels(draft.models);
    this.state.showDraft(draft);
  }

  /** Shows the last draft again, as where something was dragged to a place that is refused. */
  restore(): void {
    if (this.shown && this.open) this.show(this.shown);
  }

  /** One request after the other. */
  private run(work: () => Promise<void>): Promise<boolean> {
    const done = this.queue.then(async () => {
      this.busy = true;
      this.problem = '';
      this.refused = null;
      this.changed.emit();
      try {
        await work();
        return true;
      } catch (problem) {
        this.problem = (problem as Error).message;
        return false;
      } finally {
        this.busy = false;
        this.changed.emit();
      }
    });
    this.queue = done;
    return done;
  }
}
