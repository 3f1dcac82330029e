import {docsLink, h} from './dom';

export interface Tab {
  name: string;
  content: HTMLElement;
  docs?: string; // page of the documents that explains the panel
  mark?: HTMLElement;
}

/** Panels, one of them visible. Arrow keys move between the tabs. */
export class Tabs {
  readonly element = h('div', {class: 'tabs'});
  private readonly heads: HTMLButtonElement[];
  private readonly links: (HTMLAnchorElement | null)[];

  constructor(
    private readonly tabs: Tab[],
    private readonly opened: (name: string) => void
  ) {
    this.heads = tabs.map((tab, i) =>
      h(
        'button',
        {
          type: 'button',
          role: 'tab',
          id: `tab-${tab.name}`,
          'aria-controls': `panel-${tab.name}`,
          onclick: () => this.open(i)
        },
        tab.name,
        tab.mark
      )
    );
    this.links = tabs.map(({name, docs}) => (docs ? docsLink(docs, name) : null));
    const list = h(
      'div',
      {class: 'tablist', role: 'tablist', 'aria-label': 'Panels'},
      ...this.heads
    );
    list.addEventListener('keydown', (event) => {
      const step = event.key === 'ArrowRight' ? 1 : event.key === 'ArrowLeft' ? -1 : 0;
      if (step === 0) return;
      const at =
        (this.heads.indexOf(document.activeElement as HTMLButtonElement) + step + tabs.length) %
        tabs.length;
      this.open(at);
      this.heads[at]!.focus();
    });
    for (const tab of tabs) {
      tab.content.id = `panel-${tab.name}`;
      tab.content.setAttribute('role', 'tabpanel');
      tab.content.setAttribute('aria-labelledby', `tab-${tab.name}`);
      tab.content.tabIndex = 0;
    }
    this.element.append(
      h('div', {class: 'tabrow'}, list, ...this.links),
      ...tabs.map((tab) => tab.content)
    );
    this.open(0);
  }

  open(index: number): void {
    this.tabs.forEach((tab, i) => {
      tab.content.hidden = i !== index;
      const link = this.links[i];
      if (link) link.hidden = i !== index;
      this.heads[i]!.setAttribute('aria-selected', String(i === index));
      this.heads[i]!.tabIndex = i === index ? 0 : -1;
    });
    this.opened(this.tabs[index]!.name);
  }
}
