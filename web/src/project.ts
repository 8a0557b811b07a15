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
  /** Why the library proposes this use; missing once it was chosen by hand. */
  because?: string;
}

/** How the files of one rig are read: those that look alike. */
export interface Rig {
  /** Name of its profile, without the ending. */
  name: string;
  /** What its files have in common, as the library says. */
  layout: string;
  /** Which columns, units and scales. */
  columns: Options;
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
  /** The largest error there [% of peak-to-peak]. */
  error?: number;
  /** The stand-in for its actuator. */
  standIn?: StandIn;
}

/** A second model of the records of a model, to play voltages on. */
export interface StandIn {
  /** Name of its file in the store. */
  file: string;
  /** What it consists of. */
  sentence: string;
}

/** Everything that is saved, besides the files themselves. */
export interface Project {
  records: RecordEntry[];
  models: ModelEntry[];
  /** At most one of a layout. */
  rigs: Rig[];
  /** File of the record that is looked at. */
  record?: string;
  /** File of the model that is used. */
  model?: string;
  /** The forms of the views, by view. */
  settings: Record<string, Options>;
}

export const EMPTY: Project = { records: [], models: [], rigs: [], settings: {} };

/** Name of the project itself among its files. */
export const PROJECT = "project.json";

/** True for names of projects: the first, and those that were begun beside one that cannot be read. */
export const isProject = (name: string): boolean => /^project(-\d+)?\.json$/i.test(name);

/** The project in the text that `written` wrote. What is missing is empty; the error names what is of another kind. */
export function read(text: string): Project {
  const whole = parsed(text);
  if (!isObject(whole) || whole["piezoid"] !== 1) throw new Error("this is no project of this version of piezoid: it is of a newer one, or of another program");
  const { piezoid, ...others } = whole;
  const settings = object(whole["settings"], "settings");
  for (const [view, values] of Object.entries(settings)) object(values, `settings.${view}`);
  for (const name of ["record", "model"]) textOf(whole[name], name);
  return {
    ...others,
    records: list(whole["records"], "records", readRecord),
    models: list(whole["models"], "models", readModel),
    rigs: list(whole["rigs"], "rigs", readRig),
    settings: settings as Project["settings"],
  };
}

function parsed(text: string): unknown {
  try {
    return JSON.parse(text);
  } catch (error) {
    throw new Error(`this is not a project of piezoid, or it is damaged (${(error as Error).message})`);
  }
}

const isObject = (value: unknown): value is Options => typeof value === "object" && value !== null && !Array.isArray(value);

function wrong(value: unknown, at: string, expected: string): never {
  const shown = JSON.stringify(value) ?? "missing";
  throw new Error(`this project is damaged: ${at} is ${shown.length > 40 ? `${shown.slice(0, 40)}...` : shown}, but must be ${expected}`);
}

const object = (value: unknown, at: string): Options =>
  value === undefined ? {} : isObject(value) ? value : wrong(value, at, "an object");

const textOf = (value: unknown, at: string): string =>
  value === undefined ? "" : typeof value === "string" ? value : wrong(value, at, "a text");

function list<T>(value: unknown, at: string, each: (value: Options, at: string) => T): T[] {
  if (value === undefined) return [];
  if (!Array.isArray(value)) wrong(value, at, "a list");
  return value.map((one, k) => each(isObject(one) ? one : wrong(one, `${at}[${k}]`, "an object"), `${at}[${k}]`));
}

const named = ({ file }: Options, at: string): string =>
  typeof file === "string" && file !== "" ? file : wrong(file, `${at}.file`, "the name of a file");

function readRecord(entry: Options, at: string): RecordEntry {
  const uses: unknown[] = ["training", "small-signal", "validation", "none"] satisfies Use[];
  const { columns, prepare, use, because } = entry;
  textOf(because, `${at}.because`);
  if (!uses.includes(use)) wrong(use, `${at}.use`, `one of ${uses.join(", ")}`);
  return { ...entry, file: named(entry, at), columns: object(columns, `${at}.columns`), prepare: object(prepare, `${at}.prepare`), use: use as Use };
}

