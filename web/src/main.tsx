// Starts the page: the library, the store, the project, the views.

import { render } from "preact";
import { App } from "./app.tsx";
import { LocalLibrary } from "./library.ts";
import { ServerLibrary, ServerStore } from "./server.ts";
import { BrowserStore } from "./store.ts";
import { Workspace } from "./workspace.ts";

const served = document.documentElement.dataset["library"] === "server";
const library = served ? new ServerLibrary() : new LocalLibrary(new URL("./", document.baseURI));
const store = served ? new ServerStore() : new BrowserStore();
const workspace = new Workspace(library, store);

// The theme that was chosen by hand.
const theme = localStorage.getItem("theme");
if (theme) document.documentElement.dataset["theme"] = theme;

const page = document.getElementById("page")!;
page.replaceChildren();
render(<App workspace={workspace} served={served} />, page);
addEventListener("pagehide", () => void workspace.flush());
