// The right of Compensate: what the compensated voltage is worth, what it uses of what was measured, and the next step.

import { voltageUse } from "../drive.ts";
import { Fault, Notes, Section, Stale, Table, useShared, Verdict } from "../ui.tsx";
import type { Answer } from "../packet.ts";
import { download } from "../plot/download.ts";
import { prose, rough, short, si, unit } from "../plot/ticks.ts";
import { recorded } from "../models.tsx";
import type { ModelEntry } from "../project.ts";
import { AboutPlant, type Plant, PlantChoice, spokenPlant } from "../stand-in.tsx";
import { beyondMeasured } from "./beyond.ts";
import type { Errors, OnPlant, Played } from "./played.ts";

interface Props {
  entry: ModelEntry;
  model: any;
  plant: Plant | undefined;
  /** The voltage, which is `current` if it is that of the path as it is now. */
  answer: Answer | undefined;
  current: boolean;
  /** Why there is none. */
  error: string | undefined;
  /** The smoothing that resolves it [s]. */
  advised: unknown;
  played: Played;
  smooth(seconds: number): void;
}

export function KnownOfPath({ entry, model, plant, answer, current, error, advised, played, smooth }: Props) {
  return (
    <>
      <Section title="Before and after">
        {error && <p class="missing">There is no voltage for this path: the reason stands beside it.</p>}
        {error && typeof advised === "number" && <Smoothing seconds={advised} smooth={smooth} />}
        {!error && <Fault text={played.error} />}
        {!error && answer && (played.value && !played.stale
          ? <Proven answer={played.value} />
          : <Promised answer={answer} isPlayed={plant !== undefined && played.busy} />)}
        {!error && played.start && (
          <div class="row"><button type="button" class="main" disabled={played.busy} onClick={played.start}>Follow the path</button></div>
        )}
        <Stale stale={played.start !== undefined && played.stale} />
        {!error && entry.verdict && <p class="help">The model: {prose(entry.validated ?? entry.verdict)}</p>}
        <PlantChoice entry={entry} />
        <AboutPlant entry={entry} />
      </Section>
      {!error && answer && <Used model={model} answer={answer} smooth={smooth} />}
      {!error && answer && <Next answer={answer} current={current} />}
    </>
  );
}

/** The error that the records promise, while no plant has played the path. */
function Promised({ answer: { result }, isPlayed }: { answer: Answer; isPlayed: boolean }) {
  const expected: number | null | undefined = result.expected_rms;
  const least = result.is_beyond && expected != null ? ` The error is at least ${rough(expected)} ${unit(result.units.y)} rms.` : "";
  if (result.smoothing) return <Verdict text={beyondMeasured(result.smoothing, result.units.u) + least} />;
  if (expected === null || expected === undefined) return isPlayed ? null : <p class="help">The model does not state how good it is: no error is promised.</p>;
  return <Numbers rows={[[`${rough(expected)} ${unit(result.units.y)}`, "rms", promised(result.is_beyond)]]} />;
}

/** What the promised error is. */
const promised = (isBeyond: boolean) => (isBeyond
  ? "is the least error to expect: the voltage leaves what was recorded"
  : "promised error, from the errors of the model on its records");

/** The errors on the plant: one verdict, then the numbers. */
function Proven({ answer }: { answer: Answer }) {
  const { units, on_plant, smoothing, is_beyond } = answer.result;
  const { plant, gain, compensated, line, spread, notes }: OnPlant = on_plant;
  const of = unit(units.y);
  const on = spokenPlant(plant);
  const [low, high] = [spread?.[0] ?? 0, spread?.[1] ?? 0].map((error) => rough(error, 3));
  // Without standard errors of the parameters all stand-ins are one.
  const isSpread = spread !== null && low !== high;
  // A twin is another actuator, and promises nothing.
  const isBeyond: boolean = smoothing != null || is_beyond;
  const source = isBeyond ? "beyond what was measured: error on" : spread ? "promised error, from" : "error on";
  const isBetter = compensated.rmse < gain.rmse && !isBeyond;
  const row = (name: string, errors: Errors) => [name, rough(errors.rmse), rough(errors.max_abs), rough(errors.rms_pp_percent)];
  return (
    <>
      <p class={isBetter ? "verdict" : "verdict poor"} role="status">
        On {on}, the error goes from <b>{rough(gain.rmse)}&nbsp;{of}</b> rms with the best constant gain to{" "}
        <b>{rough(compensated.rmse)}&nbsp;{of}</b> with the compensated voltage.{smoothing && ` ${beyondMeasured(smoothing, units.u)}`}
      </p>
      <Numbers rows={[
        [`${rough(compensated.rmse)} ${of}`, "rms", `${source} ${on}${isSpread ? `; ${low} to ${high} ${of} in 8 of 10 random stand-ins, its spread and no confidence interval` : ""}`],
      ]} />
      <p class="help">Errors {compensated.n < answer.series.get("shaped")!.length ? "in the shaded part of the path" : "over the whole path"}, without their mean:</p>
      <Table caption="Errors on the plant" head={["Voltage", `rms [${of}]`, `Largest [${of}]`, "% of height"]}
        rows={[row("best constant gain", gain), row("compensated", compensated)]} />
      {line && <p class="help">{constantGain(line, unit(units.u), of)}</p>}
      <Notes title="" notes={notes} />
      <details>
        <summary>How errors count</summary>
        <p class="help">
          An error is the path less the displacement, against the path after smoothing and shaping. On a path that repeats, the past of the actuator
          shows before the shaded part; the mean depends on the zero of the sensor and on the past. The error that is promised without a plant comes from the records instead.
          Moves in time count whole periods, with the mean and the lag.
        </p>
      </details>
    </>
  );
}

