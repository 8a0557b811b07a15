// Control: schemes of feed-forward and feedback along references, on a simulated plant.

import { useMemo } from "preact/hooks";
import { reading } from "../compensate/request.ts";
import { Form } from "../form.tsx";
import { optionsOf } from "../lists.ts";
import { ModelChoice, withRecorded } from "../models.tsx";
import type { Answer } from "../packet.ts";
import { withSchemes } from "../pick.tsx";
import type { ModelEntry } from "../project.ts";
import { short } from "../plot/ticks.ts";
import { ReferenceForm, useReference } from "../reference.tsx";
import { AboutPlant, type Plant, PlantChoice, spokenPlant, usePlant, withoutPlant } from "../stand-in.tsx";
import { feedbacks, runsFigure, type Scheme, type Reference } from "../schemes.ts";
import { Chart, Choice, Download, Fault, Missing, Notes, Section, Stale, Table, useKept, useModel, useSettings, useShared } from "../ui.tsx";

/** What came of a comparison. */
interface Compared {
  answer: Answer;
  /** Sampling period [s]. */
  ts: number;
  /** The model that the schemes were tuned to. */
  model: string;
}

export function ControlView() {
  const { model, models } = useShared().workspace.project;
  const entry = models.find(({ file }) => file === model);
  if (!entry) return <Missing what="Controllers are tuned to a model, and there is none yet." title="Identify" />;
  return <Comparison key={entry.file} entry={entry} />;
}

function Comparison({ entry }: { entry: ModelEntry }) {
  const { workspace, lists } = useShared();
  const { file: model } = entry;
  const plant = usePlant(entry);
  const [settings, change] = useSettings("control");
  const options = withoutPlant(settings);
  const document = useModel();
  const ts: number = document.value?.ts ?? 5e-4;
  const start = { kind: "triangle", unit: document.value?.units?.y ?? "um", frequency: 5, duration: 1, ts };
  const reference = useReference("control", start);
  const result = useKept<Compared>(`control ${model}`, [options, reference.key, plant?.key]);
  const compare = async (plant: Plant): Promise<Compared> => {
    const files = await reference.files();
    const request = { call: "control", options, files: { model: [model], reference: files.map((file) => file.name) }, ...files.map(reading)[0] };
    const answer = await workspace.run({ name: "control", ...(await plant.on(request, [await workspace.file(model), ...files])) });
    return { answer, ts, model };
  };
  const feedForwards = lists.controllers.filter(({ name }) => name === "feed-forward" || name === "learning");
  const both = feedbacks(lists);
  const pairs = both.map(({ name, summary }) => ({ name: `feed-forward+${name}`, summary: `the inverse of the model, and: ${summary}` }));
  return (
    <>
      <Section title="Comparison" help="Schemes are tuned to the model, and drive a plant that is not the model." wide>
        <ModelChoice />
        <PlantChoice entry={entry} />
        <AboutPlant entry={entry} />
        <Form rows={withRecorded(optionsOf(lists, "control").filter(({ name }) => name !== "plant"), document.value, options)} values={options} change={change}
          names={{
            controller: withSchemes([...feedForwards, ...both, ...pairs]),
            reference: lists.references.map(({ name, summary }) => ({ name: `${name}:5`, summary: `${summary}; 5 Hz` })),
          }}
          first={["controller", "reference", "amplitude", "noise", "driver"]} open={["controller"]} />
        <ReferenceForm reference={reference} label="In place of the named references" none="none" />
        <div class="row">
          <button type="button" class="main" disabled={result.busy || !document.value || !plant} onClick={() => plant && result.start(() => compare(plant))}>Compare</button>
        </div>
        <Fault text={result.error ?? document.error} />
      </Section>
      {result.value && <Result {...result.value} stale={result.stale} />}
    </>
  );
}

