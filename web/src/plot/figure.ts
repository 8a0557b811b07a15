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
  /** When the samples of a loop were taken [s]: so plots of a link find them. */
  at?: { start: number; step: number };
  /** The samples that are drawn, all without it: each part from its first sample to the one before its last, as a line
   * of its own. */
  parts?: [from: number, to: number][];
  /** Number of its colour; 0 is the colour of measurements. */
  colour?: number;
  /** `pale`: wide and pale, for what was measured, below a model. `points`: not joined; `dots`: the same, small, for
   * clouds. `marks`: joined points. `band`: the area down to `lower`. `density`: how often each pixel is passed; lines
   * and clouds of loops become this where very many samples are in view. */
  style?: "line" | "pale" | "points" | "dots" | "marks" | "dashed" | "band" | "density";
  /** Opacity of lines and points, 1 without it. */
  alpha?: number;
  /** Lengths of dashes and gaps [pixels]. */
  dash?: number[];
  /** The lower edge of a band. */
  lower?: Float64Array;
}

/** One of several diagrams, which share the x axis. */
export interface Panel {
  /** What stands above it. */
  title?: string;
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
  /** Number of panels side by side, which then share the y axis too; fewer on a narrow screen. One below the other
   * without it. */
  columns?: number;
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

/** All samples that a figure may draw of a series. */
export function partsOf({ y, parts }: Series): [number, number][] {
  const inside = (k: number) => Math.max(0, Math.min(y.length, k));
  const all = parts?.map(([from, to]): [number, number] => [inside(from), inside(to)]) ?? [[0, y.length]];
  return all.filter(([from, to]) => from < to);
}
