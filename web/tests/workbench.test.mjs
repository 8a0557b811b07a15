// The workbench: pictures that are linked, the search as it runs, the ranking, and the whole way by keyboard.
import assert from "node:assert/strict";
import { test } from "node:test";
import { download, fixture, opened, skip } from "./browser.mjs";
import { csv, measured } from "./records.mjs";
import { fill, known } from "./steps.mjs";
import { viewed } from "./viewed.mjs";

const site = fixture();

const file = (name, buffer) => ({ name, mimeType: "text/csv", buffer });
const picture = (page, name) => page.getByRole("group", { name: "Picture" }).getByRole("button", { name, exact: true }).click();
const drawn = (page, name) => page.getByRole("img", { name });

/** A page with a record at 5 Hz, one at 20 Hz, and one to validate on. */
async function bench() {
  const { page, faults, context } = await opened(site.browser, site.server.url);
  await page.getByLabel("Data files").setInputFiles([file("slow.csv", csv(measured(5))), file("fast.csv", csv(measured(20))), file("proof.csv", csv(measured(10, 20)))]);
  await page.getByLabel("Use of proof.csv").selectOption("validate");
  await page.getByRole("button", { name: "slow.csv", exact: true }).click();
  await drawn(page, /^slow\.csv against time/).waitFor();
  return { page, faults, close: () => context.close() };
}

test("the pictures of a record share their span of time; loops are drawn from cycles, by frequency side by side", { skip }, async () => {
  const { page, faults, close } = await bench();
  const strip = page.getByRole("slider", { name: "Shown span of time" });
  const span = () => strip.getAttribute("aria-valuetext");
  const all = await span();
  await drawn(page, /^slow\.csv against time/).focus();
  for (let k = 0; k < 4; k++) await page.keyboard.press("+");
  await page.waitForFunction((text) => document.querySelector(".strip [role=slider]").getAttribute("aria-valuetext") !== text, all);
  const zoomed = await span();
  await picture(page, "Time");
  assert.equal(await span(), zoomed, "another picture keeps the span");
  await strip.focus();
  await page.keyboard.press("Home");
  assert.equal(await span(), all);

  await picture(page, "Loop less its line");
  const loop = drawn(page, /^Loop less its straight line of 3\d\.\d+ µm\/V/);
  const samples = async () => (await download(page, () => page.getByRole("button", { name: "CSV", exact: true }).first().click())).toString().trim().split("\n").length;
  await loop.waitFor();
  const few = await samples();
  await page.getByRole("button", { name: "All samples" }).click();
  assert.ok((await samples()) > 4000 && few < 4000, `${few} samples in a few cycles`);
  await page.getByRole("button", { name: "All records, by frequency" }).click();
  const head = (await download(page, () => page.getByRole("button", { name: "CSV", exact: true }).first().click())).toString().split("\n")[0];
  for (const title of ["5 Hz, slow.csv", "20 Hz, fast.csv", "10 Hz, proof.csv"]) assert.ok(head.includes(title), head);
  assert.deepEqual(faults, []);
  await close();
});

test("a search is seen over the data; a click on an operator draws it; one verdict stands, of another record", { skip }, async () => {
  const { page, faults, close } = await bench();
  await fill(page, "operator", "pi, bouc-wen, dahl");
  await page.getByRole("button", { name: "Identify", exact: true }).click();
  await drawn(page, /^slow\.csv against time.*best so far/).waitFor({ timeout: 120_000 });
  await known(page, "prandtl-ishlinskii");
  await page.locator(".verdict", { hasText: "free run on proof.csv" }).waitFor();
  assert.equal(await page.locator(".verdict").count(), 1);
  const ranks = await page.locator(".ranking li").allInnerTexts();
  const errors = ranks.map((text) => Number(text.match(/([\d.]+) %/)[1]));
  assert.ok(ranks.length >= 3 && errors.every((error, k) => k === 0 || error >= errors[k - 1]), ranks.join());
  await page.getByRole("button", { name: "dahl", exact: true }).click();
  await drawn(page, /^slow\.csv against time.*prandtl-ishlinskii, dahl/).waitFor();
  for (const name of ["Overview", "Spectrum", "Error"]) {
    await picture(page, name);
    await page.waitForTimeout(400);
    await viewed(page, `workbench-${name.toLowerCase()}`);
  }
  assert.deepEqual(faults, []);
  await close();
});

