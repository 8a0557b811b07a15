// The lowest and the highest of any stretch of samples, without reading all of them: those of blocks of 16 samples, of 16
// such blocks, and so on, are kept as long as the samples are. So the samples of a figure must not change.

import type { Span } from "./figure.ts";

/** Samples of a block, and blocks of a larger one. */
export const FAN = 16;

/** The lowest and the highest of blocks of one size. What is not a number is left out: such a block is empty. */
export interface Blocks {
  low: Float64Array;
  high: Float64Array;
}

const known = [new WeakMap<Float64Array, Blocks[]>(), new WeakMap<Float64Array, Blocks[]>()] as const;

/** The blocks of samples, the smallest first; with `log` those of positive samples. */
export function blocks(samples: Float64Array, log = false): Blocks[] {
  const store = known[log ? 1 : 0];
  const found = store.get(samples) ?? [];
  if (found.length > 0) return found;
  let below: Blocks = { low: samples, high: samples };
  do {
    const n = Math.ceil(below.low.length / FAN);
    const next = { low: new Float64Array(n), high: new Float64Array(n) };
    for (let k = 0; k < n; k++) {
      least = Infinity;
      most = -Infinity;
      scan(below, k * FAN, Math.min(below.low.length, (k + 1) * FAN), log);
      next.low[k] = least;
      next.high[k] = most;
    }
    found.push(next);
    below = next;
  } while (below.low.length > FAN);
  store.set(samples, found);
  return found;
}

// Without objects, for each frame of the screen asks for thousands of stretches.
let [least, most] = [Infinity, -Infinity];

/** Takes up a stretch of blocks. */
function scan({ low, high }: Blocks, from: number, to: number, log: boolean): void {
  for (let k = from; k < to; k++) {
    const a = low[k]!;
    const b = high[k]!;
    if (log && a <= 0) continue;
    if (a < least) least = a;
    if (b > most) most = b;
  }
}

export const joined = (a: Span, b: Span): Span => ({ from: Math.min(a.from, b.from), to: Math.max(a.to, b.to) });

/** The lowest and the highest of these samples, those that are not numbers left out. */
export function ends(samples: Float64Array, from = 0, to = samples.length, log = false): Span {
  let here: Blocks = { low: samples, high: samples };
  // Few samples are read sooner than blocks are made of all.
  const above = to - from > 8 * FAN ? blocks(samples, log) : [];
  least = Infinity;
  most = -Infinity;
  for (const next of above) {
    const first = Math.ceil(from / FAN);
    const last = Math.floor(to / FAN);
    if (first >= last) break;
    scan(here, from, first * FAN, log);
    scan(here, last * FAN, to, log);
    here = next;
    from = first;
    to = last;
  }
  scan(here, from, to, log);
  return { from: least, to: most };
}
