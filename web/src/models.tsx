// The model that is used: its choice, and whether its records have changed.

import type { OptionRow } from "./lists.ts";
import { short } from "./plot/ticks.ts";
import { changedSince, type ModelEntry, type Options, usedModel } from "./project.ts";
import { useShared, Verdict } from "./ui.tsx";

/** The choice of the model that is used, with what proves it unless the view has a verdict of its own. */
export function ModelChoice({ proof = true }: { proof?: boolean }) {
  const { workspace } = useShared();
  const { models } = workspace.project;
  const entry = usedModel(workspace.project);
  return (
    <>
      <div class="row">
        <label>
          Model{" "}
          <select value={entry?.file} onChange={(event) => workspace.change((project) => ({ ...project, model: event.currentTarget.value }))}>
            {models.map(({ file }) => <option key={file} value={file}>{file}</option>)}
          </select>
        </label>
      </div>
      {entry && <Outdated entry={entry} />}
      {proof && entry && <Verdict of={entry.validated ? "Validated" : ""} text={entry.validated ?? "not validated on other records yet"} />}
    </>
  );
}

/** Says that the records of a model are read in another way since it was identified. */
export function Outdated({ entry }: { entry: ModelEntry }) {
  const { project } = useShared().workspace;
  const files = changedSince(entry, project);
  return files.length > 0
    ? <p class="stale" role="status">{files.join(", ")} {files.length > 1 ? "are" : "is"} read or prepared in another way now than when {entry.file} was identified: identify again.</p>
    : null;
}

/** The voltages that a model was identified from, as its document states them. */
export const recorded = (model: any): { u: [number, number]; slew: number } | undefined => model?.identified;

/** Options with the recorded voltages in the place of limits that are not set: those hold then. */
export function withRecorded<Row extends OptionRow>(rows: Row[], model: any, values: Options): Row[] {
  const known = values["driver"] === undefined ? recorded(model)?.u : undefined;
  const usual = (name: string) => (name === "low" ? known?.[0] : name === "high" ? known?.[1] : undefined);
  return rows.map((row) => (usual(row.name) === undefined ? row : { ...row, usual: short(usual(row.name)!) }));
}
