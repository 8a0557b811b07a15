// The page from `piezoid serve`: the same work, in native processes, with the project in a folder.
import assert from "node:assert/strict";
import { copyFileSync, existsSync, mkdtempSync, readdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { launched, opened, skip as noBrowser } from "./browser.mjs";
import { identify as begun, known, written } from "./steps.mjs";
import { piezoid, skip as noPiezoid, started } from "./piezoid.mjs";

const skip = noBrowser || noPiezoid;
const folder = mkdtempSync(join(tmpdir(), "piezoid-project-"));
let browser, running, controller;

before(async () => {
  if (!skip) browser = await launched();
});
after(async () => {
  await browser?.close();
  running?.kill("SIGKILL");
  controller?.kill();
  rmSync(folder, { recursive: true });
});

/** Starts the server, and waits for the address that it prints. */
async function served(port = 0) {
  running?.kill("SIGKILL");
  const server = await started(["serve", folder, "--port", String(port)], /http:\/\/\S+/);
  running = server.running;
  return server.found;
}

/** A record of the simulated bender in a file of its own folder. */
function measured(name) {
  const cwd = mkdtempSync(join(tmpdir(), "piezoid-record-"));
  const run = (line) => piezoid(cwd, ...line.split(" "));
  run("excite rising-sine --amplitude 28V --frequency 5Hz --ts 0.5ms --duration 2s -o u.csv");
  run(`simulate u.csv --plant pl140 -o ${name}`);
  return join(cwd, name);
}

test("a project lives in a folder, and outlasts a server that is killed", { skip, timeout: 180_000 }, async () => {
  const url = await served();
  const { page, faults, context } = await opened(browser, url);
  await page.getByText("on this computer").waitFor();
  await page.getByLabel("Data files").setInputFiles(measured("slow.csv"));
  await page.getByText(/4,000 samples/).waitFor();
  const identify = () => begun(page, "pi");
  await identify();
  await page.locator(".verdict").first().waitFor({ timeout: 120_000 });
  await written(() => {
    const kept = readdirSync(folder).filter((name) => !name.startsWith("."));
    assert.deepEqual(kept.sort(), ["prandtl-ishlinskii.json", "project.json", "slow.csv"]);
    assert.match(readFileSync(join(folder, "project.json"), "utf8"), /"file": "prandtl-ishlinskii.json"/);
  });
  assert.deepEqual(faults, []);
  assert.equal(JSON.parse(readFileSync(join(folder, "prandtl-ishlinskii.json"))).hysteresis.operator, "prandtl-ishlinskii");

  running.kill("SIGKILL");
  await new Promise((ended) => running.on("exit", ended));
  await identify();
  await page.getByRole("alert").getByText("start it again in the same folder").first().waitFor();

  // Another program at this port gets nothing; then the server is there again, with another key.
  const heard = [];
  const foreign = createServer((request, response) => {
    heard.push(`${request.method} ${request.url.split("?")[0]} ${request.headers.authorization ?? ""}`);
    response.end("{}");
  });
  await new Promise((listens) => foreign.listen(new URL(url).port, "127.0.0.1", listens));
  await page.getByRole("button", { name: "Undo" }).click();
  await page.getByRole("button", { name: "Redo" }).click();
  await page.getByRole("alert").getByText("another server answers at this address").first().waitFor();
  assert.deepEqual([...new Set(heard)], ["GET /api/health "]);
  foreign.closeAllConnections();
  await new Promise((closed) => foreign.close(closed));
  const later = await served(new URL(url).port);
  assert.notEqual(later, url);
  const other = await context.newPage();
  await other.goto(later);
  await other.close();
  await identify();
  await page.getByRole("button", { name: "prandtl-ishlinskii-2.json", exact: true }).waitFor({ timeout: 120_000 });
  await page.waitForTimeout(500);
  await page.reload();
  await page.getByRole("button", { name: "slow.csv", exact: true }).waitFor();
  await context.close();
});

test("files of the folder become records where they are", { skip, timeout: 60_000 }, async () => {
  const { page, faults, context } = await opened(browser, await served());
  copyFileSync(measured("other.csv"), join(folder, "other.csv"));
  await page.reload();
  await page.getByText(/more file.* in the project folder/).waitFor();
  // The list of files is open until the records of the project are there.
  await page.getByRole("button", { name: "slow.csv", exact: true }).waitFor();
  const add = page.getByRole("button", { name: "Add other.csv" });
  if (!(await add.isVisible())) await page.getByText(/more file.* in the project folder/).click();
  await add.click();
  await page.getByRole("button", { name: "other.csv", exact: true }).waitFor();
  await written(() => assert.match(readFileSync(join(folder, "project.json"), "utf8"), /"file": "other.csv"/));
  assert.equal(readdirSync(folder).filter((name) => name.startsWith("other")).join(), "other.csv");
  assert.deepEqual(faults, []);
  await context.close();
});

test("drives of a plan are measured on a controller", { skip, timeout: 180_000 }, async () => {
  const instrument = await started(["instrument", "--plant", "paper", "--port", "0"], /port \d+/);
  controller = instrument.running;
  const port = instrument.found.split(" ")[1];
  const { page, faults, context } = await opened(browser, await served());
  await page.getByRole("link", { name: "Experiment", exact: true }).click();
  await page.getByRole("button", { name: "Plan", exact: true }).click();
  const section = page.locator("section").filter({ has: page.getByRole("heading", { name: "Measure on a controller" }) });
  await section.waitFor();
  await section.getByLabel("Port").fill("1");
  await section.getByRole("button", { name: "Query the controller" }).click();
  await section.getByRole("alert").getByText("no controller answers at 127.0.0.1:1").waitFor();
  await section.getByLabel("Port").fill(port);
  await section.getByRole("button", { name: "Query the controller" }).click();
  await section.getByText(/simulated controller/).waitFor();
  await section.getByRole("cell", { name: "\u221230 to 30 V", exact: true }).waitFor();

  await section.getByRole("button", { name: "Measure all drives" }).click();
  await page.getByRole("button", { name: /Cancel/ }).first().waitFor();
  await page.waitForTimeout(2500);
  await page.getByRole("button", { name: /Cancel/ }).first().click();
  await section.getByRole("button", { name: "Measure all drives", disabled: false }).waitFor();
  const where = await section.getByRole("alert").textContent();
  assert.match(where, /cancelled: .*axis 1 is at \S+ V, in open loop|cancelled: .*nothing has moved/);

  await section.getByRole("button", { name: /^Measure (?!all)/ }).click();
  await section.getByText("1 record is in the project").waitFor({ timeout: 60_000 });
  // It is back where Cancel left it.
  const [place] = where.match(/axis 1 is at \S+ V, in open loop/) ?? ["axis 1 is at 0.000 V, in open loop"];
  await section.getByRole("status").getByText(place).waitFor();
  const drive = readdirSync(folder).find((name) => name.startsWith("measured-"));
  const text = readFileSync(join(folder, drive), "utf8");
  assert.match(text, /^# piezoid: measured by the controller piezoid, E-727, simulated controller with paper/);
  assert.deepEqual(faults, []);
  if (process.env.SHOT) await page.screenshot({ path: process.env.SHOT, fullPage: true });
  await context.close();
});

for (const [what, text] of [
  ["of a newer version", '{"piezoid":2,"records":[],"models":[],"future":"precious work"}'],
  ["of another program", '{"name":"my app","version":"1.0"}'],
  ["cut in the middle", '{"piezoid":1,"records":[{"fi'],
  ["with settings that are null", '{"piezoid":1,"records":[],"models":[],"settings":null}'],
  ["with a record that is null", '{"piezoid":1,"records":[null],"models":[]}'],
]) {
  test(`a project ${what} stays, and one is begun beside it`, { skip, timeout: 60_000 }, async () => {
    for (const name of readdirSync(folder)) if (!name.startsWith(".")) rmSync(join(folder, name));
    writeFileSync(join(folder, "project.json"), text);
    const { page, faults, context } = await opened(browser, await served());
    await page.getByRole("alert").getByText("project.json cannot be read").waitFor();
    await page.getByLabel("Data files").setInputFiles(measured("slow.csv"));
    await page.getByText(/4,000 samples/).waitFor();
    await page.waitForTimeout(500);
    assert.ok(!existsSync(join(folder, "project-2.json")));
    if (process.env.SHOT) await page.screenshot({ path: process.env.SHOT });
    await page.getByRole("button", { name: "Begin another project, project-2.json" }).click();
    await written(() => assert.equal(JSON.parse(readFileSync(join(folder, "project-2.json"))).records[0].file, "slow.csv"));
    await page.reload();
    await page.getByRole("button", { name: "slow.csv", exact: true }).waitFor();
    assert.equal(await page.getByRole("alert").count(), 0);
    assert.equal(readFileSync(join(folder, "project.json"), "utf8"), text);
    assert.deepEqual(faults, []);
    await context.close();
  });
}

test("a model of the name of the project is kept under another", { skip, timeout: 120_000 }, async () => {
  for (const name of readdirSync(folder)) if (!name.startsWith(".")) rmSync(join(folder, name));
  const model = join(measured("r.csv"), "../project.json");
  piezoid(join(model, ".."), ..."identify r.csv --operator dahl --order 0 -o".split(" "), model);
  const { page, context } = await opened(browser, await served());
  await page.getByText("on this computer").waitFor();
  const drop = await page.evaluateHandle((text) => {
    const data = new DataTransfer();
    data.items.add(new File([text], "project.json"));
    return data;
  }, readFileSync(model, "utf8"));
  await page.dispatchEvent(".app", "drop", { dataTransfer: drop });
  await written(() => assert.equal(JSON.parse(readFileSync(join(folder, "file-project.json"))).hysteresis.operator, "dahl"));
  await written(() => assert.match(readFileSync(join(folder, "project.json"), "utf8"), /"file": "file-project.json"/));
  await page.reload();
  await known(page, "file-project");
  await context.close();
});
