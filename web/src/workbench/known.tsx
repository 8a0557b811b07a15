// The right of the workbench: the next step, and what is known of the actuator.

import { useEffect, useId, useMemo, useState } from "preact/hooks";
import { Form } from "../form.tsx";
import { optionsOf } from "../lists.ts";
import { Outdated } from "../models.tsx";
import { download } from "../plot/download.ts";
import { operatorsOf } from "../pick.tsx";
import { prose, rough, short } from "../plot/ticks.ts";
import { remaining, spokenTime } from "../remaining.ts";
import { type ModelEntry, nameOf, type Options, proofOf, type RecordEntry, withSettings } from "../project.ts";
import { Chart, Fault, Notes, type Outcome, Table, useModel, useOutcome, useShared, Verdict } from "../ui.tsx";
import type { Job } from "../work.ts";
import type { Workspace } from "../workspace.ts";
import { convergence } from "./figures.ts";
import { Ranking } from "./ranking.tsx";
import { drawnModel, task, validated } from "./runs.ts";
import { identifiedFrom, identify, requestOf, type Search, type Trial } from "./search.ts";
import { useUndecided } from "./undecided.ts";

interface Props {
  /** The model that is used. */
  entry: ModelEntry | undefined;
  /** Models that are drawn. */
  drawn: ModelEntry[];
  draw(files: string[]): void;
  options: Options;
}

export function KnownPane({ entry, drawn, draw, options }: Props) {
  const { workspace } = useShared();
  const { records, models } = workspace.project;
  const { search } = workspace;
  return (
    <>
      {search?.isRunning && <Running search={search} />}
      {entry && !search?.isRunning && <Model key={entry.file} entry={entry} options={options} records={records} drawn={drawn} />}
      {!search?.isRunning && <Identify hasModel={models.length > 0} />}
      {models.length > 1 && <Models entry={entry} drawn={drawn} draw={draw} />}
    </>
  );
}

/** The stage of a search: its step, and how long it has taken; of a swarm the iterations. */
function stageOf({ what, done, total }: Job, iterations: number, seconds: number): string {
  const step = total > 0 ? `step ${Math.min(done + 1, total)} of ${total}` : "";
  const all = [step, iterations > 0 ? `${iterations} iterations` : "", seconds >= 3 ? `${Math.round(seconds)} s so far` : ""];
  return `${what || "Reading the records"}${all.some(Boolean) ? `: ${all.filter(Boolean).join(", ")}` : ""}`;
}

/** The seconds since a component is shown. */
function useSeconds(): number {
  const [start] = useState(() => performance.now());
  const [now, tick] = useState(start);
  useEffect(() => {
    const clock = setInterval(() => tick(performance.now()), 1000);
    return () => clearInterval(clock);
  }, []);
  return (now - start) / 1e3;
}

/** The identification as it runs. */
function Running({ search }: { search: Search }) {
  const job = useShared().workspace.jobs.find(({ name }) => name === "identify");
  const seconds = useSeconds();
  const figure = useMemo(() => convergence(search), [search.errors.length, search.costs.length]);
  return (
    <section aria-label="The search">
      <h2>The search</h2>
      <p role="status">{search.best ? `Drawn: the best fit so far, ${search.best.operator}.` : "The linear block comes first."}</p>
      {job && (
        <div class="row">
          <progress aria-label="identify" max={job.total || 1} value={job.done > 0 ? job.done : undefined} />
          <button type="button" onClick={job.cancel}>Cancel</button>
          <span aria-hidden="true">{spokenTime(remaining(job.marks, performance.now() / 1e3))}</span>
        </div>
      )}
      {job && <p class="help" aria-hidden="true">{stageOf(job, search.trials.length === 0 ? search.costs.length : 0, seconds)}</p>}
      {search.trials.length > 0 && <Ranking trials={search.trials} search={search} />}
      {figure && <Chart figure={figure} height={200} />}
    </section>
  );
}

