// Validate: free runs of models on records, against the noise floor; several models side by side.

import { useEffect, useMemo, useState } from "preact/hooks";
import { Form } from "../form.tsx";
import { optionsOf } from "../lists.ts";
import type { Answer } from "../packet.ts";
import type { Figure, Series } from "../plot/figure.ts";
import { download } from "../plot/download.ts";
import { short } from "../plot/ticks.ts";
import { isTraining, type ModelEntry, type Options, type RecordEntry, withSettings } from "../project.ts";
import { Outdated } from "../models.tsx";
import { Chart, Fault, Missing, Notes, Section, Table, useOutcome, useShared, Verdict } from "../ui.tsx";
import type { Workspace } from "../workspace.ts";

/** A model with its answer. */
export interface Run {
  entry: ModelEntry;
  answer: Answer;
}

export function ValidateView() {
  const { workspace } = useShared();
  const { records, models } = workspace.project;
  if (models.length === 0) return <Missing what="There is no model yet." view="identify" title="Identify one" />;
  if (records.length === 0) return <Missing what="There is no record." view="data" title="Add one" />;
  return <Validation />;
}

/** The call that runs models on records. */
async function task(
  workspace: Workspace, call: "validate" | "report" | "compare", models: ModelEntry[], records: RecordEntry[], options: Options,
) {
  const data = await workspace.sources(records);
  const model = models.map((entry) => entry.file);
  return {
    name: `${call} ${model.join(", ")}`,
    request: { call, options, records: data.records, files: { model, data: records.map((entry) => entry.file) } },
    files: [...(await Promise.all(model.map((file) => workspace.file(file)))), ...data.files],
  };
}

function Validation() {
  const { workspace, lists } = useShared();
  const { records, models, model, settings } = workspace.project;
  const { models: chosenModels, records: chosenRecords, ...options } = (settings["validate"] ?? {}) as Options;
  const set = (values: Options) =>
    workspace.change((project) => withSettings(project, "validate", { ...project.settings["validate"], ...values }));
  const usedModels = models.filter((one) => (chosenModels as string[] | undefined)?.includes(one.file) ?? one.file === (model ?? models.at(-1)!.file));
  const training = (record: RecordEntry) => usedModels.some((one) => isTraining(one, record));
  const used = records.filter((one) => one.use !== "none");
  const unseen = used.filter((one) => !training(one));
  const meant = unseen.filter((one) => one.use === "validation");
  const usual = [meant, unseen, used, records].find((some) => some.length > 0)!;
  const usedRecords = (chosenRecords as string[] | undefined) ? records.filter((one) => (chosenRecords as string[]).includes(one.file)) : usual;
  const key = JSON.stringify([usedModels.map((one) => one.file), usedRecords, options]);
  const ready = usedModels.length > 0 && usedRecords.length > 0;
  const runs = useOutcome(ready ? key : undefined, () =>
    Promise.all(usedModels.map(async (entry): Promise<Run> => ({
      entry,
      answer: await workspace.answer(`validate ${JSON.stringify([entry.file, usedRecords, options])}`,
        () => task(workspace, "validate", [entry], usedRecords, options)),
    }))),
  );
  useEffect(() => {
    const verdicts = new Map((runs.value ?? []).map(({ entry, answer }) => [entry.file, answer.result.sentence]));
    const isNew = (one: ModelEntry) =>
      verdicts.get(one.file) && one.validated !== verdicts.get(one.file) && !usedRecords.some((record) => isTraining(one, record));
    if (!models.some(isNew)) return;
    workspace.amend((project) => ({
      ...project, models: project.models.map((one) => (isNew(one) ? { ...one, validated: verdicts.get(one.file) } : one)),
    }));
  }, [runs.value]);
  const toggled = (all: { file: string }[], used: { file: string }[], file: string, on: boolean) =>
    all.map((one) => one.file).filter((one) => (one === file ? on : used.some((other) => other.file === one)));
  const report = async (entries: ModelEntry[]) => {
    const call = entries.length > 1 ? "compare" : "report";
    const result = await workspace.run(await task(workspace, call, entries, usedRecords, options));
    for (const file of result.files) download(file.name, file.bytes as BlobPart, "text/html");
  };
  return (
    <>
      <Section title="What is compared" wide>
        <div class="row" role="group" aria-label="Models">
          Models:
          {models.map((one) => (
            <label key={one.file}>
              <input type="checkbox" checked={usedModels.includes(one)}
                onChange={(event) => set({ models: toggled(models, usedModels, one.file, event.currentTarget.checked) })} />{" "}
              {one.file}
            </label>
          ))}
        </div>
        <div class="row" role="group" aria-label="Records">
          Records:
          {records.map((one) => (
            <label key={one.file}>
              <input type="checkbox" checked={usedRecords.includes(one)}
                onChange={(event) => set({ records: toggled(records, usedRecords, one.file, event.currentTarget.checked) })} />{" "}
              {one.file}{training(one) ? " (identified from)" : ""}
            </label>
          ))}
        </div>
        <Form rows={optionsOf(lists, "validate")} values={options}
          change={(values) => workspace.change((project) => withSettings(project, "validate", {
            ...values, ...(chosenModels !== undefined && { models: chosenModels }), ...(chosenRecords !== undefined && { records: chosenRecords }),
          }))} />
        <Fault text={runs.error} />
        {runs.busy && !runs.value && <p class="missing">Simulating.</p>}
      </Section>
      {runs.value && runs.value.length > 0 && <Compared runs={runs.value} records={usedRecords} report={report} />}
    </>
  );
}

