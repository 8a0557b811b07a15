// What a user has: records, models and settings. A project never changes; each change makes a new one, so that all can
// be undone.

/** Values of options by name, as the library takes them. */
export type Options = Record<string, unknown>;

/** What a record is used for. */
export type Use = "training" | "small-signal" | "validation" | "none";

/** A measured record: its file, and what was said of it. */
export interface RecordEntry {
  /** Name of its file in the store. */
  file: string;
  /** Which columns, units and times. */
  columns: Options;
  /** How it is prepared. */
  prepare: Options;
  use: Use;
}

/** An identified model. */
export interface ModelEntry {
  /** Name of its file in the store. */
  file: string;
  /** The model in one line. */
  summary: string;
  /** What the records prove of it. */
  verdict: string;
  /** What else was said of its identification. */
  notes: string[];
  /** The records that it was identified from, as they were read and prepared; unknown of a model from elsewhere. */
  from?: RecordEntry[];
  /** The verdict of the last validation on records that it was not identified from. */
  validated?: string;
}

/** Everything that is saved, besides the files themselves. */
export interface Project {
  records: RecordEntry[];
  models: ModelEntry[];
  /** File of the record that is looked at. */
  record?: string;
  /** File of the model that is used. */
  model?: string;
  /** The forms of the views, by view. */
  settings: Record<string, Options>;
}

export const EMPTY: Project = { records: [], models: [], settings: {} };

/** The project in the text that `written` wrote. */
export function read(text: string): Project {
  const { piezoid, ...project } = JSON.parse(text);
  if (piezoid !== 1 || !Array.isArray(project.records) || !Array.isArray(project.models)) {
    throw new Error("this is not a project of piezoid, or of a newer version");
  }
  return { ...EMPTY, ...project };
}

/** The project as text. */
export const written = (project: Project): string => `${JSON.stringify({ piezoid: 1, ...project }, null, 1)}\n`;

/** The project with another record in the place of the one with its file. */
export const withRecord = (project: Project, entry: RecordEntry): Project => ({
  ...project,
  records: project.records.map((one) => (one.file === entry.file ? entry : one)),
});

/** The project with settings of a view. */
export const withSettings = (project: Project, view: string, values: Options): Project => ({
  ...project,
  settings: { ...project.settings, [view]: values },
});

/** True if the model was identified from the record; of a model from elsewhere the use of the record tells. */
export const isTraining = ({ from }: ModelEntry, { file, use }: RecordEntry): boolean =>
  from ? from.some((one) => one.file === file) : use === "training" || use === "small-signal";

/** The records that are read or prepared in another way since the model was identified from them. */
export const changedSince = ({ from = [] }: ModelEntry, { records }: Project): string[] => {
  const how = ({ columns, prepare }: RecordEntry) => JSON.stringify([columns, prepare]);
  const now = (file: string) => records.find((one) => one.file === file);
  return from.filter((one) => now(one.file) && how(now(one.file)!) !== how(one)).map(({ file }) => file);
};

/** The files that a project needs. */
export const filesOf = (project: Project): string[] =>
  [...project.records, ...project.models].map((entry) => entry.file);

/** A name that is not taken yet: log.csv, log-2.csv. */
export function free(name: string, taken: (name: string) => boolean): string {
  if (!taken(name)) return name;
  const dot = name.lastIndexOf(".");
  const [stem, ending] = dot > 0 ? [name.slice(0, dot), name.slice(dot)] : [name, ""];
  for (let k = 2; ; k++) {
    const next = `${stem}-${k}${ending}`;
    if (!taken(next)) return next;
  }
}

/** States that can be gone back to. */
export class History<T> {
  #past: T[] = [];
  #future: T[] = [];
  /** Where a change of several steps, such as a drag, began. */
  #before: T | undefined;

  constructor(public now: T) {}

  /** Goes on to the next state. With `passing`, the next change takes its place: a drag is undone in one step. */
  to(next: T, passing = false): void {
    this.#before ??= this.now;
    if (!passing) {
      this.#past.push(this.#before);
      if (this.#past.length > 200) this.#past.shift();
      this.#before = undefined;
      this.#future = [];
    }
    this.now = next;
  }

  /** Takes up what belongs to the present state and is no change of the user. */
  amend(next: T): void {
    this.now = next;
  }

  get canUndo(): boolean {
    return this.#past.length > 0;
  }

  get canRedo(): boolean {
    return this.#future.length > 0;
  }

  undo(): void {
    const past = this.#past.pop();
    if (past === undefined) return;
    this.#future.push(this.now);
    this.now = past;
  }

  redo(): void {
    const future = this.#future.pop();
    if (future === undefined) return;
    this.#past.push(this.now);
    this.now = future;
  }
}
