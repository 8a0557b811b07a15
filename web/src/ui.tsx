// Parts that all views are made of.

import { createContext, type ComponentChildren, isValidElement } from "preact";
import { useContext, useEffect, useId, useRef, useState } from "preact/hooks";
import { zipped } from "./archive.ts";
import type { Lists } from "./lists.ts";
import { Cancelled, type File, message, Refused } from "./packet.ts";
import { download } from "./plot/download.ts";
import { prose, short } from "./plot/ticks.ts";
import { type Options, withSettings } from "./project.ts";
import { worded } from "./words.ts";
import type { Workspace } from "./workspace.ts";

export { Chart, Overview } from "./chart.tsx";

/** What every view can reach. */
export interface Shared {
  workspace: Workspace;
  lists: Lists;
}

export const SharedContext = createContext<Shared | undefined>(undefined);

/** The shared parts; the view is drawn anew after each change of the project. */
export function useShared(): Shared {
  const shared = useContext(SharedContext);
  if (!shared) throw new Error("a view outside the page");
  return shared;
}

/** What became of asynchronous work. */
export interface Outcome<T> {
  value?: T;
  error?: string;
  /** The options that resolve the error. */
  advice?: Record<string, unknown>;
  busy: boolean;
}

/** The outcome of work that is done anew when its key changes; the last value stays until the next one is there. */
export function useOutcome<T>(key: string | undefined, work: () => Promise<T>): Outcome<T> {
  const [outcome, setOutcome] = useState<Outcome<T>>({ busy: false });
  useEffect(() => {
    if (key === undefined) return setOutcome({ busy: false });
    let current = true;
    setOutcome((before) => ({ ...(before.value !== undefined && { value: before.value }), busy: true }));
    work().then(
      (value) => current && setOutcome({ value, busy: false }),
      (error) => current && setOutcome({ error: message(error), busy: false }),
    );
    return () => void (current = false);
  }, [key]);
  return outcome;
}

/** As `useOutcome`, for what follows a hand: of keys that come while work is under way only the last is worked on. The
 * last value stays beside an error. */
export function useLatest<T>(key: string | undefined, work: () => Promise<T>): Outcome<T> {
  const [outcome, setOutcome] = useState<Outcome<T>>({ busy: false });
  const state = useRef({ busy: false, alive: true, next: undefined as (() => Promise<T>) | undefined });
  useEffect(() => () => void (state.current.alive = false), []);
  useEffect(() => {
    const now = state.current;
    now.next = work;
    const go = async () => {
      while (now.next && now.alive) {
        const task = now.next;
        now.next = undefined;
        const result = await task().then((value) => ({ value }), failure);
        if (now.alive) setOutcome((before) => ({ ...(before.value !== undefined && { value: before.value }), ...result, busy: now.next !== undefined }));
      }
      now.busy = false;
    };
    if (key === undefined) {
      now.next = undefined;
      setOutcome({ busy: false });
    } else if (!now.busy) {
      now.busy = true;
      void go();
    }
  }, [key]);
  return outcome;
}

const failure = (error: unknown) => ({ error: message(error), ...(error instanceof Refused && { advice: error.advice }) });

/** A field of text, and what is said of it to the browser. */
interface EntryProps {
  value: string;
  entered(text: string): void;
  id?: string;
  name?: string;
  "aria-describedby"?: string;
  placeholder?: string;
  required?: boolean;
  size?: number;
  inputMode?: "decimal" | "text";
  list?: string | undefined;
}

/** A field of text. What is being written stays while the view is drawn anew; `entered` gets it when it is done. */
export function Entry({ value, entered, ...rest }: EntryProps) {
  const [draft, setDraft] = useState<string>();
  return (
    <input
      {...rest}
      type="text"
      value={draft ?? value}
      autocomplete="off"
      spellcheck={false}
      onInput={(event) => setDraft(event.currentTarget.value)}
      onChange={(event) => {
        setDraft(undefined);
        entered(event.currentTarget.value);
      }}
    />
  );
}

/** A part of a view, with its heading. */
export function Section(props: { title: string; help?: string; children: ComponentChildren; wide?: boolean }) {
  const id = useId();
  return (
    <section class={props.wide ? "wide" : ""} aria-labelledby={id}>
      <h2 id={id}>{props.title}</h2>
      {props.help && <p class="help">{props.help}</p>}
      {props.children}
    </section>
  );
}

/** An error in the words of the library. */
export function Fault({ text }: { text: string | undefined }) {
  const { lists } = useShared();
  return text ? <p class="fault" role="alert">{worded(text, lists)}</p> : null;
}

/** What the records prove of a model, or a model of a voltage. */
export const Verdict = ({ text, of }: { text: string | undefined | null; of?: string }) =>
  text ? <p class={/^(the model is )?good to/.test(text) ? "verdict" : "verdict poor"}>{of && <b>{of}: </b>}{prose(text)}</p> : null;

/** Remarks. */
export function Notes({ title, notes }: { title: string; notes: string[] }) {
  const { lists } = useShared();
  return notes.length === 0 ? null : (
    <div class="notes">
      {title && <h3>{title}</h3>}
      <ul>{notes.map((note) => <li key={note}>{worded(note, lists)}</li>)}</ul>
    </div>
  );
}

/** What to do first where there is nothing to show. */
export const Missing = ({ what, title }: { what: string; title: string }) => (
  <p class="missing">
    {what} <a href="#workbench">{title}</a>
  </p>
);

