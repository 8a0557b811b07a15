// The left of Compensate: the model, the path, its limits and shaping.

import { Form } from "../form.tsx";
import { optionsOf } from "../lists.ts";
import { ModelChoice, recorded, withRecorded } from "../models.tsx";
import type { Handle } from "../plot/figure.ts";
import { short } from "../plot/ticks.ts";
import type { Options } from "../project.ts";
import { inUnit } from "../signal.tsx";
import { Entry, Fault, Section, useShared } from "../ui.tsx";
import { type Path, type Settings } from "./request.ts";

interface Props {
  path: Path;
  settings: Settings;
  change(values: Partial<Settings>, passing?: boolean): void;
  /** Why there is no voltage for the path, and whether the pictures are of the one before. */
  error: string | undefined;
  isOld: boolean;
}

const KINDS = ["sine", "triangle", "staircase"];

/** Points of a drawn path, at most. */
const MOST = 40;

export function PathForm({ path: { path, points, duration, usual, of }, settings, change, error, isOld }: Props) {
  const { workspace, lists } = useShared();
  const isKind = KINDS.includes(path ?? "");
  const kind = lists.excitations.find((one) => one.name === path);
  const number = (label: string, value: number, set: (value: number) => void) => (
    <label>
      {label}{" "}
      <Entry inputMode="decimal" size={7} value={String(value)} entered={(text) => Number(text) > 0 && set(Number(text))} />
    </label>
  );
  return (
    <Section title="Path" help={path === "drawn" ? "Drag its points in the picture, or move them with the arrow keys. A file of your own, with time and displacement, is dropped on the page." : ""}>
      <ModelChoice proof={false} />
      <div class="row">
        <label>
          Path{" "}
          <select value={path} onChange={(event) => change({ path: event.currentTarget.value })}>
            <option value="drawn">drawn by hand</option>
            {KINDS.map((name) => <option key={name} value={name}>{name}</option>)}
            {workspace.project.records.map((one) => <option key={one.file} value={one.file}>displacement in {one.file}</option>)}
          </select>
        </label>
        {(path === "drawn" || isKind) && number("Duration [s]", duration, (value) => change({ duration: value }))}
        {path === "drawn" && number("Points", points.length, (value) =>
          change({ points: Array.from({ length: Math.max(2, Math.min(MOST, Math.round(value))) }, (_, k) => points[k] ?? 0) }))}
      </div>
      {isKind && kind && (
        <Form rows={inUnit(kind.options, of).map((row) => ({ ...row, required: false, ...(row.name in usual && { usual: String(usual[row.name]) }) }))}
          values={settings.signal ?? {}} change={(signal) => change({ signal })} />
      )}
      <Fault text={error} />
      {error && isOld && <p class="help">The pictures are of the last path that could be followed.</p>}
    </Section>
  );
}

/** Limits that are not set are those of the records. */
export function Limits({ model, values, change }: { model: any; values: Options; change(values: Options): void }) {
  const { lists } = useShared();
  const rows = optionsOf(lists, "compensate").filter(({ name }) => name !== "plant" && name !== "model_error");
  return (
    <Section title="Limits and shaping"
      help={`${recorded(model) && values["driver"] === undefined ? "As long as no limits are set, voltages may leave those of the records, which are shown, by a twentieth of their range. " : ""}A path with corners is smoothed, or filtered at the resonance.`}>
      <Form rows={withRecorded(rows, model, values)}
        values={values} change={change} first={["driver", "low", "high", "clip", "smooth", "zvd"]} />
    </Section>
  );
}

/** The points of a drawn path, which are dragged in the picture. */
export function pathHandles({ path, points, duration }: Path, change: Props["change"]): Handle[] {
  if (path !== "drawn") return [];
  const step = duration / (points.length - 1);
  const moved = (k: number) => (_: number, y: number, done: boolean) =>
    change({ points: points.map((one, j) => (j === k ? Number(y.toPrecision(3)) : one)) }, !done);
  return points.map((y, k) => ({ label: `Height of the path at ${short(k * step)} s`, x: k * step, y, moves: "y", moved: moved(k) }));
}
