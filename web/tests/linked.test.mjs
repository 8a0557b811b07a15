// Plots that share a link: the span of time and the cursor.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { launched, skip } from "./browser.mjs";
import { plotPage } from "./plots.mjs";
import { viewed } from "./viewed.mjs";

let browser;
before(async () => void (browser = skip ? undefined : await launched()));
after(() => browser?.close());

/** A record of 1 s in time, its error, its loop and a strip, all linked; axes of the loop from -40 to 40. */
async function opened(use, options) {
  const { page, faults } = await plotPage(browser, { viewport: { width: 1280, height: 1500 }, ...options });
  await page.evaluate(async () => {
    globalThis.data = record(10_000, 5);
    globalThis.link = new plots.Link();
    const all = timeFigure(data);
    globalThis.time = new plots.Plot(host("100%", 300, "time"), { ...all, panels: all.panels.slice(0, 2) }, { link });
    globalThis.error = new plots.Plot(host("100%", 200, "error"), { ...all, title: "Error", panels: all.panels.slice(2) }, { link });
    const loops = loopFigure(data);
    const span = { from: -40, to: 40 };
    globalThis.loop = new plots.Plot(host("100%", 400, "loop"), {
      ...loops, x: { ...loops.x, span }, panels: [{ ...loops.panels[0], y: { ...loops.panels[0].y, span } }] }, { link });
    globalThis.strip = new plots.Strip(host("100%", 44, "strip"), all, link);
    await drawn(time, error, loop);
  });
  try {
    await use(page);
    assert.deepEqual(faults, []);
  } finally {
    await page.close();
  }
}

/** The numbers below the x axis of a plot, as its SVG has them. */
const ticks = (page, name) => page.evaluate(async (name) => {
  await frame();
  const all = [...new DOMParser().parseFromString(globalThis[name].svg(), "image/svg+xml").querySelectorAll("text")];
  const low = all.filter((text) => /^[\d.\u2212]+$/.test(text.textContent) && text.getAttribute("text-anchor") !== "end");
  return low.map((text) => Number(text.textContent.replace("\u2212", "-")));
}, name);

