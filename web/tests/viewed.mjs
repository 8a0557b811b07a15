// What the page looks like while an instrument works.
import assert from "node:assert/strict";
import { mkdirSync, readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";

/** Where pictures are kept, to be looked at. */
export const SHOTS = process.env.SHOTS;
if (SHOTS) mkdirSync(SHOTS, { recursive: true });

const AXE = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");

/** The views whose names do not stand in the header whole. */
export const cut = (page) => page.evaluate(() => [...document.querySelectorAll("nav a")]
  .filter((link) => link.scrollWidth > link.clientWidth || link.getBoundingClientRect().right > innerWidth || link.getBoundingClientRect().left < 0)
  .map((link) => link.textContent));

/** Looks at the page at two widths in both themes: nothing wider than the screen, no serious finding of axe-core. */
export async function viewed(page, name, fullPage = true) {
  for (const [width, theme] of [[1280, "light"], [1280, "dark"], [380, "light"], [380, "dark"]]) {
    await page.setViewportSize({ width, height: width > 500 ? 900 : 800 });
    await page.emulateMedia({ colorScheme: theme });
    await page.waitForTimeout(250);
    if (SHOTS) await page.screenshot({ path: join(SHOTS, `${name}-${width}-${theme}.png`), fullPage });
    await page.evaluate(AXE);
    const { violations } = await page.evaluate(() => globalThis.axe.run(document, { resultTypes: ["violations"] }));
    const grave = violations.filter(({ impact }) => impact === "serious" || impact === "critical");
    assert.deepEqual(grave.map(({ id, nodes }) => `${name}: ${id}: ${nodes[0].html.slice(0, 200)}`), []);
    const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
    assert.ok(wide <= 0, `${name} is ${wide} px wider than the screen`);
    assert.deepEqual(await cut(page), [], `${name}: views that are cut at ${width} px`);
  }
  await page.setViewportSize({ width: 1280, height: 900 });
  await page.emulateMedia({ colorScheme: "light" });
}
