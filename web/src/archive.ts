// A project in one file: a zip archive of its files and project.json.

import { strFromU8, strToU8, unzipSync, zipSync } from "fflate";
import { filesOf, type Project, read, written } from "./project.ts";
import type { File } from "./packet.ts";

/** Name of the project itself among its files. */
export const PROJECT = "project.json";

/** All in one file. */
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
  try {
    return unzipSync(bytes);
  } catch {
    throw new Error("this is no project of piezoid, or it is damaged: open a file that Save has written");
  }
}

/** Several files in one. */
export const zipped = (files: File[]): Uint8Array =>
  zipSync(Object.fromEntries(files.map((file) => [file.name, file.bytes])), { mtime: "1980-01-01" });