/** The best constant gain in words. */
const constantGain = ({ gain, offset, lead }: NonNullable<OnPlant["line"]>, u: string, y: string): string =>
  `The best constant gain for this path, by the model: ${rough(gain, 3)} ${u}/${y}, offset ${rough(offset, 3)} ${u}, ${lead > 0 ? `${si(lead, "s")} ahead of the path` : "without a lead"}.`;

/** Numbers that are read first: the value, what it is, and where it comes from. */
const Numbers = ({ rows }: { rows: [string, string, string][] }) => (
  <dl class="readings">
    {rows.map(([value, of, name]) => (
      <div key={name}>
        <dt>{name}</dt>
        <dd>{value} <small>{of}</small></dd>
      </div>
    ))}
  </dl>
);

/** What the voltage uses of its limits and of the records. */
function Used({ model, answer: { result }, smooth }: { model: any; answer: Answer; smooth(seconds: number): void }) {
  const { usage, smoothing, is_beyond, notes, units } = result;
  const known = recorded(model);
  const u = unit(units.u);
  const { low, high, slew, current } = { low: usage.lowest.limit, high: usage.highest.limit, slew: usage.slew.limit, current: usage.current };
  const isWithin = known && usage.slew.value <= known.slew && usage.lowest.value >= known.u[0] && usage.highest.value <= known.u[1];
  const records = known && { Voltage: `${short(known.u[0])} to ${short(known.u[1])} ${u}`, Rate: `${short(known.slew)} ${u}/s` };
  /** What is used, of its limit, or of what was recorded where none is set. */
  const row = (name: string, uses: string, isLimited: boolean, recorded?: string, isBeyond = false) => (
    <div key={name}>
      <dt>{name}</dt>
      <dd class={isBeyond ? "bad" : ""}>
        uses {uses}{recorded && (isBeyond ? `, beyond the recorded ${recorded}` : isLimited ? <small> recorded {recorded}</small> : ` of the recorded ${recorded}`)}
      </dd>
    </div>
  );
  return (
    <Section title="Voltage">
      <dl class="errors" aria-label="What the voltage uses of its limits">
        {row("Voltage", voltageUse(usage, units.u), low !== null || high !== null, records?.Voltage, is_beyond && !smoothing)}
        {row("Rate", `${short(usage.slew.value)} ${u}/s${slew === null ? "" : ` of ${short(slew)} ${u}/s`}`, slew !== null, records?.Rate, smoothing != null)}
        {current && row("Current", `${si(current.value, "A")}${current.limit === null ? "" : ` of ${si(current.limit, "A")}`}`, true)}
      </dl>
      {isWithin && <p class="help">Within what was measured.</p>}
      <Smoothing seconds={smoothing?.smooth} rms={smoothing?.rms && `${rough(smoothing.rms)} ${unit(units.y)}`} smooth={smooth} />
      {(notes ?? []).length > 0 && (
        <details open={smoothing != null && smoothing.smooth === null}>
          <summary>Notes</summary>
          <Notes title="" notes={notes} />
        </details>
      )}
    </Section>
  );
}

/** The smoothing that the library advises, at a press of a button. */
const Smoothing = ({ seconds, rms, smooth }: { seconds: number | null | undefined; rms?: string | undefined; smooth(seconds: number): void }) =>
  seconds ? (
    <div class="row">
      <button type="button" onClick={() => smooth(seconds)}>Smooth the path over {si(seconds, "s")}</button>
      {rms && <small>keeps the rate within that of the records; the path then differs by {rms} rms</small>}
    </div>
  ) : null;

/** The file of the voltage, what it begins from, and where to go from here. */
function Next({ answer, current }: { answer: Answer; current: boolean }) {
  const { workspace } = useShared();
  const u = answer.series.get("u")!;
  const of = unit(answer.result.units.u);
  const records = workspace.project.records.length;
  return (
    <Section title="Next">
      <div class="row">
        {answer.files.map((one) => (
          <button key={one.name} type="button" class="main" disabled={!current} onClick={() => download(one.name, one.bytes as BlobPart, "text/csv")}>
            Download {one.name}
          </button>
        ))}
        <a class="button" href="#export">Export the compensation</a>
        {records > 0 && <a class="button" href="#control">Compare controllers</a>}
      </div>
      <p class="help">
        The voltage begins at {short(u[0] ?? 0)} {of} and ends at {short(u.at(-1) ?? 0)} {of}, for an actuator that has rested at its beginning. Go there
        slowly and wait before it is played; on a path that repeats, the first period is worse than the next ones.
      </p>
    </Section>
  );
}
