// The bundled example: records of a simulated bender, measured for the occasion by its own drives.

import { useRef, useState } from "preact/hooks";
import { save } from "./archive.ts";
import type { File } from "./packet.ts";
import type { Use } from "./project.ts";
import type { Workspace } from "./workspace.ts";

/** The drives of the example, each with its use. */
const DRIVES = [
  { name: "rising-5Hz.csv", kind: "rising-sine", options: { amplitude: 28, frequency: 5, duration: 2 }, use: "training" },
  { name: "rising-20Hz.csv", kind: "rising-sine", options: { amplitude: 28, frequency: 20, duration: 1 }, use: "training" },
  { name: "prbs.csv", kind: "prbs", options: { amplitude: 1, duration: 2 }, use: "small-signal" },
  { name: "staircase.csv", kind: "staircase", options: { amplitude: 25, frequency: 10, duration: 1 }, use: "validation" },
] as const;

/** Opens the example, a project of its own, and shows its first record. */
async function example(workspace: Workspace): Promise<void> {
  const records: { file: File; use: Use }[] = [];
  for (const { name, kind, options, use } of DRIVES) {
    const ask = { name: "example", quiet: true };
    const excite = { call: "excite", options: { kind, ts: 5e-4, ...options } };
    const drive = (await workspace.run({ ...ask, request: excite, files: [] })).files[0]!;
    const simulate = { call: "simulate", options: { plant: "pl140" }, files: { input: [drive.name] } };
    const record = (await workspace.run({ ...ask, request: simulate, files: [drive] })).files[0]!;
    records.push({ file: { name, bytes: record.bytes }, use });
  }
  await workspace.addRecords(records, { look: true, fresh: true });
}

/** The button that opens the example. A project with work of its own is saved as a file first. */
export function ExampleButton({ workspace, title }: { workspace: Workspace; title: string }) {
  const dialog = useRef<HTMLDialogElement>(null);
  const [busy, setBusy] = useState(false);
  const { records, models } = workspace.project;
  const isSearching = workspace.search?.isRunning === true;
  const open = async (isSaved: boolean) => {
    dialog.current?.close();
    setBusy(true);
    try {
      if (isSaved) await save(workspace);
      await example(workspace);
    } catch (error) {
      workspace.failed(error);
    }
    setBusy(false);
  };
  const hasWork = records.length > 0 || models.length > 0;
  const count = (number: number, what: string) => (number === 0 ? [] : [`${number} ${what}${number === 1 ? "" : "s"}`]);
  const work = [...count(records.length, "record"), ...count(models.length, "model")].join(" and ");
  return (
    <>
      <button type="button" disabled={busy} onClick={() => (hasWork ? dialog.current?.showModal() : void open(false))}>{title}</button>
      <dialog ref={dialog} aria-label="The example is a project of its own">
        <h2>The example is a project of its own</h2>
        <p>
          It takes the place of this project, which has {work}. This one is saved as piezoid-project.zip first: Open takes it back, and so does Undo as
          long as this page stays open.
        </p>
        {isSearching && <p class="missing">A search is under way: cancel it first, or wait for its end.</p>}
        <div class="row">
          <button type="button" class="main" disabled={isSearching} onClick={() => void open(true)}>Save this project, and open the example</button>
          <button type="button" onClick={() => dialog.current?.close()}>Stay in this project</button>
        </div>
      </dialog>
    </>
  );
}
