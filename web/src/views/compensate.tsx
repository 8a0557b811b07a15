// Compensate: the voltage for a path, and how an actuator follows it before and after.

import { useMemo } from "preact/hooks";
import { Form } from "../form.tsx";
import { type Lists, optionsOf } from "../lists.ts";
import { ModelChoice } from "../models.tsx";
import type { Answer, File } from "../packet.ts";
import { moves, pathFile } from "../path.ts";
import type { Figure, Series } from "../plot/figure.ts";
import { download } from "../plot/download.ts";
import { rough, short, si, unit } from "../plot/ticks.ts";
import { type ModelEntry, type Options, usedModel, withSettings } from "../project.ts";
import { inUnit } from "../signal.tsx";
import { usePlant, withoutPlant } from "../stand-in.tsx";
import { Chart, Entry, Fault, Missing, Notes, Section, Table, useLatest, useOutcome, useShared } from "../ui.tsx";
import type { Workspace } from "../workspace.ts";
import { BeforeAfter } from "./before-after.tsx";
import { Moves } from "./moves.tsx";

/** What this view remembers. */
interface Settings {
  /** `drawn`, the file of a record, or a kind of signal. */
  path?: string;
  /** Heights of the points of a drawn path [output unit]. */
  points?: number[];
  /** Length of a drawn path [s]. */
  duration?: number;
  /** Options of a kind of signal. */
  signal?: Options;
  options?: Options;
  /** Options of moves in time. */
  moves?: Options;
}

/** Share of what the model reaches that a path uses at first. */
const SHARE = 0.3;

export function CompensateView() {
  const { workspace } = useShared();
  const entry = usedModel(workspace.project);
  const read = useOutcome(entry?.file, async () => {
    const model = JSON.parse(new TextDecoder().decode(await workspace.bytes(entry!.file)));
    return { model, stroke: await strokeOf(workspace, entry!.file, model) };
  });
  if (!entry) return <Missing what="There is no model yet." title="Identify one" />;
  if (!read.value) return <Fault text={read.error} />;
  return <Compensation key={entry.file} entry={entry} {...read.value} />;
}

/** The displacements of a model at the ends of its range of voltage. */
async function strokeOf(workspace: Workspace, file: string, model: any): Promise<[number, number]> {
  const [low, high]: [number, number] = model.identified?.u ?? model.hysteresis?.range ?? [0, 1];
  const unitName = model.units?.u ?? "V";
  const inputs = Array.from({ length: 400 }, (_, k) => `${k * model.ts},${k < 200 ? low : high}`);
  const drive = { name: "ends.csv", bytes: new TextEncoder().encode(`t_s,u_${unitName}\n${inputs.join("\n")}\n`) };
  const answer = await workspace.answer(`ends ${file}`, async () => ({
    name: "ends of the stroke",
    request: { call: "simulate", options: { begin: "settled" }, files: { input: [drive.name], model: [file] } },
    files: [drive, await workspace.file(file)],
  }));
  const y = answer.series.get("y")!;
  return [y[199]!, y[399]!];
}

/** A path at first: two moves to both sides of the middle, in shares of the height. */
const MOVES = [0, 1, 1, -1, -1, 0.5, 0];