/** The parts of a name that colours and legends use. */
const nameOf = (entry: ModelEntry) => entry.file.replace(/\.json$/, "");

function Compared({ runs, records, report }: { runs: Run[]; records: RecordEntry[]; report(entries: ModelEntry[]): Promise<void> }) {
  const { workspace } = useShared();
  const [chosen, setChosen] = useState(0);
  const k = Math.min(chosen, records.length - 1);
  const files = runs.map(({ answer }) => answer.result.files);
  const rows = records.flatMap((record, j) =>
    runs.map(({ entry }, i) => {
      const one = files[i]?.[j] ?? {};
      return [
        record.file, nameOf(entry), `${short(one.rms_pp_percent)} %`, `${short(one.nrmse_percent)} %`,
        `${short(one.max_abs)} ${one.unit === "um" ? "\u00b5m" : one.unit}`,
        one.floor ? `${short(one.floor.rms_pp_percent)} %` : "",
      ];
    }),
  );
  const figures = useMemo(() => ({
    time: timeFigure(runs, k),
    loops: loopsFigure(runs, k),
    frequency: binsFigure(runs, "by_frequency", { label: "Frequency", unit: "Hz", log: true }),
    amplitude: binsFigure(runs, "by_amplitude", { label: "Amplitude of the input", unit: runs[0]!.answer.result.files[0]?.units?.u ?? "V" }),
    white: whiteFigure(runs, k),
  }), [runs, k]);
  return (
    <>
      <Section title="Verdict" wide>
        {runs.map(({ entry, answer }) => (
          <div key={entry.file}>
            <Verdict of={nameOf(entry)} text={answer.result.sentence} />
            <Outdated entry={entry} />
            <TrainingRecords entry={entry} records={records} />
          </div>
        ))}
        <div class="row">
          {runs.map(({ entry }) => (
            <button key={entry.file} type="button" onClick={() => report([entry]).catch((error) => workspace.failed(error))}>
              Report of {nameOf(entry)}
            </button>
          ))}
          {runs.length > 1 && (
            <button type="button" onClick={() => report(runs.map(({ entry }) => entry)).catch((error) => workspace.failed(error))}>
              Page that compares them
            </button>
          )}
        </div>
        <Table caption="Free-run errors" rows={rows}
          head={["Record", "Model", "Error, rms [% of stroke]", "NRMSE", "Largest error", "Noise, of stroke"]} />
      </Section>
      <Section title="Free run" wide>
        {records.length > 1 && (
          <div class="row">
            <label>
              Record{" "}
              <select value={String(k)} onChange={(event) => setChosen(Number(event.currentTarget.value))}>
                {records.map((record, j) => <option key={record.file} value={String(j)}>{record.file}</option>)}
              </select>
            </label>
          </div>
        )}
        <Chart figure={figures.time} height={520} />
      </Section>
      {figures.frequency && <Section title="Error by frequency" help={EXCITED}><Chart figure={figures.frequency} bare /></Section>}
      {figures.amplitude && <Section title="Error by amplitude" help={EXCITED}><Chart figure={figures.amplitude} bare /></Section>}
      <Section title="Loop"><Chart figure={figures.loops} height={360} /></Section>
      {figures.white && (
        <Section title="Residuals" help="What is left of a good model is noise: its autocorrelation stays within the bounds.">
          {runs.map(({ entry }, i) => {
            const { advice, remarks, whiteness } = files[i]?.[k] ?? {};
            return (
              <div key={entry.file}>
                <Notes title={nameOf(entry)} notes={[...(advice ? [advice] : []), ...(remarks ?? [])]} />
                <details><summary>Tests of the residuals of {nameOf(entry)}</summary><Notes title="" notes={whiteness?.verdict ?? []} /></details>
              </div>
            );
          })}
          <Chart figure={figures.white} />
        </Section>
      )}
    </>
  );
}

/** Says which of the records say nothing new of a model. */
function TrainingRecords({ entry, records }: { entry: ModelEntry; records: RecordEntry[] }) {
  const files = records.filter((record) => isTraining(entry, record)).map(({ file }) => file);
  return files.length === 0 ? null : (
    <p class="stale" role="status">
      {nameOf(entry)} was identified from {files.join(", ")}: this is no validation{files.length < records.length ? " on these" : ""}.
    </p>
  );
}

