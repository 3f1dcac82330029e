// Pending and active injected faults, each with a button that ends it.
import {spansOf, timesOf, type FaultSpan} from '../injected_faults';
import type {Snapshot} from '../protocol';
import type {State} from '../state';
import type {Access} from './access';
import {button, card, h} from './dom';

export class InjectedCard {
  readonly element: HTMLElement;
  readonly count = h('span', {class: 'count', hidden: true, 'data-testid': 'injected-count'});
  private readonly list = h('ul', {class: 'states', 'data-testid': 'injected-faults'});
  private shown = '-';

  constructor(
    private readonly state: State,
    private readonly access: Access
  ) {
    this.element = card('Injected faults', this.list);
    state.display.on((snapshot) => this.show(snapshot));
  }

  private show(snapshot: Snapshot): void {
    if (!this.state.cell) return;
    const open = spansOf(snapshot, this.state.cell).filter(({state}) => state !== 'over');
    const key = open.map((span) => `${span.id} ${span.title} ${timesOf(span)}`).join();
    if (key === this.shown) return;
    this.shown = key;
    this.count.hidden = open.length === 0;
    this.count.textContent = String(open.length);
    this.list.replaceChildren(
      ...(open.length
        ? open.map((span) => this.line(span))
        : [h('li', {}, 'No fault is pending or active.')])
    );
    this.access.prune();
  }

  private line(span: FaultSpan): HTMLElement {
    return h(
      'li',
      {'data-testid': `injected-${span.id}`, 'data-state': span.state, title: span.details},
      h('span', {}, h('strong', {}, span.title), h('br'), h('small', {}, timesOf(span))),
      this.access.guard(
        button(
          span.state === 'waits' ? 'Cancel' : 'End',
          () => void this.access.command({case: 'endFault', value: {id: span.id}}),
          {'aria-label': `End ${span.title}`}
        ),
        undefined,
        false,
        'inject'
      )
    );
  }
}
