// Branches: the displacement, or the hidden variable, against the voltage; the separating line of the paper, and the
// branches that follow from it.

import { useMemo } from "preact/hooks";
import { Form } from "../form.tsx";
import { optionsOf } from "../lists.ts";
import type { Answer } from "../packet.ts";
import type { Figure, Series } from "../plot/figure.ts";
import { short, unit } from "../plot/ticks.ts";
import { type Options, type RecordEntry, shownRecord, withSettings } from "../project.ts";
import { Chart, Fault, Missing, Notes, Section, Table, useLatest, useOutcome, useShared } from "../ui.tsx";
import type { Workspace } from "../workspace.ts";

type Line = [number, number];

/** What this view remembers. */
interface Settings {
  /** Part of the record [s]. */
  from?: number;
  to?: number;
  /** z of the model instead of y. */
  hidden?: boolean;
  /** Other records beside the chosen one. */
  beside?: string[];
  /** The separating line by record: its z at both ends. */
  lines?: Record<string, Line>;
  /** How branches are made. */
  options?: Options;
}

export function BranchesView() {
  const { workspace } = useShared();
  const entry = shownRecord(workspace.project);
  if (!entry) return <Missing what="Branches need a record." title="Add a record" />;
  return <BranchesOf key={entry.file} entry={entry} />;
}

/** The call for the loop of a record. */
async function loopOf(workspace: Workspace, entry: RecordEntry, model: string | undefined, columns: Options, options: Options) {
  const data = await workspace.ready(entry);
  const files = { data: [data.name], ...(model && { model: [model] }) };
  return {
    name: "loops",
    request: { call: "loops", columns, options, files },
    files: [data, ...(model ? [await workspace.file(model)] : [])],
    quiet: true,
  };
}

function BranchesOf({ entry }: { entry: RecordEntry }) {
  const { workspace, lists } = useShared();
  const { records, models, model } = workspace.project;
  const settings = (workspace.project.settings["loops"] ?? {}) as Settings;
  const change = (values: Partial<Settings>, passing = false) =>
    workspace.change((project) => withSettings(project, "loops", { ...settings, ...values } as Options), passing);
  const used = settings.hidden ? models.find((one) => one.file === model)?.file : undefined;
  const part: Options = {
    ...(settings.from !== undefined && { from: settings.from }),
    ...(settings.to !== undefined && { to: settings.to }),
  };
  const line = settings.lines?.[entry.file];
  const options = { ...settings.options, ...(line && { line }) };
  const key = JSON.stringify([entry, used, part, options]);
  const whole = useOutcome(JSON.stringify(entry), () => workspace.prepared(entry));
  const own = useLatest(key, async () => workspace.run(await loopOf(workspace, entry, used, part, options)));
  const beside = besides(records, entry, settings);
  const others = useOutcome(JSON.stringify([beside, used]), () =>
    Promise.all(beside.map((one) => workspace.answer(`loops ${JSON.stringify([one, used])}`, () => loopOf(workspace, one, used, {}, {})))),
  );
  const what = used ? "z" : "y";
  const figure = useMemo(
    () => own.value && loopFigure(entry, own.value, beside, others.value ?? [], what),
    [own.value, others.value, what],
  );
  const straight = useMemo(() => own.value && withoutLine(own.value, what), [own.value, what]);
  const found = own.value?.result.loop;
  const drag = (end: 0 | 1) => (_: number, y: number, done: boolean) => {
    if (!found) return;
    const next: Line = [found.line[0][1], found.line[1][1]];
    next[end] = Number(y.toPrecision(5));
    change({ lines: { ...settings.lines, [entry.file]: next }, options: { ...settings.options, split: "line" } }, !done);
  };
  const shown: Figure | undefined = figure && found && {
    ...figure,
    handles: [0, 1].map((end) => ({
      label: `Separating line at the ${end ? "highest" : "lowest"} input`,
      x: found.line[end][0],
      y: line ? line[end as 0 | 1] : found.line[end][1],
      moves: "y" as const,
      moved: drag(end as 0 | 1),
    })),
    lines: [{ from: [found.line[0][0], line?.[0] ?? found.line[0][1]], to: [found.line[1][0], line?.[1] ?? found.line[1][1]], label: "separating line" }],
  };
  const reset = () => {
    const { [entry.file]: _, ...lines } = settings.lines ?? {};
    change({ lines });
  };
  return (
    <>
      <Choice entry={entry} settings={settings} change={change} />
      <Section title={`${what} against u: ${entry.file}`} wide
        help="Drag the two ends of the separating line, or move them with the arrow keys: the branches are fitted again at once. Ctrl+Z takes it back.">
        <Fault text={own.error ?? others.error} />
        {shown && <Chart figure={shown} height={440} />}
        {found && <Figures found={found} note={own.value!.result.note} />}
        <div class="row">
          <button type="button" disabled={!line} onClick={reset}>Line through the reversals</button>
        </div>
      </Section>
      {straight && (
        <Section title="Hysteresis alone" help="The loop minus the straight line through its ends, which shows its width.">
          <Chart figure={straight} height={320} />
        </Section>
      )}
      <Section title="Part of the record" help="Drag both ends to the cycles of the loop.">
        {whole.value?.result.record && <Part answer={whole.value} settings={settings} change={change} />}
        <Fault text={whole.error} />
      </Section>
      <Section title="Branches">
        <Form
          rows={optionsOf(lists, "loops").filter((row) => row.name !== "line")}
          values={settings.options ?? {}}
          change={(values) => change({ options: values })}
        />
      </Section>
    </>
  );
}

