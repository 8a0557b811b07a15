// Drives tried on a simulated actuator: its records go to the project.

import { Form } from "../form.tsx";
import { optionsOf } from "../lists.ts";
import { Fault, Notes, Section, useKept, useSettings, useShared } from "../ui.tsx";
import { type Drives, measured } from "./measured.ts";

/** What became of the records. */
interface Tried {
  plant: string;
  count: number;
  /** Limits that were reached. */
  reached: string[];
}

export function Twin({ drives, files }: Drives) {
  const { workspace, lists } = useShared();
  const [values, change] = useSettings("twin");
  const plant = String(values["plant"] ?? "pl140");
  const tried = useKept<Tried>("twin", values);
  const rows = optionsOf(lists, "simulate")
    .filter((row) => row.name === "plant" || row.name === "seed")
    .map((row) => (row.name === "plant" ? { ...row, help: "The actuator that is simulated" } : row));
  const measure = async (): Promise<Tried> => {
    const reached: string[] = [];
    const count = await measured(workspace, { drives, files }, plant, async (name, file) => {
      const request = { call: "simulate", options: values, files: { input: [file.name] } };
      const answer = await workspace.run({ name: `twin: ${name}`, request, files: [file] });
      if (answer.result.reached) reached.push(`${name}: ${answer.result.reached}`);
      return answer;
    });
    return { plant, count, reached };
  };
  const { value } = tried;
  return (
    <Section title="Try it on a twin" wide help="A simulated actuator follows every drive. Its records are added to the project, each with its use.">
      <Form rows={rows} values={values} change={change} />
      <div class="row">
        <button type="button" class="main" disabled={tried.busy} onClick={() => tried.start(measure)}>Measure the twin</button>
      </div>
      <Fault text={tried.error} />
      {value && (
        <p role="status">
          {value.count} records of the twin {value.plant} are in the project: <a href="#workbench">Workbench</a>
        </p>
      )}
      {value && <Notes title="Limits reached" notes={value.reached} />}
    </Section>
  );
}
