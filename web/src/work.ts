// The work that is requested of the library: what is under way, and answers that are kept.

import type { Library } from "./library.ts";
import type { Stage } from "./module.ts";
import { type Answer, Cancelled, type File, type Request } from "./packet.ts";
import { type Mark, marked } from "./remaining.ts";

/** Work of the library under way. */
export interface Job {
  /** What the user started. */
  name: string;
  /** The present step. */
  what: string;
  done: number;
  total: number;
  /** When how many steps were done. */
  marks: Mark[];
  cancel?(): void;
}

/** The name of the job that a file is read by; the file is its step. */
export const READING = "reading";

/** Time between two signs of how much of a file is read [ms]. */
const OFTEN = 100;

/** What is requested of the library, and how it is shown. */
export interface Task {
  /** What the user started, such as "identify". */
  name: string;
  request: Request;
  files: File[];
  /** Called after each step, with the figures that are numbers. */
  onStage?(stage: Stage & { figures: Record<string, number> }): void;
  /** Short work is not shown among the jobs. */
  quiet?: boolean;
  /** It does not wait for long work. */
  beside?: boolean;
}

/** Number of answers that are kept. */
const KEPT = 24;

export class Work {
  jobs: Job[] = [];
  #answers = new Map<string, Promise<Answer>>();
  #drawn = -Infinity;
  #listeners = new Set<() => void>();

  constructor(readonly library: Library) {}

  /** Calls after each change; the result ends that. */
  subscribe(listener: () => void): () => void {
    this.#listeners.add(listener);
    return () => this.#listeners.delete(listener);
  }

  changed(): void {
    this.#listeners.forEach((listener) => listener());
  }

  /** Shows that files are read, until all are taken in. */
  async reading<T>(names: string[], work: (jobs: Job[]) => Promise<T>): Promise<T> {
    const jobs = names.map((what): Job => ({ name: READING, what, done: 0, total: 0, marks: [] }));
    this.jobs = [...this.jobs, ...jobs];
    this.changed();
    try {
      return await work(jobs);
    } finally {
      this.jobs = this.jobs.filter((other) => !jobs.includes(other));
      this.changed();
    }
  }

  /** Says how much of a file is read. */
  advanced(job: Job, done: number, total: number): void {
    Object.assign(job, { done, total });
    if (done < total && performance.now() - this.#drawn < OFTEN) return;
    this.#drawn = performance.now();
    this.changed();
  }

  /** The answer to a task, with its progress among the jobs. */
  async run({ name, request, files, onStage, quiet, beside }: Task): Promise<Answer> {
    const stop = new AbortController();
    const job: Job = { name, what: "", done: 0, total: 0, marks: [], cancel: () => stop.abort() };
    if (!quiet) this.jobs = [...this.jobs, job];
    this.changed();
    try {
      const progress = (stage: Stage) => {
        const { what, done, total } = stage;
        Object.assign(job, { what, done, total, marks: marked(job.marks, { at: performance.now() / 1e3, done, total }) });
        const known = Object.fromEntries(Object.entries(stage.figures).filter(([, value]) => value !== null));
        onStage?.({ ...stage, figures: known as Record<string, number> });
        if (!quiet) this.changed();
      };
      return await this.library.call(request, files, progress, stop.signal, beside);
    } finally {
      this.jobs = this.jobs.filter((other) => other !== job);
      this.changed();
    }
  }

  /** The answer to a short task, kept for the next time that the same is requested. `key` distinguishes tasks. */
  answer(key: string, task: () => Promise<Task> | Task): Promise<Answer> {
    const known = this.#answers.get(key);
    if (known) {
      this.#answers.delete(key);
      this.#answers.set(key, known);
      return known;
    }
    const requested = Promise.resolve(task()).then((ready) => this.run({ quiet: true, ...ready }));
    this.#answers.set(key, requested);
    requested.catch((error) => error instanceof Cancelled && this.#answers.delete(key));
    const oldest = this.#answers.keys().next().value;
    if (this.#answers.size > KEPT && oldest !== undefined) this.#answers.delete(oldest);
    return requested;
  }
}
