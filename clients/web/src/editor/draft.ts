// The text of a scene that is edited, with the texts before it.
export class Draft {
  private readonly past: string[] = [];
  private future: string[] = [];

  constructor(
    public name: string,
    private present: string
  ) {}

  get text(): string {
    return this.present;
  }
  get undoable(): string | null {
    return this.past[this.past.length - 1] ?? null;
  }
  get redoable(): string | null {
    return this.future[this.future.length - 1] ?? null;
  }

  /** Accepts a changed text. */
  change(text: string): void {
    if (text === this.present) return;
    this.past.push(this.present);
    this.future = [];
    this.present = text;
  }
  undo(): void {
    const before = this.past.pop();
    if (before === undefined) return;
    this.future.push(this.present);
    this.present = before;
  }
  redo(): void {
    const after = this.future.pop();
    if (after === undefined) return;
    this.past.push(this.present);
    this.present = after;
  }
}
