// The frame of the page: views, records and models, work under way.

import { Component, type ComponentChildren, type JSX } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";
import { save, unpack } from "./archive.ts";
import { ExampleButton } from "./example.tsx";
import type { Lists } from "./lists.ts";
import { message } from "./packet.ts";
import { themeChanged } from "./plot/theme.ts";
import { SharedContext } from "./ui.tsx";
import { BranchesView } from "./views/branches.tsx";
import { CampaignView } from "./views/campaign.tsx";
import { CompensateView } from "./views/compensate.tsx";
import { ControlView } from "./views/control.tsx";
import { ExperimentView } from "./views/experiment.tsx";
import { ExportView } from "./views/export.tsx";
import { StudyView } from "./views/study.tsx";
import { WorkbenchView } from "./views/workbench.tsx";
import { READING } from "./work.ts";
import type { Workspace } from "./workspace.ts";

/** The views in the order of the work; some need instruments, which only `piezoid serve` reaches. */
const VIEWS: { name: string; title: string; show(): JSX.Element; served?: true; panes?: true }[] = [
  { name: "workbench", title: "Workbench", show: () => <WorkbenchView />, panes: true },
  { name: "experiment", title: "Experiment", show: () => <ExperimentView /> },
  { name: "campaign", title: "Campaign", show: () => <CampaignView />, served: true },
  { name: "branches", title: "Branches", show: () => <BranchesView /> },
  { name: "compensate", title: "Compensate", show: () => <CompensateView />, panes: true },
  { name: "control", title: "Control", show: () => <ControlView /> },
  { name: "export", title: "Export", show: () => <ExportView /> },
  { name: "study", title: "Study", show: () => <StudyView /> },
];

const viewsOf = (served: boolean) => VIEWS.filter((view) => served || !view.served);
/** The view of the address. Views of earlier versions that are parts of the workbench now lead there. */
const viewNow = (served: boolean) => viewsOf(served).find((view) => `#${view.name}` === location.hash) ?? VIEWS[0]!;

export function App({ workspace, served }: { workspace: Workspace; served: boolean }) {
  const [, setTick] = useState(0);
  const [view, setView] = useState(() => viewNow(served));
  const [lists, setLists] = useState<Lists>();
  const main = useRef<HTMLElement>(null);
  useEffect(() => workspace.subscribe(() => setTick((tick) => tick + 1)), []);
  useEffect(() => {
    const fail = (error: unknown) => workspace.failed(error, true);
    workspace.open().catch(fail);
    workspace.library.lists().then(setLists, fail);
    // What nearly everyone needs is loaded after the first paint.
    setTimeout(() => void workspace.library.load?.("inspect", "identify").catch(fail), 100);
    const turn = () => {
      setView(viewNow(served));
      main.current?.focus();
      scrollTo(0, 0);
    };
    addEventListener("hashchange", turn);
    // The address may have changed before this listened.
    setView(viewNow(served));
    return () => removeEventListener("hashchange", turn);
  }, []);
  useEffect(() => void (document.title = `${view.title} \u2013 piezoid`), [view]);
  useKeys(workspace);
  return (
    <div class="app" onDragOver={(event) => event.preventDefault()} onDrop={(event) => dropped(event, workspace)}>
      <a class="skip" href={`#${view.name}`} onClick={() => main.current?.focus()}>Skip to the view</a>
      <Header workspace={workspace} served={served} />
      <nav aria-label="Views">
        {viewsOf(served).map(({ name, title }) => (
          <a key={name} href={`#${name}`} aria-current={name === view.name ? "page" : undefined}>{title}</a>
        ))}
      </nav>
      <main ref={main} tabIndex={-1} aria-label={view.title}>
        {workspace.unreadable && (
          <div class="fault" role="alert">
            {workspace.unreadable}. The file is not changed. Your changes are not stored until you begin another project.
            <button type="button" onClick={() => workspace.begin()}>Begin another project, {workspace.beside}</button>
          </div>
        )}
        {workspace.fault && (
          <div class="fault" role="alert">
            {workspace.fault}
            {workspace.conflict && (
              <>
                <button type="button" onClick={() => location.reload()}>Load the other version; discard the last change here</button>
                <button type="button" onClick={() => void workspace.overwrite().catch((error) => workspace.failed(error, true))}>Overwrite it with this version</button>
              </>
            )}
            <button type="button" onClick={() => { workspace.fault = ""; workspace.changed(); }}>Close</button>
          </div>
        )}
        {lists ? (
          <SharedContext.Provider value={{ workspace, lists }}>
            <div key={view.name} class={`view ${view.panes ? "panes" : ""}`}>
              <h1 class={view.panes ? "unseen" : ""}>{view.title}</h1>
              <Guard>{view.show()}</Guard>
            </div>
          </SharedContext.Provider>
        ) : <p class="missing">Loading the lists of the library.</p>}
      </main>
      <Jobs workspace={workspace} shown={view.name === "workbench" ? ["identify", READING] : view.served ? [view.name] : []} />
    </div>
  );
}

