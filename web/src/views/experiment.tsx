// Experiment: the drives of an identification within the limits of a driver, tried on a twin; and single signals.

import { useMemo } from "preact/hooks";
import { samplesOf, type Signal, spectrumFigure, timeFigure, type Usage, type Use, voltageUse } from "../drive.ts";
import { Form } from "../form.tsx";
import { optionsOf } from "../lists.ts";
import type { Answer } from "../packet.ts";
import { short, si } from "../plot/ticks.ts";
import type { Options } from "../project.ts";
import { SignalForm, useSignal } from "../signal.tsx";
import { Chart, Download, Fault, Notes, Section, Stale, Table, TextFile, useKept, useSettings, useShared } from "../ui.tsx";
import { Instrument } from "./instrument.tsx";
import { Twin } from "./twin.tsx";

/** A drive of the plan. */
interface Drive {
  name: string;
  file: string;
  purpose: string;
  duration: number;
  percent: number;
  usage: Usage;
}

/** Where the forms begin: the bender of the examples. */
const PLAN: Options = { actuator: "pl140", bandwidth: 80, driver: "pl140" };
const SIGNAL: Options = { kind: "sine", amplitude: 10, frequency: 10, ts: 5e-4, duration: 0.5 };

export function ExperimentView() {
  const { workspace, lists } = useShared();
  const { settings, model } = workspace.project;
  const [, change] = useSettings("plan");
  const [{ advise = true, drive }, choose] = useSettings("experiment");
  const options = settings["plan"] ?? PLAN;
  const advised = model !== undefined && advise === true;
  const request = { call: "plan", options, ...(advised && { files: { model: [model] } }) };
  const outcome = useKept<Answer>("plan", request);
  const plan = async () => workspace.run({ name: "plan", request, files: advised ? [await workspace.file(model)] : [] });
  return (
    <>
      <Section title="Plan" wide help="The records that an identification needs, as drives that the driver can follow.">
        <Form rows={optionsOf(lists, "plan")} values={options} change={change}
          first={["actuator", "range", "bandwidth", "driver"]} />
        {model && (
          <div class="row"><label>
            <input type="checkbox" checked={advised} onChange={(event) => choose({ ...settings["experiment"], advise: event.currentTarget.checked })} />
            Advise what to measure next for the model {model}
          </label></div>
        )}
        <div class="row">
          <button type="button" class="main" disabled={outcome.busy} onClick={() => outcome.start(plan)}>Plan</button>
        </div>
        <Fault text={outcome.error} />
      </Section>
      {outcome.value && (
        <Drives answer={outcome.value} stale={outcome.stale} bandwidth={Number(options["bandwidth"])} chosen={String(drive ?? "")}
          choose={(name) => choose({ ...settings["experiment"], drive: name })} />
      )}
      <OneSignal />
    </>
  );
}

interface DrivesProps {
  answer: Answer;
  stale: boolean;
  bandwidth: number;
  chosen: string;
  choose(name: string): void;
}

