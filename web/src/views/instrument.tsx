// Drives measured on a controller in the network.

import { useState } from "preact/hooks";
import { Form } from "../form.tsx";
import { optionsOf } from "../lists.ts";
import { Fault, Notes, Section, useKept, useSettings, useShared } from "../ui.tsx";
import { worded } from "../words.ts";
import { those, useController } from "./controller.tsx";
import { type Drives, measured } from "./measured.ts";

interface Props extends Drives {
  /** The drive that is shown. */
  chosen: string;
}

export function Instrument({ drives, files, chosen }: Props) {
  const { workspace, lists } = useShared();
  const [values, change] = useSettings("instrument");
  const controller = useController("controller", values);
  const result = useKept<number>("instrument", values, true);
  // What was said of drives that were measured, also if a later one failed.
  const [notes, setNotes] = useState<string[]>([]);
  // Where the axis was left.
  const [left, setLeft] = useState<string>();
  const measure = (expected: string[]) => async () => {
    setNotes([]);
    setLeft(undefined);
    const some = drives.filter(({ name }) => expected.includes(name));
    return measured(workspace, { drives: some, files }, "measured", async (drive, file) => {
      const request = { call: "acquire", options: those(lists, "acquire", values), files: { drive: [file.name] } };
      const answer = await workspace.run({ name: `measure: ${drive}`, request, files: [file] });
      if (!answer.result.unfinished) setLeft(answer.result.state);
      setNotes((before) => [...before, ...answer.result.notes.map((note: string) => `${drive}: ${note}`)]);
      return answer;
    });
  };
  const busy = controller.busy || result.busy;
  return (
    <Section title="Measure on a controller" wide
      help="A controller plays the drives in open loop and records. The actuator moves. Cancel stops the wave; the voltage then stays where it is, and is shown here.">
      <Form rows={optionsOf(lists, "acquire")} values={values} change={change} first={["host", "port", "axis", "driver", "rest"]} />
      <div class="row">
        {controller.button(busy)}
        <button type="button" disabled={busy || !chosen} onClick={() => result.start(measure([chosen]))}>Measure {chosen}</button>
        <button type="button" class="main" disabled={busy} onClick={() => result.start(measure(drives.map(({ name }) => name)))}>
          Measure all drives
        </button>
      </div>
      {controller.report}
      <Fault text={result.error} />
      {result.value && (
        <p role="status">
          {result.value === 1 ? "1 record is" : `${result.value} records are`} in the project: <a href="#workbench">Workbench</a>
        </p>
      )}
      {left && !busy && <p role="status">{worded(left, lists)}</p>}
      <Notes title="Notes" notes={notes} />
    </Section>
  );
}
