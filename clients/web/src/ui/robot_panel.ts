// The pendant of one robot: its state, joints, tool and gripper.
import {create} from '@bufbuild/protobuf';
import {
  ActionKind,
  MoveToolSchema,
  PlanningMode,
  type MoveTool,
  type Pose,
  type RobotDescription,
  type RobotState
} from '../protocol';
import {commanderOf, kNotReady, statusOf} from '../robot_status';
import type {State} from '../state';
import type {CellView} from '../scene/cell_view';
import type {Access} from './access';
import {button, card, Facts, h, notify, text} from './dom';
import type {Jog} from './jog';
import {MovePreview} from './move_preview';
import {fromRollPitchYaw, toRollPitchYaw} from './rotation';
import {units, type Angle, type Length} from './units';

const kCommands: Record<number, string> = {
  [ActionKind.INITIALIZE]: 'get ready',
  [ActionKind.END]: 'end',
  [ActionKind.STOP]: 'stop',
  [ActionKind.MOVE_TO]: 'move to',
  [ActionKind.MOVE_THROUGH_TO]: 'move through to',
  [ActionKind.MOVE_SCREW]: 'screw',
  [ActionKind.MOVE_JOINTS]: 'move joints',
  [ActionKind.GRIPPER]: 'gripper',
  [ActionKind.GRIPPER_FORCE]: 'gripper force',
  [ActionKind.TOOL_CHANGER]: 'tool changer',
  [ActionKind.OVERRIDE]: 'speed override',
  [ActionKind.DWELL]: 'dwell',
  [ActionKind.MOTION_LIMIT]: 'speed limit',
  [ActionKind.PLANNING]: 'planning'
};

const kPlanning: [PlanningMode, string][] = [
  [PlanningMode.DIRECT, 'direct moves'],
  [PlanningMode.CHECK, 'refuse collisions'],
  [PlanningMode.AVOID, 'go round obstacles']
];

const kAxes = ['x', 'y', 'z'] as const;

export class RobotPanel {
  readonly element: HTMLElement;
  private readonly description = h('p', {class: 'description', 'data-testid': 'robot-description'});
  private readonly facts = new Facts();
  private readonly bars: {
    fill: HTMLMeterElement;
    value: HTMLElement;
    lower: HTMLElement;
    upper: HTMLElement;
  }[] = [];
  private readonly planning = h(
    'select',
    {title: 'How moves regard what stands around the robot', 'aria-label': 'Moves'},
    ...kPlanning.map(([mode, label]) => h('option', {value: String(mode)}, label))
  );
  private readonly preview: MovePreview;
  private readonly pose: HTMLInputElement[] = [];
  private readonly poseUnits: HTMLElement[] = [];
  private readonly poseNow: HTMLElement[] = [];
  private readonly frame = h(
    'select',
    {'aria-label': 'Frame of tool jogs'},
    h('option', {value: 'base'}, 'base frame'),
    h('option', {value: 'tool'}, 'tool frame')
  );

  constructor(
    private readonly state: State,
    private readonly access: Access,
    private readonly jog: Jog,
    private readonly view: CellView,
    private readonly robot: RobotDescription,
    private readonly index: number
  ) {
    this.preview = new MovePreview(state, access, view, index, robot.name, () => this.ready());
    this.element = h(
      'div',
      {class: 'robot', 'data-testid': `robot-${robot.name}`},
      this.statusCard(),
      this.jointCard(),
      this.toolCard(),
      this.gripperCard()
    );
  }

  private command(action: Parameters<RobotPanel['send']>[0]): void {
    void this.send(action);
  }
  private send(
    action: NonNullable<
      Extract<Parameters<Access['command']>[0], {case: 'robot'}>['value']['action']
    >
  ): Promise<boolean> {
    return this.access.command({case: 'robot', value: {robot: this.index, action}});
  }

  private async setPlanning(): Promise<void> {
    const done = await this.send({case: 'planning', value: Number(this.planning.value)});
    const now = this.state.snapshot?.robots[this.index];
    if (!done && now) this.planning.value = String(now.planning);
  }

