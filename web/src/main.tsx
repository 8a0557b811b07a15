// Starts the page: the library, the store, the project, the views.

import { render } from "preact";
import { App } from "./app.tsx";
import { LocalLibrary } from "./library.ts";
import { BrowserStore } from "./store.ts";
import { Workspace } from "./workspace.ts";

const served = document.documentElement.dataset["library"] === "server";
const { ServerLibrary, ServerStore } = served ? await import("./server.ts") : ({} as typeof import("./server.ts"));
const library = served ? new ServerLibrary() : local();
const store = served ? new ServerStore() : new BrowserStore();
const workspace = new Workspace(library, store);

const page = document.getElementById("page")!;
page.replaceChildren();
render(<App workspace={workspace} served={served} />, page);
addEventListener("pagehide", () => void workspace.flush());

function local(): any {
  const module = fetch("piezoid.wasm").then(async (r) => WebAssembly.compile(await r.arrayBuffer()));
  const inner = new LocalLibrary(module, () => new Worker("worker.js", { type: "module" }));
  return {
    lists: () => inner.lists(),
    call: (request: any, files: any, progress: any, signal?: AbortSignal) => {
      signal?.addEventListener("abort", () => inner.cancel());
      return inner.call(request, files, progress);
    },
  };
}
