import {create, fromBinary, toBinary, type MessageInitShape} from '@bufbuild/protobuf';
import {
  ViewerRequestSchema,
  ViewerUpdateSchema,
  type MovePlan,
  type MovePreview,
  type Outcome,
  type PastSnapshot,
  type ScenarioCheck,
  type ScenarioSource,
  type SceneDraft,
  type SceneSource,
  type ViewerUpdate
} from './protocol';

type Body = Exclude<MessageInitShape<typeof ViewerRequestSchema>['body'], undefined>;
type Answer =
  | Outcome
  | PastSnapshot
  | MovePreview
  | SceneSource
  | SceneDraft
  | ScenarioSource
  | ScenarioCheck;

const kLongestPause_ms = 4000;
const kWatch_ms = 1000;
const kBuildPatience_ms = 120000; // a busy daemon is slow
const kSilence_ms = 3000; // the daemon sends at least twice a second

/**
 * The WebSocket to the daemon. Reconnects by itself; matches answers to requests by id. When
 * snapshots come faster than the page draws, only the latest is passed on.
 */
export class Connection {
  onUpdate: (update: ViewerUpdate) => void = () => {};
  /** `refusal`: reason why the daemon accepts no further viewer; else empty. */
  onState: (connected: boolean, retryIn_s: number, refusal: string) => void = () => {};

  private socket: WebSocket | null = null;
  private waiting = new Map<
    number,
    {resolve: (answer: Answer) => void; reject: (problem: Error) => void}
  >();
  private nextId = 1;
  private pause_ms = 250;
  private heard = 0;
  private snapshot: ViewerUpdate | null = null; // not passed on yet
  private readonly later = new MessageChannel(); // a timer would be slow in a hidden page

  start(): void {
    this.later.port1.onmessage = () => this.passSnapshot();
    this.open();
    let last = performance.now();
    setInterval(() => {
      const now = performance.now();
      // Do not count the time in which the page itself was busy and could not receive.
      const late_ms = now - last - kWatch_ms;
      last = now;
      this.heard = Math.min(now, this.heard + Math.max(0, late_ms));
      if (this.connected && now - this.heard > kSilence_ms) this.socket?.close();
    }, kWatch_ms);
    addEventListener('online', () => this.socket ?? this.open());
  }

  get connected(): boolean {
    return this.socket?.readyState === WebSocket.OPEN;
  }

  /** Sends a command; rejects with the daemon's reason, or after the timeout. */
  async request(body: Body, patience_ms = 5000): Promise<void> {
    await this.ask(body, patience_ms);
  }

  /** Sends a request; returns the moment of the past that answers it, null for other requests. */
  async ask(body: Body, patience_ms = 5000): Promise<PastSnapshot | null> {
    const answer = await this.exchange(body, patience_ms);
    if (answer.$typeName === 'aprsim.v1.PastSnapshot') return answer;
    return null;
  }

  /** Plans a move without making it. */
  async preview(
    move: Extract<Body, {case: 'preview'}>['value'],
    patience_ms: number
  ): Promise<MovePlan> {
    const answer = await this.exchange({case: 'preview', value: move}, patience_ms);
    if (answer.$typeName === 'aprsim.v1.MovePreview' && answer.plan) return answer.plan;
    throw new Error('the daemon sent no plan');
  }

  /** The text of the present scene. */
  async sceneSource(): Promise<SceneSource> {
    const answer = await this.exchange({case: 'getScene', value: {}}, kBuildPatience_ms);
    if (answer.$typeName === 'aprsim.v1.SceneSource') return answer;
    throw new Error('the daemon sent no scene');
  }

  /** The cell of a scene's text, which the daemon builds beside the present one. */
  async draftScene(text: string): Promise<SceneDraft> {
    const answer = await this.exchange({case: 'draftScene', value: {text}}, kBuildPatience_ms);
    if (answer.$typeName === 'aprsim.v1.SceneDraft') return answer;
    throw new Error('the daemon sent no draft');
  }

  /** A shipped scenario; with an empty name the names of all. */
  async scenarioSource(name: string): Promise<ScenarioSource> {
    const answer = await this.exchange({case: 'getScenario', value: {name}}, kBuildPatience_ms);
    if (answer.$typeName === 'aprsim.v1.ScenarioSource') return answer;
    throw new Error('the daemon sent no scenario');
  }

