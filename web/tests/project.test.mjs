// What must not be lost: the project of a store that cannot be read whole, and the page when it opens damaged archives.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import Ajv from "ajv/dist/2020.js";
import { zipSync } from "fflate";
import { unpackedProject } from "../dist/parts/archive.js";
import { read } from "../dist/parts/project.js";
import { Workspace } from "../dist/parts/workspace.js";

const bytes = (text) => new TextEncoder().encode(text);

/** A store of these files, in which those that are functions fail; `written` are the names that are written. */
function stored(files) {
  const written = [];
  return {
    written, own: false,
    names: async () => Object.keys(files),
    read: async (name) => (typeof files[name] === "function" ? files[name]() : bytes(files[name])),
    write: async (name) => { written.push(name); },
    remove: async () => assert.fail("nothing is removed"),
  };
}

const fails = () => { throw new Error("no permission"); };

test("a project is not written over while a project of the store is not known", async () => {
  for (const files of [{ "project.json": fails }, { "project.json": "{", "project-2.json": fails }]) {
    const store = stored(files);
    const workspace = new Workspace({}, store);
    await assert.rejects(workspace.open(), /no permission/);
    workspace.change((project) => ({ ...project, record: "a.csv" }));
    await workspace.flush();
    assert.deepEqual(store.written, []);
  }
});

test("nothing is stored before the project of the store is read", async () => {
  const store = stored({ "project.json": JSON.stringify({ piezoid: 1, records: [], models: [], settings: {} }) });
  const workspace = new Workspace({}, store);
  await workspace.flush();
  assert.deepEqual(store.written, []);
  await workspace.open();
  await workspace.flush();
  assert.deepEqual(store.written, ["project.json"]);
});

test("a project that cannot be read stays, and the one beside it is used", async () => {
  const readable = JSON.stringify({ piezoid: 1, records: [], models: [], settings: { study: {} } });
  const store = stored({ "project.json": '{"piezoid":2}', "project-2.json": readable });
  const workspace = new Workspace({}, store);
  await workspace.open();
  assert.deepEqual(workspace.project.settings, { study: {} });
  await workspace.flush();
  assert.deepEqual(store.written, ["project-2.json"]);
});

test("the profile of a rig is stored beside the project, but not over another file", async () => {
  const record = { file: "a.csv", columns: {}, prepare: {}, use: "training" };
  const project = JSON.stringify({ piezoid: 1, records: [record], models: [], settings: {} });
  const store = stored({ "project.json": project, "a.csv": "", "bench.toml": "mine" });
  const files = [{ name: "profile.toml", bytes: bytes('input_col = "1"\n') }];
  const workspace = new Workspace({ call: async () => ({ result: { layout: '["csv"]' }, series: new Map(), files }) }, store);
  await workspace.open();
  const named = (name) => workspace.change((now) => ({ ...now, rigs: [{ name, layout: '["csv"]', columns: { input_col: "1" } }] }));
  named("bench");
  await workspace.flush();
  assert.deepEqual(store.written, ["project.json"]);
  assert.match(workspace.fault, /^bench\.toml is another file of this folder/);
  named("rig");
  await workspace.flush();
  assert.deepEqual(store.written.slice(1), ["project.json", "rig.toml"]);
});

test("an archive that unpacks to gigabytes is refused before it is unpacked", () => {
  const archive = zipSync({ "a.csv": new Uint8Array(100) });
  const view = new DataView(archive.buffer, archive.byteOffset);
  // The size in the central directory: 24 bytes after its signature.
  const directory = archive.findIndex((_, at) => at + 4 <= archive.length && view.getUint32(at, true) === 0x02014b50);
  view.setUint32(directory + 24, 3_000_000_000, true);
  assert.throws(() => unpackedProject(archive), /holds 2861 MiB, but at most 512 MiB can be opened/);
});

