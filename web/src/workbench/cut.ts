// The part of a record that is used, which two handles bound.

import { whole } from "../alike.ts";
import type { Handle } from "../plot/figure.ts";
import type { RecordEntry } from "../project.ts";

/** The handles of a record of a duration [s]. */
export function cutHandles(entry: RecordEntry, duration: number, tell: (entry: RecordEntry, passing: boolean) => void): Handle[] {
  const [first, last] = [Number(entry.columns["from"] ?? 0), Number(entry.columns["to"] ?? duration)];
  const moved = (end: "from" | "to") => (x: number, _: number, done: boolean) => {
    const at = Number(Math.max(0, Math.min(duration, x)).toPrecision(6));
    const [from, to] = end === "from" ? [Math.min(at, last), last] : [first, Math.max(at, first)];
    const { columns, ...others } = whole(entry);
    tell({ ...others, columns: { ...columns, ...(from > 0 && { from }), ...(to < duration && { to }) } }, !done);
  };
  return [
    { label: "Start of the part that is used [s]", x: first, y: 0, moves: "x", moved: moved("from") },
    { label: "End of the part that is used [s]", x: last, y: 0, moves: "x", moved: moved("to") },
  ];
}
