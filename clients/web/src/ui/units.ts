// Display units of lengths and angles. The protocol uses SI.
import {Signal} from '../state';
import {h} from './dom';

export type Length = 'mm' | 'm' | 'in';
export type Angle = 'deg' | 'rad';

const kPerMetre: Record<Length, number> = {mm: 1000, m: 1, in: 1 / 0.0254};
const kPerRadian: Record<Angle, number> = {deg: 180 / Math.PI, rad: 1};
const kLengthDigits: Record<Length, number> = {mm: 2, m: 5, in: 4};
const kAngleDigits: Record<Angle, number> = {deg: 2, rad: 4};
const kQuantity = /(-?\d+(?:\.\d+)?(?:e[-+]?\d+)?) (mm|m|deg|rad)(?=$|[^\w^²])/g;

/** Rounds; a result of zero has no sign. */
function rounded(value: number, digits: number): string {
  const text = value.toFixed(digits);
  return Number(text) === 0 ? (0).toFixed(digits) : text;
}

class Units {
  /** Carries the previous units. */
  readonly changed = new Signal<{length: Length; angle: Angle}>();
  length: Length = (localStorage.getItem('length') as Length | null) ?? 'mm';
  angle: Angle = (localStorage.getItem('angle') as Angle | null) ?? 'deg';

  set(length: Length, angle: Angle): void {
    const before = {length: this.length, angle: this.angle};
    this.length = length;
    this.angle = angle;
    localStorage.setItem('length', length);
    localStorage.setItem('angle', angle);
    this.changed.emit(before);
  }

  lengthOf(m: number): number {
    return m * kPerMetre[this.length];
  }
  metres(value: number, unit = this.length): number {
    return value / kPerMetre[unit];
  }
  angleOf(rad: number): number {
    return rad * kPerRadian[this.angle];
  }
  radians(value: number, unit = this.angle): number {
    return value / kPerRadian[unit];
  }
  lengthText(m: number): string {
    return rounded(this.lengthOf(m), kLengthDigits[this.length]);
  }
  angleText(rad: number): string {
    return rounded(this.angleOf(rad), kAngleDigits[this.angle]);
  }
  get angleSign(): string {
    return this.angle === 'deg' ? '°' : 'rad';
  }
  /** A speed with three significant digits. */
  speedText(m_s: number): string {
    return `${Number(this.lengthOf(m_s).toPrecision(3))} ${this.length}/s`;
  }

  /** A message of the daemon with its lengths, angles and speeds in these units. */
  inText(message: string): string {
    return message.replace(kQuantity, (whole, number: string, unit: string) => {
      const value = Number(number);
      if (unit === this.length || unit === this.angle) return whole;
      if (unit === 'deg' || unit === 'rad')
        return `${Number(this.angleText(this.radians(value, unit)))} ${this.angle}`;
      return `${Number(this.lengthText(this.metres(value, unit as Length)))} ${this.length}`;
    });
  }
}

export const units = new Units();

/** Two lists with which people choose units. */
export function unitChoice(): HTMLElement {
  const list = (label: string, names: string[]): HTMLSelectElement =>
    h(
      'select',
      {'aria-label': label, title: label},
      ...names.map((name) => h('option', {value: name}, name))
    );
  const length = list('Unit of lengths', ['mm', 'm', 'in']);
  const angle = list('Unit of angles', ['deg', 'rad']);
  length.value = units.length;
  angle.value = units.angle;
  for (const choice of [length, angle])
    choice.addEventListener('change', () =>
      units.set(length.value as Length, angle.value as Angle)
    );
  return h('div', {class: 'units', role: 'group', 'aria-label': 'Units'}, length, angle);
}
