// A single signal by its kind: its form, and the signal itself.

import { Form } from "./form.tsx";
import { type Lists, type OptionRow, optionsOf } from "./lists.ts";
import type { Answer } from "./packet.ts";
import type { Options } from "./project.ts";
import { type Outcome, useOutcome, useShared } from "./ui.tsx";
import { spoken } from "./words.ts";

const kindOf = (lists: Lists, values: Options) => lists.excitations.find((one) => one.name === (values["kind"] ?? "sine"));

/** Options of a voltage as those of a displacement in a unit. */
export const inUnit = (rows: OptionRow[], of: string): OptionRow[] =>
  rows.map((row) =>
    row.unit === "V" ? { ...row, unit: of, help: row.help.replaceAll("voltage", "displacement").replaceAll("Voltage", "Displacement") } : row);

/** All options of a signal of the chosen kind; of a displacement in the unit `of`, those that it has. */
function rowsOf(lists: Lists, values: Options, of?: string): OptionRow[] {
  const kind = kindOf(lists, values);
  const choices = lists.excitations.map(({ name, summary }): [string, string] => [name, summary]);
  const [first, ...common] = optionsOf(lists, "excite");
  const own = of ? inUnit(kind?.options ?? [], of) : (kind?.options ?? []);
  const others = common.filter((row) => !of || row.name === "ts" || row.name === "duration");
  return [{ ...first!, kind: "choice", choices, list: "", help: kind?.summary ?? "" }, ...own, ...others];
}

/** The fields of a signal, or of a displacement in the unit `of`. What another kind does not have is dropped with the kind. */
export function SignalForm({ values, change, of }: { values: Options; change(values: Options): void; of?: string }) {
  const { lists } = useShared();
  const rows = rowsOf(lists, values, of);
  const changed = (next: Options) => {
    const known = [...rowsOf(lists, next, of).map((row) => row.name), "unit"];
    change(Object.fromEntries(Object.entries(next).filter(([name]) => known.includes(name))));
  };
  const own = kindOf(lists, values)?.options.filter((row) => row.required || !row.usual) ?? [];
  return (
    <Form rows={rows} values={values} change={changed}
      first={["kind", ...own.map((row) => row.name), "ts", "duration"]} />
  );
}

/** The signal, made anew after each change; `lacks` names what must be given first. */
export function useSignal(values: Options | undefined): Outcome<Answer> & { lacks: string[] } {
  const { workspace, lists } = useShared();
  const needed = values ? rowsOf(lists, values).filter((row) => row.required && !(row.name in values)) : [];
  const key = `excite ${JSON.stringify(values)}`;
  const result = useOutcome(values && needed.length === 0 ? key : undefined, () =>
    workspace.answer(key, () => ({ name: "signal", request: { call: "excite", options: values! }, files: [] })));
  return { ...result, lacks: needed.map((row) => spoken(row.name)) };
}