test("the proof and the report are of the records whose use is validation, which the left says and changes", { skip }, async () => {
  const { page, faults, close } = await bench();
  await fill(page, "operator", "pi");
  await page.getByRole("button", { name: "Identify", exact: true }).focus();
  await page.keyboard.press("Enter");
  await page.getByRole("heading", { name: "The search" }).waitFor();
  assert.equal(await page.evaluate(() => document.activeElement.getAttribute("aria-label")), "What is known", "the focus stays beside the search");
  await known(page, "prandtl-ishlinskii");
  const proof = page.getByLabel("Errors on the records of the proof, of the stroke");
  await proof.getByText("proof.csv").waitFor();
  const line = (name) => page.getByRole("list", { name: "Records and their use" }).getByRole("listitem").filter({ hasText: name });
  await line("proof.csv").getByText("proves prandtl-ishlinskii").waitFor();
  await page.getByRole("button", { name: "Choose them by their use" }).click();
  assert.equal(await page.evaluate(() => document.activeElement.getAttribute("aria-label")), "Use of slow.csv");
  await page.getByLabel("Use of slow.csv").selectOption("validate");
  await line("slow.csv").getByText("prandtl-ishlinskii was identified from it: no proof").waitFor();
  await page.getByLabel("Use of proof.csv").selectOption("not used");
  await page.getByText("Not validated on another record").waitFor();
  assert.equal(await page.getByRole("button", { name: /^Report of/ }).count(), 0);
  await page.getByLabel("Use of proof.csv").selectOption("validate");
  const report = await download(page, () => page.getByRole("button", { name: "Report of prandtl-ishlinskii" }).click());
  assert.ok(report.includes("proof.csv") && report.includes("<html"));
  assert.deepEqual(faults, []);
  await close();
});

test("an operator is picked from the list, by keyboard, and identified; the next step is Compensate", { skip }, async () => {
  const { page, faults, close } = await bench();
  const press = async (locator, key = "Enter") => {
    await locator.focus();
    await page.keyboard.press(key);
  };
  await press(page.getByText("Operators, effort, order"));
  await press(page.getByText("Pick from the list"));
  const dahl = page.getByRole("button", { name: /^dahl / });
  assert.ok((await dahl.locator("svg path").getAttribute("d")).length > 500);
  await press(dahl);
  assert.equal(await page.locator("input[name=operator]").inputValue(), "dahl");
  assert.equal(await dahl.getAttribute("aria-pressed"), "true");
  await viewed(page, "workbench-pick");
  await press(page.getByRole("button", { name: "Identify", exact: true }));
  await known(page, "dahl");
  await press(page.getByRole("link", { name: "Compensate a path" }));
  await page.getByRole("button", { name: "Download voltage.csv" }).waitFor({ timeout: 60_000 });
  assert.deepEqual(faults, []);
  await close();
});

test("a unit that is not known is told where it is stated, and keeps records apart before they are identified", { skip }, async () => {
  const { page, faults, close } = await bench();
  const daq = String(csv(measured(5))).replace("u_V", "u_daq");
  await page.getByLabel("Data files").setInputFiles([file("daq.csv", Buffer.from(daq))]);
  await page.getByText(/^The unit daq of the input is no voltage/).waitFor();
  const start = page.getByRole("button", { name: "Identify", exact: true });
  await page.getByText("the input of daq.csv is in daq, that of slow.csv in V: state the right unit").waitFor();
  assert.equal(await start.isDisabled(), true);
  await fill(page, "input_unit", "furlong");
  await page.getByText(/^The unit furlong of the input/).waitFor();
  await fill(page, "input_unit", "mV");
  await page.getByText(/^The unit .* of the input/).waitFor({ state: "detached" });
  await page.getByText("in daq, that of").waitFor({ state: "detached" });
  assert.equal(await start.isDisabled(), false, "mV are converted");
  assert.deepEqual(faults, []);
  await close();
});
