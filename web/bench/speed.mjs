// What the page takes: `npm run bench` after `cargo xtask web`. Times depend on the machine and on what else it does.
import { writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { brotliCompressSync, gzipSync } from "node:zlib";
import { readdirSync, readFileSync } from "node:fs";
import { launched, opened, served } from "../tests/browser.mjs";
import { csv, measured } from "../tests/records.mjs";
import { identify } from "../tests/steps.mjs";

const [server, browser] = await Promise.all([served(), launched()]);
const row = (what, value) => console.log(`${what.padEnd(58)} ${value}`);
const ms = (start) => `${Math.round(performance.now() - start)} ms`;

const dist = new URL("../dist/", import.meta.url);
for (const name of readdirSync(dist).filter((name) => /\.(js|css|wasm|json|html)$/.test(name))) {
  const bytes = readFileSync(new URL(name, dist));
  row(`size of ${name}`, `${bytes.length} bytes, ${gzipSync(bytes, { level: 9 }).length} gzip, ${brotliCompressSync(bytes).length} brotli`);
}

const first = await opened(browser, server.url);
const paint = await first.page.evaluate(() => new Promise((resolve) => {
  new PerformanceObserver((list) => resolve(list.getEntries().at(-1).startTime)).observe({ type: "paint", buffered: true });
}));
row("first paint", `${Math.round(paint)} ms`);
let start = performance.now();
await first.page.getByRole("button", { name: "Open the example" }).click();
await first.page.getByText(/4,000 samples/).waitFor();
row("the example, from the click to its first figure, module cold", ms(start));
await first.context.close();

const rows = ["t_s,u_V,y_um"];
for (let k = 0; k < 1e6; k++) {
  const u = 30 * Math.sin(2 * Math.PI * k * 1e-4 * (1 + k / 5e5));
  rows.push(`${k / 1e4},${u.toFixed(4)},${(20 * u + Math.sin(k)).toFixed(4)}`);
}
const million = join(tmpdir(), "piezoid-million.csv");
writeFileSync(million, rows.join("\n"));
const big = await opened(browser, server.url);
await big.page.waitForTimeout(1000);
start = performance.now();
await big.page.getByLabel("Data files").setInputFiles(million);
await big.page.getByText(/1,000,000 samples/).waitFor({ timeout: 60_000 });
await big.page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
row("a CSV of a million samples, opened and drawn", ms(start));
await big.page.locator(".plot canvas").first().focus();
for (const [what, zooms] of [["whole", 0], ["a tenth", 10]]) {
  for (let k = 0; k < zooms; k++) await big.page.keyboard.press("+");
  const frames = await big.page.evaluate(async () => {
    const canvas = document.querySelector(".plot canvas");
    const times = [];
    for (let k = 0; k < 61; k++) {
      const key = k % 20 < 10 ? "ArrowRight" : "ArrowLeft";
      canvas.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true, cancelable: true }));
      times.push(await new Promise(requestAnimationFrame));
    }
    return times.slice(1).map((time, k) => time - times[k]).sort((a, b) => a - b);
  });
  row(`moved, ${what} in view: frame, median and worst of 60`, `${frames[30].toFixed(1)} and ${frames[59].toFixed(1)} ms`);
}
await big.context.close();

const ten = { name: "ten.csv", mimeType: "text/csv", buffer: csv(measured(5, 28, 10)) };
const work = await opened(browser, server.url);
await work.page.getByLabel("Data files").setInputFiles([ten]);
await work.page.getByText(/20,000 samples/).waitFor();
const cancel = work.page.getByRole("button", { name: "Cancel", exact: true });
for (const operator of ["prandtl-ishlinskii", "auto"]) {
  start = performance.now();
  await identify(work.page, operator);
  await cancel.waitFor();
  await cancel.waitFor({ state: "detached", timeout: 300_000 });
  row(`identify ${operator}, 10 s at 2 kHz`, ms(start));
}
await identify(work.page, "auto");
await work.page.waitForTimeout(3000);
start = performance.now();
await cancel.click();
await cancel.waitFor({ state: "detached" });
row("cancel", ms(start));
await browser.close();
server.close();
