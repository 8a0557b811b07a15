// The library in a thread of its own, so that the page goes on answering.

import { Module, type Stage } from "./module.ts";

/** What the page sends: first the module, then requests, each after the answer to the last. */
export type Sent = { module: WebAssembly.Module } | { request: Uint8Array };

/** What the page gets. */
export type Got = { answer: Uint8Array } | { failed: string } | { stage: Stage };

/** The part of a worker's scope that is used; the types of pages and workers exclude each other. */
interface Scope {
  onmessage: ((event: MessageEvent<Sent>) => void) | null;
  postMessage(message: Got, transfer?: Transferable[]): void;
}

const scope = self as unknown as Scope;
let library: Module | undefined;

scope.onmessage = ({ data }: MessageEvent<Sent>) => {
  const tell = (stage: Stage) => scope.postMessage({ stage });
  try {
    if ("module" in data) {
      library = Module.of(data.module);
      return;
    }
    if (!library) throw new Error("the library is not loaded yet");
    const answer = library.answer(data.request, tell);
    scope.postMessage({ answer }, [answer.buffer]);
  } catch (error) {
    scope.postMessage({ failed: `the library stopped: ${error instanceof Error ? error.message : String(error)}` });
  }
};
