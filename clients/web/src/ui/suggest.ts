// Suggestions for mistyped names.

/** Levenshtein distance of two words. */
function distance(a: string, b: string): number {
  let row = Array.from({length: b.length + 1}, (_, j) => j);
  for (let i = 1; i <= a.length; ++i) {
    const next = [i];
    for (let j = 1; j <= b.length; ++j)
      next.push(
        Math.min(row[j]! + 1, next[j - 1]! + 1, row[j - 1]! + (a[i - 1] === b[j - 1] ? 0 : 1))
      );
    row = next;
  }
  return row[b.length]!;
}

/** Distance of a word to the nearest word of a name: 0 = equal, 1 = nothing in common. */
function farness(word: string, of: string[]): number {
  return Math.min(
    ...of.map((other) =>
      other.startsWith(word)
        ? 0.2 * (1 - word.length / other.length)
        : distance(word, other) / Math.max(word.length, other.length)
    )
  );
}

const words = (text: string): string[] =>
  text
    .toLowerCase()
    .split(/[\s_]+/)
    .filter(Boolean);

/** Names most similar to the typed text, the most similar first. */
export function suggest(typed: string, names: string[], most = 3): string[] {
  const wanted = words(typed);
  if (wanted.length === 0) return [];
  return names
    .map((name) => {
      const own = words(name);
      const far = wanted.reduce((sum, word) => sum + farness(word, own), 0) / wanted.length;
      return {name, far: far + 0.02 * Math.abs(own.length - wanted.length)};
    })
    .filter(({far}) => far < 0.5)
    .sort((a, b) => a.far - b.far || a.name.length - b.name.length)
    .slice(0, most)
    .map(({name}) => name);
}
