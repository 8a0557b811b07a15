// A campaign in the page of `piezoid serve`, on a simulated controller whose commands are kept with their times.
import assert from "node:assert/strict";
import { mkdtempSync, readdirSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { download, launched, opened, skip as noBrowser } from "./browser.mjs";
import { overheard, skip as noPiezoid, started } from "./piezoid.mjs";
import { fill, written } from "./steps.mjs";
import { SHOTS, viewed } from "./viewed.mjs";

const skip = noBrowser || noPiezoid;
const folder = mkdtempSync(join(tmpdir(), "piezoid-campaign-"));
const log = [];
let browser, server, controller, line;

/** Now, by the clock that the page has too [ms]. */
const now = () => performance.timeOrigin + performance.now();

before(async () => {
  if (skip) return;
  browser = await launched();
  server = await started(["serve", folder, "--port", "0"], /http:\/\/\S+/);
  controller = await started(["instrument", "--plant", "pl140", "--port", "0"], /port \d+/);
  line = await overheard(controller, (text) => log.push({ time: now(), text }));
});
after(async () => {
  await browser?.close();
  line?.close();
  server?.running.kill("SIGKILL");
  controller?.running.kill();
  rmSync(folder, { recursive: true });
});

/** The view, with these options. */
async function campaign(options, context = {}) {
  const view = await opened(browser, server.found, context);
  const { page } = view;
  await page.getByRole("link", { name: "Campaign", exact: true }).click();
  for (const [name, value] of Object.entries({ port: line.address().port, bandwidth: 100, period: 5e-5, ...options })) {
    await fill(page, name, String(value));
  }
  return view;
}

/** Agrees to the move. */
async function move(page) {
  await page.getByRole("button", { name: "Start", exact: true }).click();
  await page.getByRole("button", { name: "Move the actuator" }).click();
}

const stopButton = (page) => page.getByRole("button", { name: "Stop", exact: true });

test("a campaign asks before it moves, is stopped, goes on, and ends with a model and a page", { skip, timeout: 400_000 }, async () => {
  const { page, faults, context } = await campaign({ wait: 0.1, ramp: 0.05, operator: "preisach", actuator: "pl140", driver: "pl140" });
  await page.getByRole("button", { name: "Query the controller" }).click();
  await page.getByText(/simulated controller with pl140/).first().waitFor();
  await page.getByRole("button", { name: "Start", exact: true }).click();
  const dialog = page.getByRole("dialog");
  await dialog.getByText("\u221228.5 and 28.5 V").waitFor();
  assert.match(await dialog.textContent(), /Axis 1 of piezoid, E-727.*for about \d+ s.*Records: small, rise1, rise2, rise3, creep, path\./);
  await viewed(page, "agreement", false);
  await page.getByRole("button", { name: "Do not move" }).click();
  assert.ok(!log.some(({ text }) => /SVA|WGO/.test(text)), "nothing has moved");

  await move(page);
  await page.getByText("Record small", { exact: true }).waitFor({ timeout: 60_000 });
  await page.locator(".parts .now", { hasText: "record rise1" }).waitFor({ timeout: 60_000 });
  await page.waitForFunction(() => /\d/.test(document.querySelector(".readings dd").textContent));
  await page.locator(".stop span", { hasText: "the drive is played" }).waitFor({ timeout: 60_000 });
  await page.waitForTimeout(700);
  if (SHOTS) await page.screenshot({ path: join(SHOTS, "running-1280-light.png"), fullPage: true });
  await stopButton(page).click();
  const fault = await page.getByRole("alert").textContent();
  assert.match(fault, /cancelled: record rise1.*axis 1 is at \S+ V, in open loop, and wave generator 1 is stopped/);
  await page.getByText("1 new record is in the project").waitFor();
  await viewed(page, "stopped");
  assert.ok(readdirSync(folder).includes("campaign-small.csv"));

  await page.getByText(/Go on with what an earlier campaign has measured.*: small/).waitFor();
  await page.getByRole("button", { name: "Start", exact: true }).click();
  await dialog.getByText("Measured earlier, and not again: small.").waitFor();
  await page.getByRole("button", { name: "Move the actuator" }).click();
  await page.locator(".stop b", { hasText: /^Record creep$/ }).waitFor({ timeout: 200_000 });
  await page.locator(".stop span", { hasText: "the drive is played" }).waitFor({ timeout: 60_000 });
  await page.waitForTimeout(4000);
  await viewed(page, "creep");
  await page.getByRole("heading", { name: "Result" }).waitFor({ timeout: 300_000 });
  await page.getByText("smaller rms error than with a straight line").waitFor();
  await viewed(page, "result");
  const html = await download(page, () => page.getByRole("button", { name: "Download campaign.html" }).click());
  assert.match(String(html), /^<!DOCTYPE html>.*Tracking/s);
  await written(() => {
    const project = JSON.parse(readFileSync(join(folder, "project.json"), "utf8"));
    const uses = Object.fromEntries(project.records.map(({ file, use }) => [file, use]));
    assert.deepEqual(uses, {
      "campaign-small.csv": "small-signal", "campaign-rise1.csv": "training", "campaign-rise2.csv": "training",
      "campaign-rise3.csv": "training", "campaign-creep.csv": "training", "campaign-path.csv": "validation",
    });
    assert.equal(project.models[0]?.file, "campaign-model.json");
    assert.equal(project.models[0].from.length, 5);
  });
  const results = JSON.parse(readFileSync(join(folder, "campaign.json"), "utf8"));
  assert.deepEqual(results.resumed, ["small"]);
  assert.ok(results.better > 2, `${results.better} times better`);
  assert.deepEqual(faults, []);
  await context.close();
});

for (const [moment, options] of [["slow move", { ramp: 4 }], ["the drive is played", { ramp: 0.05 }], ["settling", { wait: 5, ramp: 0.05 }]]) {
  test(`Stop reaches the controller within 200 ms: ${moment}`, { skip, timeout: 200_000 }, async (message) => {
    const times = [];
    const { page, context } = await campaign({ wait: 0.1, ...options });
    const again = page.getByRole("checkbox", { name: /^Go on with/ });
    if (await again.count()) await again.uncheck();
    await page.evaluate(() =>
      addEventListener("click", (event) => (globalThis.clicked = performance.timeOrigin + event.timeStamp), true));
    for (let k = 0; k < 5; k++) {
      await move(page);
      await page.locator(".stop span", { hasText: moment }).waitFor({ timeout: 60_000 });
      await page.waitForTimeout(150 + 61 * k);
      log.length = 0;
      await stopButton(page).click();
      await page.getByRole("alert").getByText("wave generator 1 is stopped").waitFor();
      const clicked = await page.evaluate(() => globalThis.clicked);
      const stopped = log.findIndex(({ text }) => text.includes("WGO 1 0"));
      assert.ok(!log.slice(stopped + 1).some(({ text }) => /SVA|WGO 1 1|SVO/.test(text.replace("SVO?", ""))), "it moves no more");
      times.push(log[stopped].time - clicked);
    }
    times.sort((a, b) => a - b);
    message.diagnostic(`${moment}: ${times.map((time) => time.toFixed(0)).join(", ")} ms`);
    assert.ok(times[2] <= 200, `median of ${times.map((time) => time.toFixed(0))} ms`);
    await context.close();
  });
}
