// What the series are under the cursor.

import { blocks, FAN } from "./extents.ts";
import { type Figure, partsOf, place, type Series } from "./figure.ts";
import { type Frame, pixelX, pixelY, type Point, valueX, valueY } from "./frame.ts";
import { drawn, within } from "./spans.ts";
import type { Theme } from "./theme.ts";
import { short, unit } from "./ticks.ts";

/** What is shown, and what marks it: a line at an x through all panels, or rings about samples. */
export interface Reading {
  text: string;
  x?: number;
  rings: Point[];
}

/** A sample of a loop. */
interface Sample {
  frame: Frame;
  series: Series;
  k: number;
}

/** How far a sample of a loop may be from the cursor [pixels]. */
const NEAR = 24;

const shown = (frame: Frame, hidden: Set<string>) => frame.panel.series.filter((series) => !hidden.has(series.name));

/** The x of the cursor: of the sample that is nearest to a place, so that all that is shown belongs together. */
export function pointed(figure: Figure, frames: Frame[], frame: Frame, hidden: Set<string>, at: Point): number {
  const under = valueX(figure, frame, at.x);
  const away = (x: number) => Math.abs(pixelX(figure, frame, x) - at.x);
  const places = frames.flatMap((one) => shown(one, hidden)).flatMap((series) => {
    const k = nearest(series, under);
    return k === undefined ? [] : [place(series, k)];
  });
  return places.sort((a, b) => away(a) - away(b)).find((x) => x >= frame.x.from && x <= frame.x.to) ?? under;
}

/** What is read at an x of a figure that is no loop. */
export function readingAt(figure: Figure, frames: Frame[], hidden: Set<string>, x: number): Reading {
  const values = frames.flatMap((frame) => shown(frame, hidden).flatMap((series) => {
    const k = nearest(series, x);
    const title = frame.panel.title ? `${frame.panel.title} ` : "";
    return k === undefined ? [] : `${title}${series.name} ${short(series.y[k]!)} ${unit(frame.panel.y.unit)}`;
  }));
  return { text: [`${short(x)} ${unit(figure.x.unit)}`, ...values].join(" \u00b7 "), x, rings: [] };
}

/** What is read in loops at a time: the samples that are drawn and were taken then. */
export function readingThen(figure: Figure, frames: Frame[], hidden: Set<string>, time: number): Reading {
  const found = frames.flatMap((frame) => shown(frame, hidden).flatMap((series): Sample[] => {
    if (!series.at) return [];
    const k = Math.round((time - series.at.start) / series.at.step);
    return drawn(figure, series, frame.x, frame.only).some(([from, to]) => k >= from && k < to) ? [{ frame, series, k }] : [];
  }));
  return {
    text: [`${short(time)} s`, ...found.map((one) => written(figure, one))].join(" \u00b7 "),
    rings: found.map((one) => ring(figure, one)),
  };
}

/** What is read at a place in a loop, and the time of the sample there. */
export function readingLoop(figure: Figure, frame: Frame, hidden: Set<string>, at: Point): Reading & { time?: number } {
  const found = sample(figure, frame, hidden, at);
  if (!found) {
    const [x, y] = [valueX(figure, frame, at.x), valueY(frame, at.y)];
    return { text: `${short(x)} ${unit(figure.x.unit)}, ${short(y)} ${unit(frame.panel.y.unit)}`, rings: [] };
  }
  const { at: taken } = found.series;
  return {
    text: written(figure, found),
    rings: [ring(figure, found)],
    ...(taken && { time: taken.start + found.k * taken.step }),
  };
}

function written(figure: Figure, { frame, series, k }: Sample): string {
  const { title, y } = frame.panel;
  const name = [title, series.name].filter(Boolean).map((text) => `${text} `).join("");
  return `${name}${short(place(series, k))} ${unit(figure.x.unit)}, ${short(series.y[k]!)} ${unit(y.unit)}`;
}

const ring = (figure: Figure, { frame, series, k }: Sample): Point => ({
  x: pixelX(figure, frame, place(series, k)),
  y: pixelY(frame, series.y[k]!),
});

/** The sample that is drawn nearest to a place, if one is near. */
function sample(figure: Figure, frame: Frame, hidden: Set<string>, at: Point): Sample | undefined {
  let best: Sample | undefined;
  let least = NEAR ** 2;
  for (const series of shown(frame, hidden)) {
    const levels = { x: series.x && blocks(series.x, figure.x.log), y: blocks(series.y, frame.panel.y.log) };
    for (const [from, to] of drawn(figure, series, frame.x, frame.only)) {
      const take = (k: number) => {
        const [dx, dy] = [pixelX(figure, frame, place(series, k)) - at.x, pixelY(frame, series.y[k]!) - at.y];
        if (dx * dx + dy * dy < least) [best, least] = [{ frame, series, k }, dx * dx + dy * dy];
      };
      // Only blocks of samples whose box is nearer than what was found are searched.
      const search = (level: number, block: number) => {
        const size = FAN ** (level + 1);
        const [first, last] = [Math.max(from, block * size), Math.min(to, (block + 1) * size)];
        if (first >= last) return;
        const [xs, ys] = [levels.x?.[level], levels.y[level]!];
        const [low, high] = xs ? [xs.low[block]!, xs.high[block]!] : [place(series, first), place(series, last - 1)];
        const dx = outside(at.x, pixelX(figure, frame, low), pixelX(figure, frame, high));
        const dy = outside(at.y, pixelY(frame, ys.high[block]!), pixelY(frame, ys.low[block]!));
        if (!(dx * dx + dy * dy < least)) return;
        if (level === 0) for (let k = first; k < last; k++) take(k);
        else for (let k = 0; k < FAN; k++) search(level - 1, block * FAN + k);
      };
      const top = levels.y.length - 1;
      for (let block = 0; block < levels.y[top]!.low.length; block++) search(top, block);
    }
  }
  return best;
}

const outside = (at: number, low: number, high: number) => Math.max(low - at, at - high, 0);

/** The sample of a series whose x rises that is nearest to x, if it is drawn. */
function nearest(series: Series, x: number): number | undefined {
  const [first, last] = within(series, { from: x, to: x });
  let best: number | undefined;
  for (let k = first; k < last; k++) {
    if (best === undefined || Math.abs(place(series, k) - x) < Math.abs(place(series, best) - x)) best = k;
  }
  return partsOf(series).some(([from, to]) => best !== undefined && best >= from && best < to) ? best : undefined;
}

/** Draws what marks a reading. */
export function mark(context: CanvasRenderingContext2D, figure: Figure, frames: Frame[], { x, rings }: Reading, theme: Theme): void {
  context.strokeStyle = theme.line;
  context.lineWidth = 1;
  context.beginPath();
  for (const frame of x === undefined ? [] : frames) {
    const { area } = frame;
    const at = pixelX(figure, frame, x!);
    if (at < area.x || at > area.x + area.width) continue;
    context.moveTo(at, area.y);
    context.lineTo(at, area.y + area.height);
  }
  context.stroke();
  context.strokeStyle = theme.text;
  context.lineWidth = 1.5;
  context.beginPath();
  for (const { x, y } of rings) {
    context.moveTo(x + 5, y);
    context.arc(x, y, 5, 0, 2 * Math.PI);
  }
  context.stroke();
}
