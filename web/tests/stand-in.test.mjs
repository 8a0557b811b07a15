// The stand-in for one's own actuator in the page of `piezoid serve`: made once from the records of the model, and played
// on by all views; a twin of the catalogue by choice alone.
import assert from "node:assert/strict";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { unzipSync } from "fflate";
import { download, launched, opened, skip as noBrowser } from "./browser.mjs";
import { piezoid, skip as noPiezoid, started } from "./piezoid.mjs";
import { viewed } from "./viewed.mjs";
import { identify, known } from "./steps.mjs";

const skip = noBrowser || noPiezoid;
const folders = [];
const servers = [];
let browser;

before(async () => {
  if (!skip) browser = await launched();
});
after(async () => {
  await browser?.close();
  servers.forEach(({ running }) => running.kill("SIGKILL"));
  folders.forEach((folder) => rmSync(folder, { recursive: true }));
});

const fresh = () => {
  folders.push(mkdtempSync(join(tmpdir(), "piezoid-stand-in-")));
  return folders.at(-1);
};

/** A page of a server with an empty folder, and the requests that it has sent to the library. */
async function page() {
  const server = await started(["serve", fresh(), "--port", "0"], /http:\/\/\S+/);
  servers.push(server);
  const calls = [];
  const { page, faults, context } = await opened(browser, server.found);
  page.on("request", (request) => {
    if (!request.url().endsWith("/api/call")) return;
    const body = request.postDataBuffer();
    calls.push(JSON.parse(body.subarray(4, 4 + body.readUInt32LE(0)).toString()));
  });
  const view = (name) => page.getByRole("navigation").getByRole("link", { name, exact: true }).click();
  const of = (name) => calls.filter(({ call }) => call === name);
  return { page, faults, calls, of, view, close: () => context.close() };
}

/** Records and a model of the simulated bender, from the command line. */
function measured() {
  const cwd = fresh();
  const run = (line) => piezoid(cwd, ...line.split(" "));
  for (const hz of [5, 20]) {
    run(`excite rising-sine --amplitude 28V --frequency ${hz}Hz --ts 0.5ms --duration 1s -o u${hz}.csv`);
    run(`simulate u${hz}.csv --plant pl140 -o r${hz}.csv`);
  }
  run("identify r5.csv r20.csv --operator pi -o model.json");
  const file = (name) => ({ name, mimeType: "application/octet-stream", buffer: readFileSync(join(cwd, name)) });
  return { model: file("model.json"), records: [file("r5.csv"), file("r20.csv")] };
}

const HEADLINE = /^On (.*), the error goes from ([\d.]+)\s.m rms with the best constant gain to ([\d.]+)\s.m with/;

/** What Compensate says of the path on this plant. */
async function played(page, plant) {
  const line = page.getByRole("region", { name: "Before and after" }).getByText(`On ${plant}, the error goes`);
  await line.waitFor({ timeout: 240_000 });
  const text = await line.textContent();
  const [, , gain, compensated] = text.match(HEADLINE);
  return { text, gain: Number(gain), compensated: Number(compensated) };
}

