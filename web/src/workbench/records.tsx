// The left of the workbench: the records with their use, and how the one that is shown is read.

import { useRef, useState } from "preact/hooks";
import { whole } from "../alike.ts";
import { taken } from "../app.tsx";
import { ExampleButton } from "../example.tsx";
import { Form } from "../form.tsx";
import { optionsOf } from "../lists.ts";
import type { Answer } from "../packet.ts";
import { short, si, unit } from "../plot/ticks.ts";
import { filesOf, nameOf, proofOf, type RecordEntry, type Use, usedModel } from "../project.ts";
import { RigLine } from "../rig.tsx";
import { Notes, useOutcome, useShared } from "../ui.tsx";
import { useProposals } from "../uses.ts";
import { READING } from "../work.ts";
import { useUnknownUnits } from "./undecided.ts";

const USES: [Use, string][] = [
  ["training", "identify: large signal"],
  ["small-signal", "identify: small signal"],
  ["validation", "validate"],
  ["none", "not used"],
];

/** Where files are dropped or chosen; large while there is no record. */
export function Drop() {
  const { workspace } = useShared();
  const input = useRef<HTMLInputElement>(null);
  const first = workspace.project.records.length === 0;
  return (
    <div class={first ? "drop first" : "drop"}>
      <p>
        {first ? "Drop measured records here: " : "Drop more here, or "}
        {first && "CSV of any kind, MATLAB, HDF5, TDMS, NumPy, oscilloscopes. A record holds the voltage and the displacement. "}
      </p>
      <button type="button" class={first ? "main" : ""} onClick={() => input.current?.click()}>Choose files</button>
      {first && <ExampleButton workspace={workspace} title="Open the example" />}
      <input
        ref={input}
        type="file"
        multiple
        hidden
        aria-label="Data files"
        onChange={(event) => {
          const files = [...(event.currentTarget.files ?? [])];
          event.currentTarget.value = "";
          void taken(files, workspace);
        }}
      />
      {!workspace.store.own && <Folder />}
      <Reading />
    </div>
  );
}

/** The files that are being read. */
function Reading() {
  const jobs = useShared().workspace.jobs.filter(({ name }) => name === READING);
  return (
    <div class="reading" role="status">
      {jobs.map(({ what, done, total }, k) => (
        <p key={k}>
          <b>{what}</b> {done < total || total === 0 ? "reading" : "inspecting"}{" "}
          <progress aria-label={`reading ${what}`} max={total || 1} value={done < total ? done : undefined} />
        </p>
      ))}
    </div>
  );
}

/** Files of the project folder that are no records of the project yet. */
function Folder() {
  const { workspace } = useShared();
  const { records } = workspace.project;
  const found = useOutcome(JSON.stringify(records.map((one) => one.file)), () => workspace.store.names());
  const known = new Set(filesOf(workspace.project));
  const names = (found.value ?? []).filter((name) => !known.has(name) && !NO_RECORDS.test(name));
  const add = (some: string[]) =>
    workspace.reading(some, () => workspace.addStored(some.map((file) => ({ file, use: "training" })), { asRig: true })).catch((error) => workspace.failed(error));
  return names.length === 0 ? null : (
    <details open={records.length === 0 && names.length <= 12}>
      <summary>{names.length} more {names.length === 1 ? "file" : "files"} in the project folder</summary>
      <div class="row">
        {names.map((name) => <button key={name} type="button" class="choice" onClick={() => void add([name])}>Add {name}</button>)}
        {names.length > 1 && <button type="button" onClick={() => void add(names)}>Add all</button>}
      </div>
    </details>
  );
}

/** Files with these endings are no records. */
const NO_RECORDS = /^\.|\.(json|zip|html|md|toml|png|svg|pdf|py|m|c|h)$/i;

/** The records, each with its state and use. */
export function Records({ shown }: { shown: RecordEntry | undefined }) {
  const { workspace } = useShared();
  const { records } = workspace.project;
  useProposals();
  const model = usedModel(workspace.project);
  const proof = model ? proofOf(model, records) : [];
  /** What a record is to the model. */
  const part = (entry: RecordEntry): string =>
    proof.includes(entry) ? `; proves ${nameOf(model!)}` : model?.from?.some((one) => one.file === entry.file) && entry.use === "validation" ? `; ${nameOf(model)} was identified from it: no proof` : "";
  const remove = (file: string) =>
    workspace.change((project) => ({ ...project, records: project.records.filter((one) => one.file !== file) }));
  return (
    <ul class="records" aria-label="Records and their use">
      {records.map((entry) => (
        <li key={entry.file} class={entry === shown ? "marked" : ""}>
          <button type="button" class="link" aria-pressed={entry === shown}
            onClick={() => workspace.amend((project) => ({ ...project, record: entry.file }))}>
            {entry.file}
          </button>
          <State entry={entry} part={part(entry)} />
          <select aria-label={`Use of ${entry.file}`} value={entry.use}
            onChange={(event) => workspace.tell(withUse(entry, event.currentTarget.value as Use))}>
            {USES.map(([use, title]) => <option key={use} value={use}>{title}</option>)}
          </select>
          <button type="button" class="quiet" aria-label={`Remove ${entry.file}`} title="Remove" onClick={() => remove(entry.file)}>{"\u00d7"}</button>
          {entry.because && <small class="because">proposed: {entry.because}</small>}
        </li>
      ))}
    </ul>
  );
}

