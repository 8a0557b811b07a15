// What is handed out of a plot.
import assert from "node:assert/strict";
import { test } from "node:test";
import { csv } from "../dist/parts/plot/download.js";

test("the name of a series is a text in spreadsheets too, whatever it begins with", () => {
  const series = ["=1+1", "+a", '@"b"', "plain"].map((name) => ({ name, x: [0], y: [1] }));
  const figure = { title: "", x: { label: "t", unit: "s" }, panels: [{ y: { label: "y", unit: "um" }, series }] };
  const [head] = csv(figure).split("\n");
  assert.equal(head, `t [s],'=1+1: y [um],t [s],'+a: y [um],t [s],"'@""b"": y [um]",t [s],plain: y [um]`);
});
