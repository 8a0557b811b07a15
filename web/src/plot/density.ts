// How often a loop passes each pixel: what very many samples look like, where a line would be a sheet of one colour.

import { type Figure, partsOf, place, type Series } from "./figure.ts";
import { type Frame, pixelX, pixelY } from "./frame.ts";
import type { Pen } from "./pens.ts";

type Parts = [number, number][];

/** Points of a line that are nearer to each other are drawn as one [pixels]. */
export const APART = 0.4;

/** A line of this length takes as long as one point more [pixels]. */
const LONG = 8;

/** About how many points a line through these samples has in view, from some thousand of them; long ones count more. */
export function crowd(figure: Figure, frame: Frame, series: Series, parts: Parts): number {
  const { area } = frame;
  const every = Math.max(1, Math.floor(parts.reduce((n, [from, to]) => n + to - from, 0) / 4000));
  let found = 0;
  for (const [from, to] of parts) {
    for (let k = from; k + 1 < to; k += every) {
      const x = pixelX(figure, frame, place(series, k));
      const y = pixelY(frame, series.y[k]!);
      if (!(x >= area.x && y >= area.y && x <= area.x + area.width && y <= area.y + area.height)) continue;
      const across = pixelX(figure, frame, place(series, k + 1)) - x;
      const up = pixelY(frame, series.y[k + 1]!) - y;
      const length = Math.min(Math.max(Math.abs(across), Math.abs(up)), area.width + area.height);
      found += every * (Math.min(1, length / APART) + length / LONG);
    }
  }
  return found;
}

/** Pixels that are counted of the lines between samples, at most: beyond, of some of the lines. */
const STEPS = 3e6;
/** Opacity of a pixel that is passed once; the most passed one has 1. */
const LEAST = 0.35;

// Used again.
let image: ImageData | undefined;

/** Draws how often each pixel is passed, by the lines that join the samples or by the samples alone. */
export function density(
  pen: Pen, figure: Figure, frame: Frame, series: Series, parts: Parts, colour: string, lines: boolean,
): void {
  const { area } = frame;
  const [width, height] = [Math.ceil(area.width), Math.ceil(area.height)];
  const counts = counted(figure, frame, series, parts, lines, width, height);
  let most = 1;
  for (let k = 0; k < width * height; k++) if (counts[k]! > most) most = counts[k]!;
  if (image?.width !== width || image.height !== height) image = new ImageData(width, height);
  const opacity = (n: number) => 255 * (LEAST + (1 - LEAST) * (most > 1 ? Math.log(n) / Math.log(most) : 1));
  const { data } = image;
  const table = Uint8Array.from({ length: 256 }, (_, n) => (n > 0 ? opacity(n) : 0));
  for (let k = 0; k < width * height; k++) {
    const n = counts[k]!;
    data[4 * k + 3] = n < 256 ? table[n]! : opacity(n);
  }
  pen.pixels({ x: Math.round(area.x), y: Math.round(area.y), width, height, image }, colour);
}

/** What was counted of a series at last, and how. */
interface Counted {
  counts: Uint32Array;
  how: unknown[];
  from: number;
  to: number;
}

const last = new WeakMap<Float64Array, Counted>();

/** How often each pixel is passed. Of a span of time that moves, only the samples that come and go are counted. */
function counted(
  figure: Figure, frame: Frame, series: Series, parts: Parts, lines: boolean, width: number, height: number,
): Uint32Array {
  const { x, y } = frame;
  const kept = lines ? share(figure, frame, series, partsOf(series)) : 1;
  const how = [series.x, x.from, x.to, y.from, y.to, frame.area.width, frame.area.height, lines, kept];
  const take = (counts: Uint32Array, from: number, to: number, begin: number, by: number) =>
    count(figure, frame, series, [from, to, begin, by], counts, width, height, lines, kept);
  const [from, to] = parts[0] ?? [0, 0];
  const before = last.get(series.y);
  const same = before && !series.parts && before.how.every((value, k) => value === how[k]);
  if (same && Math.abs(from - before.from) + Math.abs(to - before.to) < to - from) {
    if (from < before.from) take(before.counts, from, before.from, 0, 1);
    else take(before.counts, before.from, from, 0, -1);
    if (to > before.to) take(before.counts, before.to, to, 0, 1);
    else take(before.counts, to, before.to, 0, -1);
    [before.from, before.to] = [from, to];
    return before.counts;
  }
  const counts = before?.counts.length === width * height ? before.counts.fill(0) : new Uint32Array(width * height);
  for (const [first, end] of parts) take(counts, first, end, series.parts ? first : 0, 1);
  last.set(series.y, { counts, how, from, to });
  return counts;
}

