// The page in Firefox: a record becomes a model and a proof, and all is there after a reload.
import assert from "node:assert/strict";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";
import { launch } from "puppeteer-core";
import { isForeign, lacking, served } from "./browser.mjs";
import { csv, measured } from "./records.mjs";

const FIREFOX = process.env.FIREFOX ?? "/usr/bin/firefox-esr";
const skip = lacking("FIREFOX", FIREFOX);

test("in Firefox a record becomes a model and a proof; all is there after a reload", { skip }, async (sentence) => {
  const folder = mkdtempSync(join(tmpdir(), "piezoid-"));
  const server = await served();
  let browser;
  sentence.after(async () => {
    await browser?.close();
    server.close();
    rmSync(folder, { recursive: true });
  });
  browser = await launch({ browser: "firefox", executablePath: FIREFOX, headless: true });
  const page = await browser.newPage();
  const faults = [];
  page.on("console", (message) => ["error", "warn"].includes(message.type()) && faults.push(message.text()));
  page.on("pageerror", (error) => faults.push(error.message));
  page.on("request", (request) => isForeign(request.url(), server.url) && faults.push(`asked ${request.url()}`));
  const press = (what) => page.locator(what).click();
  const text = async (what) => (await page.waitForSelector(what, { timeout: 120_000 })).evaluate((node) => node.textContent);

  await page.goto(server.url);
  const files = [5, 20].map((hz) => [join(folder, `at${hz}.csv`), csv(measured(hz))]);
  for (const [path, content] of files) writeFileSync(path, content);
  const input = await page.waitForSelector("input[aria-label='Data files']");
  await input.uploadFile(...files.map(([path]) => path));
  await page.waitForSelector("select[aria-label='Use of at20.csv']");
  await page.select("select[aria-label='Use of at20.csv']", "validation");
  await press("::-p-text(Operators, effort, order)");
  await page.locator("input[name=operator]").fill("pi");
  await press("main button.main:not(:disabled)");
  // The verdict of the identification comes first, then that of the proof.
  await page.waitForSelector(".verdict ::-p-text(free run on at20.csv)", { timeout: 120_000 });
  assert.match(await text(".verdict"), /good to [01]\.\d+ % of stroke \(free run on at20\.csv; 0\.\d+ % at identification/);
  await page.waitForSelector("canvas[aria-label*='prandtl-ishlinskii']");
  const drawn = await page.waitForSelector(".plot canvas");
  await page.waitForFunction((canvas) => canvas.width > 0, {}, drawn);

  await new Promise((stored) => setTimeout(stored, 500));
  await page.reload();
  await page.waitForSelector("section[aria-label='Model prandtl-ishlinskii']");
  assert.deepEqual(faults, []);
});
