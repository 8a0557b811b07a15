// What records are probably for: the library compares their drives. A proposal holds until a use is chosen by hand, or a
// model is identified.

import { useEffect } from "preact/hooks";
import { whole } from "./alike.ts";
import type { Project, RecordEntry, Use } from "./project.ts";
import { useOutcome, useShared } from "./ui.tsx";
import type { Workspace } from "./workspace.ts";

interface Proposal {
  use: Use;
  because: string;
}

/** Keeps the proposed uses those of the records as they are read now. */
export function useProposals(): void {
  const { workspace } = useShared();
  const { project } = workspace;
  const { records } = project;
  const key = records.some((entry) => isOpen(project, entry)) ? JSON.stringify(records.map(({ file, columns, prepare }) => [file, columns, prepare])) : undefined;
  const { value } = useOutcome(key, () => proposals(workspace, records.map(whole)));
  useEffect(() => {
    if (!value) return;
    const next = (project: Project) => project.records.map((entry) => (isOpen(project, entry) ? { ...entry, ...value.get(entry.file) } : entry));
    if (JSON.stringify(next(project)) === JSON.stringify(records)) return;
    workspace.amend((project) => ({ ...project, records: next(project) }));
  }, [value]);
}

/** True if nobody has chosen the use of a record, and no model depends on it. */
const isOpen = ({ models }: Project, { file, because }: RecordEntry): boolean =>
  because !== undefined && !models.some(({ from }) => from?.some((one) => one.file === file));

/** Proposals by the names of the files. */
async function proposals(workspace: Workspace, entries: RecordEntry[]): Promise<Map<string, Proposal>> {
  const found = new Map<string, Proposal>();
  const readable: RecordEntry[] = [];
  for (const entry of entries) {
    const result = await workspace.inspected(entry).then(({ result }) => result, () => undefined);
    if (result?.record) readable.push(entry);
    else if (!result || isPath(result)) {
      found.set(entry.file, { use: "none", because: result ? "it has one signal: no record, but a path to compensate" : "" });
    }
  }
  if (readable.length < 2) return found;
  const { files, records } = await workspace.sources(readable);
  const request = { call: "inspect", records, files: { data: readable.map(({ file }) => file) } };
  const answer = await workspace.run({ name: "uses of the records", request, files, beside: true, quiet: true });
  for (const { file, use } of answer.result.files as { file: string; use: Proposal | null }[]) {
    // What most records are for needs no reason.
    if (use) found.set(file, use.use === "training" ? { use: "training", because: "" } : use);
  }
  return found;
}

/** True for a file with a single signal beside its time. */
const isPath = ({ channels }: { channels: { role: string | null }[] }): boolean => channels.filter(({ role }) => role !== "time").length === 1;
