// The modules in this thread, for tests.
import { readFileSync } from "node:fs";
import { Module } from "../dist/parts/module.js";
import { packed, unpacked } from "../dist/parts/packet.js";

export const DIST = new URL("../dist/", import.meta.url);

/** The lists for menus and forms. */
export const lists = JSON.parse(readFileSync(new URL("lists.json", DIST), "utf8"));

const modules = new Map();

/** The module of this name. */
export function module(name) {
  if (!modules.has(name)) {
    modules.set(name, Module.of(new WebAssembly.Module(readFileSync(new URL(`${name}.wasm`, DIST)))));
  }
  return modules.get(name);
}

/** The answer of the module that has the verb. */
export function call(request, files = [], progress = () => {}) {
  const row = lists.operations.find((operation) => operation.name === request.call);
  return unpacked(module(row.module).answer(packed(request, files), progress));
}

/** A text as a file. */
export const file = (name, content) => ({ name, bytes: new TextEncoder().encode(content) });

/** A file of an answer under another name. */
export const renamed = (name, { bytes }) => ({ name, bytes });

/** A record of the twin for this drive. */
export function measured(name, drive) {
  const u = call({ call: "excite", options: drive }).files[0];
  const request = { call: "simulate", options: { plant: "pl140" }, files: { input: [u.name] } };
  return renamed(name, call(request, [u]).files[0]);
}
