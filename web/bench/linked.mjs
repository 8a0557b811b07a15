// Linked plots of a million samples: `node bench/linked.mjs [samples] [cycles]`. A frame is the time from one frame of the
// screen to the next, which depends on what else the machine does; the time of the processor, of the page's thread and of
// all of the browser, hardly does.
import { readdirSync, readFileSync } from "node:fs";
import { launched } from "../tests/browser.mjs";
import { plotPage } from "../tests/plots.mjs";

const browser = await launched();
const { page, faults } = await plotPage(browser, { viewport: { width: 1440, height: 1000 } });
const SAMPLES = Number(process.argv[2] ?? 1e6);
const CYCLES = Number(process.argv[3] ?? 100);

const made = await page.evaluate(async ([n, cycles]) => {
  const all = record(n, cycles);
  const counts = new Uint32Array(2 ** 16);
  const begin = performance.now();
  for (let k = 0; k < n; k++) counts[((all.u[k] + 40) * 3) * 256 + (all.y[k] + 50) * 2 | 0]++;
  globalThis.bare = performance.now() - begin;
  globalThis.link = new plots.Link();
  globalThis.end = n * all.step;
  document.querySelector("h1").remove();
  document.querySelector("main").style.cssText = "display: grid; grid-template-columns: 2fr 1fr; gap: 1rem";
  const start = performance.now();
  globalThis.time = new plots.Plot(host("100%", 600, "time"), timeFigure(all), { link });
  globalThis.loop = new plots.Plot(host("100%", 500, "loop"), loopFigure(all), { link });
  new plots.Strip(host("100%", 44, "strip"), timeFigure(all), link);
  await frame();
  return performance.now() - start;
}, [SAMPLES, CYCLES]);
// What the machine gives at the moment.
console.log(`a bare loop that counts the samples by pixels: ${(await page.evaluate(() => bare)).toFixed(1)} ms`);
console.log(`${SAMPLES} samples, ${CYCLES} cycles: drawn at first after ${made.toFixed(0)} ms`);

const stat = (path) => {
  const [, pid, name, rest] = readFileSync(`${path}/stat`, "utf8").match(/^(\d+) \((.*)\) (.*)/s);
  const fields = rest.split(" ");
  return { pid, name, parent: fields[1], ms: 10 * (Number(fields[11]) + Number(fields[12])) };
};
const numbers = (folder) => readdirSync(folder).filter((name) => /^\d+$/.test(name));

/** Time of the processor until now [ms], by thread of the processes that this one started. */
function spent() {
  const all = numbers("/proc").flatMap((pid) => {
    try {
      return [stat(`/proc/${pid}`)];
    } catch {
      return [];
    }
  });
  const below = (pid) => all.filter(({ parent }) => parent === pid).flatMap((one) => [one.pid, ...below(one.pid)]);
  const tasks = (pid) => numbers(`/proc/${pid}/task`).map((task) => stat(`/proc/${pid}/task/${task}`));
  const threads = below(String(process.pid)).flatMap(tasks);
  return threads.reduce((sums, { name, ms }) => sums.set(name, (sums.get(name) ?? 0) + ms), new Map());
}

/** Tells the times from frame to frame while something is done in each of 60. */
const measured = async (what, ...act) => {
  const before = spent();
  const { gaps } = await page.evaluate(async (acts) => {
    const does = acts.map((text) => new Function("k", text));
    const times = [];
    for (let k = 0; k <= 60; k++) {
      times.push(await new Promise(requestAnimationFrame));
      does.forEach((one) => one(k));
    }
    return { gaps: times.slice(1).map((time, k) => time - times[k]).sort((a, b) => a - b) };
  }, act);
  const at = (share) => gaps[Math.floor(share * (gaps.length - 1))].toFixed(1);
  const after = spent();
  const used = [...after].map(([name, ms]) => [name, (ms - (before.get(name) ?? 0)) / gaps.length]);
  const sum = used.reduce((sum, [, ms]) => sum + ms, 0).toFixed(1);
  const most = used.filter(([, ms]) => ms > 0.5).sort((a, b) => b[1] - a[1]).map(([name, ms]) => `${name} ${ms.toFixed(1)}`);
  console.log(`${what}: frame median ${at(0.5)}, 95 % ${at(0.95)}, worst ${at(1)} ms; processor ${sum} ms: ${most.join(", ")}`);
};
const MOVE = (name) => `
  const canvas = document.querySelector("#${name} canvas"), box = canvas.getBoundingClientRect();
  const [x, y] = [box.x + 80 + (k * 7) % (box.width - 100), box.y + 20 + (k * 5) % (box.height - 70)];
  canvas.dispatchEvent(new PointerEvent("pointermove", { clientX: x, clientY: y, bubbles: true }));`;
const ZOOM = `const half = end * (0.02 + 0.48 * Math.abs(Math.cos(k / 20))); link.zoom({ from: end / 2 - half, to: end / 2 + half });`;
const PAN = (share) => `const from = (1 - ${share}) * end * Math.abs(Math.sin(k / 20)); link.zoom({ from, to: from + ${share} * end });`;

await measured("nothing", "");
await measured("cursor in time", MOVE("time"));
await measured("cursor in the loop", MOVE("loop"));
await measured("zoom", ZOOM);
await measured("zoom, cursor in time", ZOOM, MOVE("time"));
await measured("zoom, cursor in the loop", ZOOM, MOVE("loop"));
for (const share of [0.9, 0.3, 0.1, 0.01]) await measured(`pan, ${100 * share} % in view, cursor in time`, PAN(share), MOVE("time"));
if (process.env.SHOTS) {
  await page.evaluate(() => (link.zoom({ from: 0.1 * end, to: 0.4 * end }), link.point(0.2 * end), frame()));
  await page.screenshot({ path: `${process.env.SHOTS}/linked.png` });
}
if (faults.length > 0) console.log(faults);
await browser.close();
