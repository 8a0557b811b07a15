// The curve of a series in a panel.

import { APART, crowd, density } from "./density.ts";
import { ends } from "./extents.ts";
import { type Figure, place, type Series } from "./figure.ts";
import { type Frame, pixelX, pixelY, valueX } from "./frame.ts";
import type { Pen } from "./pens.ts";
import { drawn, reached } from "./spans.ts";
import type { Theme } from "./theme.ts";

/** Points of a loop in view from which on their density is drawn: a line of as many takes longer than a frame. */
const MANY = 20_000;

export function curve(pen: Pen, figure: Figure, frame: Frame, series: Series, theme: Theme): void {
  const { style = "line", alpha = 1 } = series;
  const own = theme.series[(series.colour ?? 0) % theme.series.length]!;
  const parts = drawn(figure, series, frame.x, frame.only);
  if (series.lower) return parts.forEach((part) => band(pen, figure, frame, series, own, part));
  const [pale, cloud] = [style === "pale", style === "dots"];
  const colour = pale ? theme.pale : own;
  const many = figure.loops && style !== "points" && style !== "marks" && crowd(figure, frame, series, parts) > MANY;
  if (many || style === "density") return density(pen, figure, frame, series, parts, colour, !cloud);
  const dash = series.dash ?? (style === "dashed" ? [6, 4] : undefined);
  for (const [from, to] of parts) {
    const points = cloud || style === "points";
    const wide = Math.abs(pixelX(figure, frame, place(series, to - 1)) - pixelX(figure, frame, place(series, from)));
    const dense = !figure.loops && !points && to - from > 4 * Math.max(1, Math.min(frame.area.width, wide));
    const count = dense ? envelope(figure, frame, series, from, to) : all(figure, frame, series, from, to);
    if (points) {
      pen.dots(room, count, colour, cloud ? 1.4 : 3, (cloud ? 0.5 : 1) * alpha);
      continue;
    }
    pen.stroke(room, count, { colour, width: dense ? 1 : pale ? 5 : 1.5, alpha, ...(dash && { dash }) });
    if (style === "marks") pen.dots(room, count, colour, 3.5, alpha);
  }
}

let room = new Float64Array(4096);

/** A room for so many numbers, used again. */
function roomFor(count: number): Float64Array {
  if (room.length < count) room = new Float64Array(count);
  return room;
}

/** The area between a series and its lower edge. */
function band(pen: Pen, figure: Figure, frame: Frame, series: Series, colour: string, [from, to]: [number, number]): void {
  const n = to - from;
  const out = new Float64Array(4 * n);
  for (let k = 0; k < n; k++) {
    const [at, back] = [2 * k, 2 * (2 * n - 1 - k)];
    out[at] = out[back] = pixelX(figure, frame, place(series, from + k));
    out[at + 1] = pixelY(frame, series.y[from + k]!);
    out[back + 1] = pixelY(frame, series.lower![from + k]!);
  }
  pen.inside(out, 2 * n, colour);
}

/** The points of a series whose x rises: of each column of pixels the first, lowest, highest and last. */
function envelope(figure: Figure, frame: Frame, series: Series, first: number, last: number): number {
  const out = roomFor(8 * (frame.area.width + 4) + 16);
  const { y } = series;
  let used = 0;
  const put = (at: number, value: number) => {
    out[used++] = at;
    out[used++] = pixelY(frame, value);
  };
  for (let k = first; k < last; ) {
    const at = pixelX(figure, frame, place(series, k));
    const next = reached(series, valueX(figure, frame, Math.max(Math.floor(at), frame.area.x - 1) + 1));
    const end = Math.min(last, Math.max(k + 1, next));
    const { from, to } = ends(y, k, end);
    put(at, y[k]!);
    if (from < to) {
      put(at, from);
      put(at, to);
      put(at, y[end - 1]!);
    }
    k = end;
  }
  return used / 2;
}

/** How far a line may be outside of a panel [pixels], for its width. */
const OUTSIDE = 8;

/** The points of a series in their order, without those in the pixel of the one before, and without lines out of view. */
function all(figure: Figure, frame: Frame, series: Series, first: number, last: number): number {
  const out = roomFor(4 * (last - first));
  const { area } = frame;
  const [left, right] = [area.x - OUTSIDE, area.x + area.width + OUTSIDE];
  const [top, low] = [area.y - OUTSIDE, area.y + area.height + OUTSIDE];
  let used = 0;
  // The last point, the sides on which it is out of view, and whether the line was left before it.
  let [lastX, lastY, sides, away] = [NaN, NaN, 0, false];
  for (let k = first; k < last; k++) {
    const x = pixelX(figure, frame, place(series, k));
    const y = pixelY(frame, series.y[k]!);
    const now = (x < left ? 1 : x > right ? 2 : 0) | (y < top ? 4 : y > low ? 8 : 0);
    if ((sides & now) !== 0) {
      away = true;
    } else {
      if (!away && Math.abs(x - lastX) < APART && Math.abs(y - lastY) < APART) continue;
      if (away) {
        out[used++] = out[used++] = NaN;
        out[used++] = lastX;
        out[used++] = lastY;
        away = false;
      }
      out[used++] = x;
      out[used++] = y;
    }
    lastX = x;
    lastY = y;
    sides = now;
  }
  return used / 2;
}
