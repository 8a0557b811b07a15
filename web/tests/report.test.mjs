// Reports in a browser, opened from a file: plots answer to the hand, ask no network, and give way to drawings in print
// and without scripts.
import assert from "node:assert/strict";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { FIGURES, figures } from "../figures.mjs";
import { launched, skip } from "./browser.mjs";
import { call, measured } from "./modules.mjs";

let folder, browser, address, text;

/** The report on a model, made by the library. */
function report() {
  const record = measured("record.csv", { kind: "rising-sine", frequency: 5, amplitude: 28, ts: 1e-3, duration: 2 });
  const large = { large_signal: [record.name] };
  const [model] = call({ call: "identify", options: { operator: "pi" }, files: large }, [record]).files;
  const files = { model: [model.name], data: [record.name] };
  return new TextDecoder().decode(call({ call: "report", files }, [model, record]).files[0].bytes);
}

before(async () => {
  if (skip) return;
  folder = mkdtempSync(join(tmpdir(), "report-"));
  text = report();
  writeFileSync(join(folder, "report.html"), text);
  address = `file://${folder}/report.html`;
  browser = await launched();
});

after(async () => {
  await browser?.close();
  if (folder) rmSync(folder, { recursive: true });
});

/** The report in a window; at the end nothing may have been wrong, and nothing asked for but the file. */
async function opened(settings, use) {
  const page = await browser.newPage({ viewport: { width: 1280, height: 900 }, ...settings });
  const wrong = [];
  page.on("console", (message) => wrong.push(message.text()));
  page.on("pageerror", (error) => wrong.push(error.message));
  page.on("request", (request) => request.url() !== address && !request.url().startsWith("blob:") && wrong.push(request.url()));
  await page.goto(address);
  try {
    await use(page);
    assert.deepEqual(wrong, []);
  } finally {
    await page.close();
  }
}

/** The figure of time series: two plots, of y and of the error. */
const series = (page) => page.locator("figure", { hasText: "Time series" });

/** The data of its plots. */
const data = async (page) => JSON.parse(await series(page).locator("script").textContent());

/** What is drawn of a plot; nothing before it is drawn. */
const drawn = (plot) =>
  plot.locator("canvas").first().evaluate((canvas) => {
    const blank = document.createElement("canvas");
    [blank.width, blank.height] = [canvas.width, canvas.height];
    const image = canvas.toDataURL();
    return image === blank.toDataURL() ? "" : image;
  });

/** A file that a button gives. */
async function input(page, button) {
  const [download] = await Promise.all([page.waitForEvent("download"), button.click()]);
  return { name: download.suggestedFilename(), text: readFileSync(await download.path(), "utf8") };
}

/** Waits until a plot is drawn in another way. */
async function redrawn(plot, before) {
  for (let tries = 0; tries < 100; tries++) {
    const now = await drawn(plot);
    if (now !== before) return now;
    await new Promise((done) => setTimeout(done, 20));
  }
  assert.fail("the plot stays as it was");
}

test("the script in reports is the one that is built", async () => {
  const built = await figures();
  assert.ok(readFileSync(FIGURES, "utf8") === built, "run `cargo xtask web` and commit crates/piezoid-report/src/page/figures.js");
});

test("every drawing becomes plots", { skip }, () =>
  opened({}, async (page) => {
    const drawings = await page.locator(".drawing").count();
    assert.ok(drawings > 5);
    await page.locator("details").evaluateAll((all) => all.forEach((one) => (one.open = true)));
    assert.equal(await page.locator(".drawing.live").count(), drawings);
    assert.equal(await page.locator(".drawing > svg:visible").count(), 0);
    assert.ok((await page.locator(".drawing .stage:visible").count()) >= drawings);
  }));

test("the wheel zooms a plot that has the focus, and a double click shows all", { skip }, () =>
  opened({}, async (page) => {
    const plot = series(page).locator(".plot").first();
    await plot.scrollIntoViewIfNeeded();
    const all = await redrawn(plot, "");
    const top = await page.evaluate(() => scrollY);
    await plot.locator(".stage").click();
    await page.mouse.wheel(0, -400);
    const zoomed = await redrawn(plot, all);
    assert.equal(await page.evaluate(() => scrollY), top, "the page does not scroll");
    await plot.locator(".stage").dblclick();
    assert.ok((await redrawn(plot, zoomed)) === all);
  }));

test("the cursor tells the values of all series", { skip }, () =>
  opened({}, async (page) => {
    const plot = series(page).locator(".plot").first();
    await plot.scrollIntoViewIfNeeded();
    await redrawn(plot, "");
    await plot.locator(".stage").hover();
    const message = await plot.locator(".readout").textContent();
    assert.match(message, / s \u00b7 .*measured .* \u00b5m/);
    assert.match(message, /model .* \u00b5m/);
  }));

