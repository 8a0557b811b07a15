// A path on the plant that was chosen: with the best constant gain, and with the compensated voltage.

import type { Answer } from "../packet.ts";
import type { ModelEntry, Options } from "../project.ts";
import type { Plant } from "../stand-in.tsx";
import { type PathFile, reading } from "./request.ts";
import { type Outcome, useKept, useLatest, useShared } from "../ui.tsx";

/** Errors of a path on a plant, as `compensate` answers. */
export interface OnPlant {
  plant: string;
  gain: Errors;
  compensated: Errors;
  /** The constant gain: `u(t) = gain r(t + lead) + offset`. */
  line?: { gain: number; offset: number; lead: number } | null;
  /** The rms error on 8 of 10 random stand-ins; of a twin none. */
  spread: [number, number] | null;
  notes: string[];
}

export interface Errors {
  /** Number of samples that count, at the end of the path. */
  n: number;
  rmse: number;
  max_abs: number;
  rms_pp_percent: number;
}

/** Samples of a path up to which it is played by itself: native, 100,000 take 1.5 s. */
const LONG = 30_000;

/** What came of it. Of a path that is too long to be played by itself, `start` plays it. */
export interface Played extends Outcome<Answer> {
  stale: boolean;
  start?: () => void;
}

interface Request {
  entry: ModelEntry;
  plant: Plant | undefined;
  path: PathFile | undefined;
  /** What the path is made of, and how many samples it has if that is known. */
  expected: string;
  samples: number;
  options: Options;
}

export function usePlayed({ entry, plant, path, expected, samples, options }: Request): Played {
  const { workspace } = useShared();
  const key = JSON.stringify([entry.file, expected, options, plant?.key]);
  const isLong = samples > LONG;
  const play = async (quiet: boolean) => {
    const request = { call: "compensate", options, ...reading(path!), files: { model: [entry.file], reference: [path!.name] } };
    const answer = await workspace.run({
      name: "before and after", ...(await plant!.on(request, [await workspace.file(entry.file), path!])), beside: true, quiet,
    });
    return { key, answer };
  };
  const now = useLatest(plant && path && !isLong ? key : undefined, () => play(true));
  const kept = useKept<{ key: string; answer: Answer }>("before and after", key);
  const { value, busy, error } = isLong ? kept : now;
  const is = plant && path ? value : undefined;
  return {
    busy, stale: is !== undefined && is.key !== key, ...(plant && error !== undefined && { error }), ...(is && { value: is.answer }),
    ...(plant && path && isLong && { start: () => kept.start(() => play(false)) }),
  };
}
