// Study: the experiment of the paper on a simulated actuator, step by step, and its tables beside ours.

import { useMemo } from "preact/hooks";
import { Form } from "../form.tsx";
import { optionsOf } from "../lists.ts";
import type { Answer } from "../packet.ts";
import type { Figure } from "../plot/figure.ts";
import { prose, short, si } from "../plot/ticks.ts";
import { Chart, Choice, Download, Fault, Notes, Section, size, Stale, Table, useKept, useSettings, useShared } from "../ui.tsx";
import { PAPER, STEPS } from "./paper.ts";

/** An error of a method at a frequency: a row of Table 1. */
interface Row {
  frequency_hz: number;
  method: string;
  mse: number;
  rms_pp_percent: number;
  printed_mse: number | null;
}

/** A linear block of Table 2. */
interface Block {
  estimator: string;
  a: number[];
  b: number[];
  poles: { hz: number; damping: number }[];
  inverse_is_stable: boolean;
  residual_sum_abs: number | null;
}

/** The study of a plant. */
interface Study {
  plant: string;
  table1: Row[];
  table2: Block[];
  convergence: number[];
  convergence_as_printed: number[];
  optimum: number;
  noise_gain: number | null;
  verdict: string;
  notes: string[];
}

export function StudyView() {
  const { workspace, lists } = useShared();
  const [options, change] = useSettings("study");
  const request = { call: "study", options };
  const result = useKept<Answer>("study", request);
  const study = () => workspace.run({ name: "study", request, files: [] });
  return (
    <>
      <Section title="The paper" wide>
        <p>{PAPER}</p>
        <ol class="steps">
          {STEPS.map(({ title, equation, text }) => (
            <li key={title}>
              <h3>{title}{equation && <span>{equation}</span>}</h3>
              <p>{text}</p>
            </li>
          ))}
        </ol>
      </Section>
      <Section title="Repeat it" wide help="Every record, fit and test of the paper on a simulated actuator, and at frequencies beyond the paper's. This takes a minute or more.">
        <Form rows={optionsOf(lists, "study")} values={options} change={change} first={["plant", "seed"]} />
        <div class="row">
          <button type="button" class="main" disabled={result.busy} onClick={() => result.start(study)}>Run the study</button>
        </div>
        <Fault text={result.error} />
      </Section>
      {result.value && <Result answer={result.value} stale={result.stale} />}
    </>
  );
}

