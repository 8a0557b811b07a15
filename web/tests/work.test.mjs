// Drives, controllers, exports and the study in a real browser, as users reach them.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { unzipSync } from "fflate";
import { download, launched, opened, served, skip } from "./browser.mjs";
import { csv, measured } from "./records.mjs";
import { fill, identify, known } from "./steps.mjs";
import { call } from "./modules.mjs";

let server, browser, model;

before(async () => {
  if (skip) return;
  [server, browser] = await Promise.all([served(), launched()]);
  const record = { name: "r.csv", bytes: csv(measured(5)) };
  model = call({ call: "identify", options: { operator: "pi" }, files: { large_signal: ["r.csv"] } }, [record]).files[0];
});
after(async () => {
  await browser?.close();
  server?.close();
});

/** A page at a view, with the model in the project if that is wanted. */
async function at(view, withModel = true) {
  const { page, faults, context } = await opened(browser, server.url);
  if (withModel) {
    await page.getByLabel("Data files").setInputFiles([{ name: "model.json", mimeType: "application/json", buffer: Buffer.from(model.bytes) }]);
    await page.waitForTimeout(300);
  }
  await page.goto(`${server.url}#${view.toLowerCase()}`);
  await page.getByRole("heading", { name: view, level: 1 }).waitFor();
  const button = (name) => page.getByRole("button", { name, exact: true });
  const field = async (name, text) => {
    await page.getByLabel(name, { exact: true }).fill(text);
    await page.getByLabel(name, { exact: true }).blur();
  };
  return { page, faults, button, field, close: () => context.close() };
}

test("drives are planned, tried on a twin, and become records with their uses", { skip }, async () => {
  const { page, faults, button, field, close } = await at("Experiment", false);
  await field("Bandwidth [Hz] *", "40");
  await button("Plan").click();
  const files = unzipSync(await download(page, () => button("Download all as zip").click()));
  assert.ok(["small_u.csv", "path_u.csv", "plan.md"].every((name) => files[name]?.length > 100), Object.keys(files).join());
  await button("rise1").click();
  await page.getByRole("img", { name: /^Spectrum of rise1; shaded: up to the bandwidth, 40 Hz/ }).waitFor();
  await button("Measure the twin").click();
  await page.getByText("records of the twin pl140").waitFor({ timeout: 120_000 });
  await page.getByRole("link", { name: "Workbench", exact: true }).first().click();
  assert.equal(await page.getByLabel("Use of pl140-small.csv").inputValue(), "small-signal");
  assert.equal(await page.getByLabel("Use of pl140-rise1.csv").inputValue(), "training");
  assert.equal(await page.getByLabel("Use of pl140-path.csv").inputValue(), "validation");
  await page.getByRole("link", { name: "Experiment", exact: true }).click();
  // The plan is still there.
  await button("Download all as zip").waitFor({ timeout: 5000 });
  await field("Bandwidth [Hz] *", "60");
  await page.getByText("The form has changed since").waitFor();
  assert.deepEqual(faults, []);
  await close();
});

test("a single signal follows its form, survives a reload, and says what it lacks", { skip }, async () => {
  const { page, faults, close } = await at("Experiment", false);
  await page.getByLabel("Kind").selectOption("triangle");
  await page.getByRole("img", { name: /^Drive triangle/ }).waitFor();
  await page.waitForTimeout(500);
  await page.reload();
  await page.getByRole("img", { name: /^Drive triangle/ }).waitFor();
  await page.getByLabel("Kind").selectOption("multisine");
  await page.getByText("Give Frequency low, Frequency high.").waitFor();
  assert.deepEqual(faults, []);
  await close();
});

test("controllers are compared along a reference, each with its error", { skip }, async () => {
  const { page, faults, button, field, close } = await at("Control");
  await page.getByText("r.csv is not in this project").waitFor();
  await page.getByRole("combobox", { name: /^Plant/ }).selectOption("pl140");
  await field("Controller", "gain, feed-forward");
  await field("Reference", "sine:1");
  await button("Compare").click();
  const table = page.getByRole("region", { name: "Errors by scheme and reference" });
  await table.waitFor({ timeout: 120_000 });
  const [gain, feed] = await table.locator("tbody td").allInnerTexts();
  assert.ok(Number(feed) < Number(gain) / 2, `${feed} % with the inverse, ${gain} % without`);
  assert.equal(await table.locator("strong").innerText(), feed);
  await page.getByRole("img", { name: /^sine 1 Hz on the twin pl140.*requested, gain, feed-forward/ }).waitFor();
  assert.match((await download(page, () => button("Download control.html").click())).toString(), /<html/);
  assert.deepEqual(faults, []);
  await close();
});

