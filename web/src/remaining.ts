// How long work still takes, from the steps that are done: only while that can be trusted.
//
// Steps take different times, and those that run side by side end in any order. An estimate is given from a quarter of
// the steps on, if the ends that were foreseen since half of them lie together, and up to four fifths: the last steps
// of a search are longer than the others.

/** Steps that were done at a time [s]. */
export interface Mark {
  at: number;
  done: number;
  total: number;
}

const [FIRST, LAST] = [0.25, 0.8];

/** Least time from the beginning [s], and how far the foreseen ends may lie apart, over the time that has passed. */
const SOON = 4;
const APART = 1;

/** The marks with another one: as many steps as ever were done. Another total begins anew. */
export function marked(marks: Mark[], { at, done, total }: Mark): Mark[] {
  const last = marks.at(-1);
  if (!last || last.total !== total) return [{ at, done, total }];
  return done > last.done ? [...marks, { at, done, total }] : marks;
}

/** The time left [s] at a time; nothing if it is not known well enough. */
export function remaining(marks: Mark[], now: number): number | undefined {
  const [first, last] = [marks[0], marks.at(-1)];
  if (!first || !last || last.total === 0) return undefined;
  const share = last.done / last.total;
  const passed = now - first.at;
  if (share < FIRST || share > LAST || passed < SOON) return undefined;
  const end = ({ at, done }: Mark) => first.at + ((at - first.at) * last.total) / done;
  const ends = marks.filter(({ done }) => done > 0 && 2 * done >= last.done).map(end);
  if (ends.length < 3 || Math.max(...ends) - Math.min(...ends) > APART * passed) return undefined;
  return Math.max(0, end(last) - now);
}

/** A time that is left, in words; nothing for none. */
export function spokenTime(seconds: number | undefined): string {
  if (seconds === undefined) return "";
  if (seconds > 90) return `about ${Math.ceil(seconds / 60)} minutes left`;
  return `about ${Math.max(10, 10 * Math.ceil(seconds / 10))} s left`;
}
