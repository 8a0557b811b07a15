// The library in a thread of its own, so that the page goes on answering.

import { Module } from "./module.ts";

/** What the page sends: first the module, then requests. */
export type Sent = { module: WebAssembly.Module } | { id: number; request: Uint8Array };

/** What the page gets. */
export type Got =
  | { lists: unknown }
  | { id: number; answer: Uint8Array }
  | { id: number; failed: string }
  | { id: number; what: string; done: number; total: number };

/** The part of a worker's scope that is used; the types of pages and workers exclude each other. */
interface Scope {
  onmessage: ((event: MessageEvent<Sent>) => void) | null;
  postMessage(message: Got, transfer?: Transferable[]): void;
}

const scope = self as unknown as Scope;
let library: Module | undefined;

scope.onmessage = ({ data }: MessageEvent<Sent>) => {
  if ("module" in data) {
    library = Module.of(data.module);
    scope.postMessage({ lists: library.lists() });
    return;
  }
  const { id, request } = data;
  const tell = (what: string, done: number, total: number) =>
    scope.postMessage({ id, what, done, total });
  try {
    if (!library) throw new Error("the library is not loaded yet");
    const answer = library.answer(request, tell);
    scope.postMessage({ id, answer }, [answer.buffer]);
  } catch (error) {
    scope.postMessage({ id, failed: error instanceof Error ? error.message : String(error) });
  }
};
