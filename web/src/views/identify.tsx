// Identify: operators side by side as they are fitted, the ranking, and what the records prove of the model.

import { useMemo, useState } from "preact/hooks";
import { Form } from "../form.tsx";
import { optionsOf } from "../lists.ts";
import { type Figure } from "../plot/figure.ts";
import { download } from "../plot/download.ts";
import { prose, short } from "../plot/ticks.ts";
import { Outdated } from "../models.tsx";
import { type ModelEntry, type RecordEntry, withSettings } from "../project.ts";
import { Cancelled } from "../packet.ts";
import { Chart, Fault, Missing, Notes, Section, Table, useLatest, useOutcome, useShared, useWork, Verdict } from "../ui.tsx";
import type { Workspace } from "../workspace.ts";
import { loopsFigure, type Run, timeFigure } from "./validate.tsx";

/** What is known of an operator while it is fitted. */
interface Trial {
  operator: string;
  parameters?: number;
  held_out_percent?: number | null;
  free_run_percent?: number | null;
  /** By which operators are ranked. */
  error_percent?: number | null;
  verdict?: string;
}

/** A step of the search: its figures, and the text of the file of a better model. */
interface SearchStep {
  what: string;
  figures: Record<string, number>;
  model?: string;
}

export function IdentifyView() {
  const { workspace, lists } = useShared();
  const { records, models, settings } = workspace.project;
  const values = settings["identify"] ?? {};
  const work = useWork<void>();
  const [steps, setSteps] = useState<SearchStep[]>([]);
  const large = records.filter((entry) => entry.use === "training");
  const small = records.filter((entry) => entry.use === "small-signal");
  const start = () => {
    setSteps([]);
    work.start(() => identify(workspace, small, large, (step) => setSteps((before) => [...before, step])));
  };
  const ready = large.length + small.length > 0;
  return (
    <>
      <Section title="Identification" wide>
        {ready ? (
          <p>
            Large signals: {named(large) || "none"}. Small signals: {named(small) || "none"}.{" "}
            <a href="#data">Change their use</a>
          </p>
        ) : <Missing what="No record is marked for identification." view="data" title="Choose records" />}
        <Form
          rows={optionsOf(lists, "identify")}
          values={values}
          change={(next) => workspace.change((project) => withSettings(project, "identify", next))}
          names={{ operator: [{ name: "auto", summary: "all that suit the records" }, ...lists.operators] }}
          first={["operator", "effort", "method", "order", "creep"]}
        />
        <div class="row">
          <button type="button" class="main" disabled={!ready || work.busy} onClick={start}>Identify</button>
          {work.busy && <span role="status">Identifying. Cancel is at the lower right.</span>}
        </div>
        <Fault text={work.error} />
      </Section>
      {(work.busy || work.error) && steps.length > 0 && <Search steps={steps} records={large.length > 0 ? large : small} />}
      {models.length > 0 && <Models />}
    </>
  );
}

const named = (entries: RecordEntry[]) => entries.map((entry) => entry.file).join(", ");

/** Identifies a model and adds it to the project. */
async function identify(workspace: Workspace, small: RecordEntry[], large: RecordEntry[], report: (step: SearchStep) => void): Promise<void> {
  const { files, records } = await workspace.sources([...small, ...large]);
  const options = workspace.project.settings["identify"] ?? {};
  const names = (entries: RecordEntry[]) => entries.map((entry) => entry.file);
  let best: string | undefined;
  const cancelled = async (error: unknown) => {
    if (!(error instanceof Cancelled) || best === undefined) throw error;
    await workspace.addModel({ name: "cancelled.json", bytes: new TextEncoder().encode(best) }, {
      summary: "", verdict: "The search was cancelled: this is the best model until then.", notes: [], from: [...small, ...large],
    });
    throw error;
  };
  const answer = await workspace.run({
    name: "identify",
    request: { call: "identify", options, records, files: { small_signal: names(small), large_signal: names(large) } },
    files,
    onStage: (what, figures, model) => {
      best = model ?? best;
      if (model !== undefined || Object.keys(figures).length > 0) report({ what, figures, ...(model !== undefined && { model }) });
    },
  }).catch(cancelled);
  const [file] = answer.files;
  if (!file) return;
  const { model, sentence, notes, reasons } = answer.result;
  const operator = String(answer.result.found.operator);
  await workspace.addModel({ name: `${operator}.json`, bytes: file.bytes }, {
    summary: model, verdict: sentence ?? "", notes: [...(notes ?? []), ...(reasons ?? [])], from: [...small, ...large],
  });
}

/** The search while it runs: the best model so far, what each operator has reached, and the errors in the order of the fits. */
function Search({ steps, records }: { steps: SearchStep[]; records: RecordEntry[] }) {
  const trials = useMemo(() => {
    const found = new Map<string, Trial>();
    for (const { what, figures } of steps) {
      if ("held_out_percent" in figures) found.set(what, { operator: what, ...found.get(what), ...figures });
    }
    return [...found.values()];
  }, [steps]);
  const figure = useMemo(() => convergence(steps), [steps]);
  return (
    <Section title="The search" wide>
      <BestSoFar model={steps.filter(({ model }) => model !== undefined).at(-1)?.model} records={records} />
      {trials.length > 0 && <Ranking trials={trials} />}
      {figure && <Chart figure={figure} height={220} />}
    </Section>
  );
}

