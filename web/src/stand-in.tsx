// The plant that the views play on: the stand-in for one's own actuator, which is made once from the records of the
// model; or a twin of the catalogue, by choice alone, because that is another actuator.

import { useEffect } from "preact/hooks";
import type { File, Request } from "./packet.ts";
import { prose } from "./plot/ticks.ts";
import { type ModelEntry, nameOf, type Options, type RecordEntry, type StandIn, withSettings } from "./project.ts";
import { Fault, useKept, useOutcome, useShared } from "./ui.tsx";
import type { Workspace } from "./workspace.ts";

/** As the library names a stand-in. */
const STAND_IN = "stand-in";

/** What calls play on. */
export interface Plant {
  /** As results name it. */
  name: string;
  /** Tells one plant from another. */
  key: string;
  /** A request with its files, on this plant. */
  on(request: Request, files: File[]): Promise<{ request: Request; files: File[] }>;
}

/** A plant in a sentence. */
export const spokenPlant = (name: string): string => (name === STAND_IN ? "the stand-in" : `the twin ${name}`);

/** Options without a plant, which is chosen for all views together. */
export const withoutPlant = ({ plant: _, ...options }: Options): Options => options;

const twinOf = (workspace: Workspace): string => String(workspace.project.settings["plant"]?.["twin"] ?? "");

/** The plant that was chosen for a model; none while there is no stand-in yet. */
export function usePlant(entry: ModelEntry | undefined): Plant | undefined {
  const { workspace } = useShared();
  const twin = twinOf(workspace);
  if (twin) {
    return { name: twin, key: twin, on: async (request, files) => ({ request: { ...request, options: { ...request.options, plant: twin } }, files }) };
  }
  const file = entry?.standIn?.file;
  return file === undefined ? undefined : {
    name: STAND_IN, key: file,
    on: async (request, files) => ({
      request: { ...request, files: { ...request.files, stand_in: [file] } },
      files: [...files, await workspace.file(file)],
    }),
  };
}

/** The records of a model: those that are in the project, and the names of the others. */
interface Sources {
  here: RecordEntry[];
  lacking: string[];
}

/** The records that a model states; none if it states none. */
async function sourcesOf(workspace: Workspace, entry: ModelEntry): Promise<Sources> {
  const { fit } = await workspace.document(entry.file);
  const stated: string[] = (Array.isArray(fit?.files) ? fit.files : []).map((one: { file?: string }) => String(one.file ?? ""));
  const elsewhere = stated.map((file): RecordEntry => ({ file, columns: {}, prepare: {}, use: "training" }));
  const all = stated.length > 0 ? (entry.from ?? elsewhere) : [];
  const isHere = ({ file }: RecordEntry) => workspace.project.records.some((one) => one.file === file);
  return { here: all.filter(isHere), lacking: all.filter((one) => !isHere(one)).map(({ file }) => file) };
}

/** As the work is called. */
const workOf = ({ file }: ModelEntry): string => `stand-in for ${file}`;

/** Makes the stand-in, and keeps it beside its model. */
async function make(workspace: Workspace, entry: ModelEntry): Promise<void> {
  const from = (await sourcesOf(workspace, entry)).here;
  // How records are read stands in the model; where they were prepared before, their origin must be the same.
  const { files, records } = entry.from
    ? await workspace.sources(from)
    : { files: await Promise.all(from.map(({ file }) => workspace.file(file))), records: {} };
  const { result, files: [model] } = await workspace.run({
    name: workOf(entry),
    request: { call: "stand-in", records, files: { model: [entry.file], records: files.map(({ name }) => name) } },
    files: [await workspace.file(entry.file), ...files],
    beside: true,
  });
  const file = await workspace.keep({ name: `${nameOf(entry)}-stand-in.json`, bytes: model!.bytes });
  const standIn: StandIn = { file, sentence: result.sentence };
  workspace.amend((project) => ({
    ...project, models: project.models.map((one) => (one.file === entry.file ? { ...one, standIn } : one)),
  }));
}

/** Models whose stand-ins were begun since the page was loaded: what was cancelled or refused does not begin again by itself. */
const begun = new Set<string>();