function Result({ answer, ts, model, stale }: Compared & { stale: boolean }) {
  const { result, files } = answer;
  const [{ reference }, choose] = useSettings("control-shown");
  const references: Reference[] = result.references;
  const schemes: Scheme[] = result.schemes;
  const fed = schemes.filter((one) => one.margins);
  const at = Math.max(0, references.findIndex((one) => one.name === reference));
  const target = references[at]!;
  const figure = useMemo(() => runsFigure(answer, at, ts), [answer, at]);
  const notes = schemes.flatMap(({ scheme, tracking }) => (tracking[at]?.notes ?? []).map((note) => `${scheme}: ${note}`));
  return (
    <>
      <Section title="Errors" wide help="Root mean square of the error, reference less displacement, in % of the height of the reference. “gain” is the best constant gain, with a shift in time. The smallest of each column is bold; a dash marks a refused run.">
        <Stale stale={stale} />
        <p>Tuned to the model {model}; played on {spokenPlant(result.plant)}{result.plant === "stand-in" ? " for its actuator" : ", which is another actuator unless the records are of it"}.</p>
        <Table caption="Errors by scheme and reference" head={["Scheme", ...references.map(({ name }) => name)]} rows={errors(schemes)} />
        <Notes title="Remarks" notes={result.remarks ?? []} />
        <div class="row"><Download files={files} title="Download control.html" /></div>
      </Section>
      {fed.length > 0 && (
        <Section title="Margins" wide help="Of the schemes with feedback, as they are tuned to the model.">
          <Table caption="Margins by scheme" head={["Scheme", "Gain margin", "Phase margin", "Peak", "Bandwidth", "Least bandwidth"]} rows={margins(fed)} />
        </Section>
      )}
      {schemes.some((one) => one.tolerance) && (
        <Section title="Random plants" wide help="Errors on plants whose parameters differ from those of the plant, along the first reference.">
          <Table caption="Errors on random plants" head={["Scheme", "Plants", "Unstable", "Median error", "Largest error"]} rows={spreads(schemes)} />
        </Section>
      )}
      <Section title="Along a reference" wide>
        <Choice label="Reference that is shown" names={references.map(({ name }) => name)} chosen={target.name} choose={(name) => choose({ reference: name })} />
        <Chart figure={figure} height={640} />
        <p class="help">The error is computed over the shaded part. Where lines coincide, the later one is dashed.</p>
        <Notes title={`Notes on ${target.name}`} notes={notes} />
      </Section>
    </>
  );
}

/** Percents of the stroke, the smallest of each reference bold. */
function errors(schemes: Scheme[]) {
  const least = schemes[0]?.tracking.map((_, j) =>
    Math.min(...schemes.map(({ tracking }) => tracking[j]?.percent_of_stroke ?? Infinity)));
  return schemes.map(({ scheme, tracking }) => [
    scheme,
    ...tracking.map(({ percent_of_stroke: percent, refused }, j) => {
      if (percent === undefined) return <span title={refused}>{"\u2013"}</span>;
      const text = short(Number(percent.toPrecision(3)));
      return percent === least?.[j] ? <strong>{text}</strong> : text;
    }),
  ]);
}

const values = (value: number | null | undefined, of = ""): string => (value == null ? "\u2013" : short(value) + of);

const margins = (schemes: Scheme[]) =>
  schemes.map(({ scheme, margins: m, least_bandwidth_hz: least }) => [
    m && !m.stable ? `${scheme} (unstable)` : scheme,
    values(m?.gain_db, " dB"), values(m?.phase_deg, "\u00b0"), values(m?.peak), values(m?.bandwidth_hz, " Hz"), values(least, " Hz"),
  ]);

const spreads = (schemes: Scheme[]) =>
  schemes.flatMap(({ scheme, tolerance }) => {
    if (!tolerance) return [];
    const sorted = [...tolerance.percent_of_stroke].sort((a, b) => a - b);
    const median = sorted[sorted.length >> 1];
    return [[scheme, String(tolerance.draws), values(tolerance.unstable), values(median, " %"), values(sorted.at(-1), " %")]];
  });
