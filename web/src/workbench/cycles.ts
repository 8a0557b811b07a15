// The cycles of a record that its loops are drawn from.

import type { Answer } from "../packet.ts";

type Part = [from: number, to: number];

/** Cycles of like frequency and amplitude; first and last samples. */
interface CycleGroup {
  frequency: number;
  amplitude: number;
  count: number;
  cycles: Part[];
}

/** Samples that loops are drawn from. */
export interface Cycles {
  /** Major loops; all samples without it. */
  parts?: Part[];
  /** Minor loops. */
  minor: Part[];
}

/** So many cycles of an amplitude are drawn. */
const FEW = 2;

/** Lines are drawn to the sample before the last of a part. */
const closed = (parts: Part[]): Part[] => parts.map(([from, to]) => [from, to + 1]);

const found = (answer: Answer): { groups: CycleGroup[]; minor: Part[] } => answer.result.shape?.cycles ?? { groups: [], minor: [] };

/** The frequencies of a record [Hz]. */
export const frequenciesOf = (answer: Answer): number[] => [...new Set(found(answer).groups.map(({ frequency }) => frequency))];

/** A few cycles of each amplitude, of one frequency or of all: the last ones, which have settled. */
export function cyclesOf(answer: Answer, frequency?: number): Cycles {
  const { groups, minor } = found(answer);
  const chosen = groups.filter((one) => frequency === undefined || one.frequency === frequency);
  if (chosen.length === 0) return { minor: closed(minor) };
  const parts = closed(chosen.flatMap(({ cycles }) => cycles.slice(-FEW)));
  const inside = ([from, to]: Part) => frequency === undefined || chosen.some(({ cycles }) => cycles.some(([a, b]) => a <= from && to <= b));
  return { parts, minor: closed(minor.filter(inside)) };
}
