// The one way in which the page writes times.

/** Simulated time, to the millisecond: one step. */
export function simSeconds(time_s: number): string {
  return `${time_s.toFixed(3)} s`;
}

/** Wall time of the browser's time zone; `time_s` counts from 1970. */
export function wallClock(time_s: number): string {
  const time = new Date(time_s * 1000);
  const two = (value: number): string => String(value).padStart(2, '0');
  const ms = String(time.getMilliseconds()).padStart(3, '0');
  return `${two(time.getHours())}:${two(time.getMinutes())}:${two(time.getSeconds())}.${ms}`;
}
