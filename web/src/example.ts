// The bundled example: records of a simulated bender, measured for the occasion by its own drives.

import type { Workspace } from "./workspace.ts";

/** The drives of the example, each with its use. */
const DRIVES = [
  { name: "prbs.csv", kind: "prbs", options: { amplitude: 1, duration: 2 }, use: "small-signal" },
  { name: "rising-5Hz.csv", kind: "rising-sine", options: { amplitude: 28, frequency: 5, duration: 2 }, use: "training" },
  { name: "rising-20Hz.csv", kind: "rising-sine", options: { amplitude: 28, frequency: 20, duration: 1 }, use: "training" },
  { name: "staircase.csv", kind: "staircase", options: { amplitude: 25, frequency: 10, duration: 1 }, use: "validation" },
] as const;

/** Adds records of the simulated bender PL140, and shows one. */
export async function example(workspace: Workspace): Promise<void> {
  for (const { name, kind, options, use } of DRIVES) {
    const excite = { call: "excite", options: { kind, ts: 5e-4, ...options } };
    const drive = (await workspace.run({ name: "example", request: excite, files: [], quiet: true })).files[0]!;
    const simulate = { call: "simulate", options: { plant: "pl140" }, files: { input: [drive.name] } };
    const record = (await workspace.run({ name: "example", request: simulate, files: [drive], quiet: true })).files[0]!;
    await workspace.addRecords([{ name, bytes: record.bytes }], use);
  }
  workspace.change((project) => ({ ...project, record: project.records.find((one) => one.file.startsWith("rising-5"))?.file ?? project.record! }));
}
