// The pictures of a record, with the free runs of models over it.

import type { Answer } from "../packet.ts";
import type { Figure, Panel, Series } from "../plot/figure.ts";
import { short, unit } from "../plot/ticks.ts";
import { type Cycles, cyclesOf, frequenciesOf } from "./cycles.ts";
import { residual, type Run, samples } from "./runs.ts";
import type { Search } from "./search.ts";

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
  const slope: number | undefined = answer.result.shape?.line?.slope;
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

/** How a loop is drawn. */
interface LoopLook {
  /** Of the straight line that is subtracted; none without it. */
  slope?: number | undefined;
  /** The samples that are drawn, all without it. */
  cycles?: Cycles | undefined;
}

/** Output against input. */
export function loopFigure(shown: Shown, runs: Run[], look: LoopLook = {}): Figure {
  const { units } = used(shown);
  const { slope } = look;
  return {
    title: slope === undefined ? "Loop" : `Loop less its straight line of ${short(slope)} ${unit(units.y)}/${unit(units.u)}`,
    x: { label: "Input u", unit: units.u },
    panels: [{ y: { label: slope === undefined ? "Output y" : "y less the line", unit: units.y }, series: loopSeries(shown, runs, look) }],
    loops: true,
  };
}

/** The loops of several records, a panel for each frequency of each. */
export function loopsFigure(all: Shown[], less: boolean): Figure | undefined {
  const panels = all.flatMap((shown) => {
    const answer = shown.used ?? shown.whole;
    const slope = less ? used(shown).slope : undefined;
    return frequenciesOf(answer).map((frequency) => ({
      title: `${short(Number(frequency.toPrecision(2)))} Hz, ${shown.file}`,
      y: { label: less ? "y less the line" : "Output y", unit: used(shown).units.y },
      series: loopSeries(shown, [], { slope, cycles: cyclesOf(answer, frequency) }),
    }));
  });
  if (panels.length === 0) return undefined;
  const { u } = used(all[0]!).units;
  return { title: "Loops by frequency", x: { label: "Input u", unit: u }, panels, loops: true, columns: Math.min(3, panels.length) };
}

function loopSeries(shown: Shown, runs: Run[], { slope, cycles }: LoopLook): Series[] {
  const { u, y, ts } = used(shown);
  const less = (inputs: Float64Array, outputs: Float64Array) => (slope ? outputs.map((value, t) => value - slope * inputs[t]!) : outputs);
  const common: Partial<Series> = { at: { start: shown.start, step: ts }, ...(cycles?.parts && { parts: cycles.parts }) };
  const minor = cycles?.minor ?? [];
  const measured = less(u, y);
  return [
    { name: "measured", x: u, y: measured, ...common, ...(runs.length > 0 ? { style: "pale" as const } : { alpha: 0.6 }) },
    ...(minor.length > 0 ? [{ name: "minor loops", x: u, y: measured, ...common, parts: minor, colour: 6 }] : []),
    ...runs.map((run): Series => {
      const inputs = samples(run, "u");
      return { name: run.name, x: inputs, y: less(inputs, samples(run, "simulated")), ...common, colour: run.colour, alpha: 0.8 };
    }),
  ];
}

/** Amplitudes of output, error and input by frequency. */
export function spectrumFigure(shown: Shown, runs: Run[]): Figure | undefined {
  const { series } = shown.used ?? shown.whole;
  const [hz, u, y] = ["hz", "u/amplitude", "y/amplitude"].map((name) => series.get(name));
  if (!hz || !u || !y) return undefined;
  const { units } = used(shown);
  const errors = runs.flatMap(({ name, colour, answer }): Series[] => {
    const [x, error] = [answer.series.get("hz/0"), answer.series.get("error/amplitude/0")];
    return x && error ? [{ name: `error of ${name}`, x, y: error, colour }] : [];
  });
  return {
    title: `Spectrum of ${shown.file}`,
    x: { label: "Frequency", unit: "Hz", log: true },
    panels: [
      { y: { label: "Output y", unit: units.y, log: true }, series: [{ name: "measured", x: hz, y }, ...errors] },
      { y: { label: "Input u", unit: units.u, log: true }, series: [{ name: "input", x: hz, y: u, colour: 7 }] },
    ],
  };
}

/** The costs of a swarm, or the errors of the operators, in the order in which they were found. */
export function convergence({ errors, costs }: Pick<Search, "errors" | "costs">): Figure | undefined {
  if (errors.length === 0 && costs.length < 2) return undefined;
  const best = errors.map((_, k) => Math.min(...errors.slice(0, k + 1)));
  const operators = errors.length > 0;
  return {
    title: operators ? "Held-out error of each fit, and the best so far" : "Cost of the search",
    x: { label: operators ? "Fit" : "Iteration", unit: "" },
    panels: [{
      y: operators ? { label: "Error", unit: "% of stroke", log: true } : { label: "Cost", unit: "", log: true },
      series: operators
        ? [
            { name: "fit", y: Float64Array.from(errors), start: 1, style: "points", colour: 1 },
            { name: "best so far", y: Float64Array.from(best), start: 1, colour: 2 },
          ]
        : [{ name: "", y: Float64Array.from(costs), colour: 1 }],
    }],
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
