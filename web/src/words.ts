// The words of the library as the page says them.

import type { Lists } from "./lists.ts";
import { prose } from "./plot/ticks.ts";

/** Options whose names are short for something. */
const LONG: Record<string, string> = {
  ts: "sampling period",
  fs: "sampling rate",
  time_col: "role time",
  input_col: "role input",
  output_col: "role output",
  from: "start",
  to: "end",
  low: "lowest voltage",
  high: "highest voltage",
  late: "samples late",
  zvd: "ZVD shaper",
};

/** The label of an option. */
export function spoken(name: string): string {
  const words = LONG[name] ?? name.replaceAll("_", " ");
  return words.charAt(0).toUpperCase() + words.slice(1);
}

/** A sentence of the library: the options that it asks for are called by their labels, and what it quotes stands in
 * quotation marks. */
export function worded(told: string, lists: Lists): string {
  const text = told.replace(/ \(see `piezoid [a-z]+`\)/g, "");
  const all = [...lists.calls, ...lists.excitations, { options: lists.columns }].flatMap(({ options }) => options);
  const label = (name: string) => (all.some((row) => row.name === name) ? spoken(name) : name);
  const quoted = (part: string, called: (name: string) => string) => part.replace(/`([^`]*)`/g, (_, name) => `\u201c${called(name)}\u201d`);
  const named = prose(text).replace(/(^|: )([a-z_]+)(?= = )/g, (_, before, name) => before + label(name));
  // Before what it asks for, it quotes names of columns.
  const [first, ...asked] = named.split(/(?<= give )(?=`)/);
  return quoted(first!, (name) => name) + quoted(asked.join(""), label);
}
