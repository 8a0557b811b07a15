// The time that a search still takes.
import assert from "node:assert/strict";
import { test } from "node:test";
import { marked, remaining, spokenTime } from "../dist/parts/remaining.js";

/** Stages of a search over all operators as they were reported: when [s], how many, of 52; it took 41.6 s. */
const SEARCH = [[1.2, 0], [7, 1], [7.1, 2], [7.3, 4], [7.5, 7], [8.7, 9], [9.3, 11], [9.6, 15], [9.9, 16], [12.9, 8], [18.5, 20], [21, 27],
  [21.7, 26], [24.6, 23], [24.8, 34], [24.9, 36], [25.1, 35], [30.5, 51]];
const END = 41.6;

/** What is estimated at each stage. */
function estimates(stages, total = 52) {
  let marks = [];
  return stages.map(([at, done]) => {
    marks = marked(marks, { at, done, total });
    return [at, remaining(marks, at)];
  });
}

test("an estimate stands from a quarter of the steps on, within a factor of two, and none in the last steps", () => {
  const given = estimates(SEARCH).filter(([, left]) => left !== undefined);
  assert.ok(given.length >= 5, String(given));
  for (const [at, left] of given) assert.ok(left > (END - at) / 2 && left < 2 * (END - at), `${left} s at ${at} s`);
  assert.equal(remaining(estimatesMarks(), 31), undefined);
});

const estimatesMarks = () => SEARCH.reduce((marks, [at, done]) => marked(marks, { at, done, total: 52 }), []);

test("nothing is estimated of work that slows down, has just begun, or does not say how long it is", () => {
  const slower = Array.from({ length: 10 }, (_, k) => [k ** 4 / 50, k]);
  assert.deepEqual(estimates(slower, 12).filter(([, left]) => left !== undefined), []);
  assert.deepEqual(estimates([[0, 0], [0.5, 3], [1, 5], [2, 6]], 10).filter(([, left]) => left !== undefined), []);
  assert.equal(remaining(marked([], { at: 0, done: 0, total: 0 }), 100), undefined);
});

test("another total begins anew", () => {
  const marks = marked(estimatesMarks(), { at: 31, done: 3, total: 10 });
  assert.deepEqual(marks, [{ at: 31, done: 3, total: 10 }]);
});

test("times are rounded up", () => {
  assert.deepEqual([undefined, 0.4, 11, 61, 200].map(spokenTime), ["", "about 10 s left", "about 20 s left", "about 70 s left", "about 4 minutes left"]);
});