/** The share of lines that are counted. */
function share(figure: Figure, frame: Frame, series: Series, parts: Parts): number {
  let [steps, judged] = [0, 0];
  const most = frame.area.width + frame.area.height;
  const n = parts.reduce((sum, [from, to]) => sum + to - from, 0);
  const every = Math.max(1, Math.floor(n / 1000));
  for (const [from, to] of parts) {
    for (let k = from; k + 1 < to; k += every) {
      const across = pixelX(figure, frame, place(series, k + 1)) - pixelX(figure, frame, place(series, k));
      const up = pixelY(frame, series.y[k + 1]!) - pixelY(frame, series.y[k]!);
      steps += Math.min(most, Math.max(1, Math.abs(across), Math.abs(up))) || 1;
      judged++;
    }
  }
  return Math.min(1, (STEPS * Math.max(1, judged)) / (steps * n || 1));
}

/** Counts the samples of a span, each with the line from the one before, unless it is the first of its part. */
function count(
  figure: Figure, frame: Frame, { x: xs, y: ys, start = 0, step = 1 }: Series,
  [from, to, begin, by]: [from: number, to: number, begin: number, by: number],
  counts: Uint32Array, width: number, height: number, lines: boolean, kept: number,
): void {
  // Written out, in numbers alone: a million samples are counted in each frame of the screen.
  const logX = figure.x.log;
  const logY = frame.panel.y.log;
  const x0 = frame.x.from;
  const y0 = frame.y.to;
  const perX = frame.area.width / (logX ? Math.log(frame.x.to / x0) : frame.x.to - x0);
  const perY = frame.area.height / (logY ? Math.log(y0 / frame.y.from) : y0 - frame.y.from);
  const limit = kept * 2 ** 32;
  let px = NaN;
  let py = NaN;
  for (let k = Math.max(begin, from - 1); k < to; k++) {
    const ax = px;
    const ay = py;
    const value = xs ? xs[k]! : start + k * step;
    px = perX * (logX ? Math.log(value / x0) : value - x0);
    py = perY * (logY ? Math.log(y0 / ys[k]!) : y0 - ys[k]!);
    if (k < from) continue;
    // Chosen as if by chance, for a fixed stride would meet the same places of every cycle.
    if (kept < 1 && Math.imul(k, 0x9e3779b1) >>> 0 > limit) continue;
    const dx = px - ax;
    const dy = py - ay;
    const n = Math.max(Math.abs(dx), Math.abs(dy));
    // The first sample has none before it: then n is not a number.
    if (lines && n > 1) line(ax, ay, dx / n, dy / n, n, by, counts, width, height);
    if (px >= 0 && py >= 0 && px < width && py < height) counts[(py | 0) * width + (px | 0)]! += by;
  }
}

/** Counts the pixels of a line of n steps, without its ends. */
function line(x: number, y: number, dx: number, dy: number, n: number, by: number, counts: Uint32Array, width: number, height: number): void {
  // From which step to which it is in view.
  const acrossA = -x / dx;
  const acrossB = (width - x) / dx;
  const upA = -y / dy;
  const upB = (height - y) / dy;
  let first = 0;
  let last = n;
  if (dx !== 0) {
    first = Math.max(first, Math.min(acrossA, acrossB));
    last = Math.min(last, Math.max(acrossA, acrossB));
  }
  if (dy !== 0) {
    first = Math.max(first, Math.min(upA, upB));
    last = Math.min(last, Math.max(upA, upB));
  }
  for (let i = first + 1; i < last; i++) {
    const u = Math.floor(x + i * dx);
    const v = Math.floor(y + i * dy);
    if (u >= 0 && v >= 0 && u < width && v < height) counts[v * width + u]! += by;
  }
}
