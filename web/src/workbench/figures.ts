// The pictures of a record, with the free runs of models over it.

import type { Answer } from "../packet.ts";
import type { Figure, Panel, Series } from "../plot/figure.ts";
import { short, unit } from "../plot/ticks.ts";
import { residual, type Run, samples } from "./runs.ts";

/** A record as it is drawn. */
export interface Shown {
  file: string;
  /** As it was read, whole. */
  whole: Answer;
  /** As it is used, if it is cut or prepared. */
  used?: Answer | undefined;
  /** Where the part that is used begins [s]. */
  start: number;
}

/** The samples that are used, their period [s], their units, and the slope of the straight line through them. */
export function used({ whole, used }: Shown) {
  const answer = used ?? whole;
  const { ts, units } = { ...whole.result.record, ...used?.result.record };
  const slope: number = (used ?? whole).result.line?.slope ?? 0;
  return { u: answer.series.get("u")!, y: answer.series.get("y")!, ts: ts as number, units: units as { u: string; y: string }, slope };
}

/** Output, error of the models and input against time. */
export function timeFigure(shown: Shown, runs: Run[]): Figure {
  const { u, y, ts, units } = used(shown);
  const { whole, start, file } = shown;
  const time = { start, step: ts };
  const read = whole.result.record;
  const before = (of: "u" | "y"): Series[] => (shown.used
    ? [{ name: "as measured", y: whole.series.get(of)!, step: read.ts, style: "pale" }]
    : []);
  const name = shown.used ? "as used" : "measured";
  const panels: (Panel | undefined)[] = [
    {
      y: { label: "Output y", unit: units.y },
      series: [
        ...before("y"),
        { name, y, ...time, ...(runs.length > 0 && !shown.used && { style: "pale" as const }) },
        ...runs.map((run): Series => ({ name: run.name, y: samples(run, "simulated"), ...time, colour: run.colour })),
      ],
    },
    runs.length > 0
      ? { y: { label: "Error", unit: units.y }, series: runs.map((run) => ({ name: run.name, y: residual(run), ...time, colour: run.colour })) }
      : undefined,
    { y: { label: "Input u", unit: units.u }, series: [...before("u"), { name: shown.used ? name : "input", y: u, ...time, colour: 7 }] },
  ];
  return {
    title: `${file} against time`,
    x: { label: "Time", unit: "s" },
    panels: panels.filter((panel): panel is Panel => panel !== undefined),
    marks: (whole.result.defects ?? []).flatMap(({ spans }: { spans: [number, number][] }) => spans.map(([from, to]) => ({ from, to }))),
  };
}

/** Output against input; with a slope, less the straight line. */
export function loopFigure(shown: Shown, runs: Run[], slope = 0): Figure {
  const { u, y, units } = used(shown);
  const less = (inputs: Float64Array, outputs: Float64Array) => (slope === 0 ? outputs : outputs.map((value, t) => value - slope * inputs[t]!));
  return {
    title: slope === 0 ? "Loop" : `Loop less its straight line of ${short(slope)} ${unit(units.y)}/${unit(units.u)}`,
    x: { label: "Input u", unit: units.u },
    panels: [{
      y: { label: slope === 0 ? "Output y" : "y less the line", unit: units.y },
      series: [
        { name: "measured", x: u, y: less(u, y), style: runs.length > 0 ? "pale" : "line" },
        ...runs.map((run): Series => {
          const inputs = samples(run, "u");
          return { name: run.name, x: inputs, y: less(inputs, samples(run, "simulated")), colour: run.colour };
        }),
      ],
    }],
    loops: true,
  };
}

interface Bin {
  at: number;
  rms_pp_percent: number;
  noise_rms_pp_percent: number | null;
  little_excited: boolean;
}

type By = "by_frequency" | "by_amplitude";

/** Errors on a record by frequency or amplitude, and the noise in them; none of a single band. Bands in which little is
 * excited are left out. */
export function binsFigure(runs: Run[], by: By, unitOfU: string): Figure | undefined {
  const bins = (run: Run): Bin[] => (run.answer.result.files[0]?.[by] ?? []).filter((bin: Bin) => !bin.little_excited);
  const drawn = runs.filter((run) => bins(run).length > 1);
  if (drawn.length === 0) return undefined;
  const noisy = bins(drawn[0]!).filter((bin) => (bin.noise_rms_pp_percent ?? 0) > 0);
  const frequency = by === "by_frequency";
  return {
    title: frequency ? "Error by frequency" : "Error by amplitude",
    x: frequency ? { label: "Frequency", unit: "Hz", log: true } : { label: "Amplitude of the input", unit: unitOfU },
    panels: [{
      y: { label: "Error, rms", unit: "% of peak-to-peak", log: true },
      series: [
        ...drawn.map((run): Series => ({
          name: run.name, x: Float64Array.from(bins(run), (bin) => bin.at),
          y: Float64Array.from(bins(run), (bin) => bin.rms_pp_percent), style: "marks", colour: run.colour,
        })),
        ...(noisy.length > 0 ? [{
          name: "noise in it", x: Float64Array.from(noisy, (bin) => bin.at),
          y: Float64Array.from(noisy, (bin) => bin.noise_rms_pp_percent!), style: "dashed" as const, colour: 7,
        }] : []),
      ],
    }],
  };
}

/** Largest lag that is drawn [samples]. */
const LAGS = 20;

/** The autocorrelation of what is left, with the bound of noise. */
export function whiteFigure(runs: Run[]): Figure | undefined {
  const of = (run: Run) => run.answer.result.files[0]?.whiteness;
  const known = runs.filter((run) => of(run)?.autocorrelation?.length);
  if (known.length === 0) return undefined;
  const bound = of(known[0]!).autocorrelation_bound;
  return {
    title: "Autocorrelation of the residuals",
    x: { label: "Lag", unit: "samples" },
    panels: [{
      y: { label: "Autocorrelation", unit: "" },
      series: known.map((run): Series => ({
        name: run.name, y: Float64Array.from(of(run).autocorrelation.slice(0, LAGS)), start: 1, step: 1, style: "marks", colour: run.colour,
      })),
      levels: [{ at: bound, label: "bound of noise" }, { at: -bound, label: "" }],
    }],
  };
}
