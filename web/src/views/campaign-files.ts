// The files of a campaign: its records and its model go to the project, and what was measured continues a campaign that
// was broken off.

import type { Answer, File } from "../packet.ts";
import { withSettings } from "../project.ts";
import type { Workspace } from "../workspace.ts";
import { useOf } from "./measured.ts";

/** Where the files of a campaign are in the store, by the names that the library gives them. */
type Places = Record<string, string>;

/** The settings that have them. */
const PLACES = "campaign-files";

const placesOf = (workspace: Workspace): Places => (workspace.project.settings[PLACES] ?? {}) as Places;

/** The names of records, which stand beside their drives: rise1.csv beside rise1_u.csv. */
export const recordsIn = (names: string[]): string[] =>
  names.flatMap((name) => (name.endsWith("_u.csv") ? [name.replace("_u.csv", "")] : [])).filter((name) => names.includes(`${name}.csv`));

/** Names of the records of the last campaign. */
export const measuredBefore = (workspace: Workspace): string[] => recordsIn(Object.keys(placesOf(workspace)));

/** What the last campaign has measured, drives and records, as far as it is still there. */
export async function earlier(workspace: Workspace): Promise<File[]> {
  const places = placesOf(workspace);
  const files: File[] = [];
  for (const name of measuredBefore(workspace).flatMap((record) => [`${record}_u.csv`, `${record}.csv`])) {
    const bytes = await workspace.bytes(places[name]!).catch(() => undefined);
    if (bytes) files.push({ name, bytes });
  }
  return files;
}

/** Keeps what a campaign has measured and found, in one step. `continued`: it went on with the records of the last one. */
export async function kept(workspace: Workspace, { result, files }: Answer, continued: boolean): Promise<void> {
  const places: Places = continued ? { ...placesOf(workspace) } : {};
  const own = ({ name }: File) => (name.startsWith("campaign") ? name : `campaign-${name}`);
  for (const file of files) {
    if (file.name !== "model.json") places[file.name] = await workspace.keep({ name: own(file), bytes: file.bytes });
  }
  const records = recordsIn(files.map(({ name }) => name));
  const entries = records.map((name) => ({ file: places[`${name}.csv`]!, use: useOf(name) }));
  await workspace.addStored(entries, { look: false, passing: true });
  const model = files.find(({ name }) => name === "model.json");
  const settled = (passing: boolean) => workspace.change((project) => withSettings(project, PLACES, places), passing);
  settled(model !== undefined);
  if (!model) return;
  const from = recordsIn(Object.keys(places)).filter((name) => useOf(name) !== "validation").map((name) => places[`${name}.csv`]);
  await workspace.addModel({ name: "campaign-model.json", bytes: model.bytes }, {
    summary: result.model ?? "from a campaign that was broken off",
    verdict: "",
    notes: result.notes ?? [],
    from: workspace.project.records.filter(({ file }) => from.includes(file)),
    ...(result.sentence && { validated: result.sentence }),
  });
}