function Compensation({ entry, model, stroke }: { entry: ModelEntry; model: any; stroke: [number, number] }) {
  const { workspace, lists } = useShared();
  const { file } = entry;
  const plant = usePlant(entry);
  const settings = (workspace.project.settings["compensate"] ?? {}) as Settings;
  const options = withoutPlant(settings.options ?? {});
  const change = (values: Partial<Settings>, passing = false) =>
    workspace.change((project) => withSettings(project, "compensate", { ...settings, ...values } as Options), passing);
  const rounded = (value: number) => Number(value.toPrecision(2));
  const [height, middle] = [rounded((SHARE * Math.abs(stroke[1] - stroke[0])) / 2), rounded((stroke[0] + stroke[1]) / 2)];
  const centre = Math.abs(middle) < 0.1 * height ? 0 : middle;
  const points = settings.points ?? MOVES.map((move) => centre + move * height);
  const duration = settings.duration ?? 0.5;
  const of = model.units?.y ?? "um";
  const usual = { amplitude: height, offset: centre, frequency: 4 / duration };
  const expected = JSON.stringify([settings.path, points, duration, settings.signal, model.ts]);
  const path = useLatest(expected, async () =>
    ({ expected, file: await pathOf(workspace, settings, lists, { points, duration, ts: model.ts, of, usual }) }));
  // Of the path that is there, which is the one before while another is made.
  const input = path.value && JSON.stringify([file, path.value.expected, options]);
  const result = useLatest(input, async () =>
    ({ input, answer: await compensated(workspace, file, path.value!.file, options) }));
  const answer = result.value?.answer;
  const smooth = (seconds: number) => change({ options: { ...options, smooth: seconds } });
  const current = path.value?.expected === expected && result.value?.input === input;
  return (
    <>
      <Path settings={settings} change={change} points={points} duration={duration} of={of} answer={answer} lists={lists} usual={usual} />
      <Fault text={path.error ?? result.error} />
      {result.error && <Smoothing seconds={advised(result.error)} smooth={smooth} />}
      {answer && <Voltage answer={answer} current={current} smooth={smooth} />}
      <Section title="Limits and shaping" help="The voltage keeps the driver's limits; a path with corners is smoothed, or filtered at the resonance.">
        <Form
          rows={optionsOf(lists, "compensate").filter(({ name }) => name !== "plant")}
          values={options}
          change={(options) => change({ options })}
          first={["driver", "clip", "smooth", "zvd"]}
        />
      </Section>
      {path.value && (
        <>
          <BeforeAfter entry={entry} plant={plant} path={path.value.file} expected={path.value.expected} options={options}
            samples={answer?.series.get("requested")?.length ?? 0} refused={result.error !== undefined} />
          <Moves file={file} model={model} plant={plant} path={path.value.file} expected={path.value.expected} shared={options}
            values={settings.moves ?? {}} change={(moves) => change({ moves })} />
        </>
      )}
    </>
  );
}

/** The voltage for a path. */
const compensated = async (workspace: Workspace, file: string, path: File, options: Options): Promise<Answer> =>
  workspace.run({
    name: "compensate",
    request: { call: "compensate", options, files: { model: [file], reference: [path.name] } },
    files: [await workspace.file(file), path],
    quiet: true,
  });

/** The options that a kind of signal has: those of another kind that was chosen before are kept, but not sent. */
function ofKind(path: string, signal: Options, lists: Lists): Options {
  const known = lists.excitations.find((one) => one.name === path)?.options ?? [];
  return Object.fromEntries(Object.entries(signal).filter(([name]) => known.some((row) => row.name === name)));
}

/** The file of the chosen path. */
async function pathOf(
  workspace: Workspace,
  { path = "drawn", signal = {} }: Settings,
  lists: Lists,
  { points, duration, ts, of, usual }: { points: number[]; duration: number; ts: number; of: string; usual: Record<string, number> },
): Promise<File> {
  const record = workspace.project.records.find((one) => one.file === path);
  if (record) return { ...(await workspace.ready(record)), name: "path.csv" };
  return pathFile(workspace, path === "drawn" ? moves(points, duration) : { kind: path, duration, ...usual, ...ofKind(path, signal, lists) }, ts, of);
}

interface Changing {
  settings: Settings;
  change(values: Partial<Settings>, passing?: boolean): void;
}

const KINDS = ["sine", "triangle", "staircase"];

