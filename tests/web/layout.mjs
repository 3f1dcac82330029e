// Faults of a page's layout, found by geometry: text and controls that are cut off, out of reach,
// covered, or on top of each other. `layoutFaults` runs inside the page.

/** Faults of what the page shows now, one sentence each. */
export const layoutFaults = (page) => page.evaluate(findFaults);

/** Controls that are covered or out of view even after scrolling to them. Leaves the scroll as it was. */
export const unreachable = (page, selector = 'body') => page.evaluate(findUnreachable, selector);

function findFaults() {
  const kSlack_px = 1.5;
  const kControls = 'button, select, input, textarea, summary, a[href]';
  const faults = [];
  const page = document.documentElement;
  if (page.scrollWidth > innerWidth) faults.push(`the page is ${page.scrollWidth} px wide`);

  const dialog = document.querySelector('dialog[open]');
  const isShown = (element) =>
    element.checkVisibility({visibilityProperty: true}) && (!dialog || dialog.contains(element));
  const nameOf = (element) => {
    const text = (element.getAttribute('aria-label') ?? element.textContent).trim();
    const id = element.dataset.testid ?? element.className.baseVal ?? element.className;
    return `${element.tagName.toLowerCase()}${id ? `.${id}` : ''} "${text.slice(0, 50)}"`;
  };
  /** The function of an element, computed once for each. */
  const once = (of) => {
    const known = new Map();
    return (element) => {
      if (!known.has(element)) known.set(element, of(element));
      return known.get(element);
    };
  };
  const boxOf = ({left, right, top, bottom}) => ({left, right, top, bottom});
  const has = (box) => box.right > box.left && box.bottom > box.top;
  const meet = (a, b) => ({
    left: Math.max(a.left, b.left),
    right: Math.min(a.right, b.right),
    top: Math.max(a.top, b.top),
    bottom: Math.min(a.bottom, b.bottom)
  });
  const beyond = (inner, outer) => ({
    x: Math.max(outer.left - inner.left, inner.right - outer.right),
    y: Math.max(outer.top - inner.top, inner.bottom - outer.bottom)
  });

  /** Where an element cuts its contents: its box and the axes that scroll, `outer` null if it cuts nothing. */
  const cutterOf = once((at) => {
    const {overflowX, overflowY, position} = getComputedStyle(at);
    const fixed = position === 'fixed';
    if (overflowX === 'visible' && overflowY === 'visible') return {fixed, outer: null};
    const scrolls = {
      x: /auto|scroll/.test(overflowX) && at !== document.body,
      y: /auto|scroll/.test(overflowY) && at !== document.body
    };
    return {fixed, outer: boxOf(at.getBoundingClientRect()), scrolls};
  });

  /** The part of a box that is in view, and by how many pixels boxes that do not scroll cut it. */
  const clip = (first, box) => {
    let cut_px = 0,
      by = '',
      seen = box;
    const scrolled = {x: false, y: false};
    for (let at = first; at; at = at.parentElement) {
      const {fixed, outer, scrolls} = cutterOf(at);
      if (outer) {
        const out = beyond(seen, outer);
        for (const axis of ['x', 'y']) {
          if (scrolls[axis]) scrolled[axis] = true;
          else if (!scrolled[axis] && out[axis] > cut_px) [cut_px, by] = [out[axis], nameOf(at)];
        }
        seen = meet(seen, outer);
      }
      if (fixed) break;
    }
    const out = beyond(seen, {left: 0, top: 0, right: innerWidth, bottom: innerHeight});
    if (has(seen) && Math.max(out.x, out.y) > cut_px)
      [cut_px, by] = [Math.max(out.x, out.y), 'the window'];
    return {seen, cut_px, by};
  };

  // ---- text
  const texts = [];
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  for (let node = walker.nextNode(); node; node = walker.nextNode()) {
    const element = node.parentElement;
    if (node.data.trim() === '' || !isShown(element)) continue;
    if (element.closest('script, style, option, datalist, .label, .robot-mark')) continue;
    const range = document.createRange();
    range.selectNodeContents(node);
    for (const rectangle of range.getClientRects()) {
      const box = boxOf(rectangle);
      if (!has(box)) continue;
      const style = getComputedStyle(element);
      const ellipsis = style.textOverflow === 'ellipsis' && element.closest('[title]') !== null;
      if (!ellipsis) {
        const {cut_px, by} = clip(element, box);
        if (cut_px > kSlack_px)
          faults.push(`${nameOf(element)} is cut off by ${cut_px.toFixed(1)} px at ${by}`);
      }
      // The nearest box that a reader sees around the text.
      let holder = element;
      while (/^(inline|contents)$/.test(getComputedStyle(holder).display))
        holder = holder.parentElement;
      const hides = /auto|scroll|hidden|clip/.test(getComputedStyle(holder).overflowX);
      const out = beyond(box, boxOf(holder.getBoundingClientRect()));
      if (!hides && out.x > kSlack_px && !(element instanceof SVGElement))
        faults.push(`${nameOf(element)} is ${out.x.toFixed(1)} px wider than its box`);
      texts.push({element, seen: clip(element, box).seen});
    }
  }

  // ---- what selects and inputs show
  const brush = document.createElement('canvas').getContext('2d');
  for (const control of document.querySelectorAll('select, input')) {
    if (!isShown(control) || /range|checkbox|radio/.test(control.type)) continue;
    const style = getComputedStyle(control);
    brush.font = `${style.fontWeight} ${style.fontSize} ${style.fontFamily}`;
    const shown =
      control instanceof HTMLSelectElement
        ? (control.selectedOptions[0]?.textContent ?? '')
        : control.value || control.placeholder;
    const arrow_px = control instanceof HTMLSelectElement ? 16 : 0;
    const room_px =
      control.clientWidth -
      parseFloat(style.paddingLeft) -
      parseFloat(style.paddingRight) -
      arrow_px;
    const needs_px = brush.measureText(shown).width;
    if (needs_px > room_px + kSlack_px)
      faults.push(
        `${nameOf(control)} shows ${room_px.toFixed(0)} of ${needs_px.toFixed(0)} px of "${shown}"`
      );
  }

  // ---- controls
  const controls = [...document.querySelectorAll(kControls)].filter(isShown).map((element) => {
    const box = boxOf(element.getBoundingClientRect());
    return {element, box, ...clip(element.parentElement, box)};
  });
  for (const {element, box, cut_px, by} of controls) {
    if (!has(box)) faults.push(`${nameOf(element)} has no size`);
    else if (cut_px > kSlack_px)
      faults.push(`${nameOf(element)} is cut off by ${cut_px.toFixed(1)} px at ${by}`);
  }

  // ---- overlaps, of what is in view
  const layerOf = once((element) =>
    element.closest('dialog, .pick, .start, .layers, .toasts, .offline-note, .stage')
  );
  const overlapping = (a, b) => {
    const {left, right, top, bottom} = meet(a.seen, b.seen);
    return right - left > kSlack_px && bottom - top > kSlack_px;
  };
  const related = (a, b) => a === b || a.contains(b) || b.contains(a);
  const visible = controls.filter(({seen}) => has(seen));
  const sticky = once((element) => element.closest('.jog-bar, th') !== null);
  visible.forEach((a, i) => {
    for (const b of visible.slice(i + 1)) {
      if (!overlapping(a, b)) continue;
      if (related(a.element, b.element) || sticky(a.element) !== sticky(b.element)) continue;
      faults.push(`${nameOf(a.element)} and ${nameOf(b.element)} overlap`);
    }
  });
  const lines = texts.filter(({seen}) => has(seen));
  lines.forEach((a, i) => {
    for (const b of lines.slice(i + 1)) {
      const {left, right, top, bottom} = meet(a.seen, b.seen);
      if (right - left <= 2 || bottom - top <= 3) continue;
      if (layerOf(a.element) !== layerOf(b.element)) continue;
      if (a.element !== b.element && sticky(a.element) === sticky(b.element))
        faults.push(`${nameOf(a.element)} is written over ${nameOf(b.element)}`);
    }
  });
  for (const {element, seen} of texts) {
    if (!has(seen)) continue;
    for (const control of visible) {
      const {left, right, top, bottom} = meet(seen, control.seen);
      if (right - left <= 2 || bottom - top <= 3) continue;
      if (related(element, control.element) || element.closest('label')?.contains(control.element))
        continue;
      if (layerOf(element) !== layerOf(control.element)) continue;
      if (sticky(element) === sticky(control.element))
        faults.push(`${nameOf(control.element)} is over the text of ${nameOf(element)}`);
    }
  }
  return [...new Set(faults)];
}