/** What is identified, how, and its start. */
function Identify({ hasModel }: { hasModel: boolean }) {
  const { workspace, lists } = useShared();
  const { records, settings } = workspace.project;
  const { small, large, all } = identifiedFrom(records);
  const why = useId();
  const names = (entries: RecordEntry[]) => entries.map((entry) => entry.file).join(", ");
  const undecided = useUndecided(all);
  return (
    <section aria-label="Identification">
      <h2>{hasModel ? "Identify again" : "Next: identify"}</h2>
      {all.length > 0
        ? <p>{large.length > 0 && `Large signals: ${names(large)}. `}{small.length > 0 && `Small signals: ${names(small)}.`}</p>
        : <p class="missing">No record is marked for identification: choose its use at the left.</p>}
      <div class="row">
        <button type="button" class={hasModel ? "" : "main"} disabled={all.length === 0 || undecided.length > 0} aria-describedby={why}
          onClick={() => void identify(workspace)}>Identify</button>
        <span id={why} class="bad">{undecided.join("; ")}</span>
      </div>
      {workspace.search?.of === requestOf(workspace) && <Fault text={workspace.search.error} />}
      <details>
        <summary>Operators, effort, order</summary>
        <Form
          rows={optionsOf(lists, "identify")}
          values={settings["identify"] ?? {}}
          change={(next) => workspace.change((project) => withSettings(project, "identify", next))}
          names={{ operator: operatorsOf(lists) }}
          first={["operator", "effort", "method", "order", "creep"]}
        />
      </details>
    </section>
  );
}

/** The proof of a model on records that it was not identified from; the verdict is kept with the model. */
function useProof(entry: ModelEntry, records: RecordEntry[], options: Options): Outcome<any> & { proof: RecordEntry[] } {
  const { workspace } = useShared();
  const proof = proofOf(entry, records);
  const key = proof.length > 0 ? JSON.stringify([entry.file, proof, options]) : undefined;
  const outcome = useOutcome(key, () => validated(workspace, drawnModel(entry, 1), proof, options));
  const { sentence, verdict } = outcome.value?.result ?? {};
  useEffect(() => {
    if (!sentence) return;
    const found = { validated: sentence, error: verdict.worst_percent ?? verdict.error_percent };
    if (entry.validated === found.validated && entry.error === found.error) return;
    workspace.amend((project) => ({
      ...project, models: project.models.map((one) => (one.file === entry.file ? { ...one, ...found } : one)),
    }));
  }, [sentence]);
  return { ...outcome, proof };
}

const percent = (value: number): string => `${rough(value)} %`;

/** What is known of a model: the verdict, then the figures, then the details. */
function Model({ entry, options, records, drawn }: { entry: ModelEntry; options: Options; records: RecordEntry[]; drawn: ModelEntry[] }) {
  const { workspace } = useShared();
  const read = useModel();
  const proof = useProof(entry, records, options);
  const trials: Trial[] = read.value?.fit?.trials ?? [];
  const parameters: { name: string; value: number; error: number }[] = read.value?.fit?.parameters ?? [];
  const { search } = workspace;
  const files: any[] = proof.value?.result.files ?? [];
  const save = async () => download(entry.file, (await workspace.bytes(entry.file)) as BlobPart, "application/json");
  return (
    <section aria-label={`Model ${nameOf(entry)}`}>
      <h2>{nameOf(entry)}</h2>
      <Verdict text={entry.validated ?? entry.verdict} />
      <Fault text={read.error ?? proof.error} />
      <Outdated entry={entry} />
      <div class="row">
        <a class="button main" href="#compensate">Compensate a path</a>
        <a class="button" href="#export">Export</a>
      </div>
      <Proof records={proof.proof} files={proof.busy ? [] : files} />
      {trials.length > 1 && <Ranking trials={trials} search={search?.result === entry.file ? search : undefined} />}
      <details>
        <summary>Parameters and notes</summary>
        <p>{prose(entry.summary)}</p>
        {entry.validated && <p>When it was identified: {prose(entry.verdict)}</p>}
        {parameters.length > 0 && (
          <Table caption="Parameters with standard errors" head={["Parameter", "Value", "Standard error"]}
            rows={parameters.map(({ name, value, error }) => [name, short(value), short(error)])} />
        )}
        <Notes title="" notes={entry.notes} />
      </details>
      <div class="row">
        <button type="button" onClick={() => void save()}>Download the model</button>
        {proof.proof.length > 0 && <Report models={drawn.includes(entry) ? drawn : [entry]} records={proof.proof} options={options} />}
      </div>
    </section>
  );
}