/** The middle of what stands on the cursor of a plot, and its size. */
const marked = (page, name) => page.evaluate((name) => {
  const canvas = document.querySelector(`#${name} canvas.cursor`);
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  const [xs, ys] = [[], []];
  for (let k = 0; k < data.length / 4; k++) if (data[4 * k + 3] > 60) (xs.push(k % canvas.width), ys.push(Math.floor(k / canvas.width)));
  if (xs.length === 0) return undefined;
  const [left, right, top, low] = [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
  return { x: (left + right + 1) / 2, y: (top + low + 1) / 2, width: right - left + 1, height: low - top + 1, canvas: canvas.width };
}, name);

/** Moves the pointer to a place in a plot. */
async function point(page, name, x, y) {
  await page.locator(`#${name} .stage`).scrollIntoViewIfNeeded();
  const box = await page.locator(`#${name} .stage`).boundingBox();
  await page.mouse.move(box.x + x, box.y + y);
}

/** Where sample k of the record is in the loop. */
const inLoop = (page, k) => page.evaluate((k) => {
  const { width, height } = document.querySelector("#loop canvas");
  return { x: 70 + ((width - 82) * (data.u[k] + 40)) / 80, y: 8 + (height - 48) * (1 - (data.y[k] + 40) / 80) };
}, k);

test("the zoom of one plot is that of the others in time, and restricts the loop", { skip }, () =>
  opened(async (page) => {
    const whole = (await page.evaluate(() => loop.svg())).length;
    await page.locator("#time canvas").first().focus();
    for (let k = 0; k < 4; k++) await page.keyboard.press("+");
    const span = await page.evaluate(() => link.span);
    assert.ok(Math.abs(span.to - span.from - 0.8 ** 4) < 1e-3);
    const [own, others] = [await ticks(page, "time"), await ticks(page, "error")];
    assert.ok(own[0] >= span.from && own.at(-1) <= span.to && own[0] > 0.2, String(own));
    assert.deepEqual(others, own);
    assert.ok((await page.evaluate(() => loop.svg())).length < 0.7 * whole, "the loop of the shown time");
    assert.deepEqual(await ticks(page, "loop"), [-40, -30, -20, -10, 0, 10, 20, 30, 40]);
    await page.keyboard.press("ArrowRight");
    assert.ok((await page.evaluate(() => link.span.from)) > span.from + 0.03);
    await page.locator("#loop").getByRole("button", { name: "All" }).click();
    assert.deepEqual([await page.evaluate(() => link.span), (await ticks(page, "error"))[0]], [undefined, 0]);
  }));

test("the cursor in time is a line in all plots of time, and a ring about the sample in the loop", { skip }, () =>
  opened(async (page) => {
    await point(page, "time", 500, 60);
    const [line, other, ring] = await Promise.all(["time", "error", "loop"].map((name) => marked(page, name)));
    assert.ok(line.width <= 2 && Math.abs(line.x - 500) <= 1 && other.x === line.x && other.width <= 2);
    const sample = Math.round(((500 - 70) / (line.canvas - 82)) * 9999);
    const place = await inLoop(page, sample);
    assert.ok(ring.width >= 10 && ring.width <= 13, `a ring of ${ring.width} px`);
    assert.ok(Math.hypot(ring.x - place.x, ring.y - place.y) < 1.5, JSON.stringify([ring, place]));
    const read = await page.locator("#loop .readout").textContent();
    assert.match(read, /^0\.\d+ s \u00b7 measured .* V, .* \u00b5m$/);
    await page.mouse.move(5, 5);
    assert.deepEqual(await Promise.all(["time", "error", "loop"].map((name) => marked(page, name))), [undefined, undefined, undefined]);
  }));

test("the cursor in the loop marks the time of the nearest sample, if it is in the shown time", { skip }, () =>
  opened(async (page) => {
    const at = (k) => page.evaluate((k) => ({ from: data.step * k, to: data.step * (k + 500) }), k);
    // Of a short time, so that no other part of the loop is near.
    await page.evaluate(async (span) => (link.zoom(span), await frame()), await at(3000));
    const place = await inLoop(page, 3250);
    await point(page, "loop", place.x, place.y);
    const time = await page.evaluate(() => link.cursor);
    assert.ok(Math.abs(time / 1e-4 - 3250) < 12, `sample ${time / 1e-4}`);
    const line = await marked(page, "error");
    assert.ok(Math.abs(line.x - (70 + ((line.canvas - 82) * (time - 0.3)) / 0.05)) <= 1);
    // A line that is drawn anew keeps the cursor.
    await page.evaluate(async (span) => (link.zoom(span), await frame()), await at(3100));
    assert.ok((await marked(page, "error")).x < line.x - 100);
    // Samples of other times are not found, nor marked.
    await page.evaluate(async (span) => (link.zoom(span), await frame()), await at(8000));
    assert.equal(await marked(page, "loop"), undefined);
    assert.equal(await marked(page, "error"), undefined);
  }));

test("the nearest sample of a loop is the one that a search of all finds", { skip }, () =>
  opened(async (page) => {
    for (const [x, y] of [[300, 250], [640, 180], [641, 200], [800, 120], [900, 75]]) {
      await point(page, "loop", x, y);
      const [found, best] = await page.evaluate(([x, y]) => {
        const { width, height } = document.querySelector("#loop canvas");
        const [across, up] = [(u) => 70 + ((width - 82) * (u + 40)) / 80, (y) => 8 + (height - 48) * (1 - (y + 40) / 80)];
        const away = (k) => Math.hypot(across(data.u[k]) - x, up(data.y[k]) - y);
        let best = 0;
        for (let k = 0; k < data.n; k++) if (away(k) < away(best)) best = k;
        const found = link.cursor === undefined ? undefined : Math.round(link.cursor / data.step);
        return [found, away(best) < 24 ? best : undefined];
      }, [x, y]);
      assert.equal(found, best);
    }
  }));

test("the strip shows the span in the whole record, and changes it", { skip }, () =>
  opened(async (page) => {
    const slider = page.getByRole("slider", { name: "Shown span of time" });
    const track = await page.locator("#strip > div").boundingBox();
    const drag = async (from, to) => {
      await page.mouse.move(track.x + from * track.width, track.y + 20);
      await page.mouse.down();
      await page.mouse.move(track.x + to * track.width, track.y + 20, { steps: 4 });
      await page.mouse.up();
      return page.evaluate(() => [link.span?.from, link.span?.to].map((t) => Number((t / 0.9999).toFixed(2))));
    };
    assert.deepEqual(await drag(0.2, 0.4), [0.2, 0.4], "a new window");
    assert.match(await slider.getAttribute("aria-valuetext"), /^0\.(2|1999|2001)\d* to 0\.\d+ s$/);
    assert.deepEqual(await drag(0.3, 0.5), [0.4, 0.6], "moved");
    assert.deepEqual(await drag(0.6, 0.8), [0.4, 0.8], "its end");
    assert.deepEqual(await drag(0.5, 1.3), [0.6, 1], "not beyond the record");
    const window = await slider.boundingBox();
    assert.ok(Math.abs(window.x - track.x - 0.6 * track.width) < 2 && Math.abs(window.width - 0.4 * track.width) < 2);
    await slider.focus();
    await page.keyboard.press("ArrowLeft");
    assert.ok(Math.abs((await page.evaluate(() => link.span.from)) - 0.56) < 0.01);
    await page.keyboard.press("+");
    assert.ok(Math.abs((await page.evaluate(() => link.span.to - link.span.from)) - 0.32) < 0.01);
    await page.keyboard.press("Home");
    assert.equal(await page.evaluate(() => link.span), undefined);
  }));

test("a density that follows the shown time is the one that is counted anew", { skip }, () =>
  opened(async (page) => {
    const [followed, anew, other] = await page.evaluate(async () => {
      const many = record(400_000, 400);
      const figure = (y) => ({ ...loopFigure(many, { style: "density", y, at: { start: 0, step: 1 / 400_000 } }), title: "Density" });
      const one = new plots.Plot(host("100%", 300, "one"), figure(many.y), { link });
      await drawn(one);
      for (const [from, to] of [[0.1, 0.9], [0.15, 0.8], [0.12, 0.83], [0.3, 0.9], [0.305, 0.88]]) {
        link.zoom({ from, to });
        await frame();
      }
      const two = new plots.Plot(host("100%", 300, "two"), figure(many.y.slice()), { link });
      await drawn(two);
      const result = [one.svg(), two.svg()];
      link.zoom({ from: 0.3, to: 0.5 });
      await frame();
      return [...result, one.svg()].map((text) => text.match(/href="([^"]*)/)[1]);
    });
    assert.ok(followed === anew && followed !== other);
  }));