  private ready(): string {
    const state = this.state.snapshot?.robots[this.index];
    return state && !state.initialized ? kNotReady : '';
  }

  private statusCard(): HTMLElement {
    const init = this.access.guard(
      button('Make ready', () => this.command({case: 'initialize', value: {}}), {
        'data-testid': `init-${this.robot.name}`,
        title: 'Clear the error and accept commands, as InitCanon does'
      })
    );
    const look = button('View', () => this.view.focusRobot(this.index), {
      title: 'Turn the view to the front of this robot',
      hidden: !this.view.draws,
      'data-testid': `look-${this.robot.name}`
    });
    this.planning.dataset.testid = `planning-${this.robot.name}`;
    this.planning.addEventListener('change', () => void this.setPlanning());
    return h(
      'section',
      {class: 'card robot-status', 'aria-label': `State of ${this.robot.name}`},
      this.description,
      this.facts.element,
      h('div', {class: 'actions'}, init, look, this.access.guard(this.planning))
    );
  }

  private jointCard(): HTMLElement {
    const rows = this.robot.joints.map((joint, i) => {
      const fill = h('meter', {
        min: joint.lowerRad,
        max: joint.upperRad,
        value: 0,
        'aria-label': `${joint.name} within its limits`
      });
      const value = h('output', {'data-testid': `${this.robot.name}-joint-${i + 1}`});
      const lower = h('span'),
        upper = h('span');
      this.bars.push({fill, value, lower, upper});
      const jog = (negative: boolean): HTMLButtonElement =>
        this.jog.makeButton(
          negative ? '−' : '+',
          `${this.robot.name} joint ${i + 1} ${negative ? 'minus' : 'plus'}`,
          this.index,
          () => ({case: 'joint', value: {joint: i, negative}})
        );
      return h(
        'div',
        {class: 'joint'},
        h('span', {}, `J${i + 1}`),
        jog(true),
        jog(false),
        h('small', {}, lower),
        fill,
        h('small', {}, upper),
        value
      );
    });
    return card('Joints', h('div', {class: 'joints'}, ...rows));
  }

  private toolCard(): HTMLElement {
    const jogRow = (label: string, kind: 'along' | 'about'): HTMLElement =>
      h(
        'div',
        {class: 'jogs'},
        h('span', {}, label),
        ...kAxes.flatMap((axis) =>
          [-1, 1].map((sign) =>
            this.jog.makeButton(
              `${sign < 0 ? '−' : '+'}${kind === 'about' ? 'r' : ''}${axis}`,
              `${this.robot.name} ${kind} ${sign < 0 ? '-' : '+'}${axis}`,
              this.index,
              () => this.toolDirection(kind, axis, sign)
            )
          )
        )
      );
    const names = ['x', 'y', 'z', 'roll', 'pitch', 'yaw'];
    const fields = names.map((name) => {
      const input = h('input', {
        type: 'number',
        step: 'any',
        'aria-label': `target ${name} of ${this.robot.name}`,
        'data-testid': `${this.robot.name}-target-${name}`,
        oninput: () => this.closePreview()
      });
      const now = h('output', {'data-testid': `${this.robot.name}-tcp-${name}`});
      const unit = h('small');
      this.pose.push(input);
      this.poseNow.push(now);
      this.poseUnits.push(unit);
      return h('div', {class: 'coordinate'}, h('span', {}, name, ' ', unit), now, input);
    });
    this.showTargetUnits();
    const go = (straight: boolean): HTMLButtonElement =>
      this.access.guard(
        button(straight ? 'Go straight' : 'Go', () => this.goTo(straight), {
          'data-testid': `${this.robot.name}-go${straight ? '-straight' : ''}`,
          title: straight
            ? 'Move the tool to the target on a straight line'
            : 'Move the tool to the target, all joints together'
        }),
        () => this.ready()
      );
    const look = this.access.guard(
      button('Preview', () => this.showPreview(), {
        'data-testid': `${this.robot.name}-preview-open`,
        title: 'Show the way to the target without moving'
      }),
      () => this.ready()
    );
    this.preview.opener = look;
    return h(
      'section',
      {class: 'card'},
      h('div', {class: 'row head'}, h('h2', {}, 'Tool'), this.frame),
      h('div', {class: 'pose'}, ...fields),
      h(
        'div',
        {class: 'row'},
        button('Current pose', () => this.fillTarget(), {
          title: 'Copy the current pose into the target'
        }),
        look,
        go(false),
        go(true)
      ),
      this.preview.element,
      jogRow('move', 'along'),
      jogRow('turn', 'about')
    );
  }

