// Which samples are drawn, and what the axes show.

import { ends, joined } from "./extents.ts";
import { type Figure, type Panel, partsOf, place, type Series, type Span } from "./figure.ts";

/** The first sample at or beyond an x, of a series whose x rises. */
export function reached({ x, y, start = 0, step = 1 }: Pick<Series, "x" | "y" | "start" | "step">, bound: number): number {
  if (!x) return Math.max(0, Math.min(y.length, Math.ceil((bound - start) / step)));
  let [low, high] = [0, y.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (x[middle]! < bound) low = middle + 1;
    else high = middle;
  }
  return low;
}

/** The samples of a series whose x rises that lie in a span, with one more on both sides. */
export function within(series: Parameters<typeof reached>[0], span: Span): [number, number] {
  return [Math.max(0, reached(series, span.from) - 1), Math.min(series.y.length, reached(series, span.to) + 2)];
}

/** The parts of a series that are drawn where x goes over this span; of a loop those of the time `only`. */
export function drawn(figure: Figure, series: Series, x: Span, only?: Span): [number, number][] {
  const { y, at } = series;
  const parts = partsOf(series);
  if (figure.loops && !(only && at)) return parts;
  const [first, last] = figure.loops ? within({ y, ...at }, only!) : within(series, x);
  const cut = parts.map(([from, to]): [number, number] => [Math.max(from, first), Math.min(to, last)]);
  return cut.filter(([from, to]) => from < to);
}

const EMPTY: Span = { from: Infinity, to: -Infinity };

/** A span that an axis can show. */
function shown(span: Span, log: boolean): Span {
  if (!(span.from <= span.to)) return log ? { from: 1, to: 10 } : { from: 0, to: 1 };
  if (span.from < span.to) return span;
  const half = log ? 0 : Math.abs(span.from) * 0.1 || 0.5;
  return log ? { from: span.from / 2, to: span.to * 2 } : { from: span.from - half, to: span.to + half };
}

/** A span that keeps its ends while what it is of moves a little: a time is moved along loops, which would tremble. */
function steady({ from, to }: Span): Span {
  const step = 2 ** Math.floor(Math.log2(to - from)) / 8;
  return step > 0 ? { from: Math.floor(from / step) * step, to: Math.ceil(to / step) * step } : { from, to };
}

/** The x to show at first: all of the shown series, of loops those of the time `only`, unless the axis says another span. */
export function spanX(figure: Figure, hidden: Set<string>, only?: Span): Span {
  if (figure.x.span) return figure.x.span;
  const of = (series: Series): Span =>
    (only ? drawn(figure, series, only, only) : partsOf(series))
      .map(([from, to]) => series.x
        ? ends(series.x, from, to, figure.x.log)
        : { from: place(series, from), to: place(series, to - 1) })
      .reduce(joined, EMPTY);
  const all = figure.panels.flatMap((panel) => panel.series).filter((series) => !hidden.has(series.name));
  const found = shown(all.map(of).reduce(joined, EMPTY), figure.x.log ?? false);
  const { from, to } = only && !figure.x.log ? steady(found) : found;
  const margin = figure.loops && !figure.x.log ? 0.04 * (to - from) : 0;
  return { from: from - margin, to: to + margin };
}

/** Ratio to the series up to which a limit is near, on a logarithmic axis. */
const NEAR = 30;

/** All y of the shown series of a panel, with a margin and the limits that are near; of time series those in the span of
 * x, of loops those of the time `only`. If the axis says another span, that one, as long as all is shown. */
function spanY(figure: Figure, panel: Panel, x: Span, hidden: Set<string>, only?: Span): Span {
  if (panel.y.span && x === figure.x.span && !panel.series.some((one) => hidden.has(one.name))) return panel.y.span;
  const { log } = panel.y;
  const of = (series: Series): Span =>
    drawn(figure, series, x, only)
      .flatMap(([from, to]) => [series.y, ...(series.lower ? [series.lower] : [])].map((y) => ends(y, from, to, log)))
      .reduce(joined, EMPTY);
  const series = panel.series.filter((one) => !hidden.has(one.name));
  const found = shown(series.map(of).reduce(joined, EMPTY), log ?? false);
  const { from, to } = only && !log ? steady(found) : found;
  const levels = (panel.levels ?? []).map(({ at }) => at);
  // Limits that are near are shown with their labels.
  if (log) {
    const near = levels.filter((at) => at > from / NEAR && at < to * NEAR);
    return { from: Math.min(from, ...near) / 1.2, to: Math.max(to, ...near) * 1.2 };
  }
  const height = to - from;
  const margin = 0.05 * height;
  const near = levels.filter((at) => at > from - 0.25 * height && at < to + 0.25 * height);
  const room = 0.12 * height;
  return {
    from: Math.min(from - margin, ...near.map((at) => at - room)),
    to: Math.max(to + margin, ...near.map((at) => at + room)),
  };
}

/** The y to show in each panel: its own; of panels side by side that of all that have samples. */
export function spansY(figure: Figure, x: Span, hidden: Set<string>, only?: Span): Span[] {
  const own = figure.panels.map((panel) => spanY(figure, panel, x, hidden, only));
  if (!figure.columns) return own;
  const held = (panel: Panel) => panel.series.some((one) => one.y.length > 0 && !hidden.has(one.name));
  const some = own.filter((_, k) => held(figure.panels[k]!));
  const all = (some.length > 0 ? some : own).reduce(joined, EMPTY);
  return own.map(() => all);
}