function readRig(entry: Options, at: string): Rig {
  const { name, layout, columns } = entry;
  if (typeof name !== "string" || fileName(`${name}.toml`) !== `${name}.toml`) wrong(name, `${at}.name`, "a name that a file can have");
  if (typeof layout !== "string" || !isLayout(layout)) wrong(layout, `${at}.layout`, "the layout of a file");
  return { ...entry, name, layout, columns: object(columns, `${at}.columns`) };
}

function isLayout(text: string): boolean {
  try {
    return Array.isArray(JSON.parse(text));
  } catch {
    return false;
  }
}

function readModel(entry: Options, at: string): ModelEntry {
  const { summary, verdict, notes, from, validated, error, standIn } = entry;
  if (notes !== undefined && !(Array.isArray(notes) && notes.every((note) => typeof note === "string"))) {
    wrong(notes, `${at}.notes`, "a list of texts");
  }
  textOf(validated, `${at}.validated`);
  const isError = error === undefined || (typeof error === "number" && error >= 0);
  if (!isError) wrong(error, `${at}.error`, "a number of percent");
  return {
    ...entry,
    file: named(entry, at),
    summary: textOf(summary, `${at}.summary`),
    verdict: textOf(verdict, `${at}.verdict`),
    notes: (notes as string[] | undefined) ?? [],
    ...(from !== undefined && { from: list(from, `${at}.from`, readRecord) }),
    ...(standIn !== undefined && { standIn: readStandIn(object(standIn, `${at}.standIn`), `${at}.standIn`) }),
  };
}

const readStandIn = (one: Options, at: string): StandIn => ({ ...one, file: named(one, at), sentence: textOf(one["sentence"], `${at}.sentence`) });

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

/** The model that is used, if there is one. */
export const usedModel = ({ models, model }: Project): ModelEntry | undefined => models.find(({ file }) => file === model) ?? models.at(-1);

/** The record that is looked at, if there is one. */
export const shownRecord = ({ records, record }: Project): RecordEntry | undefined => records.find(({ file }) => file === record) ?? records.at(-1);

/** The name of a model without its ending. */
export const nameOf = ({ file }: Pick<ModelEntry, "file">): string => file.replace(/\.json$/, "");

/** True if the model was identified from the record; of a model from elsewhere the use of the record decides. */
export const isTraining = ({ from }: ModelEntry, { file, use }: RecordEntry): boolean =>
  from ? from.some((one) => one.file === file) : use === "training" || use === "small-signal";

/** The records that prove a model, and that its report is of: those that are meant for validation, else all that it was
 * not identified from. */
export function proofOf(entry: ModelEntry, records: RecordEntry[]): RecordEntry[] {
  const unseen = records.filter((one) => one.use !== "none" && !isTraining(entry, one));
  const meant = unseen.filter((one) => one.use === "validation");
  return meant.length > 0 ? meant : unseen;
}

/** The records that are read or prepared in another way since the model was identified from them. */
export const changedSince = ({ from = [] }: ModelEntry, { records }: Project): string[] => {
  const how = ({ columns, prepare }: RecordEntry) => JSON.stringify([columns, prepare]);
  const now = (file: string) => records.find((one) => one.file === file);
  return from.filter((one) => now(one.file) && how(now(one.file)!) !== how(one)).map(({ file }) => file);
};

/** The files that a project needs. */
export const filesOf = (project: Project): string[] =>
  [...project.records, ...project.models, ...project.models.flatMap(({ standIn }) => standIn ?? [])].map((entry) => entry.file);

/** Characters that a file system refuses, and those that turn the direction of text. */
const REFUSED = /[\p{Cc}/\\<>:"|?*\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069]/gu;

/** Devices of Windows, with any extension. */
const DEVICE = /^(con|prn|aux|nul|conin\$|conout\$|clock\$|(com|lpt)[0-9\u00b9\u00b2\u00b3]) *(\.|$)/i;

/** The name under which a file can be kept anywhere, beside the project. */
export function fileName(name: string): string {
  const plain = name.replace(REFUSED, "-").replace(/^[. ]+|[. ]+$/g, "");
  return plain === "" || DEVICE.test(plain) || isProject(plain) ? `file-${plain}` : plain;
}

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

  /** Takes up in all states what is no change of the user, and is not undone. */
  amend(next: (state: T) => T): void {
    [this.#past, this.#future] = [this.#past.map(next), this.#future.map(next)];
    if (this.#before !== undefined) this.#before = next(this.#before);
    this.now = next(this.now);
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
