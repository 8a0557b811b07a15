// The whole way by keyboard alone, from files to an exported compensation: Tab, Enter, Space, arrows and text. At every
// stop the focus is seen, and nothing covers it.
import assert from "node:assert/strict";
import { test } from "node:test";
import { fixture, opened, skip } from "./browser.mjs";
import { csv, measured, scope } from "./records.mjs";

const site = fixture();

const file = (name, buffer) => ({ name, mimeType: "text/csv", buffer });

/** The control that has the focus: its name, its part of the page, and what is wrong with how it is seen. */
const focused = (page) => page.evaluate(() => {
  const one = document.activeElement;
  const text = (node) => node?.textContent.replace(/\s+/g, " ").trim() ?? "";
  const label = one.labels?.[0]?.cloneNode(true);
  label?.querySelectorAll("select, input").forEach((control) => control.remove());
  const name = one.getAttribute("aria-label") ?? (text(label) || text(one));
  const part = one.closest("header, nav, main")?.tagName.toLowerCase() ?? "page";
  const box = one.getBoundingClientRect();
  const style = getComputedStyle(one);
  const [x, y] = [(Math.max(0, box.left) + Math.min(innerWidth, box.right)) / 2, (Math.max(0, box.top) + Math.min(innerHeight, box.bottom)) / 2];
  const top = document.elementFromPoint(x, y);
  const flaws = [
    box.width === 0 || box.height === 0 ? "has no size" : "",
    box.bottom <= 0 || box.top >= innerHeight || box.right <= 0 || box.left >= innerWidth ? "is outside of the window" : "",
    style.outlineStyle === "none" || parseFloat(style.outlineWidth) < 2 ? `has the outline ${style.outline}` : "",
    top && !one.contains(top) && !top.contains(one) ? `is below ${top.outerHTML.slice(0, 80)}` : "",
  ].filter(Boolean);
  return { name, part, flaws, tag: one.tagName, isBody: one === document.body };
});

/** Presses Tab until a control of this name has the focus. */
async function tab(page, name, key = "Tab") {
  const stops = [];
  for (let k = 0; k < 90; k++) {
    await page.keyboard.press(key);
    const now = await focused(page);
    if (now.isBody) continue;
    assert.deepEqual(now.flaws, [], `${now.tag} “${now.name.slice(0, 60)}” on the way to ${name}`);
    stops.push(now);
    if (name instanceof RegExp ? name.test(now.name) : now.name === name) return stops;
  }
  assert.fail(`${name} is not reached: ${stops.map((stop) => stop.name.slice(0, 30)).join(" | ")}`);
}

/** Chooses in the select that has the focus by arrows. */
async function choose(page, value) {
  const now = () => page.evaluate(() => [document.activeElement.value, document.activeElement.selectedIndex, [...document.activeElement.options].map((one) => one.value)]);
  const [, at, all] = await now();
  const to = all.indexOf(value);
  assert.ok(to >= 0, `${value} of ${all}`);
  for (let k = 0; k < Math.abs(to - at); k++) await page.keyboard.press(to > at ? "ArrowDown" : "ArrowUp");
  assert.equal((await now())[0], value);
}

test("files, roles, identification, verdict, Compensate and an export, by keyboard alone", { skip, timeout: 300_000 }, async () => {
  const { page, faults, context } = await opened(site.browser, site.server.url);
  // The dialog of the browser is taken over from now on.
  const chosen = page.waitForEvent("filechooser", { timeout: 60_000 });
  await page.getByRole("button", { name: "Choose files" }).waitFor();
  const [first] = await tab(page, "Skip to the view");
  assert.equal(first.part, "page", "the first stop leaves out header and views");
  const parts = (await tab(page, "Choose files")).map(({ part }) => part);
  assert.deepEqual([...new Set(parts)], ["header", "nav", "main"], "header, views and view follow each other");
  assert.equal(parts.filter((part) => part === "main").length, 1, "it is the first of the view");
  await page.keyboard.press("Enter");
  await (await chosen).setFiles([file("slow.csv", csv(measured(5))), file("fast.csv", csv(measured(20))), file("scope.csv", scope(measured(10, 25)))]);

  // Roles, a factor and the use of the one that is not decided.
  await page.getByText("the roles of scope.csv are not decided").waitFor();
  await tab(page, "Use of scope.csv");
  await choose(page, "validation");
  await tab(page, "Role of CH1");
  await choose(page, "input");
  await tab(page, "Role of CH2");
  await choose(page, "output");
  await page.getByText(/4,000 samples/).waitFor();
  await tab(page, "Units, rate and part");
  await page.keyboard.press("Enter");
  await tab(page, "Output scale");
  await page.keyboard.type("100um/V");
  await page.keyboard.press("Tab");
  await page.getByText(/4,000 samples.* output in .m/).waitFor();

  // A picture by its button, zoomed and moved by keys.
  await tab(page, "Loop");
  await page.keyboard.press("Space");
  await page.getByRole("img", { name: /^Loop/ }).first().waitFor();
  await tab(page, /^Loop\. Output/);
  await page.keyboard.press("+");

  await tab(page, "Operators, effort, order");
  await page.keyboard.press("Enter");
  await tab(page, "Operator");
  await page.keyboard.type("pi");
  await tab(page, "Identify", "Shift+Tab");
  await page.keyboard.press("Enter");
  await page.locator(".verdict", { hasText: "free run on scope.csv" }).waitFor({ timeout: 120_000 });
  await tab(page, "Compensate a path");
  await page.keyboard.press("Enter");

  await page.getByRole("combobox", { name: "Model" }).waitFor();
  const path = await tab(page, "Model");
  assert.equal(path.length, 1, "a view begins with its first control");
  // A point of the path is moved by arrows.
  await page.getByRole("slider", { name: /^Height of the path at 0\.08/ }).waitFor();
  const point = await tab(page, /^Height of the path at 0\.08/);
  assert.ok(point.length < 60);
  const height = () => page.evaluate(() => Number(document.activeElement.getAttribute("aria-valuenow")));
  const before = await height();
  await page.keyboard.press("ArrowUp");
  await page.waitForFunction((value) => Number(document.activeElement.getAttribute("aria-valuenow")) > value, before);
  await page.getByRole("link", { name: "Export the compensation" }).waitFor();
  await tab(page, "Export the compensation");
  await page.keyboard.press("Enter");

  await page.getByRole("heading", { name: "Export", level: 1 }).waitFor();
  await tab(page, /^waveform/);
  await page.keyboard.press("Space");
  await tab(page, "Export as waveform");
  await page.keyboard.press("Enter");
  await page.getByRole("region", { name: "Exported files" }).waitFor();
  assert.equal((await focused(page)).name.slice(0, 40), "Export as waveform", "the focus stays");
  await tab(page, "Download piezo_model.csv");
  const [got] = await Promise.all([page.waitForEvent("download"), page.keyboard.press("Enter")]);
  assert.equal(got.suggestedFilename(), "piezo_model.csv");
  assert.deepEqual(faults, []);
  await context.close();
});
