// Files of one rig look alike: what is said of the columns of one is said of all.

import type { File } from "./packet.ts";
import { fileName, filesOf, free, type Options, PROJECT, type Project, type RecordEntry, type Rig } from "./project.ts";
import type { Workspace } from "./workspace.ts";

/** How a file looks, and how it is read. */
export interface Look {
  /** The same for files that look alike, as the library says. */
  layout: string;
  /** How the record is read, as the library writes it; nothing while the roles are not decided. */
  profile?: string;
  /** What is read: the same for ways of reading that come to the same. */
  reads: string;
}

/** What is said of a rig: all of the columns but the part of one file that is used. */
export function ofRig({ from: _f, to: _t, ...columns }: Options): Options {
  return columns;
}

/** The record without its part. */
export const whole = (entry: RecordEntry): RecordEntry => ({ ...entry, columns: ofRig(entry.columns) });

/** The record, read as the files of a rig are; its part stays. */
export function readAs(entry: RecordEntry, columns: Options): RecordEntry {
  const { from, to } = entry.columns;
  return { ...entry, columns: { ...columns, ...(from !== undefined && { from }), ...(to !== undefined && { to }) } };
}

const key = ({ file, columns }: RecordEntry): string => JSON.stringify([file, ofRig(columns)]);

const known = new WeakMap<Workspace, Map<string, Promise<Look | undefined>>>();

/** How the file of a record looks; nothing if it cannot be read. */
export function look(workspace: Workspace, entry: RecordEntry): Promise<Look | undefined> {
  const all = known.get(workspace) ?? new Map<string, Promise<Look | undefined>>();
  known.set(workspace, all);
  const inspection = all.get(key(entry)) ?? workspace.inspected(whole(entry)).then(
    ({ result, files }) => {
      const profile = files.find(({ name }) => name === "profile.toml");
      const reads = JSON.stringify([result.record, result.shape, result.channels]);
      return { layout: String(result.layout), reads, ...(profile && { profile: new TextDecoder().decode(profile.bytes) }) };
    },
    () => void all.delete(key(entry)),
  );
  all.set(key(entry), inspection);
  return inspection;
}

/** True if two files that look alike are read in the same way: the first as it is, and as the second. */
function isSame(a: RecordEntry, b: RecordEntry, looks: Looks): boolean {
  const [own, other, asOther] = [looks.of(a), looks.of(b), looks.of(readAs(a, b.columns))];
  const isWritten = own?.profile !== undefined && own.profile === other?.profile;
  return JSON.stringify(sorted(a)) === JSON.stringify(sorted(b)) || isWritten || (own !== undefined && own.reads === asOther?.reads);
}

const sorted = ({ columns }: RecordEntry) => Object.entries(ofRig(columns)).sort(([a], [b]) => (a < b ? -1 : 1));

const isSaid = ({ columns }: RecordEntry): boolean => Object.keys(ofRig(columns)).length > 0;

/** How files look. */
export class Looks {
  #all = new Map<string, Look | undefined>();

  of(entry: RecordEntry): Look | undefined {
    return this.#all.get(key(entry));
  }

  /** Of the records of a project, of them if they were read as their rigs, and of those of which nothing is said if they
   * were read as one of them. */
  static async over(workspace: Workspace, shown?: RecordEntry): Promise<Looks> {
    const looks = new Looks();
    const add = async (entry: RecordEntry) => void looks.#all.set(key(entry), await look(workspace, entry));
    const { records, rigs } = workspace.project;
    await Promise.all(records.map(add));
    const asRig = records.flatMap((entry) => {
      const rig = rigs.find(({ layout }) => layout === looks.of(entry)?.layout);
      return rig ? [readAs(entry, rig.columns)] : [];
    });
    const asShown = records.filter((entry) => shown && isSaid(shown) && !isSaid(entry) && looks.of(entry)?.layout === looks.of(shown)?.layout);
    await Promise.all([...asRig, ...asShown.map((entry) => readAs(entry, shown!.columns))].map(add));
    return looks;
  }
}

