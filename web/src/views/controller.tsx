// What the views share that work on a controller in the network, which `piezoid serve` reaches and a browser alone does not.

import type { CallName } from "../catalogue.ts";
import { type Lists, optionsOf } from "../lists.ts";
import type { Answer } from "../packet.ts";
import { short, si, unit as unitOf } from "../plot/ticks.ts";
import type { Options } from "../project.ts";
import { Fault, Table, useKept, useShared } from "../ui.tsx";

/** The options of a call among settings, which may be of an older version with other options. */
export const those = (lists: Lists, call: CallName, values: Options): Options =>
  Object.fromEntries(optionsOf(lists, call).filter(({ name }) => name in values).map(({ name }) => [name, values[name]]));

/** A controller that is queried: the button, and below it what it reports. `name` keeps the answers of views apart. */
export function useController(name: string, values: Options) {
  const { workspace, lists } = useShared();
  const request = { call: "controller", options: those(lists, "controller", values) };
  const { busy, error, value, stale, start } = useKept<Answer>(name, request);
  const ask = () => start(async () => workspace.run({ name: "controller", request, files: [] }));
  return {
    busy,
    button: (disabled: boolean) => <button type="button" disabled={disabled || busy} onClick={ask}>Query the controller</button>,
    report: (
      <>
        <Fault text={error} />
        {value && !stale && <ControllerFacts answer={value} />}
      </>
    ),
  };
}

interface Axis {
  name: string;
  unit: string;
  servo: boolean | null;
  position: number | null;
  voltage: number | null;
  range: [number, number] | null;
}

const reported = <T,>(value: T | null, text: (value: T) => string): string => (value === null ? "not reported" : text(value));

/** What a controller says of itself. */
function ControllerFacts({ answer: { result } }: { answer: Answer }) {
  const rows = result.axes.map(({ name, unit, servo, position, voltage, range }: Axis) => [
    name,
    reported(position, (value) => `${short(value)} ${unitOf(unit)}`),
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
