// The middle of the workbench: the pictures of the record, which share cursor and zoom.

import { useMemo } from "preact/hooks";
import { Form } from "../form.tsx";
import { optionsOf } from "../lists.ts";
import type { Figure } from "../plot/figure.ts";
import { type Options, type RecordEntry } from "../project.ts";
import { Chart, Choice, Fault, Notes, useSettings, useShared } from "../ui.tsx";
import { cutHandles } from "./cut.ts";
import { binsFigure, loopFigure, type Shown, timeFigure, used, whiteFigure } from "./figures.ts";
import type { Run } from "./runs.ts";

/** The pictures, by the names of their buttons. */
const PICTURES = ["Overview", "Time", "Loop", "Loop less its line", "Spectrum", "Error"] as const;
type Picture = (typeof PICTURES)[number];

/** What of the pictures is remembered. */
export interface PictureSettings {
  picture?: Picture;
  /** Options of `validate`. */
  options?: Options;
}

interface Props {
  entry: RecordEntry;
  shown: Shown;
  runs: Run[];
  /** Why a model is not drawn. */
  error?: string | undefined;
}

export function PicturePane({ entry, shown, runs, error }: Props) {
  const { workspace } = useShared();
  const [settings, change] = useSettings("workbench") as [PictureSettings, (values: Options) => void];
  const picture = settings.picture ?? "Overview";
  const of = (name: Picture) => picture === name || (picture === "Overview" && name !== "Spectrum" && name !== "Error");
  const time = useMemo(() => timeFigure(shown, runs), [shown, runs]);
  const whole = shown.whole.result.record;
  const handled: Figure = {
    ...time,
    ...(shown.used && { span: { from: shown.start, to: Number(entry.columns["to"] ?? whole.duration) } }),
    handles: cutHandles(entry, whole.duration, (next, passing) => workspace.tell(next, passing)),
  };
  const slope: number = used(shown).slope;
  const loop = useMemo(() => loopFigure(shown, runs), [shown, runs]);
  const bare = useMemo(() => (slope === 0 ? undefined : loopFigure(shown, runs, slope)), [shown, runs]);
  return (
    <div class="pictures">
      <Choice label="Picture" names={[...PICTURES]} chosen={picture} choose={(name) => change({ ...settings, picture: name })} />
      <Fault text={error} />
      {of("Time") && <Chart figure={handled} height={picture === "Time" ? 640 : 330} bare />}
      <div class={picture === "Overview" ? "pair" : ""}>
        {of("Loop") && <Chart figure={loop} height={picture === "Loop" ? 620 : 270} />}
        {of("Loop less its line") && bare && <Chart figure={bare} height={picture === "Overview" ? 270 : 620} />}
      </div>
      {picture === "Error" && <Errors shown={shown} runs={runs} />}
    </div>
  );
}

/** Errors by frequency and amplitude, and the tests of the residuals on demand. */
function Errors({ shown, runs }: Pick<Props, "shown" | "runs">) {
  const { lists } = useShared();
  const [settings, change] = useSettings("workbench") as [PictureSettings, (values: Options) => void];
  const [frequency, amplitude, white] = useMemo(() => {
    const unitOfU = used(shown).units.u;
    return [binsFigure(runs, "by_frequency", unitOfU), binsFigure(runs, "by_amplitude", unitOfU), whiteFigure(runs)];
  }, [shown, runs]);
  if (runs.length === 0) return <p class="missing">Errors are those of a model: identify one, or draw one that is there.</p>;
  return (
    <>
      <div class="pair">
        {frequency && <Chart figure={frequency} />}
        {amplitude && <Chart figure={amplitude} />}
      </div>
      {!frequency && <p class="help">This record excites one frequency alone: there is no error by frequency.</p>}
      {(frequency ?? amplitude) && (
        <p class="help">The noise has the bandwidth of the error. Bands in which little is excited are left out: their error is that of noise or of other frequencies.</p>
      )}
      {runs.map(({ name, answer }) => {
        const { advice, remarks } = answer.result.files[0] ?? {};
        return <Notes key={name} title={name} notes={[...(advice ? [advice] : []), ...(remarks ?? [])]} />;
      })}
      <details>
        <summary>Tests of the residuals</summary>
        {white && <Chart figure={white} />}
        {runs.map(({ name, answer }) => <Notes key={name} title={name} notes={answer.result.files[0]?.whiteness?.verdict ?? []} />)}
      </details>
      <details>
        <summary>Settings of the comparison</summary>
        <Form rows={optionsOf(lists, "validate")} values={settings.options ?? {}} change={(options) => change({ ...settings, options })} />
      </details>
    </>
  );
}
