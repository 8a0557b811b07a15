// Compensate: the path at the left, its pictures in the middle, and at the right what its voltage is worth.

import { useMemo, useRef } from "preact/hooks";
import { loopFigures, timeFigure } from "../compensate/figures.ts";
import { KnownOfPath } from "../compensate/known.tsx";
import { Limits, PathForm, pathHandles } from "../compensate/path.tsx";
import { usePlayed } from "../compensate/played.ts";
import { compensated, fileOf, pathOf, type Settings, strokeOf } from "../compensate/request.ts";
import type { Answer } from "../packet.ts";
import type { Handle } from "../plot/figure.ts";
import { Link } from "../plot/link.ts";
import { type ModelEntry, type Options, usedModel, withSettings } from "../project.ts";
import { usePlant, withoutPlant } from "../stand-in.tsx";
import { Chart, Choice, Fault, Missing, Overview, useLatest, useOutcome, useShared } from "../ui.tsx";
import { Moves } from "./moves.tsx";

export function CompensateView() {
  const { workspace } = useShared();
  const entry = usedModel(workspace.project);
  const read = useOutcome(entry?.file, async () => {
    const model = await workspace.document(entry!.file);
    return { file: entry!.file, model, stroke: await strokeOf(workspace, entry!.file, model) };
  });
  if (!entry) return <Missing what="There is no model yet." title="Identify one" />;
  // That of another model stays until this one is read.
  if (read.value?.file !== entry.file) return <Fault text={read.error} />;
  return <Compensation key={entry.file} entry={entry} {...read.value} />;
}

/** What the middle shows. */
const PICTURES = ["Path", "Moves in time"];

function Compensation({ entry, model, stroke }: { entry: ModelEntry; model: any; stroke: [number, number] }) {
  const { workspace, lists } = useShared();
  const { file } = entry;
  const plant = usePlant(entry);
  const settings = (workspace.project.settings["compensate"] ?? {}) as Settings;
  const options = withoutPlant(settings.options ?? {});
  // The error to expect is that of the validation, where it is larger than that of the identification.
  const requested = entry.error === undefined ? options : { ...options, model_error: entry.error };
  const change = (values: Partial<Settings>, passing = false) =>
    workspace.change((project) => withSettings(project, "compensate", { ...settings, ...values } as Options), passing);
  const target = pathOf(settings, model, stroke);
  const expected = JSON.stringify(target);
  const path = useLatest(expected, async () => ({ expected, file: await fileOf(workspace, lists, target) }));
  // Of the path that is there, which is the one before while another is made.
  const input = path.value && JSON.stringify([file, path.value.expected, requested]);
  const result = useLatest(input, async () => ({ input, answer: await compensated(workspace, file, path.value!.file, requested) }));
  const answer = result.value?.answer;
  const current = path.value?.expected === expected && result.value?.input === input;
  const error = path.error ?? result.error;
  const played = usePlayed({
    entry, plant, path: path.value?.file, expected: path.value?.expected ?? "", samples: answer?.series.get("requested")?.length ?? 0,
    options: requested,
  });
  // The picture stays until the next one is there: that of the last path if this one is refused.
  const last = useRef<{ of?: Answer | undefined; shown?: Answer | undefined }>({});
  if (error === undefined) {
    if (played.value && !played.stale) last.current = { of: answer, shown: played.value };
    else if (answer !== last.current.of || !plant) last.current = { of: answer, shown: answer };
  }
  const { shown } = last.current;
  const picture = settings.picture ?? PICTURES[0]!;
  // What is shown is no change that Undo takes back.
  const choose = (picture: string) => workspace.amend((project) => withSettings(project, "compensate", { ...project.settings["compensate"], picture }));
  return (
    <div class="bench">
      <div class="pane left" role="region" aria-label="Path and limits">
        <PathForm path={target} settings={settings} change={change} error={error} isOld={shown !== undefined} />
        <div class="details"><Limits model={model} values={options} change={(options) => change({ options })} /></div>
      </div>
      <div class="pane" role="region" aria-label="Pictures">
        <Choice label="Picture" names={PICTURES} chosen={picture} choose={choose} />
        {picture === PICTURES[0] && shown && <Pictures key={`${target.path} ${target.duration}`} answer={shown} handles={pathHandles(target, change)} />}
        {picture === PICTURES[1] && path.value && (
          <Moves file={file} model={model} plant={plant} path={path.value.file} expected={path.value.expected} shared={options}
            values={settings.moves ?? {}} change={(moves) => change({ moves })} />
        )}
      </div>
      <div class="pane" role="region" aria-label="What is known">
        <KnownOfPath entry={entry} model={model} plant={plant} answer={answer} current={current} error={error} advised={path.error ? undefined : result.advice?.["smooth"]} played={played}
          smooth={(seconds) => change({ options: { ...options, smooth: seconds } })} />
      </div>
    </div>
  );
}

/** The path against time, and its loops, with one cursor and one span of time. */
function Pictures({ answer, handles }: { answer: Answer; handles: Handle[] }) {
  const link = useMemo(() => new Link(), []);
  const [time, loops] = useMemo(() => [timeFigure(answer), loopFigures(answer)] as const, [answer]);
  return (
    <div class="pictures">
      <Chart figure={{ ...time, handles }} height={480} link={link} bare />
      <Overview figure={time} link={link} />
      <div class="pair">{loops.map((figure) => <Chart key={figure.title} figure={figure} height={260} link={link} />)}</div>
    </div>
  );
}
