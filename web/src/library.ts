// The library as the page sees it: requests in, answers out, wherever they are computed.

import type { Progress } from "./module.ts";
import { type Answer, type File, packed, Refused, type Request, unpacked } from "./packet.ts";
import { Thread } from "./thread.ts";

export { Cancelled, Refused } from "./packet.ts";

/** Answers requests. */
export interface Library {
  /** True if every call reads files of all formats; otherwise only `inspect` and `prepare` do, and others read text. */
  readonly readsAll: boolean;
  /** The lists for menus and forms. */
  lists(): Promise<any>;
  /** Loads what these verbs need, where something is loaded. */
  load?(...calls: string[]): Promise<void>;
  /**
   * The answer to a request with these files. A signal ends the work: the call is then refused with `Cancelled`. A call
   * `beside` others does not wait for them.
   */
  call(request: Request, files: File[], progress?: Progress, signal?: AbortSignal, beside?: boolean): Promise<Answer>;
}

/**
 * The library in workers of this browser, one for each module: calls of one module wait for each other, unless they are
 * beside others.
 */
export class LocalLibrary implements Library {
  readonly readsAll = false;
  #base: URL;
  #spawn: () => Worker;
  #lists: Promise<any> | undefined;
  #threads = new Map<string, Thread>();

  /** The folder with the modules, the lists and the worker, which ends with a slash. */
  constructor(base: URL, spawn = () => new Worker(new URL("worker.js", base))) {
    this.#base = base;
    this.#spawn = spawn;
  }

  lists(): Promise<any> {
    this.#lists ??= fetched(new URL("lists.json", this.#base))
      .then((response) => response.json())
      .catch((error) => {
        // The next call loads again.
        this.#lists = undefined;
        throw error;
      });
    return this.#lists;
  }

  async call(
    request: Request,
    files: File[],
    progress: Progress = () => {},
    signal?: AbortSignal,
    beside = false,
  ): Promise<Answer> {
    const thread = await this.#thread(request.call, beside);
    return unpacked(await thread.answer(packed(request, files), progress, signal));
  }

  /** Loads the modules of these verbs before they are called. */
  async load(...calls: string[]): Promise<void> {
    for (const call of calls) await (await this.#thread(call)).load();
  }

  async #thread(verb: string, beside = false): Promise<Thread> {
    const { operations } = await this.lists();
    const name = operations.find((operation: { name: string }) => operation.name === verb)?.module;
    if (name === undefined) throw new Refused(`there is no call called \`${verb}\``);
    const key = beside ? `${name} beside` : name;
    let thread = this.#threads.get(key);
    if (!thread) {
      thread = new Thread(() => compiled(new URL(`${name}.wasm`, this.#base)), this.#spawn);
      this.#threads.set(key, thread);
    }
    return thread;
  }
}

async function fetched(url: URL): Promise<Response> {
  const response = await fetch(url);
  if (!response.ok) throw new Error(`${url.pathname} cannot be loaded: ${response.status} ${response.statusText}`);
  return response;
}

/** The module there. It is compiled while it loads if the server states its type, as browsers demand. */
async function compiled(url: URL): Promise<WebAssembly.Module> {
  const response = await fetched(url);
  const isWasm = response.headers.get("content-type") === "application/wasm";
  return isWasm ? WebAssembly.compileStreaming(response) : WebAssembly.compile(await response.arrayBuffer());
}
