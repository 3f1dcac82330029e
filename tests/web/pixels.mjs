// Counts what is on a screenshot. Decodes PNG as Chromium writes it: 8 bits, RGB or RGBA.
import {inflateSync} from 'node:zlib';

function decode(png) {
  const width = png.readUInt32BE(16),
    height = png.readUInt32BE(20),
    channels = png[25] === 6 ? 4 : 3;
  const data = [];
  for (let at = 8; at < png.length; ) {
    const size = png.readUInt32BE(at);
    if (png.toString('latin1', at + 4, at + 8) === 'IDAT')
      data.push(png.subarray(at + 8, at + 8 + size));
    at += 12 + size;
  }
  const raw = inflateSync(Buffer.concat(data)),
    stride = width * channels;
  const out = Buffer.alloc(stride * height);
  for (let y = 0; y < height; ++y) {
    const filter = raw[y * (stride + 1)];
    for (let x = 0; x < stride; ++x) {
      const left = x < channels ? 0 : out[y * stride + x - channels];
      const up = y === 0 ? 0 : out[(y - 1) * stride + x];
      const corner = y === 0 || x < channels ? 0 : out[(y - 1) * stride + x - channels];
      const guess = [0, left, up, (left + up) >> 1, paeth(left, up, corner)][filter];
      out[y * stride + x] = raw[y * (stride + 1) + 1 + x] + guess;
    }
  }
  return {width, height, channels, out};
}

function paeth(a, b, c) {
  const p = a + b - c,
    da = Math.abs(p - a),
    db = Math.abs(p - b),
    dc = Math.abs(p - c);
  return da <= db && da <= dc ? a : db <= dc ? b : c;
}

export async function countColors(png, before = null) {
  const now = decode(png),
    old = before && decode(before);
  const seen = new Set();
  let yellow = 0,
    blue = 0,
    changed = 0;
  for (let i = 0; i < now.out.length; i += now.channels) {
    const [r, g, b] = [now.out[i], now.out[i + 1], now.out[i + 2]];
    seen.add(((r >> 3) << 10) | ((g >> 3) << 5) | (b >> 3));
    if (r > 130 && g > 0.6 * r && g < 0.95 * r && b < 0.55 * r) ++yellow;
    if (b > 70 && b > 1.5 * r && b > 1.15 * g) ++blue;
    if (
      old &&
      Math.abs(r - old.out[i]) + Math.abs(g - old.out[i + 1]) + Math.abs(b - old.out[i + 2]) > 40
    )
      ++changed;
  }
  return {yellow, blue, changed, different: seen.size};
}
