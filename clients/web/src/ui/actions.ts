import {button} from './dom';

/** Buttons that are disabled while they cannot be used. */
export class Actions {
  private readonly known: {control: HTMLButtonElement; can: () => boolean}[] = [];

  add(
    label: string,
    run: () => void,
    can: () => boolean,
    attributes: Record<string, string>
  ): HTMLButtonElement {
    const control = button(label, run, attributes);
    this.known.push({control, can});
    return control;
  }

  /** `open`: whether what they act on is shown; `busy`: whether nothing can be done now. */
  update(open: boolean, busy: boolean): void {
    for (const {control, can} of this.known) {
      control.hidden = !open;
      control.disabled = busy || !can();
    }
  }
}