function Drives({ answer, stale, bandwidth, chosen, choose }: DrivesProps) {
  const { lists } = useShared();
  const { result, series, files } = answer;
  const drives: Drive[] = result.drives;
  const shown = drives.find((drive) => drive.name === chosen) ?? drives[0];
  const [time, spectrum] = useMemo(() => {
    if (!shown) return [];
    const signal: Signal = { name: shown.name, ...samplesOf(series, shown.name), ts: result.ts, unit: "V", usage: shown.usage };
    return [timeFigure(signal), spectrumFigure(signal, bandwidth)];
  }, [answer, shown, bandwidth]);
  const rows = drives.map((drive) => [
    <button type="button" class="link" aria-pressed={drive === shown} onClick={() => choose(drive.name)}>{drive.name}</button>,
    drive.purpose,
    si(drive.duration, "s"),
    `${short(drive.percent)} %`,
    <Voltage usage={drive.usage} />,
    <Share use={drive.usage.slew} />,
    <Share use={drive.usage.current} />,
    <Download files={files.filter((file) => file.name === drive.file)} />,
  ]);
  const page = files.find((file) => file.name === "plan.md");
  return (
    <>
      <Section title="Drives" wide help={`Sampled every ${si(result.ts, "s")}. The bars are shares of the limits of the driver.`}>
        <Stale stale={stale} />
        <Notes title="" notes={result.advice ? [result.advice] : []} />
        <Table caption="Drives of the plan" head={["Drive", "Purpose", "Duration", "Of limits", "Uses voltage", "Uses slew", "Uses current", "File"]}
          rows={rows} marked={shown ? drives.indexOf(shown) : -1} />
        <div class="row">
          <Download files={files} archive="plan.zip" title="Download all as zip" />
          {page && <Download files={[page]} title="Download plan.md" />}
        </div>
        <Notes title="Notes" notes={result.notes ?? []} />
        {page && <details><summary>The plan in words</summary><TextFile file={page} /></details>}
      </Section>
      {time && spectrum && (
        <Section title={`Drive ${shown?.name}`} wide>
          <div class="pair"><Chart figure={time} /><Chart figure={spectrum} /></div>
        </Section>
      )}
      <Twin drives={drives} files={files} />
      {lists.operations.some(({ name }) => name === "acquire") && <Instrument drives={drives} files={files} chosen={shown?.name ?? ""} />}
    </>
  );
}

/** What is used of a limit, as words and as a bar. */
function Share({ use }: { use: Use | null }) {
  if (!use) return <>{"\u2013"}</>;
  return (
    <span class="share">
      {si(use.value, use.unit)}{use.limit !== null && ` of ${si(use.limit, use.unit)}`}
      {use.share === null ? <small>no limit</small> : <Bar share={use.share} />}
    </span>
  );
}

/** The span of a voltage, and the larger of its two shares. */
function Voltage({ usage }: { usage: Usage }) {
  const { lowest, highest } = usage;
  const shares = [lowest.share, highest.share].filter((share) => share !== null);
  return (
    <span class="share">
      {voltageUse(usage)}
      {shares.length === 0 ? <small>no limit</small> : <Bar share={Math.max(...shares)} />}
    </span>
  );
}

const Bar = ({ share }: { share: number }) => (
  <small>
    <i class={share > 1 ? "gauge over" : "gauge"} aria-hidden="true" style={{ "--share": String(Math.min(1, Math.max(0, share))) }} />
    {short(Number((100 * share).toPrecision(2)))} %
  </small>
);

function OneSignal() {
  const { workspace } = useShared();
  const [, change] = useSettings("excite");
  const values = workspace.project.settings["excite"] ?? SIGNAL;
  const outcome = useSignal(values);
  const [time, spectrum] = useMemo(() => {
    if (!outcome.value) return [];
    const { result, series } = outcome.value;
    const signal: Signal = { name: String(values["kind"] ?? "sine"), ...samplesOf(series, "u"), ...result };
    return [timeFigure(signal), spectrumFigure(signal)];
  }, [outcome.value]);
  const { clipped, usage } = outcome.value?.result ?? {};
  return (
    <Section title="A single signal" wide help="A drive signal in V, or a reference in a unit of displacement.">
      <SignalForm values={values} change={change} />
      <Fault text={outcome.error} />
      {outcome.lacks.length > 0 && <p class="missing">Give {outcome.lacks.join(", ")}.</p>}
      {time && spectrum && outcome.lacks.length === 0 && (
        <div class="pair"><Chart figure={time} height={240} /><Chart figure={spectrum} height={240} /></div>
      )}
      {usage && (
        <Table caption="What the signal uses of the limits" head={["Voltage", "Slew", "Current"]}
          rows={[[<Voltage usage={usage} />, <Share use={usage.slew} />, <Share use={usage.current} />]]} />
      )}
      {clipped > 0 && <p>{clipped} samples are clipped to the limits.</p>}
      {outcome.value && outcome.lacks.length === 0 && <div class="row"><Download files={outcome.value.files} title="Download signal.csv" /></div>}
    </Section>
  );
}