/** The records beside the chosen one: those that were chosen, at first all large-signal records. */
const besides = (records: RecordEntry[], entry: RecordEntry, { beside }: Settings): RecordEntry[] =>
  records.filter((one) => one !== entry && (beside ? beside.includes(one.file) : one.use === "training"));

interface Changing {
  settings: Settings;
  change(values: Partial<Settings>, passing?: boolean): void;
}

function Choice({ entry, settings, change }: Changing & { entry: RecordEntry }) {
  const { workspace } = useShared();
  const { records, models, model } = workspace.project;
  const shown = besides(records, entry, settings);
  const toggle = (file: string, on: boolean) => {
    const others = shown.map((one) => one.file).filter((one) => one !== file);
    change({ beside: on ? [...others, file] : others });
  };
  return (
    <Section title="Shown" wide>
      <div class="row">
        <label>
          Record{" "}
          <select value={entry.file} onChange={(event) => {
            const file = event.currentTarget.value;
            workspace.change((project) => ({ ...project, record: file }));
          }}>
            {records.map((one) => <option key={one.file} value={one.file}>{one.file}</option>)}
          </select>
        </label>
        <label>
          <input type="checkbox" checked={settings.hidden ?? false} disabled={!model}
            onChange={(event) => change({ hidden: event.currentTarget.checked })} />{" "}
          Hidden variable z, by the inverse of the model's linear block
        </label>
        {models.length > 1 && settings.hidden && (
          <select aria-label="Model" value={model} onChange={(event) => {
            const file = event.currentTarget.value;
            workspace.change((project) => ({ ...project, model: file }));
          }}>
            {models.map((one) => <option key={one.file} value={one.file}>{one.file}</option>)}
          </select>
        )}
      </div>
      {records.length > 1 && (
        <div class="row" role="group" aria-label="Records beside it">
          Other records:
          {records.filter((one) => one !== entry).map((one) => (
            <label key={one.file}>
              <input type="checkbox" checked={shown.includes(one)}
                onChange={(event) => toggle(one.file, event.currentTarget.checked)} />{" "}
              {one.file}
            </label>
          ))}
        </div>
      )}
    </Section>
  );
}

