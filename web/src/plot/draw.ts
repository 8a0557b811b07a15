// Drawing a figure: its axes, what is marked, its curves.

import { curve } from "./curve.ts";
import type { Figure } from "./figure.ts";
import { type Area, type Frame, pixelX, pixelY, RIGHT } from "./frame.ts";
import type { Pen, Stroke } from "./pens.ts";
import type { Theme } from "./theme.ts";
import { ticks, unit, written } from "./ticks.ts";

/** Draws the figure with these frames. */
export function draw(pen: Pen, figure: Figure, frames: Frame[], theme: Theme, hidden: Set<string>): void {
  frames.forEach((frame, k) => {
    axes(pen, figure, frame, theme, {
      left: frame.area.x === frames[0]!.area.x,
      low: !frames.some(({ area }) => area.x === frame.area.x && area.y > frame.area.y),
    });
    pen.clipped(frame.area, () => {
      if (figure.span) {
        const from = pixelX(figure, frame, figure.span.from);
        const to = pixelX(figure, frame, figure.span.to);
        pen.rectangle(from, frame.area.y, to - from, frame.area.height, theme.span);
      }
      for (const { from, to } of figure.marks ?? []) {
        const [left, right] = [pixelX(figure, frame, from), pixelX(figure, frame, to)];
        pen.rectangle(left - 1, frame.area.y, Math.max(3, right - left + 2), frame.area.height, theme.mark);
      }
      const shown = frame.panel.series.filter((series) => !hidden.has(series.name));
      // What is pale stands below.
      const order = [...shown.filter((one) => one.style === "pale"), ...shown.filter((one) => one.style !== "pale")];
      for (const series of order) curve(pen, figure, frame, series, theme);
      for (const level of frame.panel.levels ?? []) {
        const at = pixelY(frame, level.at);
        pen.stroke(Float64Array.of(frame.area.x, at, frame.area.x + frame.area.width, at), 2, limit(theme));
        pen.text(level.label, frame.area.x + frame.area.width - 4, beside(at, frame.area), theme.text, "right");
      }
      for (const { at: x, label } of frame.panel.places ?? []) {
        const at = pixelX(figure, frame, x);
        pen.stroke(Float64Array.of(at, frame.area.y, at, frame.area.y + frame.area.height), 2, limit(theme));
        pen.text(label, at + 4, frame.area.y + 12, theme.text, "left");
      }
      for (const { from, to } of k === 0 ? (figure.lines ?? []) : []) {
        const ends = [from, to].flatMap(([x, y]) => [pixelX(figure, frame, x), pixelY(frame, y)]);
        pen.stroke(Float64Array.from(ends), 2, limit(theme));
      }
    });
  });
}

/** Where the label of a level stands: on the side that is away from the middle, if there is room. */
function beside(at: number, { y, height }: Area): number {
  const [above, below] = [at - 4, at + 14];
  const room = at > y + height / 2 ? below + 4 < y + height : above - 12 < y;
  return room ? below : above;
}

const limit = (theme: Theme): Stroke => ({ colour: theme.line, width: 1.5, dash: [6, 4] });

function axes(pen: Pen, figure: Figure, frame: Frame, theme: Theme, outer: { left: boolean; low: boolean }): void {
  const { area, x, y, panel } = frame;
  const [low, right] = [area.y + area.height, area.x + area.width];
  const xs = ticks(x, area.width / 90, figure.x.log);
  const ys = ticks(y, Math.max(2, area.height / 42), panel.y.log);
  const grid = { colour: theme.grid, width: 1 };
  for (const value of xs) {
    const at = Math.round(pixelX(figure, frame, value)) + 0.5;
    pen.stroke(Float64Array.of(at, area.y, at, low), 2, grid);
    if (!outer.low) continue;
    // The last number does not reach over the edge of the picture.
    const text = written(value, gap(xs, value, figure.x.log));
    const over = at + 3.5 * text.length > right + RIGHT;
    pen.text(text, over ? right + RIGHT : at, low + 16, theme.text, over ? "right" : "center");
  }
  for (const value of ys) {
    const at = Math.round(pixelY(frame, value)) + 0.5;
    pen.stroke(Float64Array.of(area.x, at, right, at), 2, grid);
    if (outer.left) pen.text(written(value, gap(ys, value, panel.y.log)), area.x - 6, at + 4, theme.text, "right");
  }
  if (outer.low) pen.text(label(figure.x), area.x + area.width / 2, low + 34, theme.text, "center");
  if (panel.title) pen.text(panel.title, area.x, area.y - 5, theme.text, "left");
  if (outer.left) pen.text(label(panel.y), 12, area.y + area.height / 2, theme.text, "center", true);
}

/** The distance from a tick to its neighbour; on a logarithmic axis, the tick's own power of ten. */
const gap = (all: number[], value: number, log: boolean | undefined): number => {
  if (log) return 10 ** Math.floor(Math.log10(value) + 1e-9);
  const k = all.indexOf(value);
  const other = all[k + 1] ?? all[k - 1];
  return other === undefined ? value || 1 : Math.min(Math.abs(other - value), Math.abs(value) || Infinity);
};

const label = (axis: { label: string; unit: string }) => (axis.unit ? `${axis.label} [${unit(axis.unit)}]` : axis.label);
