// The workbench: records at the left, their pictures in the middle, and at the right what is known and the next step.

import { useMemo } from "preact/hooks";
import { type Options, type RecordEntry, shownRecord, usedModel } from "../project.ts";
import { Fault, useLatest, useOutcome, useSettings, useShared } from "../ui.tsx";
import type { Shown } from "../workbench/figures.ts";
import { KnownPane } from "../workbench/known.tsx";
import { PicturePane, type PictureSettings } from "../workbench/picture.tsx";
import { Details, Drop, Records } from "../workbench/records.tsx";
import { type Drawn, drawnModel, type Run, validated } from "../workbench/runs.ts";
import type { Fit } from "../workbench/search.ts";
import { shownOf } from "../workbench/shown.ts";
import type { Workspace } from "../workspace.ts";

/** What the workbench remembers. */
interface Settings extends PictureSettings {
  /** Files of the models that are drawn; the model in use without it. */
  drawn?: string[];
}

export function WorkbenchView() {
  const { workspace } = useShared();
  const { models } = workspace.project;
  const [settings, change] = useSettings("workbench") as [Settings, (values: Options) => void];
  const [entry, used] = [shownRecord(workspace.project), usedModel(workspace.project)];
  const read = useOutcome(entry && JSON.stringify(entry), () => shownOf(workspace, entry!));
  // That of another record stays until this one is read, and is not shown.
  const record = { ...read, value: read.value?.file === entry?.file ? read.value : undefined };
  const drawn = models.filter((one) => settings.drawn?.includes(one.file) || one === used);
  if (!entry && !used) return <Drop />;
  return (
    <div class="bench">
      <div class="pane left" role="region" aria-label="Records">
        <div>
          <Drop />
          <Records shown={entry} />
        </div>
        {entry && (
          <div key={entry.file} class="details">
            <Fault text={record.error} />
            <Details entry={entry} inspection={record.value?.whole} prepared={record.value?.used} />
          </div>
        )}
      </div>
      <div class="pane" role="region" aria-label="Pictures">
        {entry
          ? <Pictured key={entry.file} entry={entry} record={record} models={drawnNow(workspace, drawn.map((one) => drawnModel(one, colourOf(models.indexOf(one)))))} options={settings.options ?? {}} />
          : <p class="missing">Add a record: its pictures are drawn here.</p>}
      </div>
      <div class="pane" role="region" aria-label="What is known">
        <KnownPane entry={used} drawn={drawn} draw={(files) => change({ ...settings, drawn: files })} options={settings.options ?? {}} />
      </div>
    </div>
  );
}

/** The colour of a model; that of measurements, 0, is left out. */
const colourOf = (k: number): number => 1 + (k % 6);

/** What is drawn: during a search its best fit and those that are chosen, otherwise models, and chosen fits of the last search. */
function drawnNow({ search }: Workspace, models: Drawn[]): Drawn[] {
  const fits = (search?.drawn ?? []).flatMap((operator, k) => drawnFit(search!.fits.get(operator), operator, colourOf(k + 1)));
  if (!search?.isRunning) return [...models, ...fits];
  return [...drawnFit(search.best, `best so far: ${search.best?.operator}`, colourOf(0)), ...fits];
}

const drawnFit = (fit: Fit | undefined, name: string, colour: number): Drawn[] =>
  (fit ? [{ name, colour, key: fit.key, file: { name: `${fit.operator}.json`, text: fit.text } }] : []);

function Pictured({ entry, record, models, options }: { entry: RecordEntry; record: { value: Shown | undefined; busy: boolean }; models: Drawn[]; options: Options }) {
  const { workspace } = useShared();
  const isRead = record.value?.whole.result.record != null;
  const key = isRead ? JSON.stringify([entry, options, models.map(({ name, colour, key }) => [name, colour, key])]) : undefined;
  const runs = useLatest(key, async () => ({
    of: JSON.stringify(entry),
    runs: await Promise.all(models.map(async (model): Promise<Run> =>
      ({ name: model.name, colour: model.colour, key: model.key, answer: await validated(workspace, model, [entry], options) }))),
  }));
  // Runs on the record as it was before are not drawn over what it is now.
  const drawn = useMemo(() => {
    if (runs.value?.of !== JSON.stringify(entry)) return [];
    // During a search the fit before stays until the next one is simulated.
    return workspace.search?.isRunning ? runs.value.runs : runs.value.runs.filter(({ key }) => models.some((model) => model.key === key));
  }, [runs.value, key, workspace.search?.isRunning]);
  if (!record.value) return record.busy ? <p class="missing">Reading {entry.file}.</p> : null;
  if (!isRead) {
    const choose = () => document.querySelector<HTMLElement>(".channels select")?.focus();
    return (
      <p class="missing">
        The pictures need to know which channel is the input, and which is the output.{" "}
        {record.value.whole.result.channels && <button type="button" class="link" onClick={choose}>Choose the channels</button>}
      </p>
    );
  }
  return <PicturePane entry={entry} shown={record.value} runs={drawn} busy={runs.busy} error={runs.error} />;
}
