// What all views share: the project with its history and files, the library, and the work under way.

import { look as lookOf } from "./alike.ts";
import type { Library } from "./library.ts";
import { type Answer, type File, message, type Reading } from "./packet.ts";
import { Profiles } from "./profiles.ts";
import {
  EMPTY, fileName, filesOf, free, History, isProject, type ModelEntry, PROJECT, type Project, read, type RecordEntry, withRecord, written,
} from "./project.ts";
import { equal, type Store } from "./store.ts";
import { Work } from "./work.ts";
import type { Search } from "./workbench/search.ts";

/** How long the project may differ from what is stored [ms]. */
const DELAY = 200;

/** Time until what could not be stored is tried again [ms]. */
const AGAIN = 2000;

export class Workspace extends Work {
  /** The identification that is under way, or the last. */
  search: Search | undefined;
  /** The last fault of the store or the library that no view shows. */
  fault = "";
  /** Why the project of the store cannot be read; nothing is stored then, until one is begun beside it. */
  unreadable = "";
  /** True once the project of the store is known: nothing is stored before, not even if that fails. */
  #isOpen = false;
  /** Where the project is stored. */
  #name = PROJECT;
  #beside = PROJECT;
  #history = new History<Project>(EMPTY);
  #files = new Map<string, Uint8Array>();
  /** The fault because of which the project could not be stored. */
  #untold = "";
  #conflict = false;
  /** No edit of the project mends the fault. */
  #lasts = false;
  #saving: ReturnType<typeof setTimeout> | undefined;
  readonly #profiles = new Profiles();

  constructor(library: Library, readonly store: Store) {
    super(library);
  }

  get project(): Project {
    return this.#history.now;
  }

  get canUndo(): boolean {
    return this.#history.canUndo;
  }

  get canRedo(): boolean {
    return this.#history.canRedo;
  }

