// Starts the page: the library, the store, the project, the views.

import { render } from "preact";
import { App } from "./app.tsx";
import { keepFocus } from "./focus.ts";
import { LocalLibrary } from "./library.ts";
import { ServerLibrary, ServerStore } from "./server.ts";
import { BrowserStore } from "./store.ts";
import { Workspace } from "./workspace.ts";

/** Time within which a page that is left gives its lock back [ms]. */
const FREED = 1500;

const served = document.documentElement.dataset["library"] === "server";
const library = served ? new ServerLibrary() : new LocalLibrary(new URL("./", document.baseURI));
const store = served ? new ServerStore() : new BrowserStore();
const workspace = new Workspace(library, store);

try {
  // The theme that was chosen by hand.
  const theme = localStorage.getItem("theme");
  if (theme) document.documentElement.dataset["theme"] = theme;
} catch {
  // This browser keeps nothing; the store says so.
}

const page = document.getElementById("page")!;
page.replaceChildren();
keepFocus(page);
render(<App workspace={workspace} served={served} />, page);
addEventListener("pagehide", () => void workspace.flush());

// A server refuses to overwrite what has changed; a browser does not.
if (!served) {
  const held = () => new Promise<never>(() => {});
  navigator.locks?.request("piezoid", { signal: AbortSignal.timeout(FREED) }, held).catch((error: DOMException) => {
    if (error.name !== "TimeoutError") return;
    workspace.failed(new Error("this project is open in another tab as well: close one, because each overwrites the changes of the other"), true);
    // For the next tab.
    void navigator.locks.request("piezoid", held);
  });
}
