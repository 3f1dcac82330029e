// Registers of Modbus servers, with names and with texts of their values.
import {
  type ModbusServer,
  RegisterArea,
  RegisterEncoding,
  type RegisterInfo,
  WordOrder
} from '../protocol';

export interface NamedRegister {
  area: string; // 'coil', 'discrete', 'input' or 'holding'
  address: number; // the first
  words: number;
  name: string;
  /** Text of the value that these words, by address, have. */
  text(words: number[]): string;
}

const kAreas: Record<RegisterArea, string> = {
  [RegisterArea.UNSPECIFIED]: '',
  [RegisterArea.COIL]: 'coil',
  [RegisterArea.DISCRETE_INPUT]: 'discrete',
  [RegisterArea.INPUT_REGISTER]: 'input',
  [RegisterArea.HOLDING_REGISTER]: 'holding'
};

export function isBit(area: string): boolean {
  return area === 'coil' || area === 'discrete';
}

/** Counts as a signed or unsigned number. */
export function counts(info: RegisterInfo, raw: number): number {
  return info.isSigned ? signed(raw, info.words) : raw;
}

/** Counts as a physical value; empty for plain numbers. */
export function engineering(info: RegisterInfo, raw: number): string {
  if (info.resolution === 0) return '';
  const digits = Math.max(0, Math.min(6, Math.ceil(-Math.log10(info.resolution) - 1e-6)));
  return `${(counts(info, raw) * info.resolution).toFixed(digits)} ${info.unit}`;
}

/** Those of the conveyor's PLC. */
export function conveyorRegisters(map: RegisterInfo[]): NamedRegister[] {
  return map.map((info) => ({
    area: info.area,
    address: info.address,
    words: info.words,
    name: info.name,
    text: (words) => {
      const raw = joined(words);
      if (isBit(info.area)) return raw ? 'on' : 'off';
      const scaled = engineering(info, raw);
      return scaled ? `${counts(info, raw)} (${scaled})` : String(counts(info, raw));
    }
  }));
}

/** Those of a server that the scene describes; their names are signals. */
export function mapRegisters(server: ModbusServer): NamedRegister[] {
  return server.registers.map(({signal, area, address, encoding, wordOrder, scale, offset}) => ({
    area: kAreas[area],
    address,
    words: encoding >= RegisterEncoding.UINT32 ? 2 : 1,
    name: signal,
    text: (words) => {
      const ordered = wordOrder === WordOrder.LOW_FIRST ? [...words].reverse() : words;
      const count = number(ordered, encoding);
      if (encoding === RegisterEncoding.BIT) return count ? 'on' : 'off';
      if (scale === 1 && offset === 0) return short(count);
      return `${short(count)} (${short(count * scale + offset)})`;
    }
  }));
}

function number(words: number[], encoding: RegisterEncoding): number {
  const raw = joined(words);
  switch (encoding) {
    case RegisterEncoding.INT16:
    case RegisterEncoding.INT32:
      return signed(raw, words.length);
    case RegisterEncoding.FLOAT32: {
      const view = new DataView(new ArrayBuffer(4));
      view.setUint32(0, raw);
      return view.getFloat32(0);
    }
    default:
      return raw;
  }
}

function joined(words: number[]): number {
  return words.reduce((high, word) => high * 65536 + word, 0);
}

function signed(raw: number, words: number): number {
  const wrap = 2 ** (16 * words);
  return raw >= wrap / 2 ? raw - wrap : raw;
}

/** With the digits that a float of single precision has. */
function short(value: number): string {
  return Number.isInteger(value) ? String(value) : String(Number(value.toPrecision(7)));
}
