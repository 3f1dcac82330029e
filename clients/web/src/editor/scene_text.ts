// Changes of a scene's YAML text at one place: all other bytes, comments included, stay as they are.
import {
  isMap,
  isScalar,
  isSeq,
  parseDocument,
  type Document,
  type Node,
  type Pair,
  type Scalar,
  type YAMLMap
} from 'yaml';

export type Path = (string | number)[];
export type Value = string | number | boolean | null | Value[] | {[key: string]: Value};

/** Text of a value on one line, as scene files have it. */
export function flowText(value: Value): string {
  if (Array.isArray(value)) return `[${value.map(flowText).join(', ')}]`;
  if (value !== null && typeof value === 'object')
    return `{${Object.entries(value)
      .map(([key, of]) => `${keyText(key)}: ${flowText(of)}`)
      .join(', ')}}`;
  if (typeof value === 'number') return numberText(value);
  if (typeof value !== 'string') return String(value);
  // Plain words that YAML reads as words.
  if (/^[A-Za-z_][\w./-]*$/.test(value) && !/^(true|false|null|yes|no|on|off|y|n)$/i.test(value))
    return value;
  return JSON.stringify(value);
}

/** Scene files have `on` as a key without quotes. */
function keyText(key: string): string {
  return /^[A-Za-z_][\w-]*$/.test(key) ? key : flowText(key);
}

/** A number with at most nanometres, without an exponent. */
export function numberText(value: number): string {
  const text = value.toFixed(9).replace(/\.?0+$/, '');
  return text === '-0' ? '0' : text;
}

/** A scene's text and what it says. Immutable: each change returns the new text. */
export class SceneText {
  private readonly document: Document.Parsed;

  constructor(readonly text: string) {
    this.document = parseDocument(text);
  }

  /** The first mistake of the text as YAML; empty if there is none. */
  get problem(): string {
    const [first] = this.document.errors;
    if (first) return first.message.split('\n')[0]!;
    const {contents} = this.document;
    return contents === null || isMap(contents) ? '' : 'expected a map of keys';
  }

  /** The value at a path; undefined where there is none. */
  get(path: Path): Value | undefined {
    const node = this.node(path);
    return node === undefined ? undefined : (node.toJS(this.document) as Value);
  }

  /** The line of a path, from 1; 0 where there is none. */
  lineOf(path: Path): number {
    const start = this.node(path)?.range?.[0];
    return start === undefined ? 0 : this.text.slice(0, start).split('\n').length;
  }

  /** Sets a value; adds the keys that are missing. */
  set(path: Path, value: Value): string {
    const node = this.node(path);
    if (node?.range && !isEmpty(node)) return this.replace(node, value);
    const key = path[path.length - 1];
    if (key === undefined) throw new Error('no path');
    const parent = this.node(path.slice(0, -1));
    if (node?.range && parent) return this.fill(node, value);
    if (path.length === 1) return this.addAtTop(String(key), value);
    if (!parent || isEmpty(parent)) return this.set(path.slice(0, -1), {[key]: value});
    if (!isMap(parent)) throw new Error(`${path.join('.')}: its parent is no map`);
    return this.addPair(parent, String(key), value);
  }

  /** Adds an entry to a list, at its end. */
  append(path: Path, value: Value): string {
    const list = this.node(path);
    if (!list || isEmpty(list) || (isSeq(list) && list.items.length === 0)) {
      const entry = `\n  - ${flowText(value)}`;
      if (path.length !== 1) return this.set(path, [value]);
      if (!list?.range) return this.addLines(`${path[0]}:${entry}`);
      // `trays:` or `trays: []`
      const start = this.text.lastIndexOf(':', Math.max(0, list.range[0] - 1)) + 1;
      return this.splice(start, isEmpty(list) ? start : list.range[1], entry);
    }
    // One name in place of a list of names.
    if (!isSeq(list)) return this.replace(list, [list.toJS(this.document) as Value, value]);
    const last = list.items[list.items.length - 1] as Node;
    if (list.flow) return this.insert(last.range![1], `, ${flowText(value)}`);
    const end = this.lineEnd(this.endOf(last));
    return this.insert(end, `\n${this.indentOfEntry(list.items[0] as Node)}- ${flowText(value)}`);
  }

  /** Removes an entry of a list or a key of a map, with the comment on its last line. */
  remove(path: Path): string {
    const key = path[path.length - 1]!;
    const parent = this.node(path.slice(0, -1));
    if (isSeq(parent)) {
      const items = parent.items as Node[];
      const index = Number(key);
      const nodes = items.map((item) => [item.range![0], this.endOf(item)] as const);
      if (parent.flow) return this.removeFromFlow(nodes, index);
      if (items.length === 1) return this.removeOnly(path.slice(0, -1));
      const dash = this.text.lastIndexOf('-', nodes[index]![0] - 1);
      return this.removeLines(dash, nodes[index]![1]);
    }
    if (!isMap(parent)) throw new Error(`${path.join('.')} is not there`);
    const pairs = parent.items as Pair<Scalar, Node | null>[];
    const index = pairs.findIndex((pair) => String(pair.key.value) === String(key));
    const ranges = pairs.map((pair) => [pair.key.range![0], this.endOfPair(pair)] as const);
    if (parent.flow) return this.removeFromFlow(ranges, index);
    // The first key of an entry shares its line with the dash.
    const start = ranges[index]![0];
    if (index === 0 && pairs.length > 1 && !/^\s*$/.test(this.lineBefore(start)))
      return this.splice(start, ranges[1]![0], '');
    return this.removeLines(start, ranges[index]![1]);
  }