/** The choice of the plant. The stand-in is made as soon as it is needed. */
export function PlantChoice({ entry }: { entry: ModelEntry }) {
  const { workspace, lists } = useShared();
  const twin = twinOf(workspace);
  const { records } = workspace.project;
  const sources = useOutcome(twin || entry.standIn ? undefined : JSON.stringify([entry.file, records.map(({ file }) => file)]), () =>
    sourcesOf(workspace, entry));
  const work = useKept<void>(workOf(entry), [entry.file, workspace.project.records]);
  const from = sources.value?.lacking.length === 0 ? sources.value.here : [];
  const start = () => work.start(() => make(workspace, entry));
  const isNeeded = !twin && !entry.standIn && from.length > 0 && !work.busy;
  useEffect(() => {
    if (!isNeeded || begun.has(entry.file)) return;
    begun.add(entry.file);
    start();
  }, [isNeeded, entry.file]);
  const choose = (twin: string) => workspace.change((project) => withSettings(project, "plant", twin ? { twin } : {}));
  return (
    <>
      <div class="row">
        <label>
          Plant{" "}
          <select value={twin} onChange={(event) => choose(event.currentTarget.value)}>
            <option value="">stand-in from its records</option>
            <optgroup label="Another actuator: catalogue twins">
              {lists.plants.map(({ name }) => <option key={name} value={name}>{name}</option>)}
            </optgroup>
          </select>
        </label>
        {isNeeded && begun.has(entry.file) && <button type="button" class="main" onClick={start}>Make the stand-in</button>}
      </div>
      {twin && (
        <p class="stale">
          {prose(lists.plants.find(({ name }) => name === twin)?.summary ?? twin)}. This is another actuator than yours, unless your records are
          of this twin: what happens on it proves nothing about yours.
        </p>
      )}
      {!twin && <Fault text={work.error ?? sources.error} />}
      {!twin && work.busy && (
        <p role="status">
          The stand-in is being identified: a second model of another class, from the same records, once for this model. Cancel is at the lower right.
        </p>
      )}
      {!twin && !entry.standIn && sources.value && <Lack file={entry.file} {...sources.value} />}
    </>
  );
}

/** Says why there is no stand-in for a model from elsewhere, and what to do. */
function Lack({ file, here, lacking }: Sources & { file: string }) {
  if (lacking.length > 0) {
    return (
      <p class="missing">
        A stand-in comes from the records that {file} was identified from, but {lacking.join(", ")} {lacking.length > 1 ? "are" : "is"} not in
        this project. <a href="#workbench">Add {lacking.length > 1 ? "them" : "it"}</a>, or choose a twin, which is another actuator.
      </p>
    );
  }
  return here.length > 0 ? null : (
    <p class="missing">
      {file} does not state which records it was identified from, so that there is no stand-in for its actuator.{" "}
      <a href="#workbench">Identify a model here</a>, or choose a twin, which is another actuator.
    </p>
  );
}

/** What the stand-in is, if it is the plant: its sentence, and what it shows. */
export function AboutPlant({ entry }: { entry: ModelEntry }) {
  const { workspace } = useShared();
  const work = useKept<void>(workOf(entry), [entry.file, workspace.project.records]);
  if (!entry.standIn || twinOf(workspace)) return null;
  return (
    <>
      <p>{prose(entry.standIn.sentence)}.</p>
      <details>
        <summary>What a stand-in shows, and what it does not</summary>
        <p>
          A model is proven on records; what its voltage is worth shows on the actuator only. The stand-in comes from the same records, by a second
          model whose operator is of another class. Where the records leave something open, both models differ: on other amplitudes, at other rates,
          in minor loops. They differ by as much as the model is wrong on the records.
        </p>
        <p>
          Random stand-ins lie on either side of the model, and the second model has the spread of its parameters. The range is that of 8 in 10 of them:
          how far the stand-in spreads, not a confidence interval of the actuator. On simulated actuators the error on the stand-in was mostly within a
          factor of two of that on the actuator.
        </p>
        <p>
          It does not tell errors that all models here share, what happens at rates beyond the records, the past of the actuator before the path, drift,
          temperature, and the limits of a driver.
        </p>
        <button type="button" disabled={work.busy} onClick={() => work.start(() => make(workspace, entry))}>Make it again</button>
      </details>
    </>
  );
}