  /** Has a scenario checked, without running it. */
  async checkScenario(text: string): Promise<ScenarioCheck> {
    const answer = await this.exchange({case: 'checkScenario', value: {text}}, kBuildPatience_ms);
    if (answer.$typeName === 'aprsim.v1.ScenarioCheck') return answer;
    throw new Error('the daemon sent no result');
  }

  /** Has a scenario checked and started. */
  async runScenario(name: string, text: string, seed?: bigint): Promise<void> {
    const value = {name, text, ...(seed === undefined ? {} : {seed})};
    await this.exchange({case: 'runScenario', value}, kBuildPatience_ms);
  }

  private async exchange(body: Body, patience_ms: number): Promise<Answer> {
    const id = this.nextId++;
    const answer = await new Promise<Answer>((resolve, reject) => {
      if (!this.send(body, id)) return reject(new Error('not connected to the daemon'));
      this.waiting.set(id, {resolve, reject});
      if (patience_ms === Infinity) return;
      setTimeout(() => {
        if (this.waiting.delete(id)) reject(new Error('the daemon does not answer'));
      }, patience_ms);
    });
    if (answer.$typeName === 'aprsim.v1.Outcome' && !answer.ok)
      throw new Error(answer.message || answer.field);
    return answer;
  }

  /** Sends without waiting for an answer; false without a connection. */
  send(body: Body, id = 0): boolean {
    if (!this.connected) return false;
    this.socket!.send(toBinary(ViewerRequestSchema, create(ViewerRequestSchema, {id, body})));
    return true;
  }

  private open(): void {
    const scheme = location.protocol === 'https:' ? 'wss:' : 'ws:';
    const socket = new WebSocket(`${scheme}//${location.host}/ws`);
    socket.binaryType = 'arraybuffer';
    this.socket = socket;
    this.heard = performance.now();
    let opened = false;
    socket.onopen = () => {
      opened = true;
      this.pause_ms = 250;
      this.onState(true, 0, '');
    };
    socket.onmessage = (event: MessageEvent<ArrayBuffer>) => {
      this.heard = performance.now();
      const update = fromBinary(ViewerUpdateSchema, new Uint8Array(event.data));
      const {body} = update;
      switch (body.case) {
        case 'outcome':
        case 'past':
        case 'preview':
        case 'scene':
        case 'draft':
        case 'scenario':
        case 'scenarioCheck':
          this.waiting.get(body.value.id)?.resolve(body.value);
          this.waiting.delete(body.value.id);
      }
      this.pass(update);
    };
    socket.onclose = () => {
      if (this.socket !== socket) return;
      this.socket = null;
      for (const {reject} of this.waiting.values())
        reject(new Error('the connection to the daemon has been lost'));
      this.waiting.clear();
      this.onState(false, this.pause_ms / 1000, '');
      if (!opened) void this.askWhy();
      setTimeout(() => this.socket ?? this.open(), this.pause_ms);
      this.pause_ms = Math.min(this.pause_ms * 1.6, kLongestPause_ms);
    };
  }

  private pass(update: ViewerUpdate): void {
    if (update.body.case === 'snapshot') {
      // After the messages that have come already.
      if (!this.snapshot) this.later.port2.postMessage(null);
      this.snapshot = update;
      return;
    }
    this.passSnapshot();
    this.onUpdate(update);
  }

  private passSnapshot(): void {
    const {snapshot} = this;
    this.snapshot = null;
    if (snapshot) this.onUpdate(snapshot);
  }

  /** Browsers hide the reason of a refused WebSocket; a plain GET of its address returns it. */
  private async askWhy(): Promise<void> {
    try {
      const answer = await fetch('/ws');
      if (answer.status === 503 && !this.connected)
        this.onState(false, this.pause_ms / 1000, (await sentence(answer)).trim());
    } catch {
      // The daemon is not reachable.
    }
  }
}

async function sentence(answer: Response): Promise<string> {
  const body = await answer.text();
  if (!/html/.test(answer.headers.get('content-type') ?? '')) return body;
  return new DOMParser().parseFromString(body, 'text/html').querySelector('p')?.textContent ?? '';
}
