// Drives that are run one after the other, on a twin or on a controller; their records go to the project.

import type { Answer, File } from "../packet.ts";
import type { Use } from "../project.ts";
import type { Workspace } from "../workspace.ts";

/** Drives of a plan, and their files. */
export interface Drives {
  drives: { name: string; file: string }[];
  files: File[];
}

/** What the record of a drive of a plan is used for. */
export const useOf = (drive: string): Use => (drive === "small" ? "small-signal" : drive === "path" ? "validation" : "training");

/** Runs every drive, and adds the records, in one step, until one leaves the actuator elsewhere. The number of records. */
export async function measured(
  workspace: Workspace,
  { drives, files }: Drives,
  prefix: string,
  run: (drive: string, file: File) => Promise<Answer>,
): Promise<number> {
  let count = 0;
  try {
    for (const { name, file } of drives) {
      const drive = files.find((one) => one.name === file);
      if (!drive) throw new Error(`the plan lacks its file ${file}`);
      const { files: [written], result } = await run(name, drive);
      if (!written) throw new Error(`there is no record of ${file}`);
      const record = { name: `${prefix}-${name}.csv`, bytes: written.bytes };
      await workspace.addRecords([{ file: record, use: useOf(name) }], { passing: true });
      count += 1;
      // The record is measured, but the actuator is not where it was to be: no further drive.
      if (result?.unfinished) throw new Error(`${name}: ${result.unfinished}; the record is in the project`);
    }
  } finally {
    // What is measured is kept, even if a later drive fails or is cancelled, and is undone in one step.
    if (count > 0) workspace.change((project) => project);
  }
  return count;
}
