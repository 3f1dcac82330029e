// The preview of a move: what it would do, in words and in the view, and the button that makes it.
import type {MovePlan, MoveTool, RobotState} from '../protocol';
import type {CellView} from '../scene/cell_view';
import type {State} from '../state';
import type {Access} from './access';
import {button, h, notify, text} from './dom';
import {units} from './units';

/** A search for a way round takes some seconds, more on a busy machine. */
const kPatience_ms = 60000;

export class MovePreview {
  readonly element: HTMLElement;
  private readonly words = h('p', {role: 'status', 'aria-live': 'polite'});
  private readonly straight = button('', () => void this.turn());
  private readonly go: HTMLButtonElement;
  private move: MoveTool | null = null;
  private plan: MovePlan | null = null;
  private ticket = 0n; // of the robot's command before the move
  private epoch = 0n;
  private asked = 0; // previews so far; only the last one is shown

  constructor(
    private readonly state: State,
    private readonly access: Access,
    private readonly view: CellView,
    private readonly robot: number,
    name: string,
    notReady: () => string
  ) {
    this.go = access.guard(
      button('Go', () => this.make(), {
        'data-testid': `${name}-preview-go`,
        title: 'Make the move of the preview'
      }),
      () => notReady() || this.refusal
    );
    this.straight.dataset.testid = `${name}-preview-straight`;
    this.words.dataset.testid = `${name}-preview-text`;
    this.element = h(
      'div',
      {class: 'preview', role: 'group', 'aria-label': `Preview for ${name}`, hidden: true},
      this.words,
      h(
        'div',
        {class: 'row'},
        this.go,
        this.straight,
        button('Close', () => void this.close(), {
          'data-testid': `${name}-preview-close`,
          title: 'Close the preview (Escape)'
        })
      )
    );
    this.element.dataset.testid = `${name}-preview`;
  }

  /** Plans the move and shows it. */
  async show(move: MoveTool): Promise<void> {
    const number = ++this.asked;
    this.view.showPlan(null);
    this.plan = null;
    this.move = move;
    this.ticket = this.now?.action?.ticket ?? 0n;
    this.epoch = this.state.snapshot?.epoch ?? 0n;
    this.render();
    try {
      const plan = await this.state.connection.preview(
        {robot: this.robot, action: {case: 'moveTool', value: move}},
        kPatience_ms
      );
      if (number !== this.asked) return;
      this.plan = plan;
      this.view.showPlan({robot: this.robot, plan});
      this.render();
    } catch (problem) {
      if (number !== this.asked) return;
      this.close();
      notify(units.inText((problem as Error).message), 'error');
    }
  }

  /** Returns false where no preview was open. */
  close(): boolean {
    if (!this.move) return false;
    ++this.asked;
    this.move = this.plan = null;
    this.view.showPlan(null);
    this.render();
    return true;
  }

  /** A preview ends with the next command to the robot, from anywhere, and with a reset. */
  update(robot: RobotState): void {
    if (!this.move) return;
    if (robot.action?.ticket !== this.ticket && (robot.action || this.ticket !== 0n)) this.close();
    else if (this.state.snapshot?.epoch !== this.epoch) this.close();
  }

  /** Writes the text again, as after a change of units. */
  render(): void {
    const {move, plan} = this;
    const held = this.element.contains(document.activeElement);
    this.element.hidden = move === null;
    if (!move) {
      text(this.words, '');
      if (held) this.opener?.focus();
      return;
    }
    text(this.words, plan ? sentence(move, plan) : 'The move is being planned ...');
    this.words.classList.toggle('bad', plan !== null && (!plan.possible || Boolean(plan.touch)));
    text(this.straight, move.straight ? 'As a free move' : 'As a straight line');
    this.straight.title = 'Preview the other kind of move to the same target';
    this.straight.disabled = plan === null;
    this.access.update();
  }

  /** Takes the focus when the preview closes. */
  opener: HTMLElement | null = null;

  private get now(): RobotState | undefined {
    return this.state.snapshot?.robots[this.robot];
  }

  private get refusal(): string {
    if (!this.plan) return 'The move is being planned.';
    return this.plan.possible ? '' : 'The move would be refused.';
  }

  private async turn(): Promise<void> {
    if (this.move) await this.show({...this.move, straight: !this.move.straight});
  }

  private make(): void {
    const {move} = this;
    this.close();
    if (!move) return;
    void this.access.command({
      case: 'robot',
      value: {robot: this.robot, action: {case: 'moveTool', value: move}}
    });
  }
}

function sentence(move: MoveTool, plan: MovePlan): string {
  const kind = move.straight ? 'straight line' : 'free move';
  if (!plan.possible) return `This ${kind} would be refused: ${units.inText(plan.refusal)}`;
  const length = `${units.lengthText(plan.lengthM)} ${units.length}`;
  const way = `This ${kind} takes ${seconds(plan.duration)} s for ${length}.`;
  const {touch} = plan;
  if (!touch) return way;
  return `${way} Direct moves are not checked: ${touch.mover} would touch ${touch.other} after ${seconds(touch.time)} s.`;
}

function seconds(span: MovePlan['duration']): string {
  return (span ? Number(span.seconds) + span.nanos * 1e-9 : 0).toFixed(2);
}
