// Moves in time: when each step of a path settles, how far it overshoots, and the fastest moves; on the model, on the plant
// that was chosen, and, with `piezoid serve`, on a controller, once its user has agreed.

import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import type { CallName } from "../catalogue.ts";
import { beyondMeasured, type Faster } from "../compensate/beyond.ts";
import { type PathFile, reading } from "../compensate/request.ts";
import { Form } from "../form.tsx";
import { optionsOf } from "../lists.ts";
import type { Answer } from "../packet.ts";
import type { Figure } from "../plot/figure.ts";
import { short, unit as unitOf } from "../plot/ticks.ts";
import type { Options } from "../project.ts";
import { Chart, Choice, Download, Fact, Fault, Notes, Section, Stale, Table, useKept, useShared } from "../ui.tsx";
import { type Plant, spokenPlant, withoutPlant } from "../stand-in.tsx";
import { worded } from "../words.ts";
import { those, useController } from "./controller.tsx";

/** The timing of one step in one run. */
interface Step {
  at_s: number;
  from: number;
  to: number;
  move_s: number;
  settling_s: number | null;
  overshoot_percent: number;
}

interface Run {
  name: string;
  within_percent: number;
  steps: Step[];
  scan: { lag_s: number; rms: number; rms_without_lag: number } | null;
}

interface Fastest {
  purpose: string;
  shape: string;
  from: number;
  to: number;
  move_s: number | null;
  settling_s: number | null;
  overshoot: number | null;
  on_plant: { settling_s: number | null; overshoot: number } | null;
}

interface Props {
  /** The model, and its document. */
  file: string;
  model: any;
  /** What the moves are played on too. */
  plant: Plant | undefined;
  /** The path of the view, and what it is made of. */
  path: PathFile;
  expected: string;
  /** Limits and shaping, which the compensation has too. */
  shared: Options;
  values: Options;
  change(values: Options): void;
}

/** What is played: the path of the view, or a step up and down. */
const PATHS = ["this path", "a step up and down"];

export function Moves({ file, model, plant, path, expected, shared, values, change }: Props) {
  const { workspace, lists } = useShared();
  const isStep = values["along"] === PATHS[1];
  const optionsFor = (call: CallName): Options => {
    const own = withoutPlant(those(lists, call, { ...values, ...those(lists, "timing", shared) }));
    return isStep ? own : Object.fromEntries(Object.entries(own).filter(([name]) => name !== "step"));
  };
  const files = { model: [file], ...(!isStep && { path: [path.name] }) };
  const start = (call: CallName, name: string) => async () => {
    const request = { call, options: optionsFor(call), ...(isStep ? {} : reading(path)), files };
    const sent = [await workspace.file(file), ...(isStep ? [] : [path])];
    return workspace.run({ name, ...(plant ? await plant.on(request, sent) : { request, files: sent }) });
  };
  const request = [file, isStep || expected, optionsFor("timing"), plant?.key];
  const work = useKept<Answer>("timing", request);
  // Only `piezoid serve`, which has a folder, reaches a controller.
  const served = !workspace.store.own;
  const measured = useKept<Answer>("moves", [...request, served && optionsFor("moves")], true);
  const own = ["tolerance", ...(isStep ? ["step"] : [])];
  const rows = optionsOf(lists, "timing").filter(({ name }) => own.includes(name));
  const shown = measured.value && !measured.stale ? measured : work;
  const busy = work.busy || measured.busy;
  return (
    <Section title="Moves in time" wide
      help="When each step settles within the tolerance, how far it overshoots, and the fastest moves. Limits and shaping are those at the left; the voltage is clipped to the limits.">
      <p class="help">Played on the model{plant ? ` and on ${spokenPlant(plant.name)}` : "; choose a plant to play them there too"}.</p>
      <Choice label="Path of the moves" names={PATHS} chosen={isStep ? PATHS[1] : PATHS[0]} choose={(along) => change({ ...values, along })} />
      <Form rows={rows} values={values} change={change} first={own} />
      <div class="row">
        <button type="button" class="main" disabled={busy} onClick={() => work.start(start("timing", "moves in time"))}>Time the moves</button>
        {work.busy && <span role="status">The fastest moves are searched.</span>}
      </div>
      <Fault text={work.error} />
      {served && (
        <Measure model={model} values={values} change={change} busy={busy} run={() => measured.start(start("moves", "moves on the controller"))}
          isMoving={measured.busy} error={measured.error} />
      )}
      <Stale stale={shown.stale} />
      {shown.value && <Result answer={shown.value} />}
    </Section>
  );
}

/** Options of a controller that stand first. */
const FIRST = ["host", "port", "axis", "wait", "rest"];

interface MeasureProps {
  model: any;
  values: Options;
  change(values: Options): void;
  busy: boolean;
  isMoving: boolean;
  error: string | undefined;
  run(): void;
}

