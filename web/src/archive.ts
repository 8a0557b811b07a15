// A project in one file: a zip archive of its files and project.json.

import { strFromU8, strToU8, unzipSync, zipSync } from "fflate";
import { profilesOf } from "./alike.ts";
import type { File } from "./packet.ts";
import { download } from "./plot/download.ts";
import { filesOf, PROJECT, type Project, read, written } from "./project.ts";
import type { Workspace } from "./workspace.ts";

/** Most bytes that an archive may hold, unpacked: as much as `piezoid serve` takes in one file. */
const LIMIT = 512 * 2 ** 20;

/** All in one file: the project, its files and the profiles of its rigs. */
export function packedProject(project: Project, files: File[]): Uint8Array {
  const all = Object.fromEntries(files.map((file) => [file.name, file.bytes]));
  return zipSync({ ...all, [PROJECT]: strToU8(written(project)) }, { level: 6, mtime: "1980-01-01" });
}

/** The project and its files in such a file. */
export function unpackedProject(bytes: Uint8Array): { project: Project; files: File[] } {
  const all = unzipped(bytes);
  const text = all[PROJECT];
  if (!text) throw new Error(`this archive holds no ${PROJECT}: it is not a project of piezoid`);
  const project = read(strFromU8(text));
  const missing = filesOf(project).filter((name) => !all[name]);
  if (missing.length) throw new Error(`this project lacks its files ${missing.join(", ")}`);
  return { project, files: filesOf(project).map((name) => ({ name, bytes: all[name]! })) };
}

function unzipped(bytes: Uint8Array): Record<string, Uint8Array> {
  const failed = () => new Error("this is no project of piezoid, or it is damaged: open a file that Save has written");
  let size = 0;
  try {
    unzipSync(bytes, { filter: ({ originalSize }) => { size += originalSize; return false; } });
  } catch {
    throw failed();
  }
  if (size > LIMIT) {
    const [holds, most] = [size, LIMIT].map((count) => Math.round(count / 2 ** 20));
    throw new Error(`this archive holds ${holds} MiB, but at most ${most} MiB can be opened: add its records one by one`);
  }
  try {
    return unzipSync(bytes);
  } catch {
    throw failed();
  }
}

/** Several files in one. */
export const zipped = (files: File[]): Uint8Array =>
  zipSync(Object.fromEntries(files.map((file) => [file.name, file.bytes])), { mtime: "1980-01-01" });

/** Downloads the project of the page in one file, with the profiles of its rigs. */
export async function save(workspace: Workspace): Promise<void> {
  const { project } = workspace;
  const files = await Promise.all(filesOf(project).map((name) => workspace.file(name)));
  const packed = packedProject(project, [...files, ...(await profilesOf(workspace))]);
  download("piezoid-project.zip", packed as BlobPart, "application/zip");
}

/** Takes up a project from one file; the present one can be gone back to. */
export async function unpack(workspace: Workspace, bytes: Uint8Array): Promise<void> {
  const { project, files } = unpackedProject(bytes);
  const names = new Map<string, string>();
  for (const file of files) names.set(file.name, await workspace.keep(file, true));
  const named = <E extends { file: string }>(entry: E): E => ({ ...entry, file: names.get(entry.file) ?? entry.file });
  const name = (old: string | undefined) => (old === undefined ? {} : names.get(old));
  workspace.change(() => ({
    ...project,
    records: project.records.map(named),
    models: project.models.map((entry) => ({
      ...named(entry), ...(entry.from && { from: entry.from.map(named) }), ...(entry.standIn && { standIn: named(entry.standIn) }),
    })),
    ...(project.record && { record: name(project.record) as string }),
    ...(project.model && { model: name(project.model) as string }),
  }));
}
