// Every verb works in its module, with every operator, controller and target.
import assert from "node:assert/strict";
import { mkdtempSync, readdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, test } from "node:test";
import { packed, unpacked } from "../dist/parts/packet.js";
import { call, file, lists, measured, module, renamed } from "./modules.mjs";
import { piezoid, skip } from "./piezoid.mjs";

const SECONDS = { ts: 1e-3, duration: 1 };
const small = measured("small.csv", { kind: "prbs", amplitude: 1, ts: 1e-3, duration: 2 });
const record = measured("record.csv", { kind: "rising-sine", frequency: 4, amplitude: 28, ...SECONDS });
const other = measured("other.csv", { kind: "sine", frequency: 7, amplitude: 20, ...SECONDS });
const path = renamed(
  "path.csv",
  call({ call: "excite", options: { kind: "sine", frequency: 2, amplitude: 3, unit: "um", ...SECONDS } }).files[0],
);

/** The model of this operator, of the records. */
function identified(operator) {
  const stages = [];
  const files = { small_signal: [small.name], large_signal: [record.name] };
  const request = { call: "identify", options: { operator, order: 2 }, files };
  const answer = call(request, [small, record], (stage) => stages.push(stage));
  assert.match(answer.result.sentence, /good to /);
  assert.equal(JSON.parse(new TextDecoder().decode(answer.files[0].bytes)).hysteresis.operator, operator);
  assert.ok(stages.length > 0 && stages.every(({ what, done, total }) => what !== "" && done <= total));
  return renamed("model.json", answer.files[0]);
}

const cwd = mkdtempSync(join(tmpdir(), "piezoid-verbs-"));
for (const { name, bytes } of [small, record]) writeFileSync(join(cwd, name), bytes);
after(() => rmSync(cwd, { recursive: true }));

/** The same by the command line. */
function natively(operator) {
  const words = `identify ${record.name} --small-signal ${small.name} --operator ${operator} --order 2 -o m.json`;
  piezoid(cwd, ...words.split(" "));
  const model = JSON.parse(readFileSync(join(cwd, "m.json"), "utf8"));
  return { ...model, fit: { ...model.fit, command: "piezoid page" } };
}

const model = identified("prandtl-ishlinskii");
const along = { model: [model.name], reference: [path.name] };

test("a file is read, and a record is prepared", () => {
  const files = { data: [record.name] };
  assert.equal(call({ call: "inspect", files }, [record]).result.record.units.y, "um");
  const prepared = call({ call: "prepare", options: { decimate: 2 }, files }, [record]);
  assert.equal(prepared.series.get("u").length, 500);
});

test("records are packed for others, and the archive is checked", () => {
  const options = { licence: "CC0-1.0", actuator: "a", driver: "d", sensor: "s", who: "w" };
  const packed = call({ call: "contribute", options, files: { data: [record.name, small.name] } }, [record, small]);
  const archive = renamed("in.zip", packed.files[0]);
  const { result } = call({ call: "contribute", files: { check: [archive.name] } }, [archive]);
  assert.deepEqual(result, packed.result);
  assert.equal(result.files[1].use.use, "small-signal");
});

const FORMATS = new URL("../../crates/testing/golden/formats/", import.meta.url);

for (const name of readdirSync(FORMATS)) {
  test(`${name}, of another program, is read`, () => {
    const bytes = new Uint8Array(readFileSync(new URL(name, FORMATS)));
    const { result } = call({ call: "inspect", files: { data: [name] } }, [{ name, bytes }]);
    assert.notEqual(result.format, "csv");
    assert.ok(result.channels.length > 0);
  });
}

for (const { name } of lists.operators) {
  test(`${name} is identified as by the command line, to the bit`, { skip }, () => {
    assert.deepEqual(JSON.parse(new TextDecoder().decode(identified(name).bytes)), natively(name));
  });
}

test("drives are planned", () => {
  const options = { range: [0, 100], bandwidth: 20, driver: "e-610", capacitance: 1.5e-6 };
  assert.equal(call({ call: "plan", options }).files.length, 8);
});

test("a model is proven and reported", () => {
  const request = { files: { model: [model.name], data: [other.name] } };
  const { result } = call({ call: "validate", ...request }, [model, other]);
  assert.match(result.sentence, /good to/);
  const page = new TextDecoder().decode(call({ call: "report", ...request }, [model, other]).files[0].bytes);
  assert.match(page, /^<!DOCTYPE html>/);
  const certified = call({ call: "certificate", options: { date: "2026-11-30", country: "CZ" }, ...request }, [model, other]);
  assert.ok(certified.result.expanded > 0);
  assert.match(new TextDecoder().decode(certified.files[1].bytes), /^<\?xml/);
});

test("parameters follow a record", () => {
  const files = { model: [model.name], data: [other.name] };
  const { result, files: written } = call({ call: "online", files }, [model, other]);
  assert.equal(result.rows.length, 20);
  assert.equal(written[0].name, "model.json");
});

test("a displacement becomes a voltage", () => {
  const answer = call({ call: "compensate", files: along }, [model, path]);
  assert.equal(answer.series.get("u").length, 1000);
});

test("moves are timed along a path and without one", () => {
  const answer = call({ call: "timing", files: { model: [model.name], path: [path.name] } }, [model, path]);
  assert.equal(answer.series.get("y/1").length, 1000);
  const { result } = call({ call: "timing", options: { plant: "pl140" }, files: { model: [model.name] } }, [model]);
  assert.equal(result.runs.length, 4);
});

for (const { name } of lists.controllers) {
  test(`the controller ${name} follows a path`, () => {
    const answer = call({ call: "control", options: { controller: [name] }, files: along }, [model, path]);
    assert.equal(answer.series.get("y/0/0")?.length, 1000, JSON.stringify(answer.result));
  });
}

for (const { name, operators } of lists.targets) {
  test(`a model is exported to ${name}`, () => {
    const of = identified(Object.keys(operators).find((operator) => operators[operator]));
    const options = { target: name, name: "bender" };
    const files = name === "waveform" ? along : { model: [model.name] };
    assert.ok(call({ call: "export", options, files }, [of, path]).files.length > 0);
  });
}

test("the paper's experiment says which estimator is missing", () => {
  const answer = call({ call: "study", options: { plant: "paper" } });
  const [study] = answer.result.studies;
  assert.equal(study.optimum, null);
  assert.ok(study.notes.some((note) => note.includes("least-absolute")));
});

test("an error is told in the words of the library", () => {
  assert.throws(() => call({ call: "inspect", files: { data: ["a.csv"] } }, [file("a.csv", "")]), /the file is empty/);
  const fly = packed({ call: "fly" }, []);
  assert.throws(() => unpacked(module("files").answer(fly, () => {})), /no call called `fly`/);
});