/** What can be said of a record among those that look alike. */
export interface Kin {
  layout: string;
  /** The rig of files that look like this. */
  rig?: Rig | undefined;
  /** The record is read as the rig says. */
  isRig: boolean;
  /** Other records that are read as the rig says. */
  members: RecordEntry[];
  /** What a button offers: these are read as that record is. */
  offer?: { from: RecordEntry; to: RecordEntry[] } | undefined;
}

/** Nothing for a record whose file cannot be read, or is not known yet. */
export function kinOf(entry: RecordEntry, { records, rigs }: Project, looks: Looks): Kin | undefined {
  const own = looks.of(entry);
  if (!own) return undefined;
  const { layout } = own;
  const others = records.filter((one) => one.file !== entry.file && looks.of(one)?.layout === layout);
  const rig = rigs.find((one) => one.layout === layout);
  const isMember = (one: RecordEntry) => rig !== undefined && isSame(one, readAs(one, rig.columns), looks);
  // A file that was set up by itself stays as it is.
  const isOwn = (one: RecordEntry) => isSaid(one) && !isMember(one) && looks.of(one)?.profile !== undefined;
  const offer = () => {
    if (isSaid(entry) && own.profile !== undefined) return { from: entry, to: others.filter((one) => !isOwn(one) && !isSame(one, entry, looks)) };
    // Nothing is said of this file: perhaps of another one.
    if (rig || isSaid(entry)) return undefined;
    const from = others.filter((one) => isSaid(one) && looks.of(one)?.profile !== undefined && !isSame(one, entry, looks)).at(-1);
    return from && { from, to: [entry, ...others.filter((one) => !isSaid(one) && !isSame(one, from, looks))] };
  };
  const offered = offer();
  return { layout, rig, isRig: isMember(entry), members: others.filter(isMember), offer: offered?.to.length ? offered : undefined };
}

/** The project with these records read as one of them is, which describes the rig. */
export function described(project: Project, { layout, offer }: Pick<Kin, "layout" | "offer">, name: string): Project {
  if (!offer) return project;
  const columns = ofRig(offer.from.columns);
  const files = new Set(offer.to.map(({ file }) => file));
  const rig = project.rigs.find((one) => one.layout === layout);
  const rigs = rig
    ? project.rigs.map((one) => (one === rig ? { ...rig, columns } : one))
    : [...project.rigs, { name, layout, columns }];
  return { ...project, rigs, records: project.records.map((one) => (files.has(one.file) ? readAs(one, columns) : one)) };
}

/** The name of the profile of a rig among the files of the project. */
export const profileName = ({ name }: Pick<Rig, "name">): string => `${name}.toml`;

/** A name for a rig, one like the proposed that no other rig and no file has. */
export function rigName(proposed: string, project: Project, files: string[]): string {
  const plain = fileName(proposed.trim().replace(/\.toml$/i, ""));
  const taken = new Set([PROJECT, ...files, ...filesOf(project), ...project.rigs.map(profileName)].map((name) => name.toLowerCase()));
  return free(profileName({ name: plain }), (name) => taken.has(name.toLowerCase())).replace(/\.toml$/, "");
}

/** What names of files begin with: scope of scope_1.csv and scope_2.csv; nothing if that is less than two letters. */
export function common(names: string[]): string {
  const [first = "", ...others] = names.map((name) => name.replace(/\.\w+$/, ""));
  let end = first.length;
  for (const other of others) while (!other.startsWith(first.slice(0, end))) end--;
  const stem = first.slice(0, end).replace(/[\d\s._-]+$/, "");
  return /\p{L}{2}/u.test(stem) ? stem : "";
}

/** The profiles of the rigs: for the command line and Python. A rig without a record that it reads has none. */
export async function profilesOf(workspace: Workspace): Promise<File[]> {
  const { records, rigs } = workspace.project;
  if (rigs.length === 0) return [];
  const looks = await Looks.over(workspace);
  return rigs.flatMap((rig) => {
    const alike = records.filter((entry) => looks.of(entry)?.layout === rig.layout);
    const text = alike.map((entry) => looks.of(readAs(entry, rig.columns))?.profile).find((profile) => profile !== undefined);
    const isFile = filesOf(workspace.project).includes(profileName(rig));
    return text === undefined || isFile ? [] : [{ name: profileName(rig), bytes: new TextEncoder().encode(text) }];
  });
}