function Header({ workspace, served }: { workspace: Workspace; served: boolean }) {
  const opened = useRef<HTMLInputElement>(null);
  const start = (work: () => Promise<void>) => void work().catch((error) => workspace.failed(error));
  return (
    <header>
      <p class="brand"><b>piezoid</b> <span>{served ? "on this computer" : "in this browser; nothing is uploaded"}</span></p>
      <div class="actions" role="toolbar" aria-label="Project">
        <button type="button" onClick={() => workspace.undo()} disabled={!workspace.canUndo} title="Undo (Ctrl+Z)">Undo</button>
        <button type="button" onClick={() => workspace.redo()} disabled={!workspace.canRedo} title="Redo (Ctrl+Y)">Redo</button>
        <ExampleButton workspace={workspace} title="Example" />
        <button type="button" onClick={() => opened.current?.click()}>Open</button>
        <input
          ref={opened}
          type="file"
          accept=".zip"
          hidden
          aria-label="Project to open"
          onChange={(event) => {
            const [file] = event.currentTarget.files ?? [];
            event.currentTarget.value = "";
            if (file) start(() => taken([file], workspace, true));
          }}
        />
        <button type="button" onClick={() => start(() => save(workspace))}>Save</button>
        <button type="button" onClick={changeTheme} title="Dark or light">Theme</button>
      </div>
    </header>
  );
}

/** Work under way, except what the view shows itself. */
function Jobs({ workspace, shown }: { workspace: Workspace; shown: string[] }) {
  return (
    <div class="jobs" role="status" aria-live="polite">
      {workspace.jobs.filter(({ name }) => !shown.includes(name)).map((job, k) => (
        <div key={k} class="job">
          <span>{job.name}<span aria-hidden="true">{job.what && `: ${job.what}`}</span></span>
          <progress aria-label={job.name} max={job.total || 1} value={job.done > 0 ? job.done : undefined} />
          {job.cancel && <button type="button" onClick={job.cancel}>Cancel</button>}
        </div>
      ))}
    </div>
  );
}

/** Files dropped anywhere: a project, models, or records. */
async function dropped(event: DragEvent, workspace: Workspace): Promise<void> {
  event.preventDefault();
  const files = [...(event.dataTransfer?.files ?? [])];
  await taken(files, workspace);
}

/** Takes files into the project, by what they are. */
export const taken = (files: File[], workspace: Workspace, asProject = false): Promise<void> =>
  workspace.reading(files.map(({ name }) => name), async (jobs) => {
    workspace.fault = "";
    const records: Parameters<Workspace["addRecords"]>[0] = [];
    const whys: string[] = [];
    for (const [k, file] of files.entries()) {
      try {
        const bytes = await content(file, (done) => workspace.advanced(jobs[k]!, done, file.size));
        if (asProject || file.name.endsWith(".zip") && String.fromCharCode(...bytes.subarray(0, 2)) === "PK") await unpack(workspace, bytes);
        else if (file.name.endsWith(".json")) await takeModel(file.name, bytes, workspace);
        else records.push({ file: { name: file.name, bytes }, use: "training" });
      } catch (error) {
        whys.push(`${file.name}: ${message(error)}`);
      }
    }
    await workspace.addRecords(records, { look: true, asRig: true });
    // A change of the project takes the fault of the work before away.
    if (whys.length > 0) workspace.failed([...whys, workspace.fault].filter(Boolean).join("; "));
  });

/** The content of a file; `advanced` gets how much of it is read. */
async function content(file: File, advanced: (done: number) => void): Promise<Uint8Array> {
  const bytes = new Uint8Array(file.size);
  const reader = file.stream().getReader();
  let at = 0;
  for (let { done, value } = await reader.read(); !done; { done, value } = await reader.read()) {
    bytes.set(value!, at);
    at += value!.length;
    advanced(at);
  }
  return bytes;
}

async function takeModel(name: string, bytes: Uint8Array, workspace: Workspace): Promise<void> {
  const model = JSON.parse(new TextDecoder().decode(bytes));
  const operator = model?.hysteresis?.operator;
  if (model?.piezoid === undefined || !operator) throw new Error("this is not a model of piezoid");
  await workspace.addModel({ name, bytes }, { summary: `${operator}, from ${name}`, verdict: "", notes: [] });
}

const THEMES = ["auto", "dark", "light"];

/** Automatic, dark, light. */
function changeTheme(): void {
  const root = document.documentElement;
  const next = THEMES[(THEMES.indexOf(root.dataset["theme"] ?? "auto") + 1) % THEMES.length]!;
  root.dataset["theme"] = next;
  localStorage.setItem("theme", next);
  themeChanged();
}

function useKeys(workspace: Workspace): void {
  useEffect(() => {
    const key = (event: KeyboardEvent) => {
      const writes = event.target instanceof HTMLInputElement && event.target.type !== "checkbox";
      if (writes || !(event.ctrlKey || event.metaKey)) return;
      const which = event.key.toLowerCase();
      if (which === "y" || (which === "z" && event.shiftKey)) workspace.redo();
      else if (which === "z") workspace.undo();
      else return;
      event.preventDefault();
    };
    addEventListener("keydown", key);
    return () => removeEventListener("keydown", key);
  }, []);
}

/** A fault of a view is shown in its place; the other views go on. */
class Guard extends Component<{ children: ComponentChildren }, { fault?: string }> {
  override state: { fault?: string } = {};

  override componentDidCatch(error: unknown): void {
    this.setState({ fault: message(error) });
  }

  render() {
    const { fault } = this.state;
    return fault ? <p class="fault" role="alert">This view failed: {fault}. Nothing is lost; reload the page.</p> : this.props.children;
  }
}