test("a name hides its series, and a legend of several plots hides it in all", { skip }, () =>
  opened({}, async (page) => {
    const plot = series(page).locator(".plot").first();
    await plot.scrollIntoViewIfNeeded();
    const all = await redrawn(plot, "");
    const button = plot.getByRole("button", { name: "model" });
    await button.click();
    const without = await redrawn(plot, all);
    assert.equal(await button.getAttribute("aria-pressed"), "false");
    await button.click();
    assert.ok((await redrawn(plot, without)) === all);

    const loops = page.locator("figure.plates", { hasText: "without the straight line" }).first();
    await loops.scrollIntoViewIfNeeded();
    const plots = await loops.locator("div.plot").all();
    assert.equal(plots.length, 2);
    const before = await Promise.all(plots.map((one) => redrawn(one, "")));
    await loops.locator(".keys").getByRole("button", { name: "measured" }).click();
    await Promise.all(plots.map((one, k) => redrawn(one, before[k])));
  }));

test("a plot is given as CSV with its numbers, and as SVG", { skip }, () =>
  opened({ colorScheme: "dark" }, async (page) => {
    const plot = series(page).locator(".plot").first();
    await plot.scrollIntoViewIfNeeded();
    await redrawn(plot, "");
    const csv = await input(page, plot.getByRole("button", { name: "CSV", exact: true }));
    assert.match(csv.name, /^Time-series-y\.csv$/);
    const [head, ...rows] = csv.text.trimEnd().split("\n").map((line) => line.split(","));
    assert.deepEqual(head, ["t [s]", "measured: y [\u00b5m]", "t [s]", "model: y [\u00b5m]"]);
    const stored = (await data(page))[0].panels[0].series;
    stored.forEach(({ y, x, start, step }, k) => {
      const column = (j) => rows.map((row) => row[j]).filter((cell) => cell !== "").map(Number);
      assert.deepEqual(column(2 * k + 1), y);
      const places = x ?? y.map((_, n) => Number((start + n * step).toPrecision(15)));
      assert.deepEqual(column(2 * k), places);
    });
    const svg = await input(page, plot.getByRole("button", { name: "SVG" }));
    const marks = await page.evaluate((text) => {
      const parsed = new DOMParser().parseFromString(text, "image/svg+xml");
      return [parsed.querySelector("parsererror") === null, parsed.querySelectorAll("path").length, parsed.documentElement.textContent];
    }, svg.text);
    assert.ok(marks[0] && marks[1] > 5 && marks[2].includes("measured"));
    assert.match(svg.text, /#00805b/, "the colours of paper, in dark too");
    assert.equal(await page.evaluate(() => document.documentElement.dataset.theme), undefined);
  }));

test("in print stand the drawings", { skip }, () =>
  opened({ colorScheme: "dark" }, async (page) => {
    await page.emulateMedia({ media: "print" });
    assert.equal(await page.locator("canvas:visible").count(), 0);
    assert.equal(await page.locator(".plot:visible").count(), 0);
    assert.equal(await page.locator(".drawing > svg:visible").count(), await page.locator(".drawing").count());
  }));

test("without scripts the drawings stay", { skip }, () =>
  opened({ javaScriptEnabled: false }, async (page) => {
    assert.equal(await page.locator("canvas").count(), 0);
    await page.locator("summary").click();
    assert.equal(await page.locator(".drawing > svg:visible").count(), await page.locator(".drawing").count());
    assert.equal(await page.locator("script:visible").count(), 0);
  }));

test("a phone shows all without scrolling sideways", { skip }, () =>
  opened({ viewport: { width: 390, height: 844 }, deviceScaleFactor: 3, hasTouch: true, isMobile: true }, async (page) => {
    assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), 390);
    const sizes = await page.locator(".stage").evaluateAll((all) => all.map((one) => one.clientWidth));
    assert.ok(sizes.every((width) => width > 300 && width < 390), String(sizes));
    const held = () => page.evaluate(() => [...document.querySelectorAll("canvas")].reduce((n, c) => n + c.width * c.height, 0));
    const plot = series(page).locator(".plot").first();
    await plot.scrollIntoViewIfNeeded();
    await redrawn(plot, "");
    assert.ok((await held()) < 20e6, "only plots near the screen have pixels");
  }));

test("the choice of light and dark is that of the plots", { skip }, () =>
  opened({}, async (page) => {
    const plot = series(page).locator(".plot").first();
    await plot.scrollIntoViewIfNeeded();
    const light = await redrawn(plot, "");
    await page.locator(".theme").evaluate((button) => button.click());
    await redrawn(plot, light);
  }));
