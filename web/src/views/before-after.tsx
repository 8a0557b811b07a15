// A path before and after: with a constant gain, and with the compensated voltage, on the plant that was chosen.

import { useMemo } from "preact/hooks";
import type { Answer, File } from "../packet.ts";
import type { Figure, Series } from "../plot/figure.ts";
import { rough, unit } from "../plot/ticks.ts";
import type { ModelEntry, Options } from "../project.ts";
import { AboutPlant, type Plant, PlantChoice, spokenPlant } from "../stand-in.tsx";
import { Chart, Fault, Notes, Section, Stale, Table, useKept, useLatest, useShared } from "../ui.tsx";

/** Errors of a path on a plant, as `compensate` answers. */
interface OnPlant {
  plant: string;
  gain: Errors;
  compensated: Errors;
  /** The rms error on 8 of 10 random stand-ins; of a twin none. */
  spread: [number, number] | null;
  notes: string[];
}

interface Errors {
  /** Number of samples that count, at the end of the path. */
  n: number;
  rmse: number;
  max_abs: number;
  rms_pp_percent: number;
}

interface Props {
  entry: ModelEntry;
  plant: Plant | undefined;
  path: File;
  /** What the path is made of, and how many samples it has if that is known. */
  expected: string;
  samples: number;
  options: Options;
  /** True if the voltage for the path is refused, which is stated above. */
  refused: boolean;
}

/** Samples of a path up to which it is played by itself: native, 100,000 take 1.5 s. */
const LONG = 30_000;

export function BeforeAfter({ entry, plant, path, expected, samples, options, refused }: Props) {
  const { workspace } = useShared();
  const key = JSON.stringify([entry.file, expected, options, plant?.key]);
  const isLong = samples > LONG;
  const play = async (plant: Plant, quiet: boolean): Promise<Answer> => {
    const request = { call: "compensate", options, files: { model: [entry.file], reference: [path.name] } };
    return workspace.run({
      name: "before and after", ...(await plant.on(request, [await workspace.file(entry.file), path])), beside: true, quiet,
    });
  };
  const now = useLatest(plant && !isLong ? key : undefined, () => play(plant!, true));
  const started = useKept<Answer>("before and after", key);
  const outcome = isLong ? started : now;
  const answer = plant && !refused ? outcome.value : undefined;
  return (
    <Section title="Before and after" wide help="The path with a constant gain, and with the compensated voltage, on an actuator that is not the model.">
      <PlantChoice entry={entry} />
      {plant && isLong && (
        <div class="row">
          <button type="button" class="main" disabled={started.busy} onClick={() => started.start(() => play(plant, false))}>Follow the path</button>
        </div>
      )}
      {plant && !refused && <Fault text={outcome.error} />}
      {isLong && <Stale stale={started.stale} />}
      {answer && <Result answer={answer} />}
      <AboutPlant entry={entry} />
    </Section>
  );
}

function Result({ answer }: { answer: Answer }) {
  const { units, on_plant } = answer.result;
  const { plant, gain, compensated, spread, notes }: OnPlant = on_plant;
  const of = unit(units.y);
  const figure = useMemo(() => figureOf(answer), [answer]);
  const row = (name: string, errors: Errors) =>
    [name, `${rough(errors.rmse)} ${of}`, `${rough(errors.max_abs)} ${of}`, `${rough(errors.rms_pp_percent)} %`];
  return (
    <>
      <p class={compensated.rmse < gain.rmse ? "verdict" : "verdict poor"} role="status">
        On {spokenPlant(plant)}, the error goes from <b>{rough(gain.rmse)}&nbsp;{of}</b> rms with a constant
        gain ({rough(gain.rms_pp_percent)}&nbsp;% of the height of the path) to <b>{rough(compensated.rmse)}&nbsp;{of}</b> with the compensated
        voltage ({rough(compensated.rms_pp_percent)}&nbsp;%){spread && <>; in 8 of 10 random stand-ins {rough(spread[0], 3)} to {rough(spread[1], 3)}&nbsp;{of}, the
          spread of the stand-in and no confidence interval</>}.
      </p>
      <Notes title="" notes={notes} />
      <Chart figure={figure} height={440} />
      <Table caption="Errors on the plant" head={["Voltage", "Error, rms", "Largest error", "Error, rms [% of the height]"]}
        rows={[row("constant gain", gain), row("compensated", compensated)]} />
      <p class="help">
        Errors count in the shaded part only: before it, the past of the actuator shows. They are against the path after smoothing and shaping, without
        their mean, which depends on the zero of the sensor and on the past. The constant gain has the delay of the model taken out.
      </p>
    </>
  );
}

/** Requested and reached displacement; below, the errors without their mean. */
function figureOf({ result, series }: Answer): Figure {
  const { ts, units, on_plant: { plant, gain } }: { ts: number; units: { y: string }; on_plant: OnPlant } = result;
  const [r, requested] = [series.get("shaped")!, series.get("requested")!];
  const from = r.length - gain.n;
  const runs: Series[] = [["constant gain", "y/gain", 2], ["compensated", "y/compensated", 1]].map(([name, of, colour]) =>
    ({ name: String(name), y: series.get(String(of))!, step: ts, colour: Number(colour) }));
  const error = ({ y, ...run }: Series): Series => {
    const e = y.map((value, k) => value - r[k]!);
    const mean = e.subarray(from).reduce((sum, value) => sum + value, 0) / gain.n;
    return { ...run, y: e.map((value) => value - mean) };
  };
  const isShaped = r.some((value, k) => value !== requested[k]);
  return {
    title: `The path on ${spokenPlant(plant)}`,
    x: { label: "Time", unit: "s" },
    panels: [
      {
        y: { label: "Displacement", unit: units.y },
        series: [
          { name: "requested", y: requested, step: ts, style: "pale" },
          ...(isShaped ? [{ name: "shaped", y: r, step: ts, style: "dashed" as const, colour: 3 }] : []),
          ...runs,
        ],
      },
      { y: { label: "Error", unit: units.y }, series: runs.map(error) },
    ],
    ...(from > 0 && { span: { from: from * ts, to: (r.length - 1) * ts } }),
  };
}