function Result({ answer, stale }: { answer: Answer; stale: boolean }) {
  const studies: Study[] = answer.result.studies;
  const [{ plant }, choose] = useSettings("study-shown");
  const study = studies.find((one) => one.plant === plant) ?? studies[0];
  const [errors, convergence] = useMemo(() => (study ? [errorFigure(study), convergenceFigure(study)] : []), [study]);
  const report = answer.files.find(({ name }) => name === "report.html");
  if (!study || !errors || !convergence) return <p class="missing">The study holds no plant.</p>;
  const files = answer.files.map((file) => [file.name, size(file.bytes.length), <Download files={[file]} />]);
  return (
    <>
      <Section title={`Result on the plant ${study.plant}`} wide>
        <Stale stale={stale} />
        {studies.length > 1 && <Choice label="Plant" names={studies.map((one) => one.plant)} chosen={study.plant} choose={(name) => choose({ plant: name })} />}
        {study.verdict.split("\n\n").map((part) => <p key={part}>{prose(part).replaceAll("`", "")}</p>)}
        <Notes title="Notes" notes={study.notes} />
        <div class="row">
          {report && <Download files={[report]} title="Download report.html" />}
          <Download files={answer.files} archive="study.zip" title="Download all as zip" />
        </div>
      </Section>
      <Section title="Table 1" wide help="Mean squared error of the test in mm². The paper states no unit; mm² is assumed.">
        <Table caption="Table 1: mean squared errors" head={["Frequency", "The paper", ...methodsOf(study)]} rows={table1(study)} />
        <Chart figure={errors} />
        <p class="help">Errors below {short(FLOOR)} mm² are drawn at this value.</p>
      </Section>
      <Section title="Table 2" wide help="Coefficients of equation (1) in mm and V, from the paper and estimated here. The last column is the sum of absolute residuals.">
        <Table caption="Table 2: linear blocks" head={["Estimator", "a1", "a2", "b0", "b1", "b2", "Mode", "Inverse", "Cost"]} rows={table2(study)} />
        <Chart figure={convergence} />
        {study.noise_gain !== null && <p class="help">The inverse of the swarm's block multiplies noise of the displacement by {short(study.noise_gain)} V/mm.</p>}
      </Section>
      <Section title="Files" wide>
        <details>
          <summary>{files.length} files</summary>
          <Table caption="Files of the study" head={["File", "Size", "Download"]} rows={files} />
        </details>
      </Section>
    </>
  );
}

const methodsOf = ({ table1 }: Study): string[] => [...new Set(table1.map((row) => row.method))];
const frequenciesOf = ({ table1 }: Study): number[] => [...new Set(table1.map((row) => row.frequency_hz))];

function table1(study: Study) {
  const methods = methodsOf(study);
  return frequenciesOf(study).map((hz) => {
    const rows = study.table1.filter((row) => row.frequency_hz === hz);
    const printed = rows[0]?.printed_mse;
    const of = (method: string) => rows.find((row) => row.method === method)?.mse;
    return [si(hz, "Hz"), printed ? printed.toFixed(4) : "\u2013", ...methods.map((method) => short(of(method) ?? NaN))];
  });
}

const table2 = (study: Study) =>
  study.table2.map(({ estimator, a, b, poles, inverse_is_stable: stable, residual_sum_abs: cost }) => [
    estimator,
    ...[...a, ...b].map((value) => value.toFixed(4).replace(/^-0\.0000$/, "0.0000").replace("-", "\u2212")),
    poles.map(({ hz }) => si(hz, "Hz")).join(", "),
    stable ? "stable" : "unstable",
    cost === null ? "\u2013" : short(cost),
  ]);

/** Errors below are drawn here [mm²]: they come from twins without noise. */
const FLOOR = 1e-8;

/** Errors of all methods against frequency, and those that the paper printed. */
function errorFigure(study: Study): Figure {
  const points = (of: (row: Row) => number | null, rows: Row[]) => {
    const known = rows.filter((row) => of(row));
    return { x: Float64Array.from(known, (row) => row.frequency_hz), y: Float64Array.from(known, (row) => Math.max(FLOOR, of(row)!)) };
  };
  const methods = methodsOf(study);
  const rows = (method: string) => study.table1.filter((row) => row.method === method);
  return {
    title: "Error against frequency",
    x: { label: "Frequency", unit: "Hz", log: true },
    panels: [
      {
        y: { label: "Mean squared error", unit: "mm\u00b2", log: true },
        series: [
          ...methods.map((name, k) => ({ name, colour: 1 + k, style: "marks" as const, ...points((row) => row.mse, rows(name)) })),
          { name: "the paper", colour: 0, style: "points" as const, ...points((row) => row.printed_mse, rows(methods[0] ?? "")) },
        ],
      },
    ],
  };
}

/** How the cost of the swarm falls, with both readings of equation (4). */
function convergenceFigure({ convergence, convergence_as_printed: printed, optimum }: Study): Figure {
  return {
    title: "Cost of the swarm's best particle",
    x: { label: "Iteration", unit: "" },
    panels: [
      {
        y: { label: "Cost", unit: "mm", log: true },
        series: [
          { name: "best ever", y: Float64Array.from(convergence), colour: 1 },
          { name: "equation (4) as printed", y: Float64Array.from(printed), colour: 2, style: "dashed" },
        ],
        levels: [{ at: optimum, label: "smallest possible cost" }],
      },
    ],
  };
}
