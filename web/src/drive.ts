// Figures of drive signals: against time with the limits of the driver, and the amplitude spectrum.

import type { Figure } from "./plot/figure.ts";
import { short, unit } from "./plot/ticks.ts";

/** The samples of a signal and its spectrum, of an answer that has them under this name. */
export const samplesOf = (series: Map<string, Float64Array>, name: string): Pick<Signal, "u" | "hz" | "amplitude"> => ({
  u: series.get(name)!,
  hz: series.get(`${name}/hz`)!,
  amplitude: series.get(`${name}/amplitude`)!,
});

/** What a drive uses of one limit of the driver. */
export interface Use {
  unit: string;
  value: number;
  limit: number | null;
  share: number | null;
}

/** What a drive uses of all limits of the driver. */
export interface Usage {
  lowest: Use;
  highest: Use;
  slew: Use;
  current: Use | null;
}

/** What a drive uses of the limits of the voltage: "3 to 97 V of 0 to 100 V". */
export function voltageUse({ lowest, highest }: Usage, of: string = highest.unit): string {
  const [low, high] = [lowest.limit, highest.limit].map((limit) => (limit === null ? undefined : short(limit)));
  const limits = low && high ? `${low} to ${high}` : low ? `at least ${low}` : high && `at most ${high}`;
  return `${short(lowest.value)} to ${short(highest.value)} ${unit(of)}${limits ? ` of ${limits} ${unit(of)}` : ""}`;
}

/** A drive signal: samples `ts` seconds apart. */
export interface Signal {
  name: string;
  u: Float64Array;
  /** The frequencies of its spectrum [Hz], and the amplitudes there. */
  hz: Float64Array;
  amplitude: Float64Array;
  ts: number;
  unit: string;
  usage: Usage | null;
}

/** The signal against time, with its limits. */
export function timeFigure({ name, u, ts, unit: of, usage }: Signal): Figure {
  const limits = usage ? [usage.highest, usage.lowest].flatMap(({ limit }) => (limit === null ? [] : [limit])) : [];
  return {
    title: `Drive ${name}`,
    x: { label: "Time", unit: "s" },
    panels: [
      {
        y: { label: of === "V" ? "Voltage" : "Displacement", unit: of },
        series: [{ name: "", y: u, step: ts, colour: 1 }],
        levels: limits.map((at) => ({ at, label: `limit ${short(at)} ${unit(of)}` })),
      },
    ],
  };
}

/** Share of the largest amplitude below which nothing is distinguished from rounding. */
const FLOOR = 1e-6;

/** The amplitude spectrum of the signal, with the band of the application. */
export function spectrumFigure({ name, hz, amplitude, unit: of }: Signal, bandwidth?: number): Figure {
  const highest = amplitude.reduce((most, value) => Math.max(most, value), 0);
  const y = amplitude.map((value) => Math.max(value, FLOOR * highest));
  const [lowest, last] = [hz[0] ?? 0, hz.at(-1) ?? 0];
  const marked = bandwidth !== undefined && bandwidth > lowest;
  return {
    title: `Spectrum of ${name}${marked ? `; shaded: up to the bandwidth, ${short(bandwidth)} Hz` : ""}`,
    x: { label: "Frequency", unit: "Hz", log: true },
    panels: [{ y: { label: "Amplitude", unit: of, log: true }, series: [{ name: "", y, x: hz, colour: 1 }] }],
    ...(marked && { span: { from: lowest, to: Math.min(bandwidth, last) } }),
  };
}