/** The same path on a controller. */
function Measure({ model, values, change, busy, run, isMoving, error }: MeasureProps) {
  const { workspace, lists } = useShared();
  const [asks, ask] = useState(false);
  const controller = useController("moves controller", values);
  const elsewhere = new Set(optionsOf(lists, "timing").map(({ name }) => name as string));
  const rows = optionsOf(lists, "moves").filter(({ name }) => !elsewhere.has(name));
  const stop = () => workspace.jobs.find(({ name }) => name === "moves on the controller")?.cancel?.();
  return (
    <details>
      <summary>On a controller</summary>
      <p class="help">
        A controller plays the compensated voltage and that of a straight line. Before each, the actuator is demagnetised and waits; its displacement at
        rest is set to that of the model.
      </p>
      <Form rows={rows} values={values} change={change} first={FIRST} />
      <div class="row">
        {controller.button(busy)}
        <button type="button" disabled={busy || controller.busy} onClick={() => ask(true)}>Time them on the controller</button>
        {isMoving && <button type="button" class="stop" onClick={stop}>Stop</button>}
        {isMoving && <span role="status">The actuator moves.</span>}
      </div>
      {controller.report}
      <Fault text={error} />
      {asks && <Agreement model={model} host={String(values["host"] ?? "127.0.0.1")} agree={() => { ask(false); run(); }} refuse={() => ask(false)} />}
    </details>
  );
}

function Agreement({ model, host, agree, refuse }: { model: any; host: string; agree(): void; refuse(): void }) {
  const dialog = useRef<HTMLDialogElement>(null);
  useEffect(() => dialog.current?.showModal(), []);
  const [low, high]: [number, number] = model.identified?.u ?? model.hysteresis?.range ?? [NaN, NaN];
  return (
    <dialog ref={dialog} aria-labelledby="moves-agreement" onClose={refuse}>
      <h2 id="moves-agreement">The actuator will move</h2>
      <p>
        The axis of the controller at {host} moves {Number.isFinite(low) ? <>between about <b>{short(low)} and {short(high)} V</b>, the range of the
        model, or within the limits if these are narrower</> : <b>over all voltages that the limits allow</b>}: it is demagnetised twice, and plays the path twice.
      </p>
      <p class="help">Keep a hand at the switch. Stop holds the voltage where it is.</p>
      <div class="row">
        <button type="button" class="main" onClick={agree}>Move the actuator</button>
        <button type="button" autofocus onClick={() => dialog.current?.close()}>Do not move</button>
      </div>
    </dialog>
  );
}

/** A time in milliseconds, or a dash. */
const ms = (seconds: number | null | undefined): string => (seconds === null || seconds === undefined ? "\u2013" : short(1e3 * seconds));

/** Steps in the table. */
const SHOWN = 8;

/** The runs that are shown, with their numbers: the compensated ones. What they improve on stands beside the path. */
const shownRuns = ({ result }: Answer): (Run & { k: number })[] =>
  (result.runs as Run[]).map((run, k) => ({ ...run, k })).filter(({ name }) => !name.endsWith(", straight line"));

function Result({ answer }: { answer: Answer }) {
  const { lists } = useShared();
  const { result } = answer;
  const runs = shownRuns(answer);
  const faster: Faster | null | undefined = result.faster;
  const unit = unitOf(result.unit);
  const steps = runs[0]?.steps ?? [];
  // On the controller if it was measured there, or on the plant.
  const last = runs.filter(({ name }) => name.endsWith(", compensated")).at(-1);
  const [chosen, choose] = useState(0);
  const at = Math.min(chosen, steps.length - 1);
  const figure = useMemo(() => figureOf(answer, at), [answer, at]);
  return (
    <>
      {faster && <p class="verdict poor" role="status">{beyondMeasured(faster, result.units.u)} Times and errors below are those of models.</p>}
      <dl class="readings">
        {steps.length > 0 && last && <Fact value={ofSteps(last)[1]!} unit="ms" name={`slowest step, ${last.name}${faster ? "; beyond what was measured" : ""}`} />}
        <Fact value={ms(result.step.shortest?.settling_s)} unit="ms" name={`shortest step, ${result.step.shortest?.shape ?? "none settles"}`} />
        <Fact value={ms(result.flyback.shortest?.settling_s)} unit="ms" name={`shortest flyback, ${result.flyback.shortest?.shape ?? "none settles"}`} />
        <Fact value={short(result.tolerance)} unit={unit} name="tolerance" />
      </dl>
      {result.controller && (result.controller.unfinished
        ? <Fault text={result.controller.unfinished} />
        : <p role="status">{worded(result.controller.state ?? "", lists)}</p>)}
      <Table caption="Runs" head={["Run", "Within [%]", "Settled", "Slowest [ms]", "Overshoot [%]", "Lag [ms]", `rms with mean [${unit}]`]}
        rows={runs.map((run) => [run.name, short(run.within_percent), ...ofSteps(run), run.scan ? short(1e3 * run.scan.lag_s) : "\u2013", run.scan ? short(run.scan.rms) : "\u2013"])} />
      {runs.some(({ scan }) => scan) && (
        <p class="help">
          rms with mean: the error against the path as it is, with its lag and its mean, over whole periods after the first 0.25 s. At the right,
          errors are without their mean, and of the shaded part of the path.
        </p>
      )}
      {steps.length > 0 && <p class="help">Settling [ms] and overshoot [% of the step] of each run; a dash: it does not settle before the next step.</p>}
      {steps.length > 0 && (
        <Table caption="Steps" marked={at}
          head={["Step", "At [ms]", `From [${unit}]`, `To [${unit}]`, "Move [ms]", ...runs.map(({ name }) => name)]}
          rows={steps.slice(0, SHOWN).map((step, k) => [
            <button type="button" class="link" aria-pressed={k === at} onClick={() => choose(k)}>{k + 1}</button>,
            short(1e3 * step.at_s), short(step.from), short(step.to), short(1e3 * step.move_s),
            ...runs.map(({ steps }) => `${ms(steps[k]?.settling_s)}, ${short(steps[k]?.overshoot_percent ?? NaN)} %`),
          ])} />
      )}
      <Chart figure={figure} height={440} />
      <FastestMoves moves={result.fastest} unit={unit} />
      <Notes title="Notes" notes={result.notes} />
      <div class="row">
        <Download files={answer.files} title="Download timing.csv" />
        <small>It holds the runs along the straight line between the ends of the stroke too.</small>
      </div>
    </>
  );
}

