// Plots in a browser: what stands in their drawings, on the screen and as SVG.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { launched, skip } from "./browser.mjs";
import { plotPage } from "./plots.mjs";
import { viewed } from "./viewed.mjs";

let browser;
before(async () => void (browser = skip ? undefined : await launched()));
after(() => browser?.close());

/** A page with plots; at the end nothing may have been wrong. */
async function opened(use) {
  const { page, faults } = await plotPage(browser);
  try {
    await use(page);
    assert.deepEqual(faults, []);
  } finally {
    await page.close();
  }
}

/** The SVG of a figure that is made by this script from a record of so many samples. */
const svg = (page, samples, script) =>
  page.evaluate(async ([samples, script]) => {
    const data = record(samples, 4);
    globalThis.figure = new Function("data", script)(data);
    globalThis.plot = new plots.Plot(host("800px", 400), figure);
    await drawn(plot);
    return plot.svg();
  }, [samples, script]);

/** The paths of a colour in an SVG. */
const paths = (text, colour) => [...text.matchAll(/<path d="([^"]*)"[^>]*>/g)].filter(([path]) => path.includes(`stroke="${colour}"`));
const BLUE = "#0072b2";

/** How many pixels of the canvas are painted in a rectangle, and their mean opacity. */
const painted = (page, [x, y, width, height]) =>
  page.evaluate(([x, y, width, height]) => {
    const { data } = document.querySelector("#plot canvas").getContext("2d").getImageData(x, y, width, height);
    const all = Array.from({ length: width * height }, (_, k) => data[4 * k + 3]).filter((value) => value > 0);
    return { share: all.length / (width * height), mean: all.reduce((a, b) => a + b, 0) / all.length };
  }, [x, y, width, height]);

test("parts are lines of their own, with gaps between them", { skip }, () =>
  opened(async (page) => {
    const text = await svg(page, 1000, "return loopFigure(data, { parts: [[0, 250], [500, 750]] })");
    const drawn = paths(text, BLUE);
    assert.equal(drawn.length, 2);
    assert.ok(drawn.every(([, path]) => path.match(/M/g).length === 1), "no line leads from one part to the next");
    const csv = await page.evaluate(() => plots.csv(figure));
    const rows = csv.trimEnd().split("\n").slice(1);
    assert.equal(rows.length, 501);
    assert.equal(rows[250], ",");
    assert.equal(rows[251], await page.evaluate(() => `${figure.panels[0].series[0].x[500]},${figure.panels[0].series[0].y[500]}`));
  }));

test("a time series leaves its gaps empty too, and its axes show the parts alone", { skip }, () =>
  opened(async (page) => {
    const text = await svg(page, 10_000, `
      const figure = timeFigure(data);
      figure.panels = figure.panels.slice(0, 1);
      Object.assign(figure.panels[0].series[0], { colour: 1, parts: [[2000, 4000], [6000, 8000]] });
      return figure;`);
    const ends = paths(text, BLUE).map(([, path]) => {
      const x = [...path.matchAll(/[ML](\S+) /g)].map(([, value]) => Number(value));
      return [Math.min(...x), Math.max(...x)].map(Math.round);
    });
    // The axis goes from sample 2000 to 7999, over pixels 70 to 788.
    const at = (k) => Math.round(70 + (718 * (k - 2000)) / 5999);
    assert.equal(ends.length, 2);
    const expected = [[2000, 3999], [6000, 7999]].flatMap((pair) => pair.map(at));
    assert.ok(ends.flat().every((x, k) => Math.abs(x - expected[k]) <= 1), `${ends} for ${expected}`);
    // Between the parts stand at most lines of the grid.
    assert.ok((await painted(page, [at(4000) + 5, 100, at(6000) - at(4000) - 10, 20])).share < 0.1);
  }));

