// Data: records as they are read, what seems wrong with them, and how they are prepared.

import { useMemo, useRef } from "preact/hooks";
import { taken } from "../app.tsx";
import { example } from "../example.ts";
import { Form } from "../form.tsx";
import { optionsOf } from "../lists.ts";
import type { Answer } from "../packet.ts";
import type { Figure } from "../plot/figure.ts";
import { short, si, unit } from "../plot/ticks.ts";
import { filesOf, type RecordEntry, type Use } from "../project.ts";
import { Chart, Fault, Notes, Section, Table, useOutcome, useShared } from "../ui.tsx";

const USES: [Use, string][] = [
  ["training", "identify: large signal"],
  ["small-signal", "identify: small signal"],
  ["validation", "validate"],
  ["none", "not used"],
];

export function DataView() {
  const { workspace } = useShared();
  const { records, record } = workspace.project;
  const entry = records.find((one) => one.file === record) ?? records.at(-1);
  return (
    <>
      <Drop />
      {records.length > 0 && <Records shown={entry} />}
      {entry && <RecordView key={entry.file} entry={entry} />}
    </>
  );
}

function Drop() {
  const { workspace } = useShared();
  const input = useRef<HTMLInputElement>(null);
  const first = workspace.project.records.length === 0;
  return (
    <div class={first ? "drop first" : "drop"}>
      <p>
        {first ? "Drop measured records here: " : "Drop more records here, or "}
        {first && "CSV of any kind, MATLAB, HDF5, TDMS, NumPy, oscilloscopes. A record holds the voltage and the displacement. "}
      </p>
      <button type="button" class="main" onClick={() => input.current?.click()}>Choose files</button>
      {first && <button type="button" onClick={() => void example(workspace)}>Open the example</button>}
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
  const add = (some: string[]) => workspace.addStored(some.map((file) => ({ file, use: "training" }))).catch((error) => workspace.failed(error));
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

function Records({ shown }: { shown: RecordEntry | undefined }) {
  const { workspace } = useShared();
  const { records } = workspace.project;
  const remove = (file: string) =>
    workspace.change((project) => ({ ...project, records: project.records.filter((one) => one.file !== file) }));
  const rows = records.map((entry) => [
    <button
      type="button"
      class="link"
      aria-pressed={entry === shown}
      onClick={() => workspace.change((project) => ({ ...project, record: entry.file }))}
    >
      {entry.file}
    </button>,
    <State entry={entry} />,
    <select
      aria-label={`Use of ${entry.file}`}
      value={entry.use}
      onChange={(event) => workspace.tell({ ...entry, use: event.currentTarget.value as Use })}
    >
      {USES.map(([use, title]) => <option key={use} value={use}>{title}</option>)}
    </select>,
    <button type="button" aria-label={`Remove ${entry.file}`} onClick={() => remove(entry.file)}>Remove</button>,
  ]);
  return (
    <Section title="Records" wide>
      <Table caption="Records and their use" head={["Record", "State", "Use", ""]} rows={rows} marked={shown ? records.indexOf(shown) : -1} />
    </Section>
  );
}

/** The record without its cut. */
function whole(entry: RecordEntry): RecordEntry {
  const { from: _f, to: _t, ...columns } = entry.columns;
  return { ...entry, columns };
}

/** Whether a record can be used. */
function State({ entry }: { entry: RecordEntry }) {
  const { workspace } = useShared();
  const inspection = useOutcome(JSON.stringify(whole(entry)), () => workspace.inspected(whole(entry)));
  const count = inspection.value?.result.problems.length ?? 0;
  if (inspection.error) return <span class="bad">cannot be read</span>;
  if (!inspection.value) return <>{"\u2026"}</>;
  if (!inspection.value.result.record) return <span class="bad">roles not decided</span>;
  return <>{count === 0 ? "read" : `read; ${count} ${count === 1 ? "problem" : "problems"}`}</>;
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

function RecordView({ entry }: { entry: RecordEntry }) {
  const { workspace, lists } = useShared();
  const { from, to } = entry.columns;
  const inspection = useOutcome(JSON.stringify(whole(entry)), () => workspace.inspected(whole(entry)));
  const changed = from !== undefined || to !== undefined || Object.keys(entry.prepare).length > 0;
  const outcome = useOutcome(changed && inspection.value?.result.record ? JSON.stringify(entry) : undefined, () => workspace.prepared(entry));
  const result = inspection.value?.result;
  const record = result?.record;
  const shift = Number(from ?? 0);
  const figure = useMemo(() => inspection.value && record && recordFigure(entry, inspection.value, outcome.value, shift), [inspection.value, outcome.value, entry]);
  const cut = (end: "from" | "to") => (x: number, _: number, done: boolean) => {
    const [first, last] = [Number(from ?? 0), Number(to ?? record.duration)];
    const at = Number(Math.max(0, Math.min(record.duration, x)).toPrecision(6));
    const ends = end === "from" ? { from: Math.min(at, last), to: last } : { from: first, to: Math.max(at, first) };
    const { from: _f, to: _t, ...others } = entry.columns;
    const kept = { ...(ends.from > 0 && { from: ends.from }), ...(ends.to < record.duration && { to: ends.to }) };
    workspace.tell({ ...entry, columns: { ...others, ...kept } }, !done);
  };
  const handled: Figure | undefined = figure && {
    ...figure,
    ...(changed && { span: { from: shift, to: Number(to ?? record.duration) } }),
    handles: [
      { label: "Start of the part that is used [s]", x: shift, y: 0, moves: "x", moved: cut("from") },
      { label: "End of the part that is used [s]", x: Number(to ?? record.duration), y: 0, moves: "x", moved: cut("to") },
    ],
  };
  const rows = lists.columns.filter((row) => !Object.values(ROLES).includes(row.name as "time_col"));
  return (
    <>
      <Section title={entry.file} wide>
        {record && (
          <p>
            {result.format}, {record.samples.toLocaleString("en")} samples, {si(record.duration, "s")}, one every{" "}
            {si(record.ts, "s")}; input in {unit(record.units.u)}, output in {unit(record.units.y)}
          </p>
        )}
        <Fault text={inspection.error ?? outcome.error} />
        {inspection.busy && !figure && <p class="missing">Reading {entry.file}.</p>}
        {handled && <Chart figure={handled} />}
        {result && <Notes title="Problems" notes={result.problems} />}
        {outcome.value && <Notes title="Preparation of this record" notes={outcome.value.result.history ?? []} />}
        {result && !outcome.value && <Notes title="How it is read" notes={result.history} />}
      </Section>
      {result?.channels && <Channels entry={entry} channels={result.channels} />}
      <Section title="Units, rate and part">
        <Form rows={rows} values={entry.columns} change={(values) => workspace.tell({ ...entry, columns: values })}
          first={["input_unit", "output_unit", "input_scale", "output_scale", "from", "to"]} />
      </Section>
      <Section title="Preparation" help="Changes of the record before the identification. The file stays as it is.">
        <Form
          rows={optionsOf(lists, "prepare")}
          values={entry.prepare}
          change={(prepare) => workspace.tell({ ...entry, prepare })}
          first={["detrend", "outliers", "decimate", "delay"]}
        />
      </Section>
    </>
  );
}

function Channels({ entry, channels }: { entry: RecordEntry; channels: Channel[] }) {
  const { workspace } = useShared();
  const choose = (channel: Channel, k: number, role: string) => {
    const columns = { ...entry.columns };
    for (const option of Object.values(ROLES)) {
      if (columns[option] === channel.name || columns[option] === String(k + 1)) delete columns[option];
    }
    const named = channels.filter((one) => one.name === channel.name).length === 1;
    if (role) columns[ROLES[role as keyof typeof ROLES]] = named ? channel.name : String(k + 1);
    workspace.tell({ ...entry, columns });
  };
  const rows = channels.map((channel, k) => [
    channel.name || `column ${k + 1}`,
    <select
      aria-label={`Role of ${channel.name}`}
      value={channel.role ?? ""}
      onChange={(event) => choose(channel, k, event.currentTarget.value)}
    >
      <option value="">not used</option>
      {Object.keys(ROLES).map((role) => <option key={role} value={role}>{role}</option>)}
    </select>,
    unit(channel.unit ?? ""),
    `${short(channel.low)} to ${short(channel.high)}`,
    channel.flaw ?? "",
  ]);
  return (
    <Section title="Channels" help="The roles are guessed from names, units and values. Choose others where they are wrong.">
      <Table caption="Channels of the file" head={["Channel", "Role", "Unit", "Values", "Flaw"]} rows={rows} />
    </Section>
  );
}

/** Input and output against time, and what is identified of them. */
function recordFigure(entry: RecordEntry, inspection: Answer, outcome: Answer | undefined, shift: number): Figure {
  const { record, defects } = inspection.result;
  const prepared = outcome?.result.record;
  const panel = (of: "u" | "y", label: string, colour: number) => {
    const whole = { name: outcome ? "as measured" : "", y: inspection.series.get(of)!, step: record.ts };
    const used = outcome && {
      name: "as used", y: outcome.series.get(of)!, start: shift, step: prepared?.ts ?? record.ts, colour,
    };
    return {
      y: { label, unit: record.units[of] },
      series: used ? [{ ...whole, style: "pale" as const }, used] : [{ ...whole, colour }],
    };
  };
  return {
    title: `Record ${entry.file}`,
    x: { label: "Time", unit: "s" },
    panels: [panel("u", "Input", 1), panel("y", "Output", 0)],
    marks: (defects ?? []).flatMap((defect: { spans: [number, number][] }) => defect.spans.map(([a, b]) => ({ from: a, to: b }))),
  };
}
