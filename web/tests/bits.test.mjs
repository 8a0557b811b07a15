// The module gives the numbers of the library to the bit, on the vector files of every operator.
import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import { test } from "node:test";
import { Module } from "../dist/module.js";
import { packed, unpacked } from "../dist/packet.js";

const VECTORS = new URL("../../crates/piezoid/tests/vectors/", import.meta.url);
const MODULE = new URL("../dist/piezoid.wasm", import.meta.url);

const library = Module.of(new WebAssembly.Module(readFileSync(MODULE)));
const text = new TextEncoder();

/** The answer of the module. */
function call(request, files = {}) {
  const given = Object.entries(files).map(([name, content]) => ({ name, bytes: text.encode(content) }));
  return unpacked(library.answer(packed(request, given), () => {}));
}

/** A file with a column of numbers, which JavaScript writes so that they are read back to the bit. */
const csv = (ts, name, values) => `t_s,${name}\n${values.map((value, k) => `${k * ts},${value}`).join("\n")}\n`;

for (const name of readdirSync(VECTORS)) {
  test(`${name} to the bit`, () => {
    const { model, step } = JSON.parse(readFileSync(new URL(name, VECTORS), "utf8"));
    const files = { "model.json": JSON.stringify(model), "u.csv": csv(model.ts, `u_${model.units.u}`, step.inputs) };
    const request = { call: "simulate", files: { input: ["u.csv"], model: ["model.json"] } };
    const y = call(request, files).series.get("y");
    assert.deepEqual(Array.from(y), step.outputs);
  });
}

test("an error is told in the words of the library", () => {
  assert.throws(() => call({ call: "inspect", files: { data: ["a.csv"] } }, { "a.csv": "" }), /the file is empty/);
  assert.throws(() => call({ call: "fly" }), /no call called `fly`/);
});

test("a model is identified in the module, with progress", () => {
  const drive = { kind: "rising-sine", frequency: 5, amplitude: 28, ts: 1e-3, duration: 2 };
  const u = call({ call: "excite", options: drive }).files[0];
  const measure = { call: "simulate", options: { plant: "pl140" }, files: { input: [u.name] } };
  const record = unpacked(library.answer(packed(measure, [u]), () => {})).files[0];
  const stages = [];
  const request = { call: "identify", options: { operator: "pi" }, files: { large_signal: [record.name] } };
  const answer = unpacked(library.answer(packed(request, [record]), (...stage) => stages.push(stage)));
  assert.match(answer.result.told, /^good to /);
  assert.ok(stages.length > 0 && stages.every(([what, done, total]) => what !== "" && done <= total));
});