/** A number in large digits, within a list of the class `readings`. */
export const Fact = ({ value, unit, name }: { value: string; unit: string; name: string }) => (
  <div>
    <dt>{name}</dt>
    <dd>{value} <small>{unit}</small></dd>
  </div>
);

/** A table: heads, then rows of cells. Columns of numbers stand on the right. */
export function Table(props: { caption: string; head: string[]; rows: ComponentChildren[][]; marked?: number }) {
  const numeric = (j: number) => props.rows.length > 0 && props.rows.every((row) => NUMBER.test(textOf(row[j])));
  const of = props.head.map((_, j) => (j > 0 && numeric(j) ? "number" : ""));
  return (
    <div class="table" tabIndex={0} role="region" aria-label={props.caption}>
      <table>
        <caption>{props.caption}</caption>
        <thead>
          <tr>{props.head.map((cell, j) => <th key={j} scope="col" class={of[j]}>{cell}</th>)}</tr>
        </thead>
        <tbody>
          {props.rows.map((row, k) => (
            <tr key={k} class={k === props.marked ? "marked" : ""}>
              {row.map((cell, j) => (j === 0 ? <th key={j} scope="row">{cell}</th> : <td key={j} class={of[j]}>{cell}</td>))}
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

/** The text of a cell, which may be emphasised. */
const textOf = (cell: ComponentChildren): string =>
  isValidElement(cell) ? String((cell.props as { children?: ComponentChildren }).children) : String(cell);

/** What a cell of a column of numbers may hold: a number, with its unit, or a dash. */
const NUMBER = /^[\u2212-]?\d[^ ]*( .{1,4})?$|^\u2013?$/;

/** Number of outcomes that are kept. */
const KEPT = 12;

/** Outcomes that stay when another view is shown, by name; the latest last. */
const kept = new Map<string, Outcome<unknown> & { request?: string }>();

/** Work that a button starts, whose outcome stays. It is `stale` once `request`, what is asked for, has changed; an error
 * is not shown any more then, unless it `lasts`: that of work that moved an instrument says where this was left. */
export function useKept<T>(name: string, request: unknown, lasts = false): Outcome<T> & { stale: boolean; start(work: () => Promise<T>): void } {
  const { workspace } = useShared();
  const requested = JSON.stringify(request);
  const set = (outcome: Outcome<T>) => {
    kept.delete(name);
    kept.set(name, { ...outcome, request: requested });
    const oldest = kept.keys().next().value;
    if (kept.size > KEPT && oldest !== undefined) kept.delete(oldest);
    workspace.changed();
  };
  const start = (work: () => Promise<T>) => {
    const before = kept.get(name);
    set({ busy: true });
    work().then(
      (value) => set({ value, busy: false }),
      (error) => {
        if (error instanceof Cancelled) kept.set(name, before ?? { busy: false });
        else set({ error: message(error), busy: false });
        workspace.changed();
      },
    );
  };
  const { error, ...now } = (kept.get(name) ?? { busy: false }) as Outcome<T> & { request?: string };
  const isOf = now.request === requested;
  return { ...now, ...(error !== undefined && (isOf || lasts) && { error }), stale: now.value !== undefined && !isOf, start };
}

/** Says that a form has changed since its results were made. */
export const Stale = ({ stale }: { stale: boolean }) =>
  stale ? <p class="stale" role="status">The form has changed since these results.</p> : null;

/** The settings of a view, and how they are changed. */
export function useSettings(view: string): [Options, (values: Options) => void] {
  const { workspace } = useShared();
  return [workspace.project.settings[view] ?? {}, (values) => workspace.change((project) => withSettings(project, view, values))];
}

/** One of several, chosen by buttons. */
export const Choice = (props: { label: string; names: string[]; chosen: string | undefined; choose(name: string): void }) => (
  <div class="row" role="group" aria-label={props.label}>
    {props.names.map((name) => (
      <button key={name} type="button" class="choice" aria-pressed={name === props.chosen} onClick={() => props.choose(name)}>{name}</button>
    ))}
  </div>
);

/** A size of a file. */
export const size = (bytes: number): string => (bytes < 1000 ? `${bytes} B` : bytes < 1e6 ? `${short(bytes / 1e3)} kB` : `${short(bytes / 1e6)} MB`);

/** A button that offers files: one as it is, several in an archive. */
export const Download = ({ files, archive, title }: { files: File[]; archive?: string; title?: string }) => (
  <button
    type="button"
    disabled={files.length === 0}
    aria-label={title ?? `Download ${files[0]?.name}`}
    onClick={() => (archive ? download(archive, zipped(files) as BlobPart, "application/zip") : download(files[0]!.name, files[0]!.bytes as BlobPart))}
  >
    {title ?? "Download"}
  </button>
);

/** A text file, which scrolls inside. */
export function TextFile({ file }: { file: File }) {
  const bare = file.bytes.subarray(0, 1000).includes(0);
  return bare
    ? <p class="missing">{file.name} is not a text.</p>
    : <pre tabIndex={0} role="region" aria-label={`Text of ${file.name}`}>{new TextDecoder().decode(file.bytes)}</pre>;
}

/** The document of the model in use. */
export function useModel(): Outcome<any> {
  const { workspace } = useShared();
  const { model } = workspace.project;
  return useOutcome(model, () => workspace.document(model!));
}
