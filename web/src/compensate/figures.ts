// The pictures of a path: against time, and as loops, on the plant that plays it or else on the model alone.

import type { Answer } from "../packet.ts";
import type { Figure, Series } from "../plot/figure.ts";
import { short, unit } from "../plot/ticks.ts";
import { spokenPlant } from "../stand-in.tsx";
import type { OnPlant } from "./played.ts";

/** A run along the path. */
interface Run {
  name: string;
  colour: number;
  y: Float64Array;
  /** Path less displacement; on a plant without its mean. */
  error: Float64Array;
}

/** The runs of an answer, the path after shaping, and the first sample that counts. */
function runsOf({ result, series }: Answer): { runs: Run[]; r: Float64Array; from: number } {
  const r = series.get("shaped")!;
  const onPlant: OnPlant | null = result.on_plant;
  const from = onPlant ? r.length - onPlant.gain.n : 0;
  const run = (name: string, of: string, colour: number): Run => {
    const y = series.get(of)!;
    const error = r.map((value, k) => value - y[k]!);
    const mean = onPlant ? error.subarray(from).reduce((sum, value) => sum + value, 0) / (r.length - from) : 0;
    return { name, colour, y, error: mean === 0 ? error : error.map((value) => value - mean) };
  };
  const runs = onPlant
    ? [run("best constant gain", "y/gain", 2), run("compensated", "y/compensated", 1)]
    : [run("predicted by the model", "y", 1)];
  return { runs, r, from };
}

/** Displacement, error and voltage against time. The span counts that the errors are of. */
export function timeFigure(answer: Answer): Figure {
  const { result, series } = answer;
  const { ts, units, usage, on_plant: onPlant } = result;
  const { runs, r, from } = runsOf(answer);
  const requested = series.get("requested")!;
  const isShaped = r.some((value, k) => value !== requested[k]);
  const curve = (name: string, y: Float64Array, more: Partial<Series>): Series => ({ name, y, step: ts, ...more });
  const limits = [usage?.highest, usage?.lowest].flatMap((use) => (typeof use?.limit === "number" ? [use.limit as number] : []));
  return {
    title: `The path on ${onPlant ? spokenPlant(onPlant.plant) : "the model"}`,
    x: { label: "Time", unit: "s" },
    panels: [
      {
        y: { label: "Displacement", unit: units.y },
        series: [
          curve("requested", requested, { style: "pale" }),
          ...(isShaped ? [curve("shaped", r, { style: "dashed", colour: 3 })] : []),
          ...runs.map(({ name, colour, y }) => curve(name, y, { colour })),
          ...(onPlant ? [curve("predicted by the model", series.get("y")!, { style: "dashed", colour: 4 })] : []),
        ],
      },
      { y: { label: "Error", unit: units.y }, series: runs.map(({ name, colour, error }) => curve(name, error, { colour })) },
      {
        y: { label: "Voltage", unit: units.u },
        series: [curve("voltage", series.get("u")!, { colour: 7 })],
        levels: limits.map((at) => ({ at, label: `limit ${short(at)} ${unit(units.u)}` })),
      },
    ],
    ...(from > 0 && { span: { from: from * ts, to: (r.length - 1) * ts } }),
  };
}

/** The loop of the compensated voltage, and the errors over the path: what is left of the hysteresis. */
export function loopFigures(answer: Answer): [Figure, Figure] {
  const { result, series } = answer;
  const { ts, units, on_plant: onPlant } = result;
  const { runs, r, from } = runsOf(answer);
  const parts: [number, number][] = [[from, r.length]];
  const curve = ({ name, colour }: Run, x: Float64Array, y: Float64Array): Series =>
    ({ name, colour, x, y, parts, at: { start: 0, step: ts } });
  const last = runs.at(-1)!;
  const on = onPlant ? spokenPlant(onPlant.plant) : "the model";
  return [
    {
      title: `Loop of ${on}, compensated`,
      x: { label: "Voltage", unit: units.u },
      panels: [{ y: { label: "Displacement", unit: units.y }, series: [curve(last, series.get("u")!, last.y)] }],
      loops: true,
    },
    {
      title: "Error over the path",
      x: { label: "Path", unit: units.y },
      panels: [{ y: { label: "Error", unit: units.y }, series: runs.map((run) => curve(run, r, run.error)) }],
      loops: true,
    },
  ];
}
