// What an actuator does while an instrument works on it: as it is reported, and as it is drawn.

import { useMemo } from "preact/hooks";
import type { Figure, Series, Span } from "../plot/figure.ts";
import { unit as unitOf, written } from "../plot/ticks.ts";
import { Chart, Fact } from "../ui.tsx";

/** A moment: time [s], voltage [V], displacement. What is not measured is not a number. */
interface Moment {
  t: number;
  u: number;
  y: number;
  /** True while a drive is played; otherwise the actuator moves slowly or waits. */
  played: boolean;
}

/** Moments of a part that are kept; the first are dropped. */
const KEPT = 20_000;

/** What was reported of work on an instrument until now. */
export class Live {
  /** The part of the work that is under way, and what is done in it; the last part that had a name. */
  part = "";
  step = "";
  last = "";
  /** Unit of the displacement. */
  unit = "um";
  /** What the actuator did in the last part in which it moved, and that part. */
  moments: Moment[] = [];
  of = "";
  /** True once nobody wants the work to go on. */
  stopping = false;
  readonly begin = Date.now();

  /** Takes up a step of the work, `part: step` or a step alone, and the figures that it reports. */
  take(what: string, figures: Record<string, number>): void {
    const end = what.indexOf(": ");
    const [part, step] = end < 0 ? ["", what] : [what.slice(0, end), what.slice(end + 2)];
    [this.part, this.step] = [part, step.replace(" [ms]", "")];
    if (part) this.last = part;
    const { t_s: t, u_V: u = NaN } = figures;
    if (t === undefined) return;
    const position = Object.keys(figures).find((name) => name.startsWith("y_"));
    if (position) this.unit = position.slice(2);
    const before = part === this.of ? this.moments.slice(-KEPT) : [];
    this.of = part;
    this.moments = [...before, { t, u, y: figures[position ?? ""] ?? NaN, played: step.startsWith("the drive") }];
  }
}

/** The present values, and what the actuator has done in this part. */
export function LivePlots({ live, range, title }: { live: Live; range: Span; title: string }) {
  const { moments, unit } = live;
  const figures = useMemo(() => [loop(moments, unit, range, title), times(moments, unit)] as const, [moments, range.from, range.to, title]);
  const last = moments.at(-1);
  return (
    <>
      <dl class="readings">
        <Reading name="Voltage" value={last?.u} unit="V" />
        <Reading name="Displacement" value={last?.y} unit={unitOf(unit)} />
      </dl>
      <div class="pair">{figures.map((figure, k) => <Chart key={k} figure={figure} height={360} />)}</div>
    </>
  );
}

const Reading = ({ name, value, unit }: { name: string; value: number | undefined; unit: string }) => (
  <Fact name={name} value={value === undefined || Number.isNaN(value) ? "\u2013" : written(value, 0.001)} unit={unit} />
);

/** Moments as points; those that are joined in time are none of a loop. */
function points(moments: Moment[], x: (moment: Moment) => number, y: (moment: Moment) => number): Series[] {
  const some = (name: string, style: Series["style"], colour: number, chosen: Moment[]): Series =>
    ({ name, style: style!, colour, x: Float64Array.from(chosen, x), y: Float64Array.from(chosen, y) });
  return [
    some("slow move, wait", "dots", 0, moments.filter(({ played }) => !played)),
    some("drive", "points", 1, moments.filter(({ played }) => played)),
    some("now", "points", 2, moments.slice(-1)),
  ];
}

/** Displacement over voltage; the voltages are those that are agreed to. */
function loop(moments: Moment[], unit: string, { from, to }: Span, title: string): Figure {
  const margin = 0.05 * (to - from);
  return {
    title,
    x: { label: "Voltage", unit: "V", span: { from: from - margin, to: to + margin } },
    loops: true,
    panels: [{ y: { label: "Displacement", unit }, series: points(moments, ({ u }) => u, ({ y }) => y) }],
  };
}

function times(moments: Moment[], unit: string): Figure {
  const begin = moments[0]?.t ?? 0;
  const panel = (label: string, of: string, value: (moment: Moment) => number) => ({
    y: { label, unit: of },
    series: points(moments, ({ t }) => t - begin, value),
  });
  return {
    title: "Over time",
    // Room for what comes.
    x: { label: "Time", unit: "s", span: { from: 0, to: Math.max(1, 1.05 * ((moments.at(-1)?.t ?? begin) - begin)) } },
    panels: [panel("Voltage", "V", ({ u }) => u), panel("Displacement", unit, ({ y }) => y)],
  };
}
