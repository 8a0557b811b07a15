// How often a loop passes each pixel: what very many samples look like, where a line would be a sheet of one colour.

import { type Figure, place, type Series } from "./figure.ts";
import { type Frame, pixelX, pixelY } from "./frame.ts";
import type { Pen } from "./pens.ts";

type Parts = [number, number][];

/** About how many samples are in view, from every 64th if there are many. */
export function crowd(figure: Figure, frame: Frame, series: Series, parts: Parts): number {
  const { area } = frame;
  const every = parts.reduce((n, [from, to]) => n + to - from, 0) > 10_000 ? 64 : 1;
  let found = 0;
  for (const [from, to] of parts) {
    for (let k = from; k < to; k += every) {
      const x = pixelX(figure, frame, place(series, k)) - area.x;
      const y = pixelY(frame, series.y[k]!) - area.y;
      if (x >= 0 && y >= 0 && x <= area.width && y <= area.height) found += every;
    }
  }
  return found;
}

/** Pixels that are counted of the lines between samples, at most: beyond, of some of the lines. */
const STEPS = 3e6;
/** Opacity of a pixel that is passed once; the most passed one has 1. */
const LEAST = 0.3;

let counts = new Uint32Array(0);

/** Draws how often each pixel is passed, by the lines that join the samples or by the samples alone. */
export function density(
  pen: Pen, figure: Figure, frame: Frame, series: Series, parts: Parts, colour: string, lines: boolean,
): void {
  const { area } = frame;
  const [width, height] = [Math.ceil(area.width), Math.ceil(area.height)];
  if (counts.length < width * height) counts = new Uint32Array(width * height);
  else counts.fill(0, 0, width * height);
  const kept = lines ? share(figure, frame, series, parts) : 1;
  for (const [from, to] of parts) count(figure, frame, series, from, to, width, height, lines, kept);
  let most = 1;
  for (let k = 0; k < width * height; k++) if (counts[k]! > most) most = counts[k]!;
  const image = new ImageData(width, height);
  const opacity = (n: number) => 255 * (LEAST + (1 - LEAST) * (most > 1 ? Math.log(n) / Math.log(most) : 1));
  const alpha = series.alpha ?? 1;
  const table = Uint8Array.from({ length: Math.min(most, 255) + 1 }, (_, n) => (n === 0 ? 0 : alpha * opacity(n)));
  for (let k = 0; k < width * height; k++) {
    const n = counts[k]!;
    if (n > 0) image.data[4 * k + 3] = table[n] ?? alpha * opacity(n);
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
  width: number, height: number, lines: boolean, kept: number,
): void {
  // Written out, and in numbers alone: a million samples are counted in each frame of the screen.
  const [logX, logY] = [figure.x.log, frame.panel.y.log];
  const [x0, y0] = [frame.x.from, frame.y.to];
  const [perX, perY] = [
    frame.area.width / (logX ? Math.log(frame.x.to / x0) : frame.x.to - x0),
    frame.area.height / (logY ? Math.log(y0 / frame.y.from) : y0 - frame.y.from),
  ];
  const limit = kept * 2 ** 32;
  let [px, py] = [NaN, NaN];
  for (let k = from; k < to; k++) {
    const [ax, ay] = [px, py];
    const value = xs ? xs[k]! : start + k * step;
    px = perX * (logX ? Math.log(value / x0) : value - x0);
    py = perY * (logY ? Math.log(y0 / ys[k]!) : y0 - ys[k]!);
    // Chosen as if by chance, for a fixed stride would meet the same places of every cycle.
    if (kept < 1 && Math.imul(k, 0x9e3779b1) >>> 0 > limit) continue;
    if (lines && ax === ax && ay === ay) {
      if ((ax < 0 && px < 0) || (ay < 0 && py < 0) || (ax > width && px > width) || (ay > height && py > height)) continue;
      const [dx, dy] = [px - ax, py - ay];
      const n = Math.max(Math.abs(dx), Math.abs(dy));
      if (n > 1) {
        // From where to where the line is in view.
        let [first, last] = [0, 1];
        if (dx !== 0) {
          const [a, b] = [-ax / dx, (width - ax) / dx];
          [first, last] = [Math.max(first, Math.min(a, b)), Math.min(last, Math.max(a, b))];
        }
        if (dy !== 0) {
          const [a, b] = [-ay / dy, (height - ay) / dy];
          [first, last] = [Math.max(first, Math.min(a, b)), Math.min(last, Math.max(a, b))];
        }
        const [stepX, stepY] = [dx / n, dy / n];
        for (let i = first * n + 1; i < last * n; i++) {
          const [u, v] = [(ax + i * stepX) | 0, (ay + i * stepY) | 0];
          if (u >= 0 && v >= 0 && u < width && v < height) counts[v * width + u]!++;
        }
      }
    }
    if (px >= 0 && py >= 0 && px < width && py < height) counts[(py | 0) * width + (px | 0)]!++;
  }
}