test("a loop scales to the samples of the shown time", { skip }, () =>
  opened(async (page) => {
    await page.evaluate(async () => {
      globalThis.free = new plots.Plot(host("100%", 300, "free"), loopFigure(data), { link });
      await drawn(free);
    });
    const whole = await ticks(page, "free");
    // A tenth of a cycle about a reversal.
    await page.evaluate(async () => (link.zoom({ from: 0.94, to: 0.96 }), await frame()));
    const zoomed = await ticks(page, "free");
    const inputs = await page.evaluate(() => [...data.u.slice(9400, 9601)].reduce(([low, high], u) => [Math.min(low, u), Math.max(high, u)], [Infinity, -Infinity]));
    const [size, before] = [zoomed.at(-1) - zoomed[0], whole.at(-1) - whole[0]];
    assert.ok(size < before / 2, `${zoomed} of ${whole}`);
    assert.ok(zoomed[0] > inputs[0] - size / 2 && zoomed.at(-1) < inputs[1] + size / 2, `${zoomed} about ${inputs}`);
  }));

test("a wheel alone scrolls, and a hint says for a moment how it zooms", { skip }, () =>
  opened(async (page) => {
    await point(page, "time", 500, 60);
    await page.mouse.wheel(0, 30);
    await page.waitForTimeout(200);
    const { x, width, height, canvas } = await marked(page, "time");
    assert.ok(width > 100 && height >= 30 && height <= 34 && Math.abs(x - canvas / 2) < 2, `a hint of ${width} by ${height} px`);
    assert.equal(await page.evaluate(() => link.span), undefined);
    await page.waitForTimeout(1500);
    assert.equal(await marked(page, "time"), undefined);
    await page.keyboard.down("Control");
    await page.mouse.wheel(0, -100);
    await page.keyboard.up("Control");
    assert.ok(await page.evaluate(() => link.span.to - link.span.from < 0.95));
  }));

test("a finger that taps puts the cursor, which stays", { skip }, () =>
  opened(async (page) => {
    const box = await page.locator("#time .stage").boundingBox();
    await page.touchscreen.tap(box.x + 500, box.y + 60);
    assert.ok(Math.abs((await marked(page, "error")).x - 500) <= 1);
    assert.ok(await marked(page, "loop"));
    assert.equal(await page.evaluate(() => link.span), undefined);
  }, { hasTouch: true }));

test("a plot that is closed has left its link", { skip }, () =>
  opened(async (page) => {
    await page.evaluate(() => (error.close(), link.point(0.5)));
    assert.equal(await marked(page, "error"), undefined);
    assert.ok(await marked(page, "time"));
  }));

test("linked plots fit the screen, and nothing is wrong for screen readers", { skip }, () =>
  opened(async (page) => {
    await page.evaluate(async () => (link.zoom({ from: 0.2, to: 0.5 }), link.point(0.3), await frame()));
    await viewed(page, "linked");
  }));
