// A record as it is read, and as it is used where that differs.

import { whole } from "../alike.ts";
import type { RecordEntry } from "../project.ts";
import type { Workspace } from "../workspace.ts";
import type { Shown } from "./figures.ts";

export async function shownOf(workspace: Workspace, entry: RecordEntry): Promise<Shown> {
  const { from, to } = entry.columns;
  const changed = from !== undefined || to !== undefined || Object.keys(entry.prepare).length > 0;
  const read = await workspace.inspected(whole(entry));
  const used = changed && read.result.record ? await workspace.prepared(entry) : undefined;
  return { file: entry.file, whole: read, used, start: Number(from ?? 0) };
}
