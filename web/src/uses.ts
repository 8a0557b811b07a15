// What records that are added are probably for, beside those that are there: the library compares their drives.

import type { RecordEntry, Use } from "./project.ts";
import type { Workspace } from "./workspace.ts";

/** The added records, each with the use that the library proposes, and the reason. Those that cannot be read are not used. */
export async function proposed(workspace: Workspace, added: RecordEntry[]): Promise<RecordEntry[]> {
  const all = [...workspace.project.records, ...added].filter(({ use }) => use !== "none");
  if (all.length < 2) return added;
  const uses = await usesOf(workspace, all).catch(() => new Map<string, Proposal>());
  return added.map((entry) => {
    const one = entry.use === "none" ? undefined : uses.get(entry.file);
    return one && one.use !== entry.use ? { ...entry, ...one } : entry;
  });
}

interface Proposal {
  use: Use;
  because: string;
}

async function usesOf(workspace: Workspace, entries: RecordEntry[]): Promise<Map<string, Proposal>> {
  const { files, records } = await workspace.sources(entries);
  const request = { call: "inspect", records, files: { data: entries.map(({ file }) => file) } };
  const answer = await workspace.run({ name: "uses of the records", request, files, beside: true, quiet: true });
  const known: { file: string; use: Proposal | null }[] = answer.result.files;
  return new Map(known.flatMap(({ file, use }) => (use ? [[file, use] as const] : [])));
}
