// The identification that is under way, or that was the last: it goes on while another view is shown.

import type { Stage } from "../module.ts";
import { Cancelled, message } from "../packet.ts";
import type { RecordEntry } from "../project.ts";
import type { Workspace } from "../workspace.ts";

/** What is known of an operator: while it is fitted its held-out error, in the end all. */
export interface Trial {
  operator: string;
  parameters?: number;
  held_out_percent?: number | null;
  free_run_percent?: number | null;
  /** The larger of the two, by which operators are ranked. */
  error_percent?: number | null;
  verdict?: string;
}

/** The file of the model of a fit. */
export interface Fit {
  operator: string;
  text: string;
  /** Tells it from all others. */
  key: string;
}

/** An identification. */
export interface Search {
  isRunning: boolean;
  error?: string;
  trials: Trial[];
  /** The last fit of each operator that is finished. */
  fits: Map<string, Fit>;
  /** The best fit so far. */
  best?: Fit;
  /** Held-out errors or costs in the order of the fits. */
  errors: number[];
  costs: number[];
  /** Operators that are drawn beside the best. */
  drawn: string[];
  /** The records and options that it is of: an error is of no interest after they have changed. */
  of: string;
  /** The name of the model that came of it. */
  result?: string;
}

/** The error of an operator; while it is fitted, the held-out error alone is known. */
export const errorOf = (trial: Trial): number => trial.error_percent ?? trial.held_out_percent ?? Infinity;

/** The records of an identification. */
export const identifiedFrom = (records: RecordEntry[]) => {
  const small = records.filter((entry) => entry.use === "small-signal");
  const large = records.filter((entry) => entry.use === "training");
  return { small, large, all: [...small, ...large] };
};

/** What an identification depends on: its records, as they are read and prepared, and its options. */
export const requestOf = ({ project }: Workspace): string =>
  JSON.stringify([identifiedFrom(project.records), project.settings["identify"]]);

/** The browser asks before it leaves the page: the search would be lost. */
const leaves = (event: Event) => event.preventDefault();

/** Identifies a model and adds it to the project. Cancelled, the best model until then is added. */
export async function identify(workspace: Workspace): Promise<void> {
  const search: Search = { of: requestOf(workspace), isRunning: true, trials: [], fits: new Map(), errors: [], costs: [], drawn: [] };
  workspace.search = search;
  workspace.changed();
  addEventListener("beforeunload", leaves);
  try {
    await searched(workspace, search);
  } catch (error) {
    if (!(error instanceof Cancelled)) search.error = message(error);
  } finally {
    search.isRunning = false;
    removeEventListener("beforeunload", leaves);
    workspace.changed();
  }
}

async function searched(workspace: Workspace, search: Search): Promise<void> {
  const { small, large, all } = identifiedFrom(workspace.project.records);
  const names = (entries: RecordEntry[]) => entries.map((entry) => entry.file);
  const { files, records } = await workspace.sources(all);
  const options = workspace.project.settings["identify"] ?? {};
  const cancelled = async (error: unknown): Promise<never> => {
    if (error instanceof Cancelled && search.best) {
      search.result = await workspace.addModel({ name: "cancelled.json", bytes: new TextEncoder().encode(search.best.text) }, {
        summary: "", verdict: "The search was cancelled: this is the best model until then.", notes: [], from: all,
      });
    }
    throw error;
  };
  const answer = await workspace.run({
    name: "identify",
    request: { call: "identify", options, records, files: { small_signal: names(small), large_signal: names(large) } },
    files,
    onStage: (stage) => followed(search, stage),
  }).catch(cancelled);
  const [file] = answer.files;
  if (!file) return;
  const { model, sentence, notes, reasons, found } = answer.result;
  search.result = await workspace.addModel({ name: `${found.operator}.json`, bytes: file.bytes }, {
    summary: model, verdict: sentence ?? "", notes: [...(notes ?? []), ...(reasons ?? [])], from: all,
  });
}

/** Number of fits so far, of all searches. */
let count = 0;

/** Takes up a stage of the search. */
function followed(search: Search, { what, figures, model, best }: Stage & { figures: Record<string, number> }): void {
  const { held_out_percent: error, cost } = figures;
  if (cost !== undefined) search.costs.push(cost);
  if (error !== undefined) {
    if (Number.isFinite(error)) search.errors.push(error);
    const known = search.trials.find((one) => one.operator === what);
    if (known) Object.assign(known, figures);
    else search.trials.push({ operator: what, ...figures });
  }
  if (model === undefined) return;
  const fit = { operator: JSON.parse(model).hysteresis?.operator ?? what, text: model, key: `fit ${count++}` };
  search.fits.set(what, fit);
  if (best) search.best = fit;
}
