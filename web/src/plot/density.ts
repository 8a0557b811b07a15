// How often a loop passes each pixel: what very many samples look like, where a line would be a sheet of one colour.

import { type Figure, place, type Series } from "./figure.ts";
import { type Frame, pixelX, pixelY } from "./frame.ts";
import type { Pen } from "./pens.ts";

type Parts = [number, number][];

/** Points of a line that are nearer to each other are drawn as one [pixels]. */
export const APART = 0.4;

/** About how many points a line through these samples has in view; from every 64th sample if there are many. */
export function crowd(figure: Figure, frame: Frame, series: Series, parts: Parts): number {
  const { area } = frame;
  const every = parts.reduce((n, [from, to]) => n + to - from, 0) > 10_000 ? 64 : 1;
  let found = 0;
  for (const [from, to] of parts) {
    for (let k = from; k + 1 < to; k += every) {
      const x = pixelX(figure, frame, place(series, k));
      const y = pixelY(frame, series.y[k]!);
      if (!(x >= area.x && y >= area.y && x <= area.x + area.width && y <= area.y + area.height)) continue;
      const across = pixelX(figure, frame, place(series, k + 1)) - x;
      const up = pixelY(frame, series.y[k + 1]!) - y;
      found += every * Math.min(1, Math.max(Math.abs(across), Math.abs(up)) / APART);
    }
  }
  return found;
}

/** Pixels that are counted of the lines between samples, at most: beyond, of some of the lines. */
const STEPS = 3e6;
/** Opacity of a pixel that is passed once; the most passed one has 1. */
const LEAST = 0.35;

// Rooms that are used again.
let room = new Uint32Array(0);
let image: ImageData | undefined;

/** Draws how often each pixel is passed, by the lines that join the samples or by the samples alone. */
export function density(
  pen: Pen, figure: Figure, frame: Frame, series: Series, parts: Parts, colour: string, lines: boolean,
): void {
  const { area } = frame;
  const [width, height] = [Math.ceil(area.width), Math.ceil(area.height)];
  if (room.length < width * height) room = new Uint32Array(width * height);
  const counts = room.fill(0, 0, width * height);
  const kept = lines ? share(figure, frame, series, parts) : 1;
  for (const [from, to] of parts) count(figure, frame, series, from, to, counts, width, height, lines, kept);
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

/** The share of lines that are counted. */
function share(figure: Figure, frame: Frame, series: Series, parts: Parts): number {
  let [steps, seen] = [0, 0];
  const most = frame.area.width + frame.area.height;
  const n = parts.reduce((sum, [from, to]) => sum + to - from, 0);
  const every = Math.max(1, Math.floor(n / 1000));
  for (const [from, to] of parts) {
    for (let k = from; k + 1 < to; k += every) {
      const across = pixelX(figure, frame, place(series, k + 1)) - pixelX(figure, frame, place(series, k));
      const up = pixelY(frame, series.y[k + 1]!) - pixelY(frame, series.y[k]!);
      steps += Math.min(most, Math.max(1, Math.abs(across), Math.abs(up))) || 1;
      seen++;
    }
  }
  return Math.min(1, (STEPS * Math.max(1, seen)) / (steps * n || 1));
}

function count(
  figure: Figure, frame: Frame, { x: xs, y: ys, start = 0, step = 1 }: Series, from: number, to: number,
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
  for (let k = from; k < to; k++) {
    const ax = px;
    const ay = py;
    const value = xs ? xs[k]! : start + k * step;
    px = perX * (logX ? Math.log(value / x0) : value - x0);
    py = perY * (logY ? Math.log(y0 / ys[k]!) : y0 - ys[k]!);
    // Chosen as if by chance, for a fixed stride would meet the same places of every cycle.
    if (kept < 1 && Math.imul(k, 0x9e3779b1) >>> 0 > limit) continue;
    const dx = px - ax;
    const dy = py - ay;
    const n = Math.max(Math.abs(dx), Math.abs(dy));
    // The first sample has none before it: then n is not a number.
    if (lines && n > 1) line(ax, ay, dx / n, dy / n, n, counts, width, height);
    if (px >= 0 && py >= 0 && px < width && py < height) counts[(py | 0) * width + (px | 0)]!++;
  }
}

/** Counts the pixels of a line of n steps, without its ends. */
function line(x: number, y: number, dx: number, dy: number, n: number, counts: Uint32Array, width: number, height: number): void {
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
    if (u >= 0 && v >= 0 && u < width && v < height) counts[v * width + u]!++;
  }
}
