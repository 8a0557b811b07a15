// Every view at two widths in both themes: nothing wider than the screen, no serious finding of axe-core. The pictures
// are kept in dist/pictures, to be looked at.
import assert from "node:assert/strict";
import { mkdirSync, readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { after, before, test } from "node:test";
import { launched, opened, served, skip } from "./browser.mjs";
import { csv, measured } from "./records.mjs";
import { identify, known } from "./steps.mjs";
import { cut } from "./viewed.mjs";

const AXE = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const PICTURES = new URL("../dist/pictures/", import.meta.url).pathname;
const VIEWS = ["Workbench", "Experiment", "Branches", "Compensate", "Control", "Export", "Study"];
let server, browser, saved;

before(async () => {
  if (skip) return;
  mkdirSync(PICTURES, { recursive: true });
  [server, browser] = await Promise.all([served(), launched()]);
  const { page, context } = await opened(browser, server.url);
  await page.getByRole("button", { name: "Open the example" }).click();
  await page.getByRole("button", { name: "staircase.csv", exact: true }).waitFor();
  const { u, y, ts } = measured(5);
  for (const [from, to] of [[900, 903], [2000, 2040]]) y.fill(y[from], from, to);
  await page.getByLabel("Data files").setInputFiles([{ name: "faulty.csv", mimeType: "text/csv", buffer: csv({ u, y, ts }) }]);
  await page.getByRole("heading", { name: "faulty.csv" }).waitFor();
  await page.getByLabel("Use of faulty.csv").selectOption("not used");
  for (const operator of ["prandtl-ishlinskii", "bouc-wen"]) {
    await identify(page, operator);
    await known(page, operator);
  }
  await page.getByRole("link", { name: "Compensate", exact: true }).click();
  await page.getByText("On the stand-in, the error goes").waitFor({ timeout: 240_000 });
  await page.waitForTimeout(500);
  saved = context;
});
after(async () => {
  await browser?.close();
  server?.close();
});

for (const [width, theme] of [[1280, "light"], [1280, "dark"], [390, "light"], [390, "dark"]]) {
  test(`every view, ${width} px, ${theme}`, { skip }, async () => {
    const { page, faults } = await opened(browser, server.url, { context: saved });
    await page.setViewportSize({ width, height: 900 });
    await page.emulateMedia({ colorScheme: theme });
    for (const view of VIEWS) {
      await page.goto(`${server.url}#${view.toLowerCase()}`);
      await page.getByRole("heading", { name: view, level: 1 }).waitFor();
      await page.waitForTimeout(1200);
      await page.screenshot({ path: `${PICTURES}${view.toLowerCase()}-${width}-${theme}.png`, fullPage: true });
      const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
      assert.ok(wide <= 0, `${view} is ${wide} px wider than the screen`);
      assert.deepEqual(await cut(page), [], `views that are cut at ${width} px`);
      await page.evaluate(AXE);
      const { violations } = await page.evaluate(() => globalThis.axe.run(document, { resultTypes: ["violations"] }));
      const grave = violations.filter(({ impact }) => impact === "serious" || impact === "critical");
      assert.deepEqual(grave.map(({ id, nodes }) => `${view}: ${id}: ${nodes[0].html.slice(0, 200)}`), []);
    }
    assert.deepEqual(faults, []);
    await page.close();
  });
}