function findUnreachable(selector) {
  const kControls = 'button, select, input, textarea, summary, a[href]';
  const scrolled = [...document.querySelectorAll('*')]
    .filter(({scrollTop, scrollLeft}) => scrollTop !== 0 || scrollLeft !== 0)
    .map((element) => ({element, top: element.scrollTop, left: element.scrollLeft}));
  const missed = [];
  for (const root of document.querySelectorAll(selector)) {
    for (const element of root.querySelectorAll(kControls)) {
      if (!element.checkVisibility({visibilityProperty: true})) continue;
      element.scrollIntoView({block: 'nearest', inline: 'nearest'});
      const {left, right, top, bottom} = element.getBoundingClientRect();
      const over = document.elementFromPoint((left + right) / 2, (top + bottom) / 2);
      const label = element.closest('label');
      if (
        over !== null &&
        (element.contains(over) || over.contains(element) || label?.contains(over))
      )
        continue;
      missed.push(
        `${element.getAttribute('aria-label') ?? element.textContent} is under ${over?.className ?? 'nothing'}`
      );
    }
  }
  for (const element of document.querySelectorAll('*')) {
    if (element.scrollTop !== 0) element.scrollTop = 0;
    if (element.scrollLeft !== 0) element.scrollLeft = 0;
  }
  for (const {element, top, left} of scrolled)
    [element.scrollTop, element.scrollLeft] = [top, left];
  return missed;
}
