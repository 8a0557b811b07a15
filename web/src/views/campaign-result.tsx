// What a campaign found: how much better the compensated path is, both paths side by side, and the files.

import { useMemo } from "preact/hooks";
import type { Answer } from "../packet.ts";
import type { Figure, Series } from "../plot/figure.ts";
import { short, unit as unitOf } from "../plot/ticks.ts";
import { Chart, Download, Fact, Fault, Notes, Section, Table, useShared, Verdict } from "../ui.tsx";
import { worded } from "../words.ts";
import { recordsIn } from "./campaign-files.ts";

/** Errors of a path that was measured, over the samples of the path itself. */
interface Track {
  unit: string;
  path: [number, number];
  rmse: number;
  rms_pp_percent: number;
  max_abs: number;
}

export function CampaignResult({ answer }: { answer: Answer }) {
  const { result, files } = answer;
  return result.failed ? <BrokenOff answer={answer} /> : (
    <Section title="Result" wide>
      <Facts {...result} />
      <Verdict text={result.sentence} of={`Model ${result.operator}, on the record path`} />
      <State result={result} />
      <div class="row">
        <Download files={files.filter(({ name }) => name === "campaign.html")} title="Download campaign.html" />
        <Download files={files} archive="campaign.zip" title="Download all as zip" />
        <a href="#workbench">Records</a>
        <a href="#compensate">Compensate with the model</a>
        <a href="#export">Export it</a>
      </div>
      <Paths answer={answer} />
      <Notes title="Notes" notes={result.notes} />
    </Section>
  );
}

/** Where the axis is at the end. */
function State({ result: { state, unfinished } }: { result: { state: string | null; unfinished: string | null } }) {
  const { lists } = useShared();
  return unfinished ? <Fault text={unfinished} /> : <p role="status">{worded(state ?? "", lists)}</p>;
}

function BrokenOff({ answer: { result, files } }: { answer: Answer }) {
  const records = recordsIn(files.map(({ name }) => name));
  return (
    <Section title="Broken off" wide>
      <Fault text={result.failed} />
      <p role="status">
        {records.length === 1 ? "1 new record is" : `${records.length} new records are`} in the project: <a href="#workbench">Workbench</a>.
        {" "}The next campaign with these options goes on from here.
      </p>
      <Notes title="Notes" notes={result.notes.filter((note: string) => !result.failed.includes(note))} />
    </Section>
  );
}

function Facts({ better, straight, compensated }: { better: number; straight: Track; compensated: Track }) {
  const unit = unitOf(compensated.unit);
  const row = (name: string, { rmse, rms_pp_percent, max_abs }: Track) => [name, short(rmse), short(rms_pp_percent), short(max_abs)];
  return (
    <>
      <dl class="readings">
        <Fact value={short(better)} unit="times" name="smaller rms error than with a straight line" />
        <Fact value={short(compensated.rms_pp_percent)} unit="%" name="rms error over peak-to-peak, compensated" />
        <Fact value={short(compensated.max_abs)} unit={unit} name="largest error, compensated" />
      </dl>
      <Table caption="Errors of the measured path" head={["Voltages", `rms [${unit}]`, "rms / peak-to-peak [%]", `largest [${unit}]`]}
        rows={[row("straight line", straight), row("compensated", compensated)]} />
    </>
  );
}

function Paths({ answer }: { answer: Answer }) {
  const figures = useMemo(() => figuresOf(answer), [answer]);
  return (
    <>
      <Chart figure={figures.path} height={440} />
      <div class="pair">{figures.along.map((figure) => <Chart key={figure.title} figure={figure} />)}</div>
    </>
  );
}

/** Both paths over time with their errors, and measured against requested displacement. */
function figuresOf({ result, series }: Answer): { path: Figure; along: Figure[] } {
  const { ts, straight, compensated }: { ts: number; straight: Track; compensated: Track } = result;
  const { unit } = compensated;
  const part = (name: string, { path: [from, to] }: Track) => series.get(name)!.slice(from, to);
  const line = { name: "straight line", colour: 2, step: ts, r: part("r_straight", straight), y: part("straight", straight) };
  const model = { name: "compensated", colour: 1, step: ts, r: part("r", compensated), y: part("compensated", compensated) };
  const errors = [line, model].map(({ r, y, ...rest }) => ({ ...rest, y: y.map((value, k) => r[k]! - value) }));
  const requested: Series = { name: "requested", style: "pale", step: ts, y: model.r };
  const measured = [line, model].map(({ r: _, ...rest }): Series => rest);
  const along = ({ name, colour, r, y }: typeof line, title: string): Figure => ({
    title,
    x: { label: "Requested", unit },
    loops: true,
    panels: [{ y: { label: "Measured", unit }, series: [{ name, colour, x: r, y }] }],
  });
  return {
    path: {
      title: "The path, and the error of the measured displacement",
      x: { label: "Time", unit: "s" },
      panels: [
        { y: { label: "Displacement", unit }, series: [requested, ...measured] },
        { y: { label: "Error", unit }, series: errors },
      ],
    },
    along: [along(line, "With a straight line"), along(model, "Compensated")],
  };
}
