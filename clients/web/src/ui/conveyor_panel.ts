// The belt's drive and the registers of its PLC.
import {
  ConveyorDirection,
  DriveFault,
  type CellDescription,
  type RegisterInfo,
  type Snapshot
} from '../protocol';
import type {State} from '../state';
import type {Access} from './access';
import {button, card, Facts, h, text} from './dom';
import {CurtainCard} from './curtain_card';
import {counts, engineering, isBit} from './named_registers';
import {RegisterInput} from './register_input';
import {units} from './units';

const kFaults: Record<number, string> = {
  [DriveFault.UNSPECIFIED]: 'none',
  [DriveFault.EMERGENCY_STOP]: 'emergency stop',
  [DriveFault.WATCHDOG]: 'watchdog',
  [DriveFault.LIGHT_CURTAIN]: 'light curtain'
};

export class ConveyorPanel {
  readonly element = h('div', {class: 'panel'});
  private readonly facts = new Facts();
  private readonly speed = h('input', {
    type: 'range',
    min: 0,
    max: 1,
    step: 'any',
    value: 0,
    'aria-label': 'Belt speed'
  });
  private readonly table = h('tbody');
  private rows: {hex: HTMLElement; value: HTMLElement}[] = [];
  private stop: HTMLButtonElement | null = null;
  private setting = false;
  private readonly curtain: CurtainCard;

  constructor(
    private readonly state: State,
    private readonly access: Access
  ) {
    this.curtain = new CurtainCard(state, access);
    state.cellChanged.on((cell) => this.build(cell));
    state.display.on((snapshot) => this.show(snapshot));
    state.registersChanged.on((values) => this.showRegisters(values));
  }

  private drive(
    value: Extract<Parameters<Access['command']>[0], {case: 'conveyor'}>['value']
  ): void {
    void this.access.command({case: 'conveyor', value});
  }

  private build(cell: CellDescription): void {
    const belt = cell.conveyor;
    if (!belt) {
      this.element.replaceChildren(card('Conveyor', h('p', {}, 'This cell has no conveyor.')));
      return;
    }
    this.speed.max = String(belt.maxSpeedMS);
    this.speed.addEventListener('input', () => (this.setting = true));
    this.speed.addEventListener('change', () => {
      this.setting = false;
      this.drive({speedMS: Number(this.speed.value)});
    });
    const guard = (control: HTMLButtonElement): HTMLButtonElement => this.access.guard(control);
    this.stop = guard(
      button(
        'Emergency stop',
        () => this.drive({emergencyStop: !this.state.snapshot?.conveyor?.emergencyStop}),
        {class: 'danger'}
      )
    );
    const run = (direction: ConveyorDirection): void => {
      const speed = Number(this.speed.value) || belt.maxSpeedMS / 2;
      this.drive({run: true, direction, speedMS: speed});
    };
    this.access.guard(this.speed);
    this.element.replaceChildren(
      card(
        'Conveyor',
        this.facts.element,
        h('label', {class: 'row slider'}, 'speed', this.speed),
        h(
          'div',
          {class: 'row'},
          guard(button('◀ Reverse', () => run(ConveyorDirection.REVERSE))),
          guard(button('Stop', () => this.drive({run: false}))),
          guard(
            button('Forward ▶', () => run(ConveyorDirection.FORWARD), {
              'data-testid': 'belt-forward'
            })
          ),
          this.stop,
          guard(button('Reset fault', () => this.drive({faultReset: true})))
        )
      ),
      this.curtain.element,
      card(
        'Registers',
        h(
          'div',
          {class: 'scroll', tabindex: 0, role: 'region', 'aria-label': 'Registers'},
          h(
            'table',
            {class: 'registers', 'data-testid': 'registers'},
            h(
              'thead',
              {},
              h(
                'tr',
                {},
                ...['address', 'name', 'value', 'write'].map((t) => h('th', {scope: 'col'}, t))
              )
            ),
            this.table
          )
        )
      )
    );
    this.rows = [];
  }

  private show(snapshot: Snapshot): void {
    const c = snapshot.conveyor;
    if (!c) return;
    this.facts.set(
      'drive',
      c.run ? (c.forward ? 'forward' : 'reverse') : 'stopped',
      c.run ? 'busy' : ''
    );
    this.facts.set('speed', `${units.lengthText(c.speedMS)} ${units.length}/s`);
    this.facts.set('set to', `${units.lengthText(c.speedSettingMS)} ${units.length}/s`);
    this.facts.set('travel', `${units.lengthText(c.travelM)} ${units.length}`);
    this.facts.set('fault', kFaults[c.fault] ?? '?', c.fault ? 'bad' : '');
    this.facts.set('current', `${c.motorCurrentA.toFixed(2)} A`);
    this.facts.set('load', `${c.loadKg.toFixed(2)} kg`);
    c.photoEyes.forEach((eye, i) => {
      const name = this.state.cell?.conveyor?.photoEyes[i]?.name ?? String(i + 1);
      this.facts.set(
        `eye ${name}`,
        `${eye.broken ? 'broken' : 'clear'}, ${eye.count} counted`,
        eye.broken ? 'busy' : ''
      );
    });
    if (this.stop) {
      text(this.stop, c.emergencyStop ? 'Release emergency stop' : 'Emergency stop');
      this.stop.classList.toggle('held', c.emergencyStop);
    }
    if (!this.setting && document.activeElement !== this.speed)
      this.speed.value = String(c.speedSettingMS);
  }

  private showRegisters(values: number[]): void {
    const map = this.state.registerMap;
    if (this.rows.length !== map.length) this.buildRows(map);
    values.forEach((raw, i) => {
      const info = map[i],
        row = this.rows[i];
      if (!info || !row) return;
      text(
        row.hex,
        isBit(info.area)
          ? String(raw)
          : `0x${raw
              .toString(16)
              .toUpperCase()
              .padStart(4 * info.words, '0')}`
      );
      text(row.value, valueText(info, raw));
    });
  }

  private buildRows(map: RegisterInfo[]): void {
    this.rows = map.map(() => ({hex: h('code'), value: h('span')}));
    this.table.replaceChildren(
      ...map.map((info, i) =>
        h(
          'tr',
          {title: info.meaning, 'data-testid': `register-${info.area}-${info.name}`},
          h(
            'td',
            {},
            h('code', {}, `0x${info.address.toString(16).toUpperCase()}`),
            h('small', {}, info.area)
          ),
          h('td', {}, info.name),
          h('td', {}, this.rows[i]!.value, h('small', {}, this.rows[i]!.hex)),
          h(
            'td',
            {},
            info.writable ? new RegisterInput(info, this.state, this.access).element : null
          )
        )
      )
    );
  }
}

function valueText(info: RegisterInfo, raw: number): string {
  if (isBit(info.area)) return raw ? 'on' : 'off';
  return engineering(info, raw) || String(counts(info, raw));
}
