// What a Modbus/TCP message says, in a line and in words.

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

const hex = (value: number, digits = 4): string =>
  `0x${value.toString(16).toUpperCase().padStart(digits, '0')}`;

export function modbusLine(
  data: Uint8Array,
  fromClient: boolean
): {type: string; summary: string; bad: boolean} {
  if (data.length < 8) return {type: 'fragment', summary: '', bad: true};
  const code = data[7]!,
    body = data.subarray(8);
  const word = (at: number): number => ((body[at] ?? 0) << 8) | (body[at + 1] ?? 0);
  const type = `${code & 0x7f} ${kFunctions[code & 0x7f] ?? 'function'}`;
  if (code >= 0x80)
    return {type, summary: `exception ${body[0]}: ${kExceptions[body[0] ?? 0] ?? '?'}`, bad: true};
  if (fromClient) {
    if (code === 5 || code === 6)
      return {type, summary: `${hex(word(0))} := ${word(2)} (${hex(word(2))})`, bad: false};
    if (code === 15 || code === 16) {
      const words =
        code === 16 ? Array.from({length: word(2)}, (_, i) => word(5 + 2 * i)).join(' ') : '';
      return {type, summary: `${hex(word(0))} + ${word(2)} := ${words}`, bad: false};
    }
    return {type, summary: code <= 4 ? `${hex(word(0))} + ${word(2)}` : '', bad: false};
  }
  if (code === 3 || code === 4) {
    const count = Math.min((body[0] ?? 0) / 2, 24);
    return {
      type,
      summary: Array.from({length: count}, (_, i) => word(1 + 2 * i)).join(' '),
      bad: false
    };
  }
  return {
    type,
    summary: code <= 2 ? [...body.subarray(1)].map((b) => hex(b, 2)).join(' ') : 'ok',
    bad: false
  };
}

export function modbusDump(data: Uint8Array): string {
  const bytes = [...data].map((b) => b.toString(16).padStart(2, '0').toUpperCase());
  const lines: string[] = [];
  for (let i = 0; i < bytes.length; i += 16)
    lines.push(`${i.toString(16).padStart(4, '0')}  ${bytes.slice(i, i + 16).join(' ')}`);
  return lines.join('\n');
}
