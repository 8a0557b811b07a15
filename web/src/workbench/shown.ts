// A record as it is read, and as it is used where that differs.

import type { RecordEntry } from "../project.ts";
import type { Workspace } from "../workspace.ts";
import { uncut } from "./cut.ts";
import type { Shown } from "./figures.ts";

export async function shownOf(workspace: Workspace, entry: RecordEntry): Promise<Shown> {
  const { from, to } = entry.columns;
  const changed = from !== undefined || to !== undefined || Object.keys(entry.prepare).length > 0;
  const whole = await workspace.inspected(uncut(entry));
  const used = changed && whole.result.record ? await workspace.prepared(entry) : undefined;
  return { file: entry.file, whole, used, start: Number(from ?? 0) };
}
