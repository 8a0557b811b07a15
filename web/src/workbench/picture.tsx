// The middle of the workbench: the pictures of the record, which share cursor and zoom.

import { useMemo } from "preact/hooks";
import { Form } from "../form.tsx";
import { optionsOf } from "../lists.ts";
import type { Figure } from "../plot/figure.ts";
import { Link } from "../plot/link.ts";
import { short, unit } from "../plot/ticks.ts";
import { type Options, type RecordEntry, withSettings } from "../project.ts";
import { Chart, Choice, Fault, Notes, Overview, Table, useOutcome, useSettings, useShared } from "../ui.tsx";
import { cutHandles } from "./cut.ts";
import { cyclesOf } from "./cycles.ts";
import { binsFigure, loopFigure, loopsFigure, type Shown, spectrumFigure, timeFigure, used, whiteFigure } from "./figures.ts";
import type { Run } from "./runs.ts";
import { shownOf } from "./shown.ts";

/** The pictures, by the names of their buttons. */
const PICTURES = ["Overview", "Time", "Loop", "Loop less its line", "Spectrum", "Error"] as const;
type Picture = (typeof PICTURES)[number];

/** What of the pictures is remembered. */
export interface PictureSettings {
  picture?: Picture;
  cycles?: (typeof CYCLES)[number];
  /** Options of `validate`. */
  options?: Options;
}

/** What is shown is no change that Undo takes back. */
function usePictures(): [PictureSettings, (values: Options) => void] {
  const { workspace } = useShared();
  const [settings] = useSettings("workbench");
  return [settings as PictureSettings, (values) => workspace.amend((project) => withSettings(project, "workbench", values))];
}

interface Props {
  entry: RecordEntry;
  shown: Shown;
  runs: Run[];
  /** Models are being simulated. */
  busy: boolean;
  /** Why a model is not drawn. */
  error?: string | undefined;
}

export function PicturePane({ entry, shown, runs, busy, error }: Props) {
  const { workspace } = useShared();
  const [settings, change] = usePictures();
  const picture = settings.picture ?? "Overview";
  // One span and one cursor for all pictures of a record, also when another picture is chosen.
  const link = useMemo(() => new Link(), [entry.file]);
  const of = (...names: Picture[]) => names.includes(picture);
  const time = useMemo(() => timeFigure(shown, runs), [shown, runs]);
  const whole = shown.whole.result.record;
  // Anew for another entry alone: a chart is drawn again for each figure.
  const handled = useMemo((): Figure => ({
    ...time,
    ...(shown.used && { span: { from: shown.start, to: Number(entry.columns["to"] ?? whole.duration) } }),
    handles: cutHandles(entry, whole.duration, (next, passing) => workspace.tell(next, passing)),
  }), [time, entry]);
  const spectrum = useMemo(() => spectrumFigure(shown, runs), [shown, runs]);
  return (
    <div class="pictures">
      <Choice label="Picture" names={[...PICTURES]} chosen={picture} choose={(name) => change({ ...settings, picture: name })} />
      <Fault text={error} />
      {of("Overview", "Time") && (
        <>
          <Chart figure={handled} height={picture === "Time" ? 600 : 320} link={link} bare />
          <Overview figure={time} link={link} />
        </>
      )}
      {of("Overview", "Loop", "Loop less its line") && <Loops picture={picture} shown={shown} runs={runs} link={link} />}
      {of("Spectrum") && (spectrum ? <Chart figure={spectrum} height={600} bare /> : <p class="missing">A record this short has no spectrum.</p>)}
      {of("Error") && <Errors shown={shown} runs={runs} busy={busy} />}
    </div>
  );
}

/** What of the samples loops are drawn from. */
const CYCLES = ["A few cycles of each amplitude", "All samples", "All records, by frequency"] as const;

/** The loop, and the loop less its straight line: both, or the one that is chosen. */
function Loops({ picture, shown, runs, link }: Pick<Props, "shown" | "runs"> & { picture: Picture; link: Link }) {
  const [settings, change] = usePictures();
  const alone = picture !== "Overview";
  const cycles = (alone && settings.cycles) || CYCLES[0];
  const answer = shown.used ?? shown.whole;
  const [loop, bare] = useMemo(() => {
    const { slope } = used(shown);
    const look = { cycles: cycles === CYCLES[1] ? undefined : cyclesOf(answer) };
    return [loopFigure(shown, runs, look), slope === undefined ? undefined : loopFigure(shown, runs, { ...look, slope })];
  }, [shown, runs, cycles]);
  const height = alone ? 560 : 260;
  return (
    <>
      {alone && <Choice label="Cycles" names={[...CYCLES]} chosen={cycles} choose={(name) => change({ ...settings, cycles: name as (typeof CYCLES)[number] })} />}
      {alone && cycles === CYCLES[2] ? <ByFrequency less={picture !== "Loop"} /> : (
        <div class={alone ? "" : "pair"}>
          {picture !== "Loop less its line" && <Chart figure={loop} height={height} link={link} />}
          {picture !== "Loop" && bare && <Chart figure={bare} height={height} link={link} />}
        </div>
      )}
    </>
  );
}

/** The loops of all records that are used, side by side. */
function ByFrequency({ less }: { less: boolean }) {
  const { workspace } = useShared();
  const used = workspace.project.records.filter((one) => one.use !== "none");
  const all = useOutcome(JSON.stringify(used), async () => {
    const read = await Promise.all(used.map((one) => shownOf(workspace, one).catch(() => undefined)));
    return read.filter((one): one is Shown => one?.whole.result.record);
  });
  const figure = useMemo(() => all.value && loopsFigure(all.value, less), [all.value, less]);
  if (!all.value) return <p class="missing">Reading the records.</p>;
  return figure ? <Chart figure={figure} height={280} bare /> : <p class="missing">No record has regular cycles.</p>;
}

const percent = (value: number): string => `${short(value)} %`;

/** Errors by frequency and amplitude, and the tests of the residuals on demand. */
function Errors({ shown, runs, busy }: Pick<Props, "shown" | "runs" | "busy">) {
  const { lists } = useShared();
  const [settings, change] = usePictures();
  const [frequency, amplitude, white] = useMemo(() => {
    const unitOfU = used(shown).units.u;
    return [binsFigure(runs, "by_frequency", unitOfU), binsFigure(runs, "by_amplitude", unitOfU), whiteFigure(runs)];
  }, [shown, runs]);
  if (runs.length === 0) return busy ? <p class="missing">Simulating the model.</p> : <p class="missing">Errors are those of a model: identify one, or draw one that is there.</p>;
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
      <Table caption="Errors of the free runs" head={["Model", "Error, rms", "NRMSE", "Largest error", "Noise"]}
        rows={runs.map(({ name, answer }) => {
          const { rms_pp_percent, nrmse_percent, max_abs, unit: of, floor } = answer.result.files[0];
          return [name, percent(rms_pp_percent), percent(nrmse_percent), `${short(max_abs)} ${unit(of)}`, floor ? percent(floor.rms_pp_percent) : ""];
        })} />
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