/** Loop and errors of the best model so far, on the first record. */
function BestSoFar({ model, records }: { model: string | undefined; records: RecordEntry[] }) {
  const { workspace } = useShared();
  const drawn = useLatest(model, async (): Promise<Run> => {
    const { files, records: origins } = await workspace.sources(records.slice(0, 1));
    const file = { name: "best so far.json", bytes: new TextEncoder().encode(model) };
    const answer = await workspace.run({
      name: "best so far",
      request: {
        call: "validate", options: { offset: "free" }, records: origins,
        files: { model: [file.name], data: records.slice(0, 1).map((entry) => entry.file) },
      },
      files: [file, ...files], quiet: true, beside: true,
    });
    return { entry: { file: file.name, summary: "", verdict: "", notes: [] }, answer };
  });
  const figures = useMemo(() => drawn.value && [loopsFigure([drawn.value], 0), timeFigure([drawn.value], 0)], [drawn.value]);
  if (!figures) return null;
  return <>{figures.map((figure) => <Chart key={figure.title} figure={figure} height={320} />)}</>;
}

/** The costs of a swarm, or the errors of the operators, in the order in which they were found. */
function convergence(steps: SearchStep[]): Figure | undefined {
  const by = (name: string) => steps.filter(({ figures }) => name in figures).map(({ figures }) => figures[name]!);
  const [errors, costs] = [by("held_out_percent").filter(Number.isFinite), by("cost")];
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

/** The error of an operator; while it is fitted, the held-out error alone is known. */
const errorOf = (trial: Trial): number => trial.error_percent ?? trial.held_out_percent ?? Infinity;

function Ranking({ trials }: { trials: Trial[] }) {
  const sorted = [...trials].sort((a, b) => errorOf(a) - errorOf(b));
  const least = Math.log(Math.max(1e-6, Math.min(...sorted.map(errorOf))) / 2);
  const most = Math.log(Math.max(...sorted.map(errorOf).filter(Number.isFinite), 1e-5));
  const bar = (trial: Trial) => {
    const error = errorOf(trial);
    return Number.isFinite(error)
      ? <meter min={0} max={1} value={most > least ? (Math.log(Math.max(1e-6, error)) - least) / (most - least) : 1} aria-label={`error of ${trial.operator}`} />
      : "";
  };
  const percent = (value: number | null | undefined) => (value === null || value === undefined ? "" : `${short(value)} %`);
  const rows = sorted.map((trial) => [
    trial.operator,
    trial.parameters === undefined ? "" : String(trial.parameters),
    percent(trial.held_out_percent),
    percent(trial.free_run_percent),
    bar(trial),
    trial.verdict ?? "",
  ]);
  return (
    <Table
      caption="Operators by their larger error"
      head={["Operator", "Parameters", "Held-out error", "Free-run error", "Larger of the two, on a logarithmic scale", ""]}
      rows={rows}
      marked={sorted.findIndex((trial) => trial.verdict === "taken")}
    />
  );
}

function Models() {
  const { workspace } = useShared();
  const { models, model } = workspace.project;
  const entry = models.find((one) => one.file === model) ?? models.at(-1)!;
  const remove = (file: string) =>
    workspace.change((project) => {
      const { model: _, ...others } = project;
      const left = project.models.filter((one) => one.file !== file);
      const last = left.at(-1)?.file;
      return { ...others, models: left, ...(last !== undefined && { model: last }) };
    });
  const rows = models.map((one) => [
    <button type="button" class="link" aria-pressed={one === entry}
      onClick={() => workspace.change((project) => ({ ...project, model: one.file }))}>
      {one.file}
    </button>,
    prose(one.verdict || one.summary),
    <button type="button" aria-label={`Remove ${one.file}`} onClick={() => remove(one.file)}>Remove</button>,
  ]);
  return (
    <>
      <Section title="Models" wide>
        <Table caption="Models of this project" head={["Model", "What is proven", ""]} rows={rows} marked={models.indexOf(entry)} />
      </Section>
      <ModelView key={entry.file} entry={entry} />
    </>
  );
}

function ModelView({ entry }: { entry: ModelEntry }) {
  const { workspace } = useShared();
  const read = useOutcome(entry.file, async () => JSON.parse(new TextDecoder().decode(await workspace.bytes(entry.file))));
  const model = read.value;
  const trials: Trial[] = model?.fit?.trials ?? [];
  const parameters: { name: string; value: number; error: number }[] = model?.fit?.parameters ?? [];
  const save = async () => download(entry.file, (await workspace.bytes(entry.file)) as BlobPart, "application/json");
  return (
    <>
      <Section title={entry.file} wide>
        <Fault text={read.error} />
        <p>{prose(entry.summary)}</p>
        <Verdict text={entry.verdict} />
        <Verdict of="Validated" text={entry.validated} />
        <Outdated entry={entry} />
        <div class="row">
          <button type="button" onClick={() => void save()}>Download the model</button>
          <a href="#validate">Validate it</a>
          <a href="#compensate">Compensate with it</a>
          <a href="#export">Export it</a>
        </div>
      </Section>
      {trials.length > 1 && <Section title="Operators that were tried" wide><Ranking trials={trials} /></Section>}
      {parameters.length > 0 && (
        <Section title="Parameters" help="With their standard errors.">
          <Table
            caption="Parameters with standard errors"
            head={["Parameter", "Value", "Standard error"]}
            rows={parameters.map(({ name, value, error }) => [name, short(value), short(error)])}
          />
        </Section>
      )}
      {entry.notes.length > 0 && <Section title="Notes"><Notes title="" notes={entry.notes} /></Section>}
    </>
  );
}