test("a path is played on the stand-in, which is made once, by itself, and kept with the project", { skip, timeout: 420_000 }, async () => {
  const { page: one, faults, of, calls, view, close } = await page();
  await one.getByRole("button", { name: "Open the example" }).click();
  await one.getByRole("button", { name: "staircase.csv", exact: true }).waitFor();
  await identify(one, "pi");
  await known(one, "prandtl-ishlinskii");

  // It can be cancelled, and does not begin again by itself.
  await view("Compensate");
  await one.getByRole("progressbar", { name: "stand-in for prandtl-ishlinskii.json" }).waitFor();
  await one.getByRole("button", { name: "Cancel", exact: true }).click();
  await one.getByRole("button", { name: "Make the stand-in" }).click();
  const first = await played(one, "the stand-in");
  assert.ok(first.compensated > 0 && first.compensated < first.gain / 3, first.text);
  assert.equal(await one.locator(".verdict").count(), 1, "one verdict");
  await one.getByText(/^promised error, from the stand-in; [\d.]+ to [\d.]+ .m in 8 of 10 random stand-ins, its spread and no confidence interval$/).waitFor();
  await one.getByText(/^The best constant gain for this path, by the model: [\d.]+ V\/.m, offset .+ V, .* (ahead of the path|without a lead)\.$/).waitFor();
  await one.getByText("Within what was measured.").waitFor();
  await one.getByText(/^The stand-in is the model and .* % of its difference from a model with/).waitFor();
  await one.getByRole("img", { name: /^The path on the stand-in.*requested, best constant gain, compensated/ }).waitFor();
  // The error is the path less the displacement, as in Control, without a constant.
  const text = String(await download(one, () => one.getByRole("button", { name: "CSV", exact: true }).first().click()));
  const [head, ...rows] = text.trim().split("\n").map((row) => row.split(","));
  const column = (name) => rows.map((row) => Number(row[head.indexOf(name)]));
  const [r, y, e] = ["requested: Displacement [um]", "best constant gain: Displacement [um]", "best constant gain: Error [um]"].map(column);
  const aside = e.map((value, k) => r[k] - y[k] - value);
  assert.ok(Math.max(...aside) - Math.min(...aside) < 1e-9 && Math.max(...e) - Math.min(...e) > 1, `${aside.slice(0, 3)} of ${e.slice(0, 3)}`);
  assert.equal(of("stand-in").length, 2);
  const { records, model } = of("stand-in")[1].files;
  assert.deepEqual([model, records.toSorted()], [["prandtl-ishlinskii.json"], ["prbs.csv", "rising-20Hz.csv", "rising-5Hz.csv"]]);
  assert.deepEqual(of("compensate").at(-1).files.stand_in, ["prandtl-ishlinskii-stand-in.json"]);
  await viewed(one, "stand-in");

  // Another path is followed without a button; an undo takes back the path alone.
  await one.getByRole("combobox", { name: /^Path/ }).selectOption("sine");
  await one.waitForFunction((text) => ![...document.querySelectorAll("[role=status]")].some((line) => line.textContent === text), first.text);
  await one.getByRole("button", { name: "Undo" }).click();
  await one.getByRole("status").getByText(first.text, { exact: true }).waitFor();

  await view("Control");
  for (const [name, text] of [["Controller", "gain, feed-forward"], ["Reference", "sine:5"]]) {
    await one.getByLabel(name, { exact: true }).fill(text);
    await one.getByLabel(name, { exact: true }).blur();
  }
  await one.getByRole("button", { name: "Compare", exact: true }).click();
  await one.getByText("Tuned to the model prandtl-ishlinskii.json; played on the stand-in for its actuator.").waitFor({ timeout: 60_000 });
  assert.deepEqual(of("control")[0].files.stand_in, ["prandtl-ishlinskii-stand-in.json"]);
  await viewed(one, "stand-in-control");
  assert.deepEqual(calls.filter(({ call, options }) => call !== "simulate" && options?.plant), [], "no twin of the catalogue");

  const saved = await download(one, () => one.getByRole("button", { name: "Save", exact: true }).click());
  assert.ok(unzipSync(saved)["prandtl-ishlinskii-stand-in.json"]?.length > 1000);
  assert.deepEqual(faults, []);
  await close();

  const other = await page();
  await other.page.getByLabel("Project to open").setInputFiles([{ name: "shared.zip", mimeType: "application/zip", buffer: saved }]);
  await other.page.getByRole("button", { name: "staircase.csv", exact: true }).waitFor();
  await other.view("Compensate");
  assert.equal((await played(other.page, "the stand-in")).text, first.text);
  assert.deepEqual(other.of("stand-in"), []);
  assert.deepEqual(other.faults, []);
  await other.close();
});

test("without the records of a model nothing is played until they are added, or a twin is chosen", { skip, timeout: 360_000 }, async () => {
  const { model, records } = measured();
  const { page: one, faults, of, view, close } = await page();
  const add = (files) => one.getByLabel("Data files").setInputFiles(files);
  await add([model]);
  await one.waitForTimeout(500);
  for (const name of ["Control", "Compensate"]) {
    await view(name);
    await one.getByText(/model\.json was identified from, but r5\.csv, r20\.csv are not in this project\. Add them, or choose a twin/).waitFor();
  }
  await view("Control");
  assert.equal(await one.getByRole("button", { name: "Compare", exact: true }).isDisabled(), true);
  await view("Compensate");
  await one.getByRole("button", { name: "Download voltage.csv", disabled: false }).waitFor();
  assert.deepEqual(of("compensate").filter(({ options, files }) => options?.plant || files.stand_in), []);

  await one.getByRole("combobox", { name: /^Plant/ }).selectOption("p885");
  await one.getByText("This is another actuator than yours, unless your records are of this twin").waitFor();
  await played(one, "the twin p885");
  assert.equal(await one.getByText(/random stand-ins|promised error/).count(), 0);
  await one.getByText(/p885.* is not the actuator of this model/).waitFor();
  assert.equal(of("compensate").at(-1).options.plant, "p885");
  assert.deepEqual(of("stand-in"), []);
  await viewed(one, "stand-in-twin");

  await one.getByRole("combobox", { name: /^Plant/ }).selectOption("");
  await view("Workbench");
  await add(records);
  await one.getByRole("heading", { name: "r20.csv" }).waitFor();
  await view("Compensate");
  const { gain, compensated, text } = await played(one, "the stand-in");
  assert.ok(compensated < gain / 3, text);
  assert.deepEqual(faults, []);
  await close();
});

test("the smoothing that the library advises is set by a button", { skip, timeout: 120_000 }, async () => {
  const { model } = measured();
  const { page: one, faults, view, close } = await page();
  await one.getByLabel("Data files").setInputFiles([model]);
  await one.waitForTimeout(500);
  await view("Compensate");
  await one.getByRole("combobox", { name: /^Path/ }).selectOption("staircase");
  const smooth = one.getByRole("button", { name: /^Smooth the path over [\d.]+ ms$/ });
  await one.getByText(/^Beyond what was measured: the voltage changes by up to [\d.e]+ V\/s, that of the records by/).waitFor();
  await smooth.focus();
  await one.keyboard.press("Enter");
  await smooth.waitFor({ state: "detached" });
  assert.equal(await one.getByText(/Beyond what was measured/).count(), 0);
  assert.notEqual(await one.evaluate(() => document.activeElement.tagName), "BODY", "the focus is still in the page");
  assert.ok(Number(await one.getByLabel("Smooth [s]", { exact: true }).inputValue()) > 0);
  await one.getByRole("button", { name: "Download voltage.csv", disabled: false }).waitFor();
  assert.deepEqual(faults, []);
  await close();
});
