// The units in which people read lengths and angles. The wire is SI throughout.
import {Signal} from '../state';

export type Length = 'mm' | 'm' | 'in';
export type Angle = 'deg' | 'rad';

const kPerMetre: Record<Length, number> = {mm: 1000, m: 1, in: 1 / 0.0254};
const kLengthDigits: Record<Length, number> = {mm: 2, m: 5, in: 4};

class Units {
  readonly changed = new Signal<void>();
  length: Length = (localStorage.getItem('length') as Length | null) ?? 'mm';
  angle: Angle = (localStorage.getItem('angle') as Angle | null) ?? 'deg';

  set(length: Length, angle: Angle): void {
    this.length = length;
    this.angle = angle;
    localStorage.setItem('length', length);
    localStorage.setItem('angle', angle);
    this.changed.emit();
  }

  lengthOf(m: number): number {
    return m * kPerMetre[this.length];
  }
  metres(value: number): number {
    return value / kPerMetre[this.length];
  }
  angleOf(rad: number): number {
    return this.angle === 'deg' ? (rad * 180) / Math.PI : rad;
  }
  radians(value: number): number {
    return this.angle === 'deg' ? (value * Math.PI) / 180 : value;
  }
  lengthText(m: number): string {
    return this.lengthOf(m).toFixed(kLengthDigits[this.length]);
  }
  angleText(rad: number): string {
    return this.angleOf(rad).toFixed(this.angle === 'deg' ? 2 : 4);
  }
  get angleSign(): string {
    return this.angle === 'deg' ? '°' : 'rad';
  }
}

export const units = new Units();
