// XML as people read it: one element a line, coloured by kind. Builds nodes, never markup.
import {h} from './dom';

export function prettyXml(source: string): HTMLElement {
  const out = h('pre', {class: 'xml', tabindex: 0});
  const document = new DOMParser().parseFromString(source, 'application/xml');
  if (document.querySelector('parsererror')) {
    out.textContent = source;
    return out;
  }
  write(document.documentElement, 0, out);
  return out;
}

function write(element: Element, depth: number, out: HTMLElement): void {
  const indent = '  '.repeat(depth);
  out.append(indent, span('tag', `<${element.tagName}`));
  for (const attribute of element.attributes) {
    out.append(' ', span('name', attribute.name), '=', span('text', `"${attribute.value}"`));
  }
  const children = [...element.children];
  const words = element.textContent?.trim() ?? '';
  if (children.length === 0) {
    if (words === '') out.append(span('tag', '/>'), '\n');
    else
      out.append(span('tag', '>'), span('text', words), span('tag', `</${element.tagName}>`), '\n');
    return;
  }
  out.append(span('tag', '>'), '\n');
  for (const child of children) write(child, depth + 1, out);
  out.append(indent, span('tag', `</${element.tagName}>`), '\n');
}

function span(kind: string, content: string): HTMLElement {
  return h('span', {class: kind}, content);
}
