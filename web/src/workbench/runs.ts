// What is drawn of a record: its samples, and the free runs of models on it.

import type { Answer } from "../packet.ts";
import type { ModelEntry, Options, RecordEntry } from "../project.ts";
import type { Workspace } from "../workspace.ts";

/** The free run of a model on records. */
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

/** The name of a model without its ending. */
export const nameOf = ({ file }: Pick<ModelEntry, "file">): string => file.replace(/\.json$/, "");

/** The free run of a model on records; `options` are those of `validate`. */
export function validated(workspace: Workspace, { key, file }: Drawn, records: RecordEntry[], options: Options): Promise<Answer> {
  return workspace.answer(`validate ${JSON.stringify([key, records, options])}`, async () => {
    const data = await workspace.sources(records);
    const model = typeof file === "string" ? await workspace.file(file) : { name: file.name, bytes: new TextEncoder().encode(file.text) };
    return {
      name: `validate ${model.name}`,
      request: { call: "validate", options, records: data.records, files: { model: [model.name], data: records.map((one) => one.file) } },
      files: [model, ...data.files],
      beside: true,
    };
  });
}

/** The model of a project as it is drawn. */
export const drawnModel = (entry: ModelEntry, colour: number): Drawn =>
  ({ name: nameOf(entry), colour, key: entry.file, file: entry.file });

const NONE = new Float64Array();

/** Samples of a run on the record number `k`. */
export const samples = ({ answer }: Run, name: "u" | "y" | "simulated", k = 0): Float64Array => answer.series.get(`${name}/${k}`) ?? NONE;

/** What is left of a record by a model: measured less simulated. */
export function residual(run: Run, k = 0): Float64Array {
  const simulated = samples(run, "simulated", k);
  return samples(run, "y", k).map((y, t) => y - simulated[t]!);
}