/** The record with a use that was chosen by hand, which needs no reason. */
function withUse({ because: _, ...entry }: RecordEntry, use: Use): RecordEntry {
  return { ...entry, use };
}

/** Whether a record can be used, and what it is to the model. */
function State({ entry, part }: { entry: RecordEntry; part: string }) {
  const { workspace } = useShared();
  const inspection = useOutcome(JSON.stringify(whole(entry)), () => workspace.inspected(whole(entry)));
  const count = inspection.value?.result.problems.length ?? 0;
  if (inspection.error) return <small class="bad">cannot be read</small>;
  if (!inspection.value) return <small>{"\u2026"}</small>;
  if (!inspection.value.result.record) return <small class="bad">roles not decided</small>;
  return <small>{count === 0 ? "read" : `read; ${count} ${count === 1 ? "problem" : "problems"}`}{part}</small>;
}

interface Channel {
  name: string;
  unit: string;
  samples: number;
  low: number;
  high: number;
  role: "time" | "input" | "output" | null;
  flaw: string | null;
}

const ROLES = { time: "time_col", input: "input_col", output: "output_col" } as const;

/** How the shown record is read and prepared. */
export function Details({ entry, inspection, prepared }: { entry: RecordEntry; inspection: Answer | undefined; prepared: Answer | undefined }) {
  const { workspace, lists } = useShared();
  // Roles that are chosen by hand stay in sight once they are decided.
  const [choosing, choose] = useState(false);
  const result = inspection?.result;
  const record = result?.record;
  const unknown = useUnknownUnits(record?.units);
  const rows = lists.columns.filter((row) => !Object.values(ROLES).includes(row.name as "time_col"));
  return (
    <>
      <h2>{entry.file}</h2>
      {record && (
        <p>
          {result.format}, {record.samples.toLocaleString("en")} samples, {si(record.duration, "s")}, one every{" "}
          {si(record.ts, "s")}; input in {unit(record.units.u)}, output in {unit(record.units.y)}
        </p>
      )}
      {unknown.map((text) => <p key={text} class="stale" role="status">{text}</p>)}
      {result && <Notes title="Problems" notes={result.problems} />}
      <RigLine entry={entry} />
      {result?.channels && (
        <details open={!record || choosing}>
          <summary>Channels</summary>
          <Channels entry={entry} channels={result.channels} chosen={() => choose(true)} />
        </details>
      )}
      <details>
        <summary>Units, rate and part</summary>
        <Form rows={rows} values={entry.columns} change={(values) => workspace.tell({ ...entry, columns: values })}
          first={["input_unit", "output_unit", "input_scale", "output_scale", "from", "to"]} />
      </details>
      <details>
        <summary>Preparation</summary>
        <p class="help">Changes of the record before the identification. The file stays as it is.</p>
        <Form rows={optionsOf(lists, "prepare")} values={entry.prepare} change={(prepare) => workspace.tell({ ...entry, prepare })}
          first={["detrend", "outliers", "decimate", "delay"]} />
      </details>
      <details open={prepared !== undefined}>
        <summary>{prepared ? "Preparation of this record" : "How it is read"}</summary>
        <Notes title="" notes={(prepared ?? inspection)?.result.history ?? []} />
      </details>
    </>
  );
}

function Channels({ entry, channels, chosen }: { entry: RecordEntry; channels: Channel[]; chosen(): void }) {
  const { workspace } = useShared();
  const lacking = (["input", "output"] as const).filter((role) => !channels.some((channel) => channel.role === role));
  const left = channels.filter(({ role, flaw }) => !role && !flaw);
  // What is chosen stands at once, while the file is read so: arrow keys go on from there.
  const roleOf = ({ name, role }: Channel, k: number) =>
    Object.entries(ROLES).find(([, option]) => [name, String(k + 1)].includes(String(entry.columns[option] ?? "")))?.[0] ?? role ?? "";
  const choose = (channel: Channel, k: number, role: string) => {
    chosen();
    const columns = { ...entry.columns };
    for (const option of Object.values(ROLES)) {
      if (columns[option] === channel.name || columns[option] === String(k + 1)) delete columns[option];
    }
    const named = channels.filter((one) => one.name === channel.name).length === 1;
    if (role) columns[ROLES[role as keyof typeof ROLES]] = named ? channel.name : String(k + 1);
    workspace.tell({ ...entry, columns });
  };
  return (
    <>
      {lacking.length > 0
        ? <p>Which channel is the {lacking.join(", and which the ")}?</p>
        : <p class="help">The roles are guessed from names, units and values. Choose others where they are wrong.</p>}
      {lacking.length === 1 && left.length === 1 && (
        <button type="button" class="main" onClick={() => choose(left[0]!, channels.indexOf(left[0]!), lacking[0]!)}>Use {left[0]!.name || "the other column"} as the {lacking[0]}</button>
      )}
      <ul class="channels">
        {channels.map((channel, k) => (
          <li key={k}>
            <b>{channel.name || `column ${k + 1}`}</b>
            <select aria-label={`Role of ${channel.name}`} value={roleOf(channel, k)} onChange={(event) => choose(channel, k, event.currentTarget.value)}>
              <option value="">not used</option>
              {Object.keys(ROLES).map((role) => <option key={role} value={role}>{role}</option>)}
            </select>
            <small>{short(channel.low)} to {short(channel.high)} {unit(channel.unit ?? "")}{channel.flaw && `; ${channel.flaw}`}</small>
          </li>
        ))}
      </ul>
    </>
  );
}