  private gripperCard(): HTMLElement {
    const set = (label: string, setting: number): HTMLButtonElement =>
      this.access.guard(
        button(label, () => this.command({case: 'gripper', value: {setting}}), {
          'data-testid': `${this.robot.name}-gripper-${label.toLowerCase()}`
        }),
        () => this.ready()
      );
    return h(
      'section',
      {class: 'card gripper'},
      h('div', {class: 'row head'}, h('h2', {}, 'Gripper'), set('Open', 1), set('Close', 0)),
      this.gripper.element
    );
  }
  private readonly gripper = new Facts();

  private toolDirection(kind: 'along' | 'about', axis: 'x' | 'y' | 'z', sign: number) {
    const vector = {x: 0, y: 0, z: 0, [axis]: sign};
    return {
      case: 'tool' as const,
      value: {[kind]: vector, inToolFrame: this.frame.value === 'tool'}
    };
  }

  private fillTarget(): void {
    const pose = this.state.snapshot?.robots[this.index]?.toolInReference;
    if (!pose?.positionM) return;
    this.fillPosition(pose.positionM);
    this.fillRotation(pose);
  }

  /** Sets the target to a position in the robot's CRCL frame. Keeps the target's rotation; an empty one
   * becomes the tool's current rotation. */
  setTarget(positionM: {x: number; y: number; z: number}): void {
    this.fillPosition(positionM);
    const pose = this.state.snapshot?.robots[this.index]?.toolInReference;
    if (this.pose.slice(3).some((input) => input.value === '') && pose) this.fillRotation(pose);
    this.pose[0]!.scrollIntoView({block: 'center'});
    this.pose[0]!.focus({preventScroll: true});
  }

  private fillPosition({x, y, z}: {x: number; y: number; z: number}): void {
    [x, y, z].forEach((v, i) => (this.pose[i]!.value = String(Number(units.lengthText(v)))));
  }

  private fillRotation(pose: Pose): void {
    toRollPitchYaw(pose.orientation).forEach(
      (v, i) => (this.pose[3 + i]!.value = String(Number(units.angleText(v))))
    );
  }

  private showTargetUnits(): void {
    this.poseUnits.forEach((unit, i) => text(unit, i < 3 ? units.length : units.angleSign));
  }

  /** Converts the target to the new units; its pose stays the same. */
  changeUnits(before: {length: Length; angle: Angle}): void {
    this.preview.render();
    this.showTargetUnits();
    this.pose.forEach((input, i) => {
      if (input.value === '') return;
      const value = Number(input.value);
      input.value = String(
        Number(
          i < 3
            ? units.lengthText(units.metres(value, before.length))
            : units.angleText(units.radians(value, before.angle))
        )
      );
    });
  }

  private goTo(straight: boolean): void {
    const move = this.target(straight);
    if (move) this.command({case: 'moveTool', value: move});
  }

  private showPreview(): void {
    const move = this.target(false);
    if (move) void this.preview.show(move);
  }

  /** Returns false where no preview was open. */
  closePreview(): boolean {
    return this.preview.close();
  }

