// Drives tried on a simulated actuator: its records go to the project.

import { Form } from "../form.tsx";
import { optionsOf } from "../lists.ts";
import type { File } from "../packet.ts";
import type { Options, Use } from "../project.ts";
import { Fault, Notes, Section, useKept, useSettings, useShared } from "../ui.tsx";

/** What the records of these drives are used for; of all others, training. */
const USES: Record<string, Use> = { small: "small-signal", path: "validation" };

/** What became of the records. */
interface Tried {
  plant: string;
  count: number;
  /** Limits that were reached. */
  reached: string[];
}

export function Twin({ drives, files }: { drives: { name: string; file: string }[]; files: File[] }) {
  const { workspace, lists } = useShared();
  const [values, change] = useSettings("twin");
  const plant = String(values["plant"] ?? "pl140");
  const tried = useKept<Tried>("twin", values);
  const rows = optionsOf(lists, "simulate")
    .filter((row) => row.name === "plant" || row.name === "seed")
    .map((row) => (row.name === "plant" ? { ...row, help: "The actuator that is simulated" } : row));
  const measure = async (): Promise<Tried> => {
    const made: { file: File; use: Use }[] = [];
    const reached: string[] = [];
    for (const { name, file } of drives) {
      const drive = files.find((one) => one.name === file);
      if (!drive) throw new Error(`the plan lacks its file ${file}`);
      const record = await workspace.run({ name: `twin: ${name}`, request: asked(values, file), files: [drive] });
      const [written] = record.files;
      if (!written) throw new Error(`the twin gave no record of ${file}`);
      made.push({ file: { name: `${plant}-${name}.csv`, bytes: written.bytes }, use: USES[name] ?? "training" });
      if (record.result.reached) reached.push(`${name}: ${record.result.reached}`);
    }
    await workspace.addRecords(made, false);
    return { plant, count: made.length, reached };
  };
  const { value } = tried;
  return (
    <Section title="Try it on a twin" wide help="A simulated actuator follows every drive. Its records are added to the project, each with its use.">
      <Form rows={rows} values={values} change={change} names={{ plant: lists.plants }} />
      <div class="row">
        <button type="button" class="main" disabled={tried.busy} onClick={() => tried.start(measure)}>Measure the twin</button>
      </div>
      <Fault text={tried.error} />
      {value && (
        <p role="status">
          {value.count} records of the twin {value.plant} are in the project: <a href="#data">Data</a>
        </p>
      )}
      {value && <Notes title="Limits reached" notes={value.reached} />}
    </Section>
  );
}

const asked = (options: Options, file: string) => ({ call: "simulate", options, files: { input: [file] } });
