// The model that is used: its choice, and whether its records have changed.

import { changedSince, type ModelEntry, usedModel } from "./project.ts";
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
