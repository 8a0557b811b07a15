// Drives measured on a controller in the network, which `piezoid serve` reaches and a browser alone does not.

import { useState } from "preact/hooks";
import { Form } from "../form.tsx";
import { optionsOf } from "../lists.ts";
import type { Answer } from "../packet.ts";
import { short, si, unit as unitOf } from "../plot/ticks.ts";
import { Fault, Notes, Section, Table, useKept, useSettings, useShared } from "../ui.tsx";
import { worded } from "../words.ts";
import { type Drives, measured } from "./measured.ts";

interface Axis {
  name: string;
  unit: string;
  servo: boolean | null;
  position: number | null;
  voltage: number | null;
  range: [number, number] | null;
}

interface Props extends Drives {
  /** The drive that is shown. */
  chosen: string;
}

export function Instrument({ drives, files, chosen }: Props) {
  const { workspace, lists } = useShared();
  const [values, change] = useSettings("instrument");
  // The settings may be of an older version, with other options.
  const those = (call: "controller" | "acquire") =>
    Object.fromEntries(optionsOf(lists, call).filter(({ name }) => name in values).map(({ name }) => [name, values[name]]));
  const connection = { call: "controller", options: those("controller") };
  const requested = useKept<Answer>("controller", connection);
  const result = useKept<number>("instrument", values);
  // What was said of drives that were measured, also if a later one failed.
  const [notes, setNotes] = useState<string[]>([]);
  // Where the axis was left.
  const [left, setLeft] = useState<string>();
  const ask = async () => workspace.run({ name: "controller", request: connection, files: [] });
  const measure = (expected: string[]) => async () => {
    setNotes([]);
    setLeft(undefined);
    const some = drives.filter(({ name }) => expected.includes(name));
    return measured(workspace, { drives: some, files }, "measured", async (drive, file) => {
      const request = { call: "acquire", options: those("acquire"), files: { drive: [file.name] } };
      const answer = await workspace.run({ name: `measure: ${drive}`, request, files: [file] });
      if (!answer.result.unfinished) setLeft(answer.result.state);
      setNotes((before) => [...before, ...answer.result.notes.map((note: string) => `${drive}: ${note}`)]);
      return answer;
    });
  };
  const busy = requested.busy || result.busy;
  return (
    <Section title="Measure on a controller" wide
      help="A controller with PI's GCS 2.0 plays the drives in open loop and records. The actuator moves. Cancel stops the wave; the voltage then stays where it is, and is shown here.">
      <Form rows={optionsOf(lists, "acquire")} values={values} change={change} first={["host", "port", "axis", "driver", "rest"]} />
      <div class="row">
        <button type="button" disabled={busy} onClick={() => requested.start(ask)}>Query the controller</button>
        <button type="button" disabled={busy || !chosen} onClick={() => result.start(measure([chosen]))}>Measure {chosen}</button>
        <button type="button" class="main" disabled={busy} onClick={() => result.start(measure(drives.map(({ name }) => name)))}>
          Measure all drives
        </button>
      </div>
      <Fault text={requested.error} />
      {requested.value && !requested.stale && <ControllerFacts answer={requested.value} />}
      <Fault text={result.error} />
      {result.value && (
        <p role="status">
          {result.value === 1 ? "1 record is" : `${result.value} records are`} in the project: <a href="#data">Data</a>
        </p>
      )}
      {left && !busy && <p role="status">{worded(left, lists)}</p>}
      <Notes title="Notes" notes={notes} />
    </Section>
  );
}

const reported = <T,>(value: T | null, text: (value: T) => string): string => (value === null ? "not reported" : text(value));

/** What a controller says of itself. */
function ControllerFacts({ answer: { result } }: { answer: Answer }) {
  const rows = result.axes.map(({ name, unit, servo, position, voltage, range }: Axis) => [
    name,
    reported(position, (value) => si(value, unitOf(unit))),
    reported(voltage, (value) => si(value, "V")),
    reported(range, ([low, high]) => `${short(low)} to ${short(high)} V`),
    reported(servo, (on) => (on ? "on" : "off")),
  ]);
  return (
    <>
      <p role="status">{result.identity}, servo cycle {reported(result.cycle as number | null, (cycle) => si(cycle, "s"))}</p>
      {result.in_use && <p class="fault" role="alert">In use: {result.in_use}</p>}
      <Table caption="Axes of the controller" head={["Axis", "Position", "Voltage", "Limits", "Servo"]} rows={rows} />
    </>
  );
}
