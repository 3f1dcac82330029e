// Resolution of the pictures: lower where drawing is slow, higher again where there is time.

const kSlow_ms = 45;
const kRoom = 0.8; // share of that time which a finer picture may take
const kStep = 0.7;
const kCoarsest = 0.5;
const kSettle_ms = 3000;
/** A rise that is reverted within this time was a mistake; the next one waits longer. */
const kTrial_ms = 20000;
const kLongestWait_ms = 240000;

export class Fineness {
  /** Device pixels per CSS pixel in one direction. */
  ratio: number;
  /** Time that a picture takes, smoothed. */
  frame_ms = 16;
  private settled = 4000;
  private mayRise = 0;
  private rose = -Infinity;
  private wait_ms = kSettle_ms;

  constructor(
    readonly finest: number,
    private readonly adapts: boolean
  ) {
    this.ratio = finest;
  }

  get slow(): boolean {
    return this.frame_ms > kSlow_ms;
  }

  /** Records the time of one picture; returns whether the ratio has changed. */
  took(picture_ms: number, now: number): boolean {
    this.frame_ms += 0.1 * (picture_ms - this.frame_ms);
    if (!this.adapts || now <= this.settled) return false;
    const finer = Math.min(this.finest, this.ratio / kStep);
    // At worst the time grows with the number of pixels.
    const finer_ms = this.frame_ms * (finer / this.ratio) ** 2;
    if (this.slow && this.ratio > kCoarsest) {
      this.wait_ms =
        now - this.rose < kTrial_ms ? Math.min(2 * this.wait_ms, kLongestWait_ms) : kSettle_ms;
      this.ratio = Math.max(kCoarsest, kStep * this.ratio);
      this.mayRise = now + this.wait_ms;
    } else if (finer > this.ratio && finer_ms < kRoom * kSlow_ms && now > this.mayRise) {
      this.ratio = finer;
      this.rose = now;
    } else {
      return false;
    }
    this.settled = now + kSettle_ms;
    return true;
  }
}
