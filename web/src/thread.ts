// A module in a worker of its own, which answers one request after the other.

import type { Progress } from "./module.ts";
import { Cancelled, Refused } from "./packet.ts";
import type { Got, Sent } from "./worker.ts";

interface Job {
  request: Uint8Array;
  progress: Progress;
  resolve(answer: Uint8Array): void;
  reject(error: unknown): void;
}

/** A module with its worker, which begins with the first request. */
export class Thread {
  #load: () => Promise<WebAssembly.Module>;
  #spawn: () => Worker;
  #module: Promise<WebAssembly.Module> | undefined;
  #worker: Worker | undefined;
  /** The worker has the first one; the others wait here, so that they outlive it. */
  #jobs: Job[] = [];

  constructor(load: () => Promise<WebAssembly.Module>, spawn: () => Worker) {
    this.#load = load;
    this.#spawn = spawn;
  }

  /** The packed answer to a packed request, which is taken. A signal ends the work, with `Cancelled`. */
  answer(request: Uint8Array, progress: Progress, signal?: AbortSignal): Promise<Uint8Array> {
    return new Promise((resolve, reject) => {
      const job = { request, progress, resolve, reject };
      const cancel = () => this.#failed(job, new Cancelled("cancelled"));
      this.#jobs.push(job);
      if (this.#jobs.length === 1) void this.#begin(job);
      if (signal?.aborted) cancel();
      signal?.addEventListener("abort", cancel, { once: true });
    });
  }

  /** Loads the module, and begins the worker, before the first request. */
  async load(): Promise<void> {
    try {
      const module = await (this.#module ??= this.#load());
      this.#worker ??= this.#started(module);
    } catch (error) {
      // The next call loads again.
      this.#module = undefined;
      throw error;
    }
  }

  async #begin(job: Job): Promise<void> {
    try {
      await this.load();
      if (this.#jobs[0] !== job) return;
      this.#worker!.postMessage({ request: job.request } satisfies Sent, [job.request.buffer]);
    } catch (error) {
      this.#failed(job, error);
    }
  }

  #started(module: WebAssembly.Module): Worker {
    const worker = this.#spawn();
    /** The job at work, unless this worker has been ended. */
    const job = () => (worker === this.#worker ? this.#jobs[0] : undefined);
    const failed = (why: string) => {
      const ended = job();
      if (ended) this.#failed(ended, new Refused(why));
    };
    worker.onerror = (event) => failed(event.message);
    worker.onmessage = ({ data }: MessageEvent<Got>) => {
      if ("stage" in data) job()?.progress(data.stage);
      else if ("failed" in data) failed(data.failed);
      else if (job()) {
        const { resolve } = this.#jobs.shift()!;
        this.#next();
        resolve(data.answer);
      }
    };
    worker.postMessage({ module } satisfies Sent);
    return worker;
  }

  /** Takes a job away. If it was at work, its worker ends: nobody knows what its memory holds. */
  #failed(job: Job, error: unknown): void {
    const at = this.#jobs.indexOf(job);
    if (at < 0) return;
    this.#jobs.splice(at, 1);
    if (at === 0) {
      this.#worker?.terminate();
      this.#worker = undefined;
      this.#next();
    }
    job.reject(error);
  }

  #next(): void {
    if (this.#jobs[0]) void this.#begin(this.#jobs[0]);
  }
}
