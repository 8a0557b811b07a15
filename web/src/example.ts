// The bundled example: records of a simulated bender, measured for the occasion by its own drives.

import type { Workspace } from "./workspace.ts";

/** The drives of the example, each with its use. */
const DRIVES = [
  { name: "rising-5Hz.csv", kind: "rising-sine", options: { amplitude: 28, frequency: 5, duration: 2 }, use: "training" },
  { name: "rising-20Hz.csv", kind: "rising-sine", options: { amplitude: 28, frequency: 20, duration: 1 }, use: "training" },
  { name: "prbs.csv", kind: "prbs", options: { amplitude: 1, duration: 2 }, use: "small-signal" },
  { name: "staircase.csv", kind: "staircase", options: { amplitude: 25, frequency: 10, duration: 1 }, use: "validation" },
] as const;

/** Adds records of the simulated bender PL140, and shows the first. */
export async function example(workspace: Workspace): Promise<void> {
  for (const [k, { name, kind, options, use }] of DRIVES.entries()) {
    const ask = { name: "example", quiet: true };
    const excite = { call: "excite", options: { kind, ts: 5e-4, ...options } };
    const drive = (await workspace.run({ ...ask, request: excite, files: [] })).files[0]!;
    const simulate = { call: "simulate", options: { plant: "pl140" }, files: { input: [drive.name] } };
    const record = (await workspace.run({ ...ask, request: simulate, files: [drive] })).files[0]!;
    await workspace.addRecords([{ file: { name, bytes: record.bytes }, use }], { look: k === 0 });
  }
}