/** The records of the proof, which the report is of too, each with its error; and where they are chosen. */
function Proof({ records, files }: { records: RecordEntry[]; files: any[] }) {
  const meant = records.some((one) => one.use === "validation");
  const choose = () => document.querySelector<HTMLElement>(".records select")?.focus();
  return (
    <>
      <h3>Records of the proof and the report</h3>
      {records.length > 0 && (
        <dl class="errors" aria-label="Errors on the records of the proof, of the stroke">
          {records.map(({ file }, k) => (
            <div key={file}>
              <dt>{file}</dt>
              <dd>{files[k] && <b>{percent(files[k].rms_pp_percent)}</b>}{files[k]?.floor && <small> noise {percent(files[k].floor.rms_pp_percent)}</small>}</dd>
            </div>
          ))}
        </dl>
      )}
      <p class="help">
        {records.length === 0 ? "Not validated on another record: add one, with the use \u201cvalidate\u201d."
          : meant ? "Those of the use \u201cvalidate\u201d." : "No record has the use \u201cvalidate\u201d: these are all that the model was not identified from."}
        {records.length > 0 && <>{" "}<button type="button" class="link" onClick={choose}>Choose them by their use</button></>}
      </p>
    </>
  );
}

/** The report of a model, or the page that compares several. */
function Report({ models, records, options }: { models: ModelEntry[]; records: RecordEntry[]; options: Options }) {
  const { workspace } = useShared();
  const call = models.length > 1 ? "compare" : "report";
  const make = async () => {
    // Only a project in a folder is the same for whoever opens its page; a browser keeps its own.
    const linked = workspace.store.own ? options : { ...options, project: location.href };
    const answer = await workspace.run(await task(workspace, call, models.map(({ file }) => file), records, linked));
    for (const file of answer.files) download(file.name, file.bytes as BlobPart, "text/html");
  };
  return (
    <button type="button" onClick={() => make().catch((error) => workspace.failed(error))}>
      {models.length > 1 ? "Page that compares them" : `Report of ${nameOf(models[0]!)}`}
    </button>
  );
}

/** The models of the project: which is used, and which are drawn. */
function Models({ entry, drawn, draw }: Pick<Props, "entry" | "drawn" | "draw">) {
  const { workspace } = useShared();
  const { models } = workspace.project;
  const toggle = (file: string, on: boolean) =>
    draw(models.map((one) => one.file).filter((one) => (one === file ? on : drawn.some((other) => other.file === one))));
  return (
    <section aria-label="Models">
      <h2>Models</h2>
      <ul class="models">
        {models.map((one) => (
          <li key={one.file} class={one === entry ? "marked" : ""}>
            <input type="checkbox" aria-label={`Draw ${one.file}`} checked={drawn.includes(one)} onChange={(event) => toggle(one.file, event.currentTarget.checked)} />
            <button type="button" class="link" aria-pressed={one === entry} onClick={() => use(workspace, one)}>{one.file}</button>
            <button type="button" class="quiet" aria-label={`Remove ${one.file}`} title="Remove" onClick={() => remove(workspace, one)}>{"\u00d7"}</button>
            <small>{prose(one.validated ?? (one.verdict || one.summary))}</small>
          </li>
        ))}
      </ul>
    </section>
  );
}

const use = (workspace: Workspace, { file }: ModelEntry) => workspace.change((project) => ({ ...project, model: file }));

function remove(workspace: Workspace, { file }: ModelEntry): void {
  workspace.change((project) => {
    const { model: _, ...others } = project;
    const models = project.models.filter((one) => one.file !== file);
    const last = models.at(-1)?.file;
    return { ...others, models, ...(last !== undefined && { model: last }) };
  });
}