test("a model is exported for a target; files are read and downloaded", { skip }, async () => {
  const { page, faults, button, close } = await at("Export");
  await button("Export as c").click();
  await button("piezo_model.c").click();
  const shown = await page.getByRole("region", { name: "Text of piezo_model.c" }).innerText();
  const saved = (await download(page, () => button("Download piezo_model.c").click())).toString();
  assert.equal(shown.trim(), saved.trim());
  await page.getByRole("button", { name: /^waveform/ }).click();
  await page.getByText("The form has changed since").waitFor();
  await button("Export as waveform").click();
  await page.getByRole("alert").getByText("one period of the requested displacement").waitFor();
  await page.getByLabel("Reference", { exact: true }).selectOption("a signal");
  await page.getByLabel("Amplitude [\u00b5m] *", { exact: true }).fill("200");
  await page.getByLabel("Amplitude [\u00b5m] *", { exact: true }).blur();
  await page.waitForTimeout(500);
  await button("Export as waveform").click();
  await button("piezo_model.csv").waitFor();
  assert.deepEqual(faults, []);
  await close();
});

/** The program of the exported files, with one that feeds it numbers. */
function compiled(files) {
  const folder = mkdtempSync(join(tmpdir(), "piezoid-"));
  for (const [name, content] of Object.entries(files)) writeFileSync(join(folder, name), content);
  writeFileSync(join(folder, "run.c"), `#include <stdio.h>
#include "piezo_model.h"
int main(void) {
  piezo_model_state state;
  double u;
  piezo_model_reset(&state);
  while (scanf("%lf", &u) == 1) printf("%.17g\\n", piezo_model_step(&state, u));
  return 0;
}
`);
  const built = ["-std=c99", "-O2", "-ffp-contract=off", "-o", "run", "run.c", "piezo_model.c", "-lm"];
  execFileSync("gcc", built, { cwd: folder });
  return (inputs) => {
    const printed = execFileSync(join(folder, "run"), { input: `${inputs.join("\n")}\n`, maxBuffer: 1 << 26 });
    return printed.toString().trim().split("\n").map(Number);
  };
}

test("the exported C gives the numbers of the page to the bit", { skip }, async () => {
  const { page, faults, button, close } = await at("Export");
  await button("Export as c").click();
  const files = unzipSync(await download(page, () => button("Download all as zip").click()));
  await page.getByLabel("Project to open").waitFor({ state: "attached" });
  await page.goto(`${server.url}#workbench`);
  const record = { name: "other.csv", mimeType: "text/csv", buffer: csv(measured(20)) };
  await page.getByLabel("Data files").setInputFiles([record]);
  await page.getByText(/4,000 samples/).waitFor();
  await page.getByRole("img", { name: /^other\.csv against time\. .*Error/ }).waitFor();
  const text = (await download(page, () => page.getByRole("button", { name: "CSV", exact: true }).first().click())).toString();
  const [head, ...rows] = text.trim().split("\n").map((row) => row.split(","));
  const column = (name) => rows.map((row) => Number(row[head.findIndex((cell) => cell.startsWith(name))]));
  const [inputs, simulated] = [column("input: "), column("model: Output y")];
  assert.equal(inputs.length, 4000);
  assert.deepEqual(compiled(files)(inputs), simulated);
  assert.deepEqual(faults, []);
  await close();
});

test("the voltage of Compensate is that of the path that is chosen", { skip }, async () => {
  const { page, faults, field, close } = await at("Compensate");
  await page.getByRole("combobox", { name: /^Path/ }).selectOption("sine");
  const height = async (amplitude) => {
    await field("Amplitude [\u00b5m]", String(amplitude));
    await page.waitForTimeout(100);
    const button = page.getByRole("button", { name: "Download voltage.csv", disabled: false });
    await button.waitFor();
    const text = (await download(page, () => button.click())).toString();
    const u = text.trim().split("\n").filter((row) => /^\d/.test(row)).map((row) => Number(row.split(",")[1]));
    return Math.max(...u) - Math.min(...u);
  };
  const [small, large] = [await height(50), await height(200)];
  assert.ok(large > 3 * small && large < 5 * small, `${small} V and ${large} V`);
  // What another kind alone has stays with that kind.
  const kind = page.getByRole("combobox", { name: /^Path/ });
  await kind.selectOption("staircase");
  await field("Levels", "4");
  await kind.selectOption("sine");
  const again = await height(50);
  assert.ok(Math.abs(again - small) < 1e-9, `${small} V and ${again} V`);
  assert.deepEqual(faults, []);
  await close();
});

test("a path that is refused keeps the last picture, and says why beside the path until that is mended", { skip }, async () => {
  const { page, faults, close } = await at("Compensate");
  const picture = page.getByRole("img", { name: /^The path on the model/ });
  await picture.waitFor();
  const csv = async () => String(await download(page, () => page.getByRole("button", { name: "CSV", exact: true }).first().click()));
  const before = await csv();
  await fill(page, "high", "0.5");
  const path = page.getByRole("region", { name: "Path", exact: true });
  await path.getByRole("alert").waitFor();
  assert.equal(await page.getByRole("alert").count(), 1);
  await path.getByText("The pictures are of the last path that could be followed.").waitFor();
  assert.equal(await csv(), before, "the picture is the last one");
  assert.equal(await page.getByRole("button", { name: "Download voltage.csv" }).count(), 0);
  await fill(page, "high", "");
  await path.getByRole("alert").waitFor({ state: "detached" });
  await page.getByRole("button", { name: "Download voltage.csv", disabled: false }).waitFor();
  await page.getByRole("button", { name: "Moves in time" }).click();
  await page.getByRole("button", { name: "Time the moves" }).waitFor();
  assert.equal(await page.getByText("On a controller").count(), 0, "no browser reaches a controller");
  assert.deepEqual(faults, []);
  await close();
});