test("a line of alpha is translucent on the screen and as SVG", { skip }, () =>
  opened(async (page) => {
    const text = await svg(page, 1000, "return loopFigure(data, { alpha: 0.25 })");
    assert.match(paths(text, BLUE)[0][0], /stroke-opacity="0.25"/);
    const strongest = () => page.evaluate(async () => {
      await frame();
      const { data } = document.querySelector("#plot canvas").getContext("2d").getImageData(70, 8, 700, 340);
      // The blue of the series alone; lines of the grid are nearly white.
      return data.reduce((most, value, k) => k % 4 === 3 && data[k - 1] - data[k - 3] > 60 ? Math.max(most, value) : most, 0);
    });
    const translucent = await strongest();
    await page.evaluate(() => {
      const [panel] = figure.panels;
      plot.set({ ...figure, panels: [{ ...panel, series: [{ ...panel.series[0], alpha: 1 }] }] });
    });
    const full = await strongest();
    assert.ok(translucent < 0.6 * full, `${translucent} of ${full}`);
  }));

test("very many samples of a loop are drawn as a density, few as a line", { skip }, () =>
  opened(async (page) => {
    const many = await svg(page, 400_000, "return loopFigure(record(400_000, 400))");
    assert.equal(paths(many, BLUE).length, 0);
    assert.equal([...many.matchAll(/<image [^>]*href="data:image\/png/g)].length, 1);
    const rare = await page.evaluate(async () => {
      // One sample far off is not lost among the others.
      const series = { name: "", colour: 1, style: "density", x: new Float64Array(300_000).fill(5), y: new Float64Array(300_000).fill(5) };
      [series.x[1000], series.y[1000]] = [2, 8];
      const axis = { label: "", unit: "", span: { from: 0, to: 10 } };
      plot.set({ title: "", x: axis, loops: true, panels: [{ y: axis, series: [series] }] });
      await frame();
      const context = document.querySelector("#plot canvas").getContext("2d");
      const at = (x, y) => [...context.getImageData(Math.floor(70 + 71.8 * x), Math.floor(8 + 35.2 * y), 1, 1).data];
      return [at(2, 2), at(5, 5), at(8.3, 8.3)];
    });
    assert.ok(rare[0][3] > 70 && rare[1][3] === 255 && rare[2][3] === 0, JSON.stringify(rare));
    await page.evaluate(() => plot.close());
    const few = await svg(page, 4000, "return loopFigure(data)");
    assert.equal(paths(few, BLUE).length, 1);
    assert.ok(!few.includes("<image"));
  }));

test("panels side by side share both axes, and zoom together", { skip }, () =>
  opened(async (page) => {
    const text = await svg(page, 4000, `
      const figure = loopFigure(data);
      const [series] = figure.panels[0].series;
      const cycles = [[0, 1000], [1000, 2000], [3000, 4000]];
      const panels = cycles.map((part, k) => ({ ...figure.panels[0], title: "Cycle " + k, series: [{ ...series, parts: [part] }] }));
      return { ...figure, columns: 3, panels };`);
    for (const k of [0, 1, 2]) assert.ok(text.includes(`>Cycle ${k}</text>`));
    const wide = (drawn) => drawn.map(([, path]) => {
      const x = [...path.matchAll(/[ML](\S+) /g)].map(([, value]) => Number(value));
      return Math.max(...x) - Math.min(...x);
    });
    const [first, , last] = wide(paths(text, BLUE));
    const ratio = await page.evaluate(() => {
      const { x } = figure.panels[0].series[0];
      const size = (from, to) => Math.max(...x.subarray(from, to)) - Math.min(...x.subarray(from, to));
      return size(0, 1000) / size(3000, 4000);
    });
    assert.ok(ratio > 1.3 && Math.abs(first / last / ratio - 1) < 0.02, `${first} and ${last} of ${ratio}`);
    assert.match(await page.locator("#plot canvas").first().getAttribute("aria-label"), /Cycle 1, Output/);
    assert.match(await page.evaluate(() => plots.csv(figure).split("\n")[0]), /Cycle 2: measured: Output \[um\]/);
    await page.locator("#plot canvas").first().focus();
    await page.keyboard.press("+");
    const zoomed = wide(paths(await page.evaluate(async () => (await frame(), plot.svg())), BLUE));
    assert.ok(zoomed.every((width, k) => width > 1.1 * wide(paths(text, BLUE))[k]), String(zoomed));
    await page.keyboard.press("Home");
    assert.equal(await page.evaluate(async () => (await frame(), plot.svg())), text);
    await page.evaluate(() => (document.querySelector("#plot").style.width = "100%"));
    await viewed(page, "columns");
  }));
