// Data of an exported run: all motion, and the traffic on the wires.
import {fromBinary} from '@bufbuild/protobuf';
import {MotionRecordSchema, type MotionHeader} from '../../generated/aprsim/v1/motion_pb';
import type {Snapshot} from '../protocol';
import {simTime} from '../state';

/** One message on a wire, or one event in the cell. */
export interface Line {
  time_s: number;
  wire: string; // "cell" for an event in the cell
  direction: 'in' | 'out' | '';
  text: string;
}

/** Data of the run besides its motion. */
export interface About {
  title: string;
  facts: [string, string][];
  lines: Line[];
  notes: string[];
}

/** A picture of the run. */
export interface Moment {
  time_s: number; // since the run's beginning, also over resets
  header: MotionHeader; // of its scene
  snapshot: Snapshot;
}

export interface Recording {
  header: MotionHeader;
  moments: Moment[];
}

async function unpacked(base64: string): Promise<Uint8Array> {
  const packed = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('gzip'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Reads length-delimited messages of MotionRecord, packed with gzip, as base64. */
export async function readRecording(base64: string): Promise<Recording> {
  const bytes = await unpacked(base64);
  let header: MotionHeader | null = null;
  const moments: Moment[] = [];
  let base_s = 0,
    latest_s = 0,
    epoch: bigint | null = null;
  for (let at = 0; at < bytes.length; ) {
    let size = 0;
    for (let shift = 1; ; shift *= 128) {
      const byte = bytes[at++]!;
      size += (byte & 127) * shift;
      if (byte < 128) break;
    }
    const {record} = fromBinary(MotionRecordSchema, bytes.subarray(at, at + size));
    at += size;
    if (record.case === 'header') header = record.value;
    if (record.case !== 'snapshot') continue;
    const now_s = simTime(record.value);
    // Each reset begins time anew; the run's goes on.
    if (epoch !== null && record.value.epoch !== epoch) base_s = latest_s - now_s;
    epoch = record.value.epoch;
    latest_s = base_s + now_s;
    if (header) moments.push({time_s: latest_s, header, snapshot: record.value});
  }
  header = moments[0]?.header ?? null;
  if (!header || moments.length === 0) throw new Error('the page has no recording');
  return {header, moments};
}

/** Index of the last of the times that is not after `time_s`; 0 when all are. */
export function indexAt(times: {time_s: number}[], time_s: number): number {
  let low = 0,
    high = times.length;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle]!.time_s <= time_s + 1e-9) low = middle;
    else high = middle;
  }
  return low;
}
