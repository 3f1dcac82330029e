// Modbus/TCP messages as text.
import type {NamedRegister} from './named_registers';

const kFunctions: Record<number, string> = {
  1: 'read coils',
  2: 'read discrete inputs',
  3: 'read holding registers',
  4: 'read input registers',
  5: 'write coil',
  6: 'write register',
  15: 'write coils',
  16: 'write registers',
  22: 'mask write register',
  23: 'read/write registers',
  43: 'device identification'
};
const kExceptions: Record<number, string> = {
  1: 'illegal function',
  2: 'illegal data address',
  3: 'illegal data value',
  4: 'server device failure',
  6: 'server device busy',
  11: 'gateway target failed to respond'
};
const kAreas: Record<number, string> = {
  1: 'coil',
  2: 'discrete',
  3: 'holding',
  4: 'input',
  5: 'coil',
  6: 'holding',
  15: 'coil',
  16: 'holding',
  22: 'holding',
  23: 'holding'
};
const kMaxValues = 16;

export interface ModbusLine {
  type: string;
  summary: string;
  bad: boolean;
}

const hex = (value: number, digits = 4): string =>
  `0x${value.toString(16).toUpperCase().padStart(digits, '0')}`;

/** Requests and replies of one server with the names of its registers. */
export class ModbusText {
  constructor(private readonly registers: NamedRegister[]) {}

  /** `request`: the request of a reply, if known. */
  line(data: Uint8Array, fromClient: boolean, request?: Uint8Array): ModbusLine {
    if (data.length < 8) return {type: 'fragment', summary: '', bad: true};
    const code = data[7]! & 0x7f;
    const type = `${code} ${kFunctions[code] ?? 'function'}`;
    if (data[7]! >= 0x80) {
      const cause = kExceptions[data[8] ?? 0] ?? '?';
      const about = request ? ` (${this.asked(request)})` : '';
      return {type, summary: `exception ${data[8]}: ${cause}${about}`, bad: true};
    }
    return {
      type,
      summary: fromClient ? this.asked(data) : this.answered(code, data, request),
      bad: false
    };
  }

  private asked(data: Uint8Array): string {
    const code = data[7]!,
      {word, byte} = reader(data);
    const area = kAreas[code] ?? '',
      start = this.place(area, word(0));
    switch (code) {
      case 1:
      case 2:
      case 3:
      case 4:
        return word(2) === 1 ? start : `${start} and ${word(2) - 1} more`;
      case 5:
        return this.values(area, word(0), 1, () => word(2), ' := ');
      case 6:
        return this.values(area, word(0), 1, () => word(2), ' := ');
      case 15:
        return this.values(area, word(0), word(2), bitsOf(data.subarray(13)), ' := ');
      case 16:
        return this.values(area, word(0), word(2), (i) => word(5 + 2 * i), ' := ');
      case 22:
        return `${start} and ${hex(word(2))} or ${hex(word(4))}`;
      case 23:
        return `${this.values(area, word(4), Math.min(word(6), byte(8) / 2), (i) => word(9 + 2 * i), ' := ')}; read ${this.place(area, word(0))} + ${word(2)}`;
      default:
        return '';
    }
  }

  private answered(code: number, data: Uint8Array, request?: Uint8Array): string {
    const {word, byte} = reader(data);
    if (code === 5 || code === 6 || code === 22) return this.asked(data).replace(':=', '=');
    if (code === 15 || code === 16)
      return `${this.place(kAreas[code]!, word(0))} + ${word(2)} written`;
    if (!request || !kAreas[code]) return '';
    const asked = reader(request);
    const count = code <= 2 ? asked.word(2) : byte(0) / 2;
    const at = code <= 2 ? bitsOf(data.subarray(9)) : (i: number): number => word(1 + 2 * i);
    return this.values(kAreas[code]!, asked.word(0), count, at, ' = ');
  }

  private find(area: string, address: number): NamedRegister | undefined {
    return this.registers.find((each) => each.area === area && each.address === address);
  }

  private place(area: string, address: number): string {
    const name = this.find(area, address)?.name;
    return name ? `${name} ${hex(address)}` : hex(address);
  }

  private values(
    area: string,
    start: number,
    count: number,
    at: (i: number) => number,
    sign: string
  ): string {
    const lines: string[] = [];
    for (let i = 0; i < count; ) {
      if (lines.length === kMaxValues) return `${lines.join(', ')}, …`;
      const register = this.find(area, start + i);
      const whole = register !== undefined && i + register.words <= count;
      const words = Array.from({length: whole ? register.words : 1}, (_, k) => at(i + k));
      const text = whole ? register.text(words) : plain(area, words[0]!);
      lines.push(`${this.place(area, start + i)}${sign}${text}`);
      i += words.length;
    }
    return lines.join(', ');
  }
}

function plain(area: string, word: number): string {
  if (area === 'coil' || area === 'discrete') return word ? 'on' : 'off';
  return String(word);
}

/** Reader of the data after the function code. */
function reader(data: Uint8Array) {
  const body = data.subarray(8);
  const byte = (at: number): number => body[at] ?? 0;
  return {byte, word: (at: number): number => (byte(at) << 8) | byte(at + 1)};
}

function bitsOf(bytes: Uint8Array): (i: number) => number {
  return (i) => ((bytes[i >> 3] ?? 0) >> (i & 7)) & 1;
}

export function hexOf(data: Uint8Array): string {
  return [...data].map((b) => b.toString(16).padStart(2, '0').toUpperCase()).join(' ');
}

export function modbusDump(data: Uint8Array): string {
  const lines: string[] = [];
  for (let i = 0; i < data.length; i += 16)
    lines.push(`${i.toString(16).padStart(4, '0')}  ${hexOf(data.subarray(i, i + 16))}`);
  return lines.join('\n');
}
