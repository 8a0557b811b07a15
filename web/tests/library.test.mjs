// The library in workers: modules are loaded once, wait for nobody else, and are ended by a signal.
import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { createServer } from "node:http";
import { after, before, test } from "node:test";
import { Worker } from "node:worker_threads";
import { Cancelled, LocalLibrary, Refused } from "../dist/parts/library.js";
import { DIST, measured } from "./modules.mjs";

const ENDLESS = { call: "study", options: { plant: "paper" } };
const EXCITE = { call: "excite", options: { kind: "sine", frequency: 5, amplitude: 1, ts: 1e-3, duration: 1 } };
const record = measured("record.csv", { kind: "rising-sine", frequency: 4, amplitude: 28, ts: 1e-3, duration: 2 });
const SIMULATE = { call: "simulate", options: { plant: "pl140" }, files: { input: [record.name] } };
const IDENTIFY = { call: "identify", files: { large_signal: [record.name] } };

/** A worker of a browser, by a thread of Node.js. */
class BrowserWorker {
  constructor() {
    const scope = `
      const { parentPort } = require("node:worker_threads");
      globalThis.self = { postMessage: (data, transfer) => parentPort.postMessage(data, transfer) };
      const ready = import(${JSON.stringify(new URL("worker.js", DIST))});
      parentPort.on("message", (data) => ready.then(() => self.onmessage({ data })));`;
    this.thread = new Worker(scope, { eval: true });
    this.thread.on("message", (data) => this.onmessage({ data }));
    this.thread.on("error", (error) => this.onerror(error));
    this.thread.unref();
    spawned.push(this);
  }
  postMessage(data, transfer) {
    this.thread.postMessage(data, transfer);
  }
  terminate() {
    void this.thread.terminate();
  }
}

const TYPES = { wasm: "application/wasm", json: "application/json" };
let server, base, spawned, loaded, types, missing, library;

before(async () => {
  server = createServer(async (request, response) => {
    const name = request.url.slice(1);
    loaded.push(name);
    if (missing === name) return response.writeHead(404).end();
    response.writeHead(200, { "content-type": types[name.split(".").pop()] ?? "text/plain" });
    response.end(await readFile(new URL(name, DIST)));
  });
  await new Promise((listening) => server.listen(0, "127.0.0.1", listening));
  base = new URL(`http://127.0.0.1:${server.address().port}/`);
});

after(() => server.close().closeAllConnections());

function begin() {
  [spawned, loaded, types, missing] = [[], [], TYPES, undefined];
  library = new LocalLibrary(base, () => new BrowserWorker());
}

test("a module is loaded when a call needs it, and once", async () => {
  begin();
  const [first, second] = await Promise.all([library.call(SIMULATE, [record]), library.call(SIMULATE, [record])]);
  assert.deepEqual(first.series.get("y"), second.series.get("y"));
  assert.deepEqual([loaded, spawned.length], [["lists.json", "models.wasm"], 1]);
});

test("a server that tells no type serves as well", async () => {
  begin();
  types = {};
  assert.equal((await library.call(SIMULATE, [record])).series.get("y").length, 2000);
});

test("a call of one module does not wait for another module", async () => {
  begin();
  const stop = new AbortController();
  const study = library.call(ENDLESS, [], undefined, stop.signal);
  await library.call(SIMULATE, [record]);
  stop.abort();
  await assert.rejects(study, Cancelled);
});

test("a signal ends its call alone, and progress is told until then", async () => {
  begin();
  const [first, second] = [new AbortController(), new AbortController()];
  const identified = library.call(IDENTIFY, [record], () => first.abort(), first.signal);
  const waiting = library.call(SIMULATE, [record]);
  const ended = library.call(SIMULATE, [record], undefined, second.signal);
  second.abort();
  await assert.rejects(ended, Cancelled);
  await assert.rejects(identified, Cancelled);
  assert.equal((await waiting).series.get("y").length, 2000);
  assert.deepEqual([spawned.length, loaded.filter((name) => name === "models.wasm").length], [2, 1]);
  await assert.rejects(library.call(SIMULATE, [record], undefined, AbortSignal.abort()), Cancelled);
});

test("what cannot be loaded is named, and loaded by the next call", async () => {
  begin();
  missing = "models.wasm";
  await assert.rejects(library.call(SIMULATE, [record]), /models.wasm cannot be loaded: 404/);
  missing = undefined;
  assert.equal((await library.call(SIMULATE, [record])).series.get("y").length, 2000);
});

test("an error is told in the words of the library", async () => {
  begin();
  await assert.rejects(library.call({ call: "fly" }, []), Refused);
  await assert.rejects(library.call({ call: "excite", options: { ...EXCITE.options, kind: "cosine" } }, []), /cosine/);
});