  /** Takes up what was stored: the first project that can be read. One that cannot be read stays as it is, with all files. */
  async open(): Promise<void> {
    const names = await this.store.names();
    const number = (name: string) => Number(name.match(/\d+/)?.[0] ?? 1);
    const projects = names.filter(isProject).sort((a, b) => number(a) - number(b));
    const whys: string[] = [];
    for (const name of projects) {
      const text = new TextDecoder().decode(await this.store.read(name));
      try {
        this.#history = new History(read(text));
        this.#name = name;
        this.#profiles.opened(this.project.rigs, names);
        break;
      } catch (error) {
        whys.push(`${name} cannot be read: ${(error as Error).message}`);
      }
    }
    if (whys.length === projects.length) this.unreadable = whys.join("; ");
    this.#beside = free(PROJECT, (name) => projects.includes(name));
    this.#isOpen = true;
    const used = new Set([this.#name, ...filesOf(this.project)]);
    const unused = this.store.own && whys.length === 0 ? names.filter((name) => !used.has(name)) : [];
    for (const name of unused) await this.store.remove(name);
    this.changed();
  }

  /** The name of a project that is begun beside one that cannot be read. */
  get beside(): string {
    return this.#beside;
  }

  /** Stores the project under that name from now on. */
  begin(): void {
    this.#name = this.#beside;
    this.unreadable = "";
    this.#save();
    this.changed();
  }

  /** Goes on to another project. With `passing`, the next change is undone together with this one. */
  change(next: (project: Project) => Project, passing = false): void {
    this.#edited(() => this.#history.to(next(this.project), passing));
  }

  /** Adds to the project what is no change of the user, and is not undone. */
  amend(next: (project: Project) => Project): void {
    this.#history.amend(next);
    this.#save();
    this.changed();
  }

  undo(): void {
    this.#edited(() => this.#history.undo());
  }

  redo(): void {
    this.#edited(() => this.#history.redo());
  }

  /** After an edit of the user, a fault of the work before is of no interest. */
  #edited(edit: () => void): void {
    if (!this.#lasts) this.fault = "";
    edit();
    this.#save();
    this.changed();
  }

  /** Stores what is not stored yet, at once. */
  async flush(): Promise<void> {
    clearTimeout(this.#saving);
    this.#saving = undefined;
    if (!this.#isOpen || this.unreadable) return;
    await this.store.write(this.#name, new TextEncoder().encode(written(this.project)));
    if (!this.store.own) await this.#profiles.store(this);
  }

  /** True while the page says that another tab or program has written another version of the project. */
  get conflict(): boolean {
    return this.#conflict && this.fault !== "" && this.fault === this.#untold;
  }

  /** Stores the project in the place of another version of it, which another tab or program has written. */
  async overwrite(): Promise<void> {
    await this.store.read(this.#name);
    await this.flush();
    this.fault = "";
    this.changed();
  }

  #save(delay = DELAY): void {
    clearTimeout(this.#saving);
    this.store.soon?.();
    this.#saving = setTimeout(() => this.flush().then(() => this.#stored(), (error) => this.#unstored(error)), delay);
  }

  /** What could not be stored before is stored now. */
  #stored(): void {
    if (this.fault !== this.#untold) return;
    this.#untold = this.fault = "";
    this.changed();
  }

  #unstored(error: Error): void {
    this.failed(error, true);
    this.#untold = this.fault;
    this.#conflict = error.name === "Conflict";
    // A server that is gone may come back.
    if (error.name === "Gone") this.#save(AGAIN);
  }

  /** Shows a fault; until it is closed, or else until the next edit. */
  failed(error: unknown, lasts = false): void {
    this.fault = message(error);
    this.#lasts = lasts;
    this.changed();
  }

  // Files.

  /** The content of a file of the project. */
  async bytes(name: string): Promise<Uint8Array> {
    const known = this.#files.get(name) ?? (await this.store.read(name));
    this.#files.set(name, known);
    return known;
  }

  /** The document in a file of the project, such as a model. */
  async document(name: string): Promise<any> {
    return JSON.parse(new TextDecoder().decode(await this.bytes(name)));
  }

  async file(name: string): Promise<File> {
    return { name, bytes: await this.bytes(name) };
  }

  /** Keeps a content under its name, or under one like it that is free; the result is the name. With `same`, a file that
   * is there already with this name and content will do. */
  async keep(file: File, same = false): Promise<string> {
    const stored = new Set(await this.store.names());
    const plain = fileName(file.name);
    if (same && plain === file.name && (this.#files.has(file.name) || stored.has(file.name)) && equal(await this.bytes(file.name), file.bytes)) return file.name;
    const name = free(plain, (one) => this.#files.has(one) || stored.has(one));
    this.#files.set(name, file.bytes);
    await this.store.write(name, file.bytes);
    return name;
  }

  /** Adds records in one step; with `look`, the last becomes the one that is looked at. What cannot be kept is reported. */
  async addRecords(files: { file: File; use: RecordEntry["use"] }[], { look = false, passing = false, asRig = false, fresh = false } = {}): Promise<void> {
    const kept: Pick<RecordEntry, "file" | "use">[] = [];
    const whys: string[] = [];
    for (const { file, use } of files) {
      try {
        kept.push({ file: await this.keep(file, fresh), use });
      } catch (error) {
        whys.push(`${file.name}: ${message(error)}`);
      }
    }
    await this.addStored(kept, { look, passing, asRig, fresh });
    if (whys.length > 0) this.failed(whys.join("; "));
  }

  /** The same for files that are in the store already. With `asRig`, those that look like the files of a rig are read
   * like them, and the library proposes their uses. With `fresh`, they begin a project, in the place of this one,
   * and the first is looked at. */
  async addStored(stored: Pick<RecordEntry, "file" | "use">[], { look = true, passing = false, asRig = false, fresh = false } = {}): Promise<void> {
    const entries: RecordEntry[] = [];
    for (const { file, use } of stored) {
      const entry = await this.#usable({ file, columns: {}, prepare: {}, use });
      entries.push(asRig ? await this.#asRig({ ...entry, because: "" }) : entry);
    }
    const shown = entries.at(fresh ? 0 : -1);
    if (!shown) return;
    const looked = look ? { record: shown.file } : {};
    if (fresh) this.search = undefined;
    this.change((now) => {
      const project = fresh ? EMPTY : now;
      return { ...project, records: [...project.records, ...entries], ...looked };
    }, passing);
  }

  /** The entry; a file that cannot be read at all is not used. */
  async #usable(entry: RecordEntry): Promise<RecordEntry> {
    return this.inspected(entry).then(() => entry, () => ({ ...entry, use: "none" as const }));
  }

  /** The entry, read as the files that look alike. */
  async #asRig(entry: RecordEntry): Promise<RecordEntry> {
    if (this.project.rigs.length === 0) return entry;
    const layout = (await lookOf(this, entry))?.layout;
    const rig = this.project.rigs.find((one) => one.layout === layout);
    return rig ? { ...entry, columns: rig.columns } : entry;
  }

  /** Adds a model, which becomes the one that is used. */
  async addModel(file: File, facts: Omit<ModelEntry, "file">): Promise<string> {
    const name = await this.keep(file);
    const entry = { file: name, ...facts };
    this.change((project) => ({ ...project, models: [...project.models, entry], model: name }));
    return name;
  }

  // Records.

  /** What a record's file holds, as it is read with what was said of it. */
  inspected(entry: RecordEntry): Promise<Answer> {
    return this.answer(`inspect ${JSON.stringify([entry.file, entry.columns])}`, async () => ({
      name: "inspect",
      request: { call: "inspect", columns: entry.columns, files: { data: [entry.file] } },
      files: [await this.file(entry.file)],
    }));
  }

  /** The record as it is identified: read, prepared, written as CSV in our own columns. */
  prepared(entry: RecordEntry): Promise<Answer> {
    return this.answer(`prepare ${JSON.stringify([entry.file, entry.columns, entry.prepare])}`, async () => ({
      name: "prepare",
      request: { call: "prepare", columns: entry.columns, options: entry.prepare, files: { data: [entry.file] } },
      files: [await this.file(entry.file)],
    }));
  }

  /** The prepared record as CSV, under the name of its file. */
  async ready(entry: RecordEntry): Promise<File> {
    const [result] = (await this.prepared(entry)).files;
    if (!result) throw new Error(`${entry.file}: nothing was prepared`);
    return { name: entry.file, bytes: result.bytes };
  }

  /** Records for a call: their files and how they are read; where calls read text alone, the prepared records and
   * where they come from. */
  async sources(entries: RecordEntry[]): Promise<{ files: File[]; records: Record<string, Reading> }> {
    const { readsAll } = this.library;
    const files = await Promise.all(entries.map((entry) => (readsAll ? this.file(entry.file) : this.ready(entry))));
    const reading = async (entry: RecordEntry): Promise<Reading> => {
      if (readsAll) return { columns: entry.columns, preparation: [{ prepare: entry.prepare }] };
      return { origin: (await this.prepared(entry)).result.origin };
    };
    const each = entries.map(async (entry) => [entry.file, await reading(entry)] as const);
    return { files, records: Object.fromEntries(await Promise.all(each)) };
  }

  /** Changes what is said of a record. */
  tell(entry: RecordEntry, passing = false): void {
    this.change((project) => withRecord(project, entry), passing);
  }
}
