// What must be said of records before a model is identified from them: roles, and units that the library does not know.

import { whole } from "../alike.ts";
import type { RecordEntry } from "../project.ts";
import { useOutcome, useShared } from "../ui.tsx";
import { worded } from "../words.ts";
import type { Workspace } from "../workspace.ts";

/** Roles by the names of their signals. */
const ROLES = { u: "input", y: "output" } as const;
type Units = Record<keyof typeof ROLES, string>;

const known = new Map<string, Promise<boolean>>();

/** True if the library knows a unit as one of a voltage or a displacement: it decides roles of columns by that. */
function isKnown(workspace: Workspace, unit: string): Promise<boolean> {
  const ask = async () => {
    const rows = [0, 1, 2, 3, 4, 5].map((k) => `${k},${k % 2},${k % 3}`);
    const bytes = new TextEncoder().encode(`t [s],"a [${unit.replace(/["[\]]/g, "")}]",b [m]\n${rows.join("\n")}\n`);
    const request = { call: "inspect", files: { data: ["unit.csv"] } };
    const { result } = await workspace.run({ name: "unit", request, files: [{ name: "unit.csv", bytes }], quiet: true });
    const [, a, b] = result.channels;
    return a?.role === "input" || b?.role !== "output";
  };
  const answer = known.get(unit) ?? ask().catch(() => known.delete(unit));
  known.set(unit, answer);
  return answer;
}

/** What stands at a record whose units the library does not know. */
export function useUnknownUnits(units: Units | undefined): string[] {
  const { workspace } = useShared();
  const unknown = async () => {
    const all = Object.entries(ROLES).map(async ([signal, role]) => {
      const unit = units![signal as keyof Units];
      return (await isKnown(workspace, unit)) ? [] : [`The unit ${unit} of the ${role} is no voltage and no displacement that piezoid knows: nothing is ` +
        `converted. State the right one below, or a factor such as ${signal === "u" ? "20V" : "5um"}/${unit}.`];
    });
    return (await Promise.all(all)).flat();
  };
  return useOutcome(units && JSON.stringify(units), unknown).value ?? [];
}

/** Why a model cannot be identified from these records as they are read, and what to do. */
export function useUndecided(entries: RecordEntry[]): string[] {
  const { workspace, lists } = useShared();
  const why = async () => {
    const [undecided, mixed]: [string[], string[]] = [[], []];
    const read: { file: string; units: Units }[] = [];
    for (const entry of entries) {
      const { result } = await workspace.inspected(whole(entry)).catch(() => ({ result: undefined }));
      if (result?.record) {
        read.push({ file: entry.file, units: result.record.units });
        continue;
      }
      const has = (role: string) => result?.channels.some((channel: { role: string | null }) => channel.role === role);
      const problem = !result ? `${entry.file} cannot be read`
        : has("input") && has("output") ? `${entry.file}: ${worded(result.problems[0] ?? "it is no record", lists)}` : `the roles of ${entry.file} are not decided`;
      undecided.push(problem);
    }
    for (const [signal, role] of Object.entries(ROLES) as [keyof Units, string][]) {
      for (const { file, units } of read) {
        const other = read.find((one) => one.units[signal] !== units[signal]);
        if (!other || (await isKnown(workspace, units[signal]))) continue;
        mixed.push(`the ${role} of ${file} is in ${units[signal]}, that of ${other.file} in ${other.units[signal]}: state the right unit or a factor at the left`);
      }
    }
    const remedy = ": choose its channels at the left, or the use \u201cnot used\u201d";
    return [...(undecided.length > 0 ? [undecided.join("; ") + remedy] : []), ...mixed];
  };
  return useOutcome(JSON.stringify(entries.map(whole)), why).value ?? [];
}
