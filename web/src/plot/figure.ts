// What a plot shows. Samples are read, never copied: a record of a million samples stays one array.

/** An axis: what it measures, and its unit. */
export interface Axis {
  label: string;
  unit: string;
  /** Logarithmic. */
  log?: boolean;
  /** What is shown at first; all samples without it. */
  span?: Span;
}

/** Samples against x; without `x` they are `step` apart, from `start` on. */
export interface Series {
  name: string;
  y: Float64Array;
  x?: Float64Array;
  start?: number;
  step?: number;
  /** Number of its colour; 0 is the colour of measurements. */
  colour?: number;
  /** `pale`: wide and pale, for what was measured, below a model. `points`: not joined; `dots`: the same, small, for
   * clouds. `marks`: joined points. `band`: the area down to `lower`. */
  style?: "line" | "pale" | "points" | "dots" | "marks" | "dashed" | "band";
  /** Lengths of dashes and gaps [pixels]. */
  dash?: number[];
  /** The lower edge of a band. */
  lower?: Float64Array;
}

/** One of several diagrams above each other, which share the x axis. */
export interface Panel {
  y: Axis;
  series: Series[];
  /** Straight lines at a height, such as limits, by their labels. */
  levels?: { at: number; label: string }[];
  /** The same at an x. */
  places?: { at: number; label: string }[];
}

/** A point that is dragged, or moved with arrow keys. */
export interface Handle {
  label: string;
  x: number;
  y: number;
  panel?: number;
  /** Which ways it moves. */
  moves: "x" | "y" | "both";
  /** Its new place; `done` when it is let go. */
  moved(x: number, y: number, done: boolean): void;
}

/** What a plot shows. */
export interface Figure {
  title: string;
  x: Axis;
  panels: Panel[];
  /** True if x is not time: lines may go back, as in loops. */
  loops?: boolean;
  /** A span of x that is marked. */
  span?: { from: number; to: number };
  /** Straight lines between two points. */
  lines?: { from: [number, number]; to: [number, number]; label: string }[];
  /** Spans of x where something is wrong. */
  marks?: Span[];
  handles?: Handle[];
}

/** A span of an axis. */
export interface Span {
  from: number;
  to: number;
}

/** Where sample `k` of a series is on the x axis. */
export const place = (series: Series, k: number): number =>
  series.x ? series.x[k]! : (series.start ?? 0) + k * (series.step ?? 1);

/** The samples of a series whose x rises that lie in a span, with one more on both sides. */
export function within(series: Series, span: Span): [number, number] {
  const n = series.y.length;
  if (!series.x) {
    const step = series.step ?? 1;
    const start = series.start ?? 0;
    const clamp = (k: number) => Math.max(0, Math.min(n, k));
    return [clamp(Math.floor((span.from - start) / step)), clamp(Math.ceil((span.to - start) / step) + 2)];
  }
  const first = (bound: number) => {
    let [low, high] = [0, n];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (series.x![middle]! < bound) low = middle + 1;
      else high = middle;
    }
    return low;
  };
  return [Math.max(0, first(span.from) - 1), Math.min(n, first(span.to) + 2)];
}

const EMPTY: Span = { from: Infinity, to: -Infinity };

/** The lowest and the highest of these samples, those that are not numbers left out. */
export function ends(samples: Float64Array, from = 0, to = samples.length, log = false): Span {
  let [low, high] = [Infinity, -Infinity];
  for (let k = from; k < to; k++) {
    const value = samples[k]!;
    if (log && value <= 0) continue;
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return { from: low, to: high };
}

const joined = (a: Span, b: Span): Span => ({ from: Math.min(a.from, b.from), to: Math.max(a.to, b.to) });

/** A span that an axis can show. */
function shown(span: Span, log: boolean): Span {
  if (!(span.from <= span.to)) return log ? { from: 1, to: 10 } : { from: 0, to: 1 };
  if (span.from < span.to) return span;
  const half = log ? 0 : Math.abs(span.from) * 0.1 || 0.5;
  return log ? { from: span.from / 2, to: span.to * 2 } : { from: span.from - half, to: span.to + half };
}

/** The x to show at first: all of the shown series, unless the axis says another span. */
export function spanX(figure: Figure, hidden: Set<string>): Span {
  if (figure.x.span) return figure.x.span;
  const of = (series: Series): Span => {
    const n = series.y.length;
    if (n === 0) return EMPTY;
    if (series.x) return ends(series.x, 0, n, figure.x.log);
    return { from: place(series, 0), to: place(series, n - 1) };
  };
  const all = figure.panels.flatMap((panel) => panel.series).filter((series) => !hidden.has(series.name));
  const { from, to } = shown(all.map(of).reduce(joined, EMPTY), figure.x.log ?? false);
  const margin = figure.loops && !figure.x.log ? 0.04 * (to - from) : 0;
  return { from: from - margin, to: to + margin };
}

/** Ratio to the series up to which a limit is near, on a logarithmic axis. */
const NEAR = 30;

/** All y of the shown series of a panel, with a margin and the limits that are near; of time series those in the span of
 * x. If the axis says another span, that one, as long as all is shown. */
export function spanY(figure: Figure, panel: Panel, x: Span, hidden: Set<string>): Span {
  if (panel.y.span && x === figure.x.span && !panel.series.some((one) => hidden.has(one.name))) return panel.y.span;
  const of = (series: Series): Span => {
    const [from, to] = figure.loops ? [0, series.y.length] : within(series, x);
    const span = ends(series.y, from, to, panel.y.log);
    return series.lower ? joined(span, ends(series.lower, from, to, panel.y.log)) : span;
  };
  const series = panel.series.filter((one) => !hidden.has(one.name));
  const { from, to } = shown(series.map(of).reduce(joined, EMPTY), panel.y.log ?? false);
  const levels = (panel.levels ?? []).map(({ at }) => at);
  // Limits that are near are shown with their labels.
  if (panel.y.log) {
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