test("a damaged archive or project says what is damaged", () => {
  const of = (project) => unpackedProject(zipSync({ "project.json": bytes(project) }));
  assert.throws(() => unpackedProject(bytes("no archive")), /this is no project of piezoid, or it is damaged/);
  assert.throws(() => unpackedProject(zipSync({ "a.csv": bytes("") })), /holds no project\.json/);
  for (const [text, why] of [
    ["{", /is damaged/],
    ['{"piezoid":2}', /it is of a newer one, or of another program/],
    ['{"piezoid":1,"settings":null}', /settings is null, but must be an object/],
    ['{"piezoid":1,"records":[null]}', /records\[0\] is null/],
    ['{"piezoid":1,"models":[{"file":7}]}', /models\[0\]/],
    ['{"piezoid":1,"models":[{"file":"a.json","standIn":"b.json"}]}', /models\[0\]\.standIn is "b\.json", but must be an object/],
    ['{"piezoid":1,"models":[{"file":"a.json","standIn":{"file":"b.json"}}]}', /lacks its files a\.json, b\.json/],
    ['{"piezoid":1,"rigs":[{"name":"../a","layout":"[]"}]}', /rigs\[0\]\.name is "\.\.\/a", but must be a name that a file can have/],
    ['{"piezoid":1,"rigs":[{"name":"a","layout":"csv"}]}', /rigs\[0\]\.layout is "csv"/],
    ['{"piezoid":1,"rigs":[{"name":"a","layout":"[]","columns":7}]}', /rigs\[0\]\.columns is 7, but must be an object/],
    ['{"piezoid":1,"records":[{"file":"a.csv","columns":{},"prepare":{},"use":"none"}]}', /lacks its files a\.csv/],
  ]) assert.throws(() => of(text), why, text);
});

test("what is no change of the user stays after an undo, and is kept once", async () => {
  const model = { file: "a.json", summary: "", verdict: "", notes: [] };
  const workspace = new Workspace({}, stored({ "project.json": JSON.stringify({ piezoid: 1, models: [model] }) }));
  await workspace.open();
  workspace.change((project) => ({ ...project, settings: { compensate: { path: "sine" } } }));
  const standIn = { file: "a-stand-in.json", sentence: "" };
  workspace.amend((project) => ({ ...project, models: project.models.map((one) => ({ ...one, standIn })) }));
  for (const step of ["undo", "redo"]) {
    workspace[step]();
    assert.deepEqual(workspace.project.models[0].standIn, standIn, step);
    assert.equal(Object.keys(workspace.project.settings).length, step === "undo" ? 0 : 1);
  }
});

test("a fault goes with the next edit, unless no edit mends it", async () => {
  const workspace = new Workspace({}, stored({ "project.json": JSON.stringify({ piezoid: 1 }) }));
  await workspace.open();
  const edit = () => workspace.change((project) => ({ ...project, settings: { ...project.settings, control: {} } }));
  workspace.failed(new Error("this is not a model"));
  workspace.amend((project) => ({ ...project, record: "a.csv" }));
  assert.equal(workspace.fault, "this is not a model", "what the page does by itself leaves it");
  edit();
  assert.equal(workspace.fault, "");
  workspace.failed(new Error("open in another tab"), true);
  edit();
  workspace.undo();
  assert.equal(workspace.fault, "open in another tab");
});

test("what is read as a project keeps its schema, and what keeps the schema is read", () => {
  const schema = JSON.parse(readFileSync(new URL("../../docs/schema/project-1.json", import.meta.url), "utf8"));
  const keeps = new Ajv().compile(schema);
  const record = { file: "a.csv", columns: { fs: 2000 }, prepare: {}, use: "training", because: "it has a large range" };
  const standIn = { file: "s.json", sentence: "a line" };
  const model = { file: "m.json", summary: "one", verdict: "good", notes: ["a"], from: [record], validated: "good", error: 0.5, standIn };
  const rig = { name: "bench", layout: '["csv"]', columns: {} };
  const project = { piezoid: 1, records: [record], models: [model], rigs: [rig], record: "a.csv", model: "m.json", settings: { identify: {} } };
  const isRead = (changed) => {
    try {
      return Boolean(read(JSON.stringify(changed)));
    } catch {
      return false;
    }
  };
  /** The value with a change at one of its fields, for each of them. */
  function* changes(value, at = []) {
    if (at.length) yield* [undefined, null, 1, -1, "text", "", true, [], [1], {}].map((other) => [at, other]);
    if (typeof value === "object") for (const [key, inner] of Object.entries(value)) yield* changes(inner, [...at, key]);
  }
  assert.ok(keeps(project) && isRead(project));
  let count = 0;
  for (const [at, other] of changes(project)) {
    const changed = structuredClone(project);
    const owner = at.slice(0, -1).reduce((value, key) => value[key], changed);
    if (other === undefined && !Array.isArray(owner)) delete owner[at.at(-1)];
    else owner[at.at(-1)] = other;
    const whole = JSON.parse(JSON.stringify(changed));
    assert.equal(keeps(whole), isRead(whole), `${at.join(".")} = ${JSON.stringify(other)}`);
    count += 1;
  }
  assert.ok(count > 300, `${count}`);
});
