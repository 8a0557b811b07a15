// Schemes of control along a reference, as the library answers and as they are drawn.

import type { Lists, Member } from "./lists.ts";
import type { Answer } from "./packet.ts";
import { ends } from "./plot/extents.ts";
import type { Figure, Series } from "./plot/figure.ts";
import { spokenPlant } from "./stand-in.tsx";

/** The controllers with feedback alone, of which each is exported too. */
export const feedbacks = (lists: Lists): Omit<Member, "reference">[] => lists.controllers.slice(3).filter(({ name }) => name !== "predictive");

/** A reference of a comparison. */
export interface Reference {
  name: string;
  samples: number;
  /** The sample from which the error counts. */
  from: number;
  height: number;
}

/** A scheme and what it reached, by reference. */
export interface Scheme {
  scheme: string;
  margins: { gain_db: number | null; phase_deg: number | null; peak: number; bandwidth_hz: number | null; stable: boolean } | null;
  least_bandwidth_hz: number | null;
  /** One a reference; a refused one has no error. */
  tracking: { reference: string; percent_of_stroke?: number; notes?: string[]; refused?: string }[];
  tolerance: { draws: number; unstable: number | null; percent_of_stroke: number[] } | null;
}

/** Share of the height of a panel below which two lines are not reported apart. */
const NEAR = 0.005;

/** Requested and reached displacement, error and voltage of all schemes along a reference. */
export function runsFigure({ result, series }: Answer, at: number, ts: number): Figure {
  const reference: Reference = result.references[at];
  const runs = (result.schemes as Scheme[]).flatMap(({ scheme }, k) => {
    const of = (name: string) => series.get(`${name}/${k}/${at}`);
    const [r, u, y] = [of("r"), of("u"), of("y")];
    return r && u && y ? [{ name: scheme, colour: 1 + (k % 7), step: ts, r, u, y, e: y.map((value, j) => r[j]! - value) }] : [];
  });
  const line = (of: "u" | "y" | "e"): Series[] => {
    const height = Math.max(...runs.map((run) => span(run[of])));
    return runs.map(({ name, colour, step, ...run }, k) => {
      const twin = runs.slice(0, k).some((other) => apart(other[of], run[of]) < NEAR * height);
      return { name, colour, step, y: run[of], ...(twin && { style: "dashed" }) };
    });
  };
  const requested: Series[] = runs[0] ? [{ name: "requested", y: runs[0].r, step: ts, style: "pale" }] : [];
  const { unit } = result;
  return {
    title: `${reference.name} on ${spokenPlant(result.plant)}`,
    x: { label: "Time", unit: "s" },
    panels: [
      { y: { label: "Displacement", unit }, series: [...requested, ...line("y")] },
      { y: { label: "Error", unit }, series: line("e") },
      { y: { label: "Voltage", unit: "V" }, series: line("u") },
    ],
    span: { from: reference.from * ts, to: reference.samples * ts },
  };
}

const span = (samples: Float64Array): number => {
  const { from, to } = ends(samples);
  return to - from;
};

/** The root mean square of a difference. */
const apart = (a: Float64Array, b: Float64Array): number =>
  Math.sqrt(a.reduce((sum, value, k) => sum + (value - b[k]!) ** 2, 0) / Math.max(1, a.length));
