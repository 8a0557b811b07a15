// A model is the same wherever it is identified, and states what repeats it: command line, `piezoid serve`, static page.
// (Python is compared with the command line in crates/piezoid-py/tests/test_identify.py.)
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { download, launched, opened, served, skip as noBrowser } from "./browser.mjs";
import { fill } from "./steps.mjs";
import { PIEZOID, piezoid as run, skip as noPiezoid } from "./piezoid.mjs";

const skip = noBrowser || noPiezoid;
const cwd = mkdtempSync(join(tmpdir(), "piezoid-origin-"));
const piezoid = (...words) => run(cwd, ...words);
let browser, server, running;

before(async () => {
  if (skip) return;
  [browser, server] = await Promise.all([launched(), served()]);
  piezoid(..."excite rising-sine --amplitude 28 --frequency 5 --ts 0.5ms --duration 2 -o u.csv".split(" "));
  piezoid(..."simulate u.csv --plant pl140 -o log.mat".split(" "));
  piezoid(..."identify log.mat --operator pi --order 2 --elements 8 --from 0.1 --output-scale 2 -o line.json".split(" "));
});
after(async () => {
  await browser?.close();
  server?.close();
  running?.kill("SIGKILL");
  rmSync(cwd, { recursive: true });
});

/** The address of `piezoid serve`. */
async function native() {
  running = spawn(PIEZOID, ["serve", "project", "--port", "0"], { cwd, stdio: ["ignore", "pipe", "ignore"] });
  for await (const piece of running.stdout) {
    const address = String(piece).match(/http:\/\/\S+/)?.[0];
    if (address) return address;
  }
}

/** The model that the page identifies, with the options of the command line above. */
async function identified(url) {
  const { page, faults, context } = await opened(browser, url);
  await page.getByLabel("Data files").setInputFiles(join(cwd, "log.mat"));
  await page.getByText(/4,000 samples/).waitFor();
  await fill(page, "from", "0.1");
  await fill(page, "output_scale", "2");
  await page.getByText("cut from 0.1 s").waitFor();
  for (const [name, value] of [["operator", "pi"], ["order", "2"], ["elements", "8"]]) await fill(page, name, value);
  await page.getByRole("button", { name: "Identify", exact: true }).click();
  await page.locator(".verdict").first().waitFor({ timeout: 120_000 });
  const model = await download(page, () => page.getByRole("button", { name: "Download the model" }).click());
  assert.deepEqual(faults, []);
  await context.close();
  return model;
}

/** The model of the command line under the name of another front end. */
function line(command) {
  const model = JSON.parse(readFileSync(join(cwd, "line.json")));
  assert.equal(model.fit.command, "piezoid identify");
  return { ...model, fit: { ...model.fit, command } };
}

test("the model of `piezoid serve` is that of the command line to the bit", { skip, timeout: 180_000 }, async () => {
  const model = await identified(await native());
  assert.deepEqual(JSON.parse(model), line("piezoid serve"));
  writeFileSync(join(cwd, "serve.json"), model);
  assert.match(piezoid("identify", "--again", "serve.json", "log.mat"), /Equal to serve.json to the bit/);
});

test("the model of the static page is that of the command line to the bit", { skip, timeout: 180_000 }, async () => {
  const model = await identified(server.url);
  assert.deepEqual(JSON.parse(model), line("piezoid page"));
  writeFileSync(join(cwd, "page.json"), model);
  assert.match(piezoid("identify", "--again", "page.json", "log.mat"), /Equal to page.json to the bit/);
});
