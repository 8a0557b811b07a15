// Moves in time in the page of `piezoid serve`: on the model and a twin, then on a simulated controller.
import assert from "node:assert/strict";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { download, launched, opened, skip as noBrowser } from "./browser.mjs";
import { overheard, skip as noPiezoid, started } from "./piezoid.mjs";
import { identify, known } from "./steps.mjs";
import { viewed } from "./viewed.mjs";

const skip = noBrowser || noPiezoid;
const folder = mkdtempSync(join(tmpdir(), "piezoid-moves-"));
const log = [];
let browser, server, controller, line;

before(async () => {
  if (skip) return;
  browser = await launched();
  server = await started(["serve", folder, "--port", "0"], /http:\/\/\S+/);
  controller = await started(["instrument", "--plant", "pl140", "--port", "0"], /port \d+/);
  line = await overheard(controller, (text) => log.push(text));
});
after(async () => {
  await browser?.close();
  line?.close();
  server?.running.kill("SIGKILL");
  controller?.running.kill();
  rmSync(folder, { recursive: true });
});

test("moves are timed on the model, on a twin, and on a controller once its user agrees", { skip, timeout: 240_000 }, async () => {
  const { page, faults, context } = await opened(browser, server.found);
  await page.getByRole("button", { name: "Open the example" }).click();
  await page.getByRole("button", { name: "staircase.csv", exact: true }).waitFor();
  await identify(page, "preisach");
  await known(page, "preisach");
  await page.getByRole("link", { name: "Compensate", exact: true }).click();
  // The controller is this twin: no stand-in is needed.
  await page.getByRole("button", { name: "Cancel", exact: true }).click();
  await page.getByRole("combobox", { name: /^Plant/ }).selectOption("pl140");
  const limits = page.getByRole("region", { name: "Limits and shaping" });
  await limits.locator("select[name=driver]").selectOption("pl140");
  await fill(limits, "smooth", "12ms");

  await page.getByRole("button", { name: "Moves in time" }).click();
  const moves = page.getByRole("region", { name: "Moves in time" });
  await moves.getByRole("button", { name: "a step up and down" }).click();
  for (const [name, value] of [["tolerance", "5um"], ["step", "200um"]]) await fill(moves, name, value);
  await moves.getByRole("button", { name: "Time the moves" }).click();
  const cells = (run) => moves.getByRole("region", { name: "Runs", exact: true }).locator("tr", { hasText: run }).locator("td");
  await cells("pl140, compensated").first().waitFor({ timeout: 60_000 });
  const slowest = async (run) => Number(await cells(run).nth(2).textContent());
  const [onModel, onTwin] = [await slowest("model, compensated"), await slowest("pl140, compensated")];
  assert.ok(onModel > 5 && Math.abs(onModel - onTwin) <= 2.1, `${onModel} ms on the model, ${onTwin} ms on the twin`);
  await moves.getByRole("button", { name: "2", exact: true }).click();
  await moves.getByText("Step 2, and when each run has settled").first().waitFor({ state: "attached" });
  await viewed(page, "moves");
  const text = String(await download(page, () => moves.getByRole("button", { name: "Download timing.csv" }).click()));
  assert.match(text, /^t_s,u_V,r_um,model_compensated_um,model_straight_line_um,pl140_compensated_um,pl140_straight_line_um\n/);

  await moves.locator("summary", { hasText: "On a controller" }).click();
  for (const [name, value] of [["port", line.address().port], ["wait", 0.1]]) await fill(moves, name, value);
  await moves.getByRole("button", { name: "Time them on the controller" }).click();
  await page.getByRole("dialog").getByText("it is demagnetised twice").waitFor();
  await page.getByRole("button", { name: "Do not move" }).click();
  assert.equal(log.length, 0, "nothing was asked of the controller");
  await moves.getByRole("button", { name: "Time them on the controller" }).click();
  await page.getByRole("button", { name: "Move the actuator" }).click();
  await moves.getByText("The actuator moves.").waitFor();
  await cells("controller, compensated").first().waitFor({ timeout: 120_000 });
  const onController = await slowest("controller, compensated");
  assert.ok(Math.abs(onController - onTwin) <= 1.1, `${onController} ms on the controller, ${onTwin} ms on the twin`);
  await moves.getByText("Axis 1 is at 0.000 V, in open loop", { exact: false }).or(moves.getByText("axis 1 is at 0.000 V, in open loop")).first().waitFor();
  await viewed(page, "controller");

  log.length = 0;
  await moves.getByRole("button", { name: "Time them on the controller" }).click();
  await page.getByRole("button", { name: "Move the actuator" }).click();
  while (!log.some((text) => text.includes("WGO 1 1"))) await page.waitForTimeout(50);
  await moves.getByRole("button", { name: "Stop", exact: true }).click();
  await moves.getByRole("alert").getByText(/axis 1 is at \S+ V, in open loop/).waitFor({ timeout: 20_000 });
  assert.deepEqual(faults, []);
  await context.close();
});

/** Fills the field of an option, opening its group if need be. */
async function fill(within, name, value) {
  const field = within.locator(`[name="${name}"]`);
  await field.waitFor({ state: "attached" });
  while (!(await field.isVisible())) {
    await within.locator("details:not([open])", { has: within.page().locator(`[name="${name}"]`) }).first().locator("summary").first().click();
  }
  await field.fill(String(value));
  await field.blur();
}
