// What is drawn of a record: its samples, and the free runs of models on it.

import type { Answer } from "../packet.ts";
import { type ModelEntry, nameOf, type Options, type RecordEntry } from "../project.ts";
import type { Task } from "../work.ts";
import type { Workspace } from "../workspace.ts";

/** The free run of a model on a record. */
export interface Run {
  /** As it stands in legends. */
  name: string;
  /** Number of its colour. */
  colour: number;
  /** That of the model. */
  key: string;
  answer: Answer;
}

/** A model that is drawn. */
export interface Drawn {
  name: string;
  colour: number;
  /** Names the content of its file. */
  key: string;
  /** Its file: of a model of the project, or of a fit that is under way. */
  file: string | { name: string; text: string };
}

/** The call that runs models on records. */
export async function task(
  workspace: Workspace, call: "validate" | "report" | "compare", models: Drawn["file"][], records: RecordEntry[], options: Options,
): Promise<Task> {
  const data = await workspace.sources(records);
  const content = (file: Drawn["file"]) =>
    (typeof file === "string" ? workspace.file(file) : { name: file.name, bytes: new TextEncoder().encode(file.text) });
  const files = await Promise.all(models.map(content));
  const model = files.map(({ name }) => name);
  return {
    name: `${call} ${model.join(", ")}`,
    request: { call, options, records: data.records, files: { model, data: records.map((one) => one.file) } },
    files: [...files, ...data.files],
  };
}

/** The free run of a model on records; `options` are those of `validate`. */
export const validated = (workspace: Workspace, { key, file }: Drawn, records: RecordEntry[], options: Options): Promise<Answer> =>
  workspace.answer(`validate ${JSON.stringify([key, records, options])}`, async () =>
    ({ ...(await task(workspace, "validate", [file], records, options)), beside: true }));

/** The model of a project as it is drawn. */
export const drawnModel = (entry: ModelEntry, colour: number): Drawn =>
  ({ name: nameOf(entry), colour, key: entry.file, file: entry.file });

const NONE = new Float64Array();

/** Samples of a run on a record. */
export const samples = ({ answer }: Run, name: "u" | "y" | "simulated"): Float64Array => answer.series.get(`${name}/0`) ?? NONE;

/** What is left of a record by a model: measured less simulated. */
export function residual(run: Run): Float64Array {
  const simulated = samples(run, "simulated");
  return samples(run, "y").map((y, t) => y - simulated[t]!);
}