test("a path that only smoothing makes possible has a button that smooths it", { skip }, async () => {
  const { page, faults, close } = await at("Compensate");
  await page.getByRole("combobox", { name: /^Path/ }).selectOption("triangle");
  // Its corners ask for up to 426 V/s.
  await fill(page, "slew", "400");
  const fault = page.getByRole("region", { name: "Path", exact: true }).getByRole("alert");
  await fault.getByText("exceeds its limits: slew 4").waitFor();
  await page.getByRole("button", { name: /^Smooth the path over [\d.]+ ms$/ }).click();
  await fault.waitFor({ state: "detached" });
  await page.getByRole("button", { name: "Download voltage.csv", disabled: false }).waitFor();
  assert.deepEqual(faults, []);
  await close();
});

test("a waveform is exported along the path of Compensate, which is chosen if one is set", { skip }, async () => {
  const { page, faults, button, field, close } = await at("Compensate");
  await page.getByRole("combobox", { name: /^Path/ }).selectOption("sine");
  await field("Amplitude [\u00b5m]", "123");
  await page.getByRole("button", { name: "Download voltage.csv", disabled: false }).waitFor();
  await page.goto(`${server.url}#export`);
  await page.getByRole("button", { name: /^waveform/ }).click();
  const reference = page.getByLabel("Reference", { exact: true });
  assert.equal(await reference.locator("option:checked").innerText(), "the path of Compensate");
  await button("Export as waveform").click();
  const text = (await download(page, () => button("Download piezo_model.csv").click())).toString();
  const r = text.trim().split("\n").filter((row) => /^\d/.test(row)).map((row) => Number(row.split(",").at(-1)));
  assert.ok(Math.abs(Math.max(...r) - Math.min(...r) - 246) < 1, `the path goes from ${Math.min(...r)} to ${Math.max(...r)}: ${text.slice(0, 300)}`);
  assert.deepEqual(faults, []);
  await close();
});

test("what a controller or a driver is chosen from is in sight", { skip }, async () => {
  const { page, faults, button, close } = await at("Control");
  const schemes = page.getByRole("button", { name: /^feed-forward\+integral-notch/ });
  await schemes.click();
  assert.equal(await page.getByLabel("Controller", { exact: true }).inputValue(), "feed-forward+integral-notch");
  await page.getByLabel("Driver", { exact: true }).selectOption("e-503");
  await page.getByText("PI E-503.00, module with three channels").and(page.locator("b")).waitFor();
  await page.goto(`${server.url}#export`);
  await page.getByLabel("Controller", { exact: true }).selectOption("pi");
  await button("Export as c").click();
  await page.getByRole("region", { name: "Operations of each function" }).getByText("control_step").waitFor();
  assert.deepEqual(faults, []);
  await close();
});

test("a model remembers its records; what cannot be read is not used", { skip }, async () => {
  const { page, faults, close } = await at("Workbench", false);
  const training = "log.csv";
  await page.getByLabel("Data files").setInputFiles([{ name: training, mimeType: "text/csv", buffer: csv(measured(5)) }]);
  await identify(page, "pi");
  await known(page, "prandtl-ishlinskii");
  await page.getByLabel(`Use of ${training}`).selectOption("validation");
  await page.getByLabel("Data files").setInputFiles([{ name: "letter.txt", mimeType: "text/plain", buffer: Buffer.from("Dear all,\nno numbers here.\n") }]);
  await page.getByText("cannot be read", { exact: true }).waitFor();
  assert.equal(await page.getByLabel("Use of letter.txt").inputValue(), "none");
  await page.getByRole("button", { name: training, exact: true }).click();
  await page.getByText("Not validated on another record").waitFor();
  await fill(page, "input_scale", "2");
  await page.getByText(/prepared in another way now than when .* was identified/).waitFor();
  await page.goto(`${server.url}#compensate`);
  await page.getByText(/prepared in another way now than when .* was identified/).waitFor();
  assert.deepEqual(faults, []);
  await close();
});

test("without a model, Control and Export lead to the workbench; Study explains the paper", { skip }, async () => {
  const { page, faults, close } = await at("Control", false);
  for (const view of ["control", "export"]) {
    await page.goto(`${server.url}#${view}`);
    assert.equal(await page.locator("main").getByRole("link", { name: "Identify" }).getAttribute("href"), "#workbench");
  }
  await page.goto(`${server.url}#study`);
  assert.equal(await page.locator(".steps li").count(), 6);
  assert.deepEqual(faults, []);
  await close();
});
