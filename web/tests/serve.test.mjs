// The page from `piezoid serve`: the same work, in native processes, with the project in a folder.
import assert from "node:assert/strict";
import { execFileSync, spawn } from "node:child_process";
import { existsSync, mkdtempSync, readdirSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { launched, opened, skip as noBrowser } from "./browser.mjs";

const target = process.env.CARGO_TARGET_DIR ?? new URL("../../target", import.meta.url).pathname;
const PIEZOID = join(target, "debug/piezoid");
const skip = noBrowser || (existsSync(PIEZOID) || process.env.CI ? false : `no ${PIEZOID}: cargo build -p piezoid-cli`);
const folder = mkdtempSync(join(tmpdir(), "piezoid-project-"));
let browser, running;

before(async () => {
  if (!skip) browser = await launched();
});
after(async () => {
  await browser?.close();
  running?.kill("SIGKILL");
  rmSync(folder, { recursive: true });
});

/** Starts the server, and waits for the address that it prints. */
async function served(port = 0) {
  running = spawn(PIEZOID, ["serve", folder, "--port", String(port)], { stdio: ["ignore", "pipe", "inherit"] });
  let printed = "";
  for await (const piece of running.stdout) {
    printed += piece;
    const url = printed.match(/http:\/\/\S+/)?.[0];
    if (url) return url;
  }
  throw new Error(`the server ended: ${printed}`);
}

/** A record of the simulated bender in a file of its own folder. */
function measured(name) {
  const cwd = mkdtempSync(join(tmpdir(), "piezoid-record-"));
  const run = (line) => execFileSync(PIEZOID, line.split(" "), { cwd, stdio: "ignore" });
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
  const identify = async () => {
    await page.getByRole("link", { name: "Identify", exact: true }).click();
    await page.getByLabel("Operator", { exact: true }).fill("pi");
    await page.getByLabel("Operator", { exact: true }).blur();
    await page.getByRole("button", { name: "Identify", exact: true }).click();
  };
  await identify();
  await page.locator(".verdict").first().waitFor({ timeout: 120_000 });
  await page.waitForTimeout(500);
  assert.deepEqual(faults, []);
  const kept = readdirSync(folder).filter((name) => !name.startsWith("."));
  assert.deepEqual(kept.sort(), ["prandtl-ishlinskii.json", "project.json", "slow.csv"]);
  assert.equal(JSON.parse(readFileSync(join(folder, "prandtl-ishlinskii.json"))).hysteresis.operator, "prandtl-ishlinskii");

  running.kill("SIGKILL");
  await new Promise((ended) => running.on("exit", ended));
  await identify();
  await page.getByRole("alert").getByText("start it again in the same folder").first().waitFor();

  await served(new URL(url).port);
  await identify();
  await page.getByRole("button", { name: "prandtl-ishlinskii-2.json", exact: true }).waitFor({ timeout: 120_000 });
  await page.waitForTimeout(500);
  await page.reload();
  await page.getByRole("link", { name: "Data", exact: true }).click();
  await page.getByRole("button", { name: "slow.csv", exact: true }).waitFor();
  await context.close();
});
