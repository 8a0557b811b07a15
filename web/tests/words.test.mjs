// The words of the library as the page says them.
import assert from "node:assert/strict";
import { test } from "node:test";
import { helpOf, spoken, worded } from "../dist/parts/words.js";

const row = (name) => ({ name });
const lists = { operations: [{ options: [row("driver_lag")] }], excitations: [{ options: [row("frequency_end")] }], columns: [row("ts"), row("time_col")] };

test("options are called by their labels, columns by their names", () => {
  const message = "a.csv: there is no time column among the columns `u`, `ts`; give `{ts}` or `{time_col}`";
  assert.equal(worded(message, lists), "a.csv: there is no time column among the columns “u”, “ts”; give “Sampling period” or “Role time”");
  assert.equal(worded("{driver_lag} = -1: must be positive", lists), "Driver lag = −1: must be positive");
  assert.equal(worded("a.csv: {frequency_end} = 3 Hz", lists), "a.csv: Frequency end = 3 Hz");
  assert.equal(worded("{y_um} = 3 um", lists), "y_um = 3 µm");
  const help = "Largest current (see {list}); needs {driver_lag} of `a`";
  assert.equal(helpOf({ ...row("current"), help }), "Largest current (see the list); needs “Driver lag” of a");
  assert.equal(spoken("zvd"), "ZVD shaper");
});
