// What is requested of the library for a path: its file, its voltage, and the displacements that it can reach.

import type { Lists } from "../lists.ts";
import { recorded } from "../models.tsx";
import type { Answer, File } from "../packet.ts";
import { moves, pathFile } from "../path.ts";
import type { Options } from "../project.ts";
import type { Workspace } from "../workspace.ts";

/** What the view remembers. */
export interface Settings {
  /** `drawn`, the file of a record, or a kind of signal. */
  path?: string;
  /** Heights of the points of a drawn path [output unit]. */
  points?: number[];
  /** Length of a drawn path [s]. */
  duration?: number;
  /** Options of a kind of signal. */
  signal?: Options;
  options?: Options;
  /** Options of moves in time. */
  moves?: Options;
  /** What the middle shows. */
  picture?: string;
}

/** A requested path, with what is left out filled in. */
export interface Path extends Pick<Settings, "path" | "signal"> {
  points: number[];
  duration: number;
  /** Options of a kind of signal at first. */
  usual: Record<string, number>;
  /** Sampling period [s], and unit. */
  ts: number;
  of: string;
}

/** Share of what the model reaches that a path uses at first. */
const SHARE = 0.3;

/** A path at first: two moves to both sides of the middle, in shares of the height. */
const MOVES = [0, 1, 1, -1, -1, 0.5, 0];

/** The displacements of a model at the ends of its range of voltage. */
export async function strokeOf(workspace: Workspace, file: string, model: any): Promise<[number, number]> {
  const [low, high]: [number, number] = recorded(model)?.u ?? model.hysteresis?.range ?? [0, 1];
  const unitName = model.units?.u ?? "V";
  const inputs = Array.from({ length: 400 }, (_, k) => `${k * model.ts},${k < 200 ? low : high}`);
  const drive = { name: "ends.csv", bytes: new TextEncoder().encode(`t_s,u_${unitName}\n${inputs.join("\n")}\n`) };
  const answer = await workspace.answer(`ends ${file}`, async () => ({
    name: "ends of the stroke",
    request: { call: "simulate", options: { begin: "settled" }, files: { input: [drive.name], model: [file] } },
    files: [drive, await workspace.file(file)],
  }));
  const y = answer.series.get("y")!;
  return [y[199]!, y[399]!];
}

/** The path of these settings, for a model with this stroke. */
export function pathOf({ path = "drawn", signal = {}, points, duration = 0.5 }: Settings, model: any, stroke: [number, number]): Path {
  const rounded = (value: number) => Number(value.toPrecision(2));
  const [height, middle] = [rounded((SHARE * Math.abs(stroke[1] - stroke[0])) / 2), rounded((stroke[0] + stroke[1]) / 2)];
  const centre = Math.abs(middle) < 0.1 * height ? 0 : middle;
  return {
    path, signal, duration, points: points ?? MOVES.map((move) => centre + move * height), ts: model.ts, of: model.units?.y ?? "um",
    usual: { amplitude: height, offset: centre, frequency: 4 / duration },
  };
}

/** The options that a kind of signal has: those of another kind that was chosen before are kept, but not sent. */
function ofKind(path: string, signal: Options, lists: Lists): Options {
  const known = lists.excitations.find((one) => one.name === path)?.options ?? [];
  return Object.fromEntries(Object.entries(signal).filter(([name]) => known.some((row) => row.name === name)));
}

/** The file of a path, with how its columns are read if it is not of our own. */
export interface PathFile extends File {
  columns?: Options;
}

/** What a call states of a path. */
export const reading = ({ columns }: PathFile): { columns?: Options } => (columns ? { columns } : {});

/** The file of a path. */
export async function fileOf(workspace: Workspace, lists: Lists, { path = "drawn", signal = {}, points, duration, usual, ts, of }: Path): Promise<PathFile> {
  const record = workspace.project.records.find((one) => one.file === path);
  if (record && (await workspace.inspected(record)).result.record) return { ...(await workspace.ready(record)), name: "path.csv" };
  // A file without a voltage is no record, but it has a path.
  if (record) return { ...(await workspace.file(record.file)), columns: record.columns };
  return pathFile(workspace, path === "drawn" ? moves(points, duration) : { kind: path, duration, ...usual, ...ofKind(path, signal, lists) }, ts, of);
}

/** The voltage for a path. */
export const compensated = async (workspace: Workspace, file: string, path: PathFile, options: Options): Promise<Answer> =>
  workspace.run({
    name: "compensate",
    request: { call: "compensate", options, ...reading(path), files: { model: [file], reference: [path.name] } },
    files: [await workspace.file(file), path],
    quiet: true,
  });