const series = (run: Run, name: string, k: number) => run.answer.series.get(`${name}/${k}`) ?? new Float64Array();

/** Input, output and error of a record against time. */
export function timeFigure(runs: Run[], k: number): Figure {
  const first = runs[0]!;
  const { ts, units, file } = first.answer.result.files[k];
  const errors = runs.map((run, i): Series => {
    const [y, simulated] = [series(run, "y", k), series(run, "simulated", k)];
    return { name: nameOf(run.entry), y: y.map((value, t) => value - simulated[t]!), step: ts, colour: 1 + i };
  });
  return {
    title: `Free run on ${file}`,
    x: { label: "Time", unit: "s" },
    panels: [
      {
        y: { label: "Output", unit: units.y },
        series: [
          { name: "measured", y: series(first, "y", k), step: ts, style: "pale" },
          ...runs.map((run, i): Series => ({ name: nameOf(run.entry), y: series(run, "simulated", k), step: ts, colour: 1 + i })),
        ],
      },
      { y: { label: "Residual", unit: units.y }, series: errors },
      { y: { label: "Input", unit: units.u }, series: [{ name: "input", y: series(first, "u", k), step: ts, colour: 7 }] },
    ],
  };
}

export function loopsFigure(runs: Run[], k: number): Figure {
  const first = runs[0]!;
  const { units, file } = first.answer.result.files[k];
  return {
    title: `Loop of ${file}`,
    x: { label: "Input", unit: units.u },
    panels: [{
      y: { label: "Output", unit: units.y },
      series: [
        { name: "measured", x: series(first, "u", k), y: series(first, "y", k), style: "pale" },
        ...runs.map((run, i): Series => ({
          name: nameOf(run.entry), x: series(run, "u", k), y: series(run, "simulated", k), colour: 1 + i,
        })),
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

/** What stands beside errors by frequency or amplitude. */
const EXCITED = "The noise has the bandwidth of the error. Bands in which little is excited are not drawn: their error is that of noise or of other frequencies.";

/** Errors of all records by frequency or amplitude, and the noise in them. */
function binsFigure(runs: Run[], by: "by_frequency" | "by_amplitude", x: Figure["x"]): Figure | undefined {
  const excited = (file: Record<typeof by, Bin[] | undefined>) => (file[by] ?? []).filter((bin) => !bin.little_excited);
  const all = runs.flatMap((run, i) =>
    run.answer.result.files.map((file: Record<typeof by, Bin[] | undefined>, j: number): Series => {
      const bins = excited(file);
      return {
        // One entry of the legend for all records.
        name: j === 0 ? nameOf(run.entry) : "", x: Float64Array.from(bins, (bin) => bin.at),
        y: Float64Array.from(bins, (bin) => bin.rms_pp_percent), style: "marks", colour: 1 + i,
      };
    }));
  if (all.every((one) => one.y.length === 0)) return undefined;
  const noise = runs[0]!.answer.result.files.map((file: Record<typeof by, Bin[] | undefined>, j: number): Series => {
    const bins = excited(file).filter((bin) => (bin.noise_rms_pp_percent ?? 0) > 0);
    return {
      name: j === 0 ? "noise in it" : "", x: Float64Array.from(bins, (bin) => bin.at),
      y: Float64Array.from(bins, (bin) => bin.noise_rms_pp_percent!), style: "dashed", colour: 7,
    };
  });
  return {
    title: by === "by_frequency" ? "Error by frequency" : "Error by amplitude",
    x,
    panels: [{
      y: { label: "Error, rms", unit: "% of peak-to-peak", log: true },
      series: [...all, ...noise.filter((one: Series) => one.y.length > 0)],
    }],
  };
}

/** Largest lag that is drawn [samples]. */
const LAGS = 20;

function whiteFigure(runs: Run[], k: number): Figure | undefined {
  const of = (run: Run) => run.answer.result.files[k]?.whiteness;
  const known = runs.filter((run) => of(run)?.autocorrelation?.length);
  if (known.length === 0) return undefined;
  const bound = of(known[0]!).autocorrelation_bound;
  return {
    title: "Autocorrelation of the residuals",
    x: { label: "Lag", unit: "samples" },
    panels: [{
      y: { label: "Autocorrelation", unit: "" },
      series: known.map((run): Series => ({
        name: nameOf(run.entry), y: Float64Array.from(of(run).autocorrelation.slice(0, LAGS)), start: 1, step: 1, style: "marks", colour: 1 + runs.indexOf(run),
      })),
      levels: [{ at: bound, label: "bound of noise" }, { at: -bound, label: "" }],
    }],
  };
}
