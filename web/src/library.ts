// The library as the page sees it: requests in, answers out, wherever they are computed.

import { type Answer, Cancelled, type File, packed, Refused, type Request, unpacked } from "./packet.ts";
import type { Progress } from "./module.ts";
import type { Got, Sent } from "./worker.ts";

/** Answers requests, one after the other. */
export interface Library {
  /** The lists for menus and forms. */
  lists(): Promise<any>;
  /** The answer to a request with these files. */
  call(request: Request, files: File[], progress?: Progress): Promise<Answer>;
  /** Ends all work; calls that have no answer yet are refused with `Cancelled`. */
  cancel(): void;
}

interface Waiting {
  request: Uint8Array;
  progress: Progress;
  resolve(answer: Answer): void;
  reject(error: Error): void;
}

/** The library in a worker of this browser. A worker that is ended is replaced from the compiled module. */
export class LocalLibrary implements Library {
  #module: Promise<WebAssembly.Module>;
  #spawn: () => Worker;
  #worker: Worker | undefined;
  #lists: Promise<any> | undefined;
  #waiting = new Map<number, Waiting>();
  #last = 0;

  constructor(module: Promise<WebAssembly.Module>, spawn: () => Worker) {
    this.#module = module;
    this.#spawn = spawn;
  }

  lists(): Promise<any> {
    this.#lists ??= this.#begin();
    return this.#lists;
  }

  async call(request: Request, files: File[], progress: Progress = () => {}): Promise<Answer> {
    const id = ++this.#last;
    const answer = new Promise<Answer>((resolve, reject) => {
      this.#waiting.set(id, { request: packed(request, files), progress, resolve, reject });
    });
    // The call may be cancelled while the worker begins.
    void this.lists().then(() => this.#send(id), (error) => this.#settle(id)?.reject(error));
    return answer;
  }

  cancel(): void {
    this.#worker?.terminate();
    this.#worker = this.#lists = undefined;
    for (const id of [...this.#waiting.keys()]) this.#settle(id)?.reject(new Cancelled("cancelled"));
  }

  #send(id: number): void {
    const waiting = this.#waiting.get(id);
    if (waiting) this.#worker?.postMessage({ id, request: waiting.request } satisfies Sent, [waiting.request.buffer]);
  }

  #settle(id: number): Waiting | undefined {
    const waiting = this.#waiting.get(id);
    this.#waiting.delete(id);
    return waiting;
  }

  async #begin(): Promise<any> {
    const module = await this.#module;
    const worker = (this.#worker = this.#spawn());
    return new Promise((resolve, reject) => {
      worker.onerror = (event) => reject(new Error(event.message));
      worker.onmessage = ({ data }: MessageEvent<Got>) => {
        if ("lists" in data) resolve(data.lists);
        else if ("answer" in data) this.#answered(data.id, data.answer);
        else if ("failed" in data) this.#settle(data.id)?.reject(new Refused(data.failed));
        else this.#waiting.get(data.id)?.progress(data.what, data.done, data.total);
      };
      worker.postMessage({ module } satisfies Sent);
    });
  }

  #answered(id: number, answer: Uint8Array): void {
    const waiting = this.#settle(id);
    try {
      waiting?.resolve(unpacked(answer));
    } catch (error) {
      waiting?.reject(error as Error);
    }
  }
}
