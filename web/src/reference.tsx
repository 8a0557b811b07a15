// A requested displacement: that of a record, a path drawn by hand, or a signal.

import { useId } from "preact/hooks";
import { fileOf, type PathFile, pathOf, type Settings, strokeOf } from "./compensate/request.ts";
import { csv } from "./path.ts";
import { type Options, type Project, usedModel } from "./project.ts";
import { SignalForm, useSignal } from "./signal.tsx";
import { Fault, useSettings, useShared } from "./ui.tsx";

/** Stands for a signal among the names of records, which have an ending. */
const SIGNAL = "signal";
/** Stands for the path of the view Compensate. */
const COMPENSATED = "drawn";

/** True if Compensate was used. */
const isCompensated = ({ settings }: Project): boolean => settings["compensate"] !== undefined;

/** The choice of a view, and the file that it stands for; of no choice none. */
export interface Reference {
  chosen: string;
  values: Options;
  change(values: Options): void;
  /** Tells one choice from another. */
  key: unknown;
  /** Of a signal: what is wrong with it. */
  error: string | undefined;
  lacks: string[];
  files(): Promise<PathFile[]>;
}

/** The reference that a view has chosen. `start` is the signal at first; with `compensated`, the path of Compensate is
 * chosen at first, if that view was used. */
export function useReference(view: string, start: Options, compensated = false): Reference {
  const { workspace, lists } = useShared();
  const [{ from, signal }, set] = useSettings(`${view}-reference`);
  const values: Options = { ...((signal as Options | undefined) ?? start), unit: start["unit"] };
  const { settings } = workspace.project;
  const chosen = String(from ?? (compensated && isCompensated(workspace.project) ? COMPENSATED : ""));
  const outcome = useSignal(chosen === SIGNAL ? values : undefined);
  const files = async (): Promise<PathFile[]> => {
    if (chosen === "") return [];
    if (chosen === COMPENSATED) return [await compensatedPath()];
    if (chosen !== SIGNAL) return [await displacement(chosen)];
    if (outcome.lacks.length > 0) throw new Error(`the signal of the reference lacks its ${outcome.lacks.join(", ")}`);
    if (!outcome.value) throw new Error(outcome.error ?? "the signal of the reference is not ready yet: try again");
    return [{ name: "signal.csv", bytes: outcome.value.files[0]!.bytes }];
  };
  const compensatedPath = async (): Promise<PathFile> => {
    const entry = usedModel(workspace.project);
    if (!entry) throw new Error("there is no model: identify one, or choose another reference");
    const model = await workspace.document(entry.file);
    const stroke = await strokeOf(workspace, entry.file, model);
    return fileOf(workspace, lists, pathOf((settings["compensate"] ?? {}) as Settings, model, stroke));
  };
  /** The displacement of a record, without its voltage. */
  const displacement = async (name: string): Promise<PathFile> => {
    const entry = workspace.project.records.find((one) => one.file === name);
    if (!entry) throw new Error(`there is no record ${name}: choose another reference`);
    const { result, series } = await workspace.prepared(entry);
    const { ts, units } = result.record;
    return csv(`${name.replace(/\.\w+$/, "")}.csv`, units.y, ts, series.get("y")!);
  };
  const change = (next: Options) => set({ from: next["from"] ?? chosen, signal: next["signal"] ?? values });
  const { path, points, duration, signal: ofKind } = (settings["compensate"] ?? {}) as Settings;
  const key = chosen === SIGNAL ? values : chosen === COMPENSATED ? [path, points, duration, ofKind] : chosen;
  return { chosen, values, change, key, error: outcome.error, lacks: outcome.lacks, files };
}

/** The fields of a reference. */
export function ReferenceForm({ reference, label, none }: { reference: Reference; label: string; none: string }) {
  const { workspace } = useShared();
  const { chosen, values, change, error, lacks } = reference;
  const id = useId();
  return (
    <>
      <div class="row">
        <label for={id}>{label}</label>
        <select id={id} value={chosen} onChange={(event) => change({ from: event.currentTarget.value })}>
          <option value="">{none}</option>
          <option value={SIGNAL}>a signal</option>
          {usedModel(workspace.project) && <option value={COMPENSATED}>the path of Compensate</option>}
          {workspace.project.records.map(({ file }) => <option key={file} value={file}>displacement of {file}</option>)}
        </select>
      </div>
      {chosen === SIGNAL && <SignalForm values={values} change={(signal) => change({ signal })} of={String(values["unit"])} />}
      <Fault text={error} />
      {lacks.length > 0 && <p class="missing">Give {lacks.join(", ")}.</p>}
    </>
  );
}