  /** The move to the target; null, with a notice, where a number is missing. */
  private target(straight: boolean): MoveTool | null {
    const values = this.pose.map((input) => (input.value === '' ? NaN : Number(input.value)));
    if (values.some((v) => !Number.isFinite(v))) {
      notify('Fill in all six numbers of the target; "Current pose" fills them.', 'error');
      return null;
    }
    const [x, y, z] = values.slice(0, 3).map((v) => units.metres(v)) as [number, number, number];
    const [roll, pitch, yaw] = values.slice(3).map((v) => units.radians(v)) as [
      number,
      number,
      number
    ];
    return create(MoveToolSchema, {
      toolInReference: {positionM: {x, y, z}, orientation: fromRollPitchYaw(roll, pitch, yaw)},
      straight,
      speed: this.jog.share
    });
  }

  update(robot: RobotState): void {
    this.preview.update(robot);
    this.showStatus(robot);
    robot.joints.forEach((joint, i) => {
      const limits = this.robot.joints[i],
        bar = this.bars[i];
      if (!limits || !bar) return;
      bar.fill.value = joint.positionRad;
      const edge =
        Math.min(joint.positionRad - limits.lowerRad, limits.upperRad - joint.positionRad) <
        (limits.prismatic ? 0.005 : 0.05);
      bar.fill.classList.toggle('edge', edge);
      if (limits.prismatic) {
        text(bar.value, `${units.lengthText(joint.positionRad)} ${units.length}`);
        text(bar.lower, String(Number(units.lengthOf(limits.lowerRad).toPrecision(3))));
        text(bar.upper, String(Number(units.lengthOf(limits.upperRad).toPrecision(3))));
        return;
      }
      text(bar.value, `${units.angleText(joint.positionRad)} ${units.angleSign}`);
      const digits = units.angle === 'deg' ? 0 : 2;
      text(bar.lower, units.angleOf(limits.lowerRad).toFixed(digits));
      text(bar.upper, units.angleOf(limits.upperRad).toFixed(digits));
    });
    const pose = robot.toolInReference,
      p = pose?.positionM;
    if (p) [p.x, p.y, p.z].forEach((v, i) => text(this.poseNow[i]!, units.lengthText(v)));
    toRollPitchYaw(pose?.orientation).forEach((v, i) =>
      text(this.poseNow[3 + i]!, units.angleText(v))
    );
    const g = robot.gripper;
    if (!g) return;
    this.gripper.set('commanded', g.setting >= 0.5 ? 'open' : 'closed');
    this.gripper.set('separation', `${units.lengthText(g.separationM)} ${units.length}`);
    this.gripper.set(
      'force',
      `${(g.forceN[0] ?? 0).toFixed(1)} / ${(g.forceN[1] ?? 0).toFixed(1)} N`
    );
    this.gripper.set(
      'holds',
      g.holding ? g.heldBody || 'something' : 'nothing',
      g.holding ? 'good' : ''
    );
  }

  private showStatus(robot: RobotState): void {
    text(this.description, units.inText(robot.action?.description ?? ''));
    this.description.hidden = statusOf(robot).stopped !== ''; // then told beside the state of the robot
    const mode = String(robot.planning);
    // A choice that is being made stays.
    if (document.activeElement !== this.planning && this.planning.value !== mode) {
      this.planning.value = mode;
    }
    this.facts.set('ready', robot.initialized ? 'yes' : 'no', robot.initialized ? 'good' : '');
    const f = robot.toolForceN;
    this.facts.set('tool force', f ? `${Math.hypot(f.x, f.y, f.z).toFixed(1)} N` : '–');
    this.facts.set('drives', robot.drivesOn ? 'on' : 'off, brakes hold');
    this.facts.set(
      'last command',
      robot.action?.ticket
        ? `${kCommands[robot.action.kind] ?? '?'} (no. ${robot.action.ticket})`
        : 'none'
    );
    const alarm = robot.motion?.alarm ?? '';
    this.facts.set(
      'commander',
      alarm ? `none, ${units.inText(alarm)}` : commanderOf(robot.motion),
      alarm ? 'bad' : ''
    );
  }
}