/** How many steps of a run settle, the slowest, and the most overshoot. */
function ofSteps({ steps }: Run): string[] {
  if (steps.length === 0) return ["\u2013", "\u2013", "\u2013"];
  const settled = steps.filter(({ settling_s }) => settling_s !== null);
  const slowest = settled.length === steps.length ? Math.max(...settled.map(({ settling_s }) => settling_s!)) : null;
  return [`${settled.length} of ${steps.length}`, ms(slowest), short(Math.max(...steps.map(({ overshoot_percent }) => overshoot_percent)))];
}

function FastestMoves({ moves, unit }: { moves: Fastest[]; unit: string }) {
  const onPlant = moves.some(({ on_plant }) => on_plant);
  return (
    <Table caption="Fastest moves, within the limits, whose displacement is within the tolerance"
      head={["Move", "Shape", "Move [ms]", "Settling [ms]", `Overshoot [${unit}]`, ...(onPlant ? ["On the plant [ms]"] : [])]}
      rows={moves.map((move) => [
        `${move.purpose}, ${short(move.from)} to ${short(move.to)} ${unit}`, move.shape, ms(move.move_s), ms(move.settling_s),
        move.overshoot === null ? "\u2013" : short(move.overshoot), ...(onPlant ? [ms(move.on_plant?.settling_s)] : []),
      ])} />
  );
}

/** What is shown of a step, over its longest move or settling; a part of it before; at least so many samples. */
const AROUND = 1.6;
const BEFORE = 0.15;
const FEWEST = 20;

/** Errors that are shown at first [tolerances]. */
const ERRORS = 8;

/** Displacement and error of each run, at first around a step, with the tolerance and when each run has settled. */
function figureOf(answer: Answer, at: number): Figure {
  const runs = shownRuns(answer);
  const { result, series } = answer;
  const { ts, unit, tolerance }: { ts: number; unit: string; tolerance: number } = result;
  const r = series.get("r")!;
  const step = runs[0]?.steps[at];
  const next = runs[0]?.steps[at + 1]?.at_s ?? ts * (r.length - 1);
  const settled = runs.flatMap(({ name, steps }) => (typeof steps[at]?.settling_s === "number" ? [{ name, time: steps[at]!.settling_s! }] : []));
  const length = step && AROUND * Math.max(step.move_s, FEWEST * ts, ...settled.map(({ time }) => time));
  const y = runs.map(({ name, k }, j) => ({ name, step: ts, y: series.get(`y/${k}`)!, colour: 1 + (j % 7) }));
  const errors = y.map(({ y, ...rest }) => ({ ...rest, y: y.map((value, k) => r[k]! - value) }));
  const goal = step ? [{ at: step.to - tolerance, label: "" }, { at: step.to + tolerance, label: "" }] : [];
  const most = errors.reduce((most, { y }) => y.reduce((most, value) => Math.max(most, Math.abs(value)), most), tolerance);
  const high = Math.min(1.1 * most, ERRORS * tolerance);
  // Runs that settle at the same sample share a mark.
  const marks = [...new Set(settled.map(({ time }) => time))].map((time) => {
    const names = settled.filter((one) => one.time === time).map(({ name }) => name);
    return { at: step!.at_s + time, label: names.length === 1 ? names[0]! : `${names.length} runs` };
  });
  return {
    title: step ? `Step ${at + 1}, and when each run has settled` : "Displacement along the path",
    x: { label: "Time", unit: "s", ...(step && length && { span: { from: Math.max(0, step.at_s - BEFORE * length), to: Math.min(next, step.at_s + length) } }) },
    panels: [
      { y: { label: "Displacement", unit }, series: [{ name: "path", style: "pale", step: ts, y: r }, ...y], levels: goal, places: marks.map(({ at }) => ({ at, label: "" })) },
      { y: { label: "Error", unit, span: { from: -high, to: high } }, series: errors,
        levels: [{ at: -tolerance, label: "" }, { at: tolerance, label: "tolerance" }], places: marks },
    ],
  };
}