  // ---- places

  private node(path: Path): Node | undefined {
    let node: unknown = this.document.contents;
    for (const key of path) {
      // Keys of a scene may be numbers, which paths have as texts.
      if (isMap(node))
        node = node.items.find((pair) => String((pair.key as Scalar).value) === String(key))?.value;
      else node = isSeq(node) ? node.items[Number(key)] : undefined;
    }
    return (node ?? undefined) as Node | undefined;
  }

  private splice(start: number, end: number, by: string): string {
    return this.text.slice(0, start) + by + this.text.slice(end);
  }
  private insert(at: number, what: string): string {
    return this.splice(at, at, what);
  }
  private lineBefore(at: number): string {
    return this.text.slice(this.text.lastIndexOf('\n', at - 1) + 1, at);
  }
  private lineEnd(at: number): number {
    const end = this.text.indexOf('\n', at);
    return end < 0 ? this.text.length : end;
  }

  /** End of a node without the spaces and line ends that YAML counts to blocks. */
  private endOf(node: Node): number {
    if (isMap(node) && !node.flow && node.items.length > 0)
      return this.endOfPair(node.items[node.items.length - 1] as Pair<Scalar, Node | null>);
    if (isSeq(node) && !node.flow && node.items.length > 0)
      return this.endOf(node.items[node.items.length - 1] as Node);
    const [start, end] = node.range!;
    return start + this.text.slice(start, end).trimEnd().length;
  }
  private endOfPair({key, value}: Pair<Scalar, Node | null>): number {
    const end = key.range![1];
    return value?.range && !isEmpty(value) ? this.endOf(value) : this.text.indexOf(':', end) + 1;
  }

  /** The indentation of a list, from its first entry. */
  private indentOfEntry(item: Node): string {
    const before = this.lineBefore(item.range![0]);
    const dash = before.lastIndexOf('-');
    return before.slice(0, dash).replace(/[^ ]/g, ' ');
  }

  // ---- changes

  private replace(node: Node, value: Value): string {
    // Numbers of a list one by one, so that comments within it stay.
    if (isSeq(node) && Array.isArray(value) && value.length === node.items.length) {
      let {text} = this;
      for (let i = value.length; i-- > 0; ) {
        const item = node.items[i] as Node;
        if (!isScalar(item) || typeof value[i] === 'object') return this.replaceWhole(node, value);
        if (item.value === value[i]) continue;
        text = text.slice(0, item.range![0]) + flowText(value[i]!) + text.slice(item.range![1]);
      }
      return text;
    }
    if (isScalar(node) && node.value === value) return this.text;
    return this.replaceWhole(node, value);
  }
  private replaceWhole(node: Node, value: Value): string {
    return this.splice(node.range![0], this.endOf(node), flowText(value));
  }
  /** Gives a key without a value one. */
  private fill(node: Node, value: Value): string {
    const [start, end] = node.range!;
    if (start < end) return this.splice(start, end, flowText(value)); // null, ~
    const colon = this.text.lastIndexOf(':', start) + 1;
    return this.insert(colon, ` ${flowText(value)}`);
  }

  private addPair(map: YAMLMap, key: string, value: Value): string {
    const added = `${keyText(key)}: ${flowText(value)}`;
    const last = map.items[map.items.length - 1] as Pair<Scalar, Node | null> | undefined;
    if (!last) return this.splice(map.range![0], map.range![1], `{${added}}`);
    if (map.flow) return this.insert(this.endOfPair(last), `, ${added}`);
    const first = map.items[0] as Pair<Scalar>;
    const indent = this.lineBefore(first.key.range![0]).replace(/[^ ]/g, ' ');
    return this.insert(this.lineEnd(this.endOfPair(last)), `\n${indent}${added}`);
  }
  private addAtTop(key: string, value: Value): string {
    return this.addLines(`${keyText(key)}: ${flowText(value)}`);
  }
  private addLines(lines: string): string {
    const {contents} = this.document;
    // An empty map on one line is no place for further lines.
    const empty = isMap(contents) && contents.flow ? contents.range! : null;
    const text = empty ? this.splice(empty[0], empty[1], '') : this.text;
    return `${text.trimEnd()}${text.trim() === '' ? '' : '\n\n'}${lines}\n`;
  }

  private removeFromFlow(ranges: (readonly [number, number])[], index: number): string {
    const [start, end] = ranges[index]!;
    const next = ranges[index + 1],
      before = ranges[index - 1];
    if (next) return this.splice(start, next[0], '');
    return before ? this.splice(before[1], end, '') : this.splice(start, end, '');
  }
  private removeLines(start: number, end: number): string {
    const from = start - this.lineBefore(start).length;
    return this.splice(from, Math.min(this.lineEnd(end) + 1, this.text.length), '');
  }
  /** A list loses its only entry: its key goes too. */
  private removeOnly(path: Path): string {
    return this.remove(path);
  }
}

/** Whether a key has no value. */
function isEmpty(node: Node): boolean {
  return isScalar(node) && node.value === null;
}
