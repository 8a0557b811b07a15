// What a browser loads stays small.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { gzipSync } from "node:zlib";
import { DIST } from "./modules.mjs";

/** The largest sizes [bytes, gzipped], for a line of 1.6 Mbit/s: 4 s for each module that a first identification needs,
 * 5 s for the others, which are loaded when their views are opened. */
const LARGEST = {
  "files.wasm": 800_000,
  "models.wasm": 800_000,
  "plans.wasm": 1_000_000,
  "compensation.wasm": 1_000_000,
  "reports.wasm": 1_000_000,
  "studies.wasm": 1_000_000,
  "exports.wasm": 1_000_000,
  "lists.json": 10_000,
};

for (const [name, largest] of Object.entries(LARGEST)) {
  test(`the size of ${name}`, (message) => {
    const size = gzipSync(readFileSync(new URL(name, DIST)), { level: 9 }).length;
    message.diagnostic(`${name}: ${size} bytes gzipped, ${largest} at most`);
    assert.ok(size <= largest, `${name} has ${size} bytes gzipped, but ${largest} at most are loaded quickly`);
  });
}
