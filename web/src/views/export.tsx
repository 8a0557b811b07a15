// Export: the model, its feed-forward and its controller for another machine.

import { reading } from "../compensate/request.ts";
import { Form } from "../form.tsx";
import { optionsOf } from "../lists.ts";
import { ModelChoice, withRecorded } from "../models.tsx";
import type { Answer } from "../packet.ts";
import { short } from "../plot/ticks.ts";
import type { Options } from "../project.ts";
import { ReferenceForm, useReference } from "../reference.tsx";
import { feedbacks } from "../schemes.ts";
import { Download, Fault, Missing, Notes, Section, size, Stale, Table, TextFile, useKept, useModel, useSettings, useShared } from "../ui.tsx";

export function ExportView() {
  const { model } = useShared().workspace.project;
  if (!model) return <Missing what="A model is exported, and there is none yet." title="Identify" />;
  return <Exports key={model} model={model} />;
}

function Exports({ model }: { model: string }) {
  const { workspace, lists } = useShared();
  const [{ target, ...options }, change] = useSettings("export");
  const document = useModel();
  const operator = String(document.value?.hysteresis?.operator ?? "");
  const chosen = lists.targets.find(({ name }) => name === target) ?? lists.targets[0]!;
  const limited = lists.targets.flatMap(({ takes }) => takes);
  const taken = (name: string) => !limited.includes(name) || chosen.takes.includes(name);
  const rows = withRecorded(optionsOf(lists, "export").filter(({ name }) => name !== "target" && taken(name)), document.value, options);
  const [input, kept] = [true, false].map((expected) =>
    Object.fromEntries(Object.entries(options).filter(([name]) => taken(name) === expected)),
  ) as [Options, Options];
  const start = { kind: "sine", unit: document.value?.units?.y ?? "um", frequency: 10, duration: 0.1, ts: document.value?.ts ?? 5e-4 };
  const reference = useReference("export", start, true);
  const result = useKept<Answer>(`export ${model}`, [chosen.name, input, taken("reference") && reference.key]);
  const write = async () => {
    const files = taken("reference") ? await reference.files() : [];
    const named = { model: [model], reference: files.map((file) => file.name) };
    const request = { call: "export", options: { target: chosen.name, ...input }, files: named, ...files.map(reading)[0] };
    return workspace.run({ name: "export", request, files: [await workspace.file(model), ...files] });
  };
  return (
    <>
      <Section title="Target" wide help={`The output to write for the model${operator && `, whose operator is ${operator}`}.`}>
        <ModelChoice />
        <div class="cards" role="group" aria-label="Target">
          {lists.targets.map(({ name, summary, operators }) => {
            const makes = operators[operator] ?? [];
            return (
              <button key={name} type="button" class="card choice" aria-pressed={name === chosen.name} disabled={!!operator && makes.length === 0}
                onClick={() => change({ ...options, target: name })}>
                <b>{name}</b>
                <span>{summary}</span>
                {operator && <small>{makes.length > 0 ? `makes ${makes.join(" and ")}` : `does not serve ${operator}`}</small>}
              </button>
            );
          })}
        </div>
        <Fault text={document.error} />
      </Section>
      <Section title="Options">
        <Form rows={rows} values={input} change={(values) => change({ ...kept, ...values, ...(target !== undefined && { target }) })}
          names={{ controller: feedbacks(lists) }} first={["name", "float", "controller", "preview", "driver"]} />
        {taken("reference") && (
          <>
            <ReferenceForm reference={reference} label="Reference" none="none: a waveform needs one" />
            <p class="help">One period of the requested displacement. A path that ends where it begins repeats without a jump.</p>
          </>
        )}
        <div class="row">
          <button type="button" class="main" disabled={result.busy} onClick={() => result.start(write)}>Export as {chosen.name}</button>
        </div>
        <Fault text={result.error} />
      </Section>
      {result.value && <Result answer={result.value} stale={result.stale} />}
    </>
  );
}

/** A function of the exported code, with the operations of a sample. */
interface Written {
  function: string;
  about: string;
  operations: { mean: Record<string, number>; most_seen: number; bound: number | null };
}

function Result({ answer, stale }: { answer: Answer; stale: boolean }) {
  const { result, files } = answer;
  const [{ file: name }, choose] = useSettings("export-shown");
  const shown = files.find((file) => file.name === name) ?? files[0];
  const functions: Written[] = result.functions ?? [];
  const rows = files.map((file) => [
    <button type="button" class="link" aria-pressed={file === shown} onClick={() => choose({ file: file.name })}>{file.name}</button>,
    size(file.bytes.length),
    <Download files={[file]} />,
  ]);
  const counted = functions.map(({ function: called, about, operations: { mean, most_seen, bound } }) => [
    called,
    about,
    ...["additions", "multiplications", "divisions", "comparisons"].map((kind) => short(mean[kind] ?? NaN)),
    short(most_seen),
    bound === null ? "\u2013" : short(bound),
  ]);
  const head = ["Function", "What it does", "Additions", "Multiplications", "Divisions", "Comparisons", "Largest observed", "Upper bound"];
  return (
    <>
      <Section title="Files">
        <Stale stale={stale} />
        <Table caption="Exported files" head={["File", "Size", "Download"]} rows={rows} marked={shown ? files.indexOf(shown) : -1} />
        <div class="row"><Download files={files} archive="piezoid-export.zip" title="Download all as zip" /></div>
        <Notes title="Notes" notes={result.notes ?? []} />
      </Section>
      {counted.length > 0 && (
        <Section title="Operations per sample" wide help="Operations of one call: the mean of a test, the largest number observed in it, and an upper bound.">
          <Table caption="Operations of each function" head={head} rows={counted} />
        </Section>
      )}
      {shown && <Section title={shown.name} wide><TextFile file={shown} /></Section>}
    </>
  );
}
