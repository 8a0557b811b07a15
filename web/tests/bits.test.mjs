// The modules give the numbers of the library to the bit, on the vector files of every operator.
import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import { test } from "node:test";
import { call, file } from "./modules.mjs";

const VERSIONS = new URL("../../crates/piezoid/tests/compatibility/", import.meta.url);

/** A column of numbers, which JavaScript writes so that they are read back to the bit. */
const csv = (ts, name, values) => `t_s,${name}\n${values.map((value, k) => `${k * ts},${value}`).join("\n")}\n`;

for (const name of readdirSync(VERSIONS, { recursive: true }).filter((name) => name.includes("operators/"))) {
  test(`${name} to the bit`, () => {
    const { model, step } = JSON.parse(readFileSync(new URL(name, VERSIONS), "utf8"));
    const files = [
      file("model.json", JSON.stringify(model)),
      file("u.csv", csv(model.ts, `u_${model.units.u}`, step.inputs)),
    ];
    const request = { call: "simulate", files: { input: ["u.csv"], model: ["model.json"] } };
    assert.deepEqual(Array.from(call(request, files).series.get("y")), step.outputs);
  });
}