function Part({ answer, settings, change }: Changing & { answer: Answer }) {
  const { record } = answer.result;
  const moved = (end: "from" | "to") => (x: number, _: number, done: boolean) => {
    const at = Number(Math.max(0, Math.min(record.duration, x)).toPrecision(6));
    const { from = 0, to = record.duration } = settings;
    change(end === "from" ? { from: Math.min(at, to) } : { to: Math.max(at, from) }, !done);
  };
  const base = useMemo((): Figure => ({
    title: "Input against time",
    x: { label: "Time", unit: "s" },
    panels: [{ y: { label: "Input", unit: record.units.u }, series: [{ name: "", y: answer.series.get("u")!, step: record.ts, colour: 1 }] }],
  }), [answer]);
  const { from = 0, to = record.duration } = settings;
  const figure: Figure = {
    ...base,
    span: { from, to },
    handles: [
      { label: "Start of the part [s]", x: from, y: 0, moves: "x", moved: moved("from") },
      { label: "End of the part [s]", x: to, y: 0, moves: "x", moved: moved("to") },
    ],
  };
  return (
    <>
      <Chart figure={figure} height={200} />
      <button type="button" onClick={() => change({ from: 0, to: record.duration })}>Whole record</button>
    </>
  );
}

function Figures({ found, note }: { found: any; note: string | null }) {
  const rows = [
    ["Frequency", found.frequency_hz === null ? "no dominant frequency" : `${short(found.frequency_hz)} Hz`],
    ["Width of the loop", `${short(found.loop_width_percent)} % of its height`],
    ["Distance of the points from their branch", `${short(found.error_percent)} % of its height, rms`],
    ["Points whose side agrees with their direction", `${short(100 * found.agreement)} %`],
    ["Ascending branch", found.ascending_below ? "below the line" : "above the line: inverted"],
  ];
  return (
    <>
      <Table caption="The loop and its branches" head={["Figure", "Value"]} rows={rows} />
      <Notes title="Notes" notes={note ? [note] : []} />
    </>
  );
}

const picked = (samples: Float64Array, at: number[]) => Float64Array.from(at, (k) => samples[k]!);

function loopFigure(entry: RecordEntry, own: Answer, beside: RecordEntry[], others: Answer[], what: string): Figure {
  const { units, reversals, loop } = own.result;
  const [u, z, at] = ["u", "z", "at"].map((name) => own.series.get(name)!) as [Float64Array, Float64Array, Float64Array];
  const name = (file: string, hz: number | null) => (hz === null ? file : `${file}, ${short(hz)} Hz`);
  const series: Series[] = [
    { name: name(entry.file, loop.frequency_hz), x: u, y: z },
    ...others.map((other, k): Series => ({
      name: name(beside[k]?.file ?? "", other.result.loop.frequency_hz),
      x: other.series.get("u")!,
      y: other.series.get("z")!,
      colour: 3 + (k % 5),
    })),
    { name: "ascending branch", x: at, y: own.series.get("ascending")!, colour: 1 },
    { name: "descending branch", x: at, y: own.series.get("descending")!, colour: 2 },
    { name: "reversals", x: picked(u, reversals), y: picked(z, reversals), style: "points", colour: 6 },
  ];
  const height = what === "z" ? { label: "Hidden variable z", unit: units.u } : { label: "Output y", unit: units.y };
  return { title: `Loop of ${entry.file}`, x: { label: "Input u", unit: units.u }, panels: [{ y: height, series }], loops: true };
}

/** The loop and its branches, less the line through the branches' common ends. */
function withoutLine(own: Answer, what: string): Figure {
  const get = (name: string) => own.series.get(name)!;
  const [at, rising] = [get("at"), get("ascending")];
  const [low, high] = [at[0]!, at.at(-1)!];
  const slope = (rising.at(-1)! - rising[0]!) / (high - low);
  const less = (u: Float64Array, z: Float64Array) => z.map((value, k) => value - rising[0]! - slope * (u[k]! - low));
  const { units } = own.result;
  const series: Series[] = [
    { name: "record", x: get("u"), y: less(get("u"), get("z")) },
    { name: "ascending branch", x: at, y: less(at, rising), colour: 1 },
    { name: "descending branch", x: at, y: less(at, get("descending")), colour: 2 },
  ];
  const of = what === "z" ? units.u : units.y;
  return {
    title: `${what} without its straight line of ${short(slope)} ${unit(of)}/${unit(units.u)}`,
    x: { label: "Input u", unit: units.u },
    panels: [{ y: { label: `${what} \u2212 line`, unit: of }, series }],
    loops: true,
  };
}
