// A requested displacement as the library takes it.

import type { File } from "./packet.ts";
import type { Options } from "./project.ts";
import type { Workspace } from "./workspace.ts";

/** A path drawn by hand as a signal: moves through points that are evenly spread over the duration. */
export function moves(points: number[], duration: number): Options {
  const amplitude = Math.max(...points.map(Math.abs)) || 1;
  return { kind: "moves", amplitude, points: points.map((height) => height / amplitude), duration };
}

/** The file of a signal of displacements. */
export async function pathFile(workspace: Workspace, signal: Options, ts: number, unit: string): Promise<File> {
  const request = { call: "excite", options: { ...signal, ts, unit } };
  const answer = await workspace.run({ name: "path", request, files: [], quiet: true });
  return csv("path.csv", unit, ts, answer.series.get("u")!);
}

/** A path as a file that the library reads to the bit. */
export function csv(name: string, unit: string, ts: number, path: Float64Array): File {
  const rows = Array.from(path, (value, k) => `${k * ts},${value}`);
  return { name, bytes: new TextEncoder().encode(`t_s,r_${unit}\n${rows.join("\n")}\n`) };
}
