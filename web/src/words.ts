// The words of the library as the page says them.

import type { Lists, OptionRow } from "./lists.ts";
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
  delay_samples: "sensor delay in samples",
  zvd: "ZVD shaper",
};

/** The label of an option. */
export function spoken(name: string): string {
  const words = LONG[name] ?? name.replaceAll("_", " ");
  return words.charAt(0).toUpperCase() + words.slice(1);
}

/** A text of the library: options, which stand in braces, are called by their labels, and what it quotes stands in
 * quotation marks. */
export function worded(text: string, lists: Lists): string {
  const all = [...lists.operations, ...lists.excitations, { options: lists.columns }].flatMap(({ options }) => options);
  const label = (name: string) => (all.some((row) => row.name === name) ? spoken(name) : name);
  return prose(text).replace(/\{([a-z_]+)\}/g, (_, name) => label(name)).replace(/`([^`]*)`/g, "\u201c$1\u201d");
}

/** The help of an option: other options, in braces, are called by their labels. */
export const helpOf = (row: OptionRow): string =>
  row.help.replace(/\{([a-z_]+)\}/g, (_, name) => (name === "list" ? "the list" : `\u201c${spoken(name)}\u201d`)).replaceAll("`", "");
