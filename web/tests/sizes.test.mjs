// What a browser loads stays small.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { gzipSync } from "node:zlib";
import { DIST } from "./modules.mjs";

/** The largest sizes [bytes, gzipped]: just above those that were reached. */
const LARGEST = {
  "files.wasm": 745_000,
  "models.wasm": 825_000,
  "reports.wasm": 1_022_000,
  "exports.wasm": 965_000,
  "lists.json": 9_200,
};

for (const [name, largest] of Object.entries(LARGEST)) {
  test(`the size of ${name}`, (told) => {
    const size = gzipSync(readFileSync(new URL(name, DIST)), { level: 9 }).length;
    told.diagnostic(`${name}: ${size} bytes gzipped, ${largest} at most`);
    assert.ok(size <= largest, `${name} has ${size} bytes gzipped, but ${largest} at most are loaded quickly`);
  });
}