function Path({ settings, change, points, duration, of, answer, lists, usual }: Changing & {
  points: number[]; duration: number; of: string; answer: Answer | undefined; lists: Lists; usual: Record<string, number>;
}) {
  const { workspace } = useShared();
  const { path = "drawn" } = settings;
  const isKind = KINDS.includes(path);
  const kind = lists.excitations.find((one) => one.name === path);
  const base = useMemo((): Figure | undefined => answer && pathFigure(answer), [answer]);
  const step = duration / (points.length - 1);
  const moved = (k: number) => (_: number, y: number, done: boolean) =>
    change({ points: points.map((one, j) => (j === k ? Number(y.toPrecision(3)) : one)) }, !done);
  const figure: Figure | undefined = base && {
    ...base,
    ...(path === "drawn" && {
      handles: points.map((y, k) => ({ label: `Height of the path at ${short(k * step)} s`, x: k * step, y, moves: "y" as const, moved: moved(k) })),
    }),
  };
  const number = (label: string, value: number, set: (value: number) => void) => (
    <label>
      {label}{" "}
      <Entry inputMode="decimal" size={7} value={String(value)} entered={(text) => Number(text) > 0 && set(Number(text))} />
    </label>
  );
  return (
    <Section title="Path" wide help={path === "drawn" ? "Drag the points, or move them with the arrow keys." : ""}>
      <ModelChoice />
      <div class="row">
        <label>
          Path{" "}
          <select value={path} onChange={(event) => change({ path: event.currentTarget.value })}>
            <option value="drawn">drawn by hand</option>
            {KINDS.map((name) => <option key={name} value={name}>{name}</option>)}
            {workspace.project.records.map((one) => <option key={one.file} value={one.file}>displacement of {one.file}</option>)}
          </select>
        </label>
        {(path === "drawn" || isKind) && number("Duration [s]", duration, (value) => change({ duration: value }))}
        {path === "drawn" && number("Points", points.length, (value) =>
          change({ points: Array.from({ length: Math.max(2, Math.min(40, Math.round(value))) }, (_, k) => points[k] ?? 0) }))}
      </div>
      {isKind && kind && (
        <Form rows={inUnit(kind.options, of).map((row) => ({ ...row, required: false, ...(row.name in usual && { usual: String(usual[row.name]) }) }))}
          values={settings.signal ?? {}} change={(signal) => change({ signal })} />
      )}
      {figure && <Chart figure={figure} height={380} bare />}
    </Section>
  );
}

function pathFigure(answer: Answer): Figure {
  const { ts, units } = answer.result;
  const get = (name: string) => answer.series.get(name) ?? new Float64Array();
  const curve = (name: string, of: string, more: Partial<Series>): Series => ({ name, y: get(of), step: ts, ...more });
  return {
    title: "Path and voltage",
    x: { label: "Time", unit: "s" },
    panels: [
      {
        y: { label: "Displacement", unit: units.y },
        series: [
          curve("requested", "requested", { style: "pale" }),
          curve("shaped", "shaped", { style: "dashed", colour: 2 }),
          curve("reached by the model", "y", { colour: 1 }),
        ].filter((one) => one.y.length > 0),
      },
      { y: { label: "Voltage", unit: units.u }, series: [curve("voltage", "u", { colour: 7 })] },
    ],
  };
}

/** The smoothing that an error advises [s]. */
const advised = (error: string): number | null => Number(error.match(/\{smooth\}` = ([\d.e+-]+)/)?.[1] ?? NaN) || null;

/** The smoothing that the library advises, at a press of a button. */
const Smoothing = ({ seconds, smooth }: { seconds: number | null | undefined; smooth(seconds: number): void }) =>
  seconds ? <div class="row"><button type="button" onClick={() => smooth(seconds)}>Smooth the path over {si(seconds, "s")}</button></div> : null;

/** What the voltage begins from. */
const Start = ({ u, of }: { u: Float64Array; of: string }) => (
  <p>
    It begins at {short(u[0] ?? 0)} {of} and ends at {short(u.at(-1) ?? 0)} {of}, for an actuator that has rested at its beginning. Go there slowly and
    wait before it is played; on a path that repeats, the first period is worse than the next ones.
  </p>
);

function Voltage({ answer, current, smooth }: { answer: Answer; current: boolean; smooth(seconds: number): void }) {
  const { result } = answer;
  const { usage } = result;
  const rows = Object.values(usage ?? {})
    .filter((one: any) => one)
    .map((one: any) => [one.quantity, `${short(one.value)} ${one.unit}`, one.limit === null ? "none" : `${short(one.limit)} ${one.unit}`, one.share === null ? "" : `${short(100 * one.share)} %`]);
  return (
    <Section title="Voltage">
      {result.expected_rms !== null && result.expected_rms !== undefined && (
        <p>Expected error on the actuator: {rough(result.expected_rms)} {unit(result.units.y)} rms, by the records of the identification.</p>
      )}
      <Table caption="What the voltage uses of its limits" head={["Quantity", "Value", "Limit", "Used"]} rows={rows} />
      <Start u={answer.series.get("u")!} of={unit(result.units.u)} />
      <Notes title="Notes" notes={result.notes ?? []} />
      <Smoothing seconds={result.smoothing?.smooth} smooth={smooth} />
      <div class="row">
        {answer.files.map((one) => (
          <button key={one.name} type="button" class="main" disabled={!current} onClick={() => download(one.name, one.bytes as BlobPart, "text/csv")}>
            Download {one.name}
          </button>
        ))}
      </div>
    </Section>
  );
}
