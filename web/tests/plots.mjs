// A page with plots alone, and records to draw in them.
import { readFileSync } from "node:fs";
import { build } from "esbuild";

const contents = ["plot", "link", "strip", "download"].map((name) => `export * from "./${name}.ts";`).join("\n");

/** What every page has at hand: the plotter as `plots`, and a record of a play with minor loops as `record(samples)`. */
const RECORD = `
globalThis.record = (n, cycles = 100) => {
  const [u, y, error, straight] = Array.from({ length: 4 }, () => new Float64Array(n));
  let [z, seed] = [0, 1];
  for (let k = 0; k < n; k++) {
    const t = k / n;
    seed = (Math.imul(seed, 1103515245) + 12345) >>> 0;
    const noise = seed / 2 ** 32 - 0.5;
    u[k] = 30 * (1 - 0.6 * t) * Math.sin(2 * Math.PI * cycles * t) + 2 * Math.sin(2 * Math.PI * 7.3 * cycles * t);
    z = Math.max(u[k] - 6, Math.min(u[k] + 6, z));
    y[k] = 0.8 * u[k] + 0.5 * z + 0.05 * noise;
    straight[k] = y[k] - 1.3 * u[k];
    error[k] = 0.1 * Math.sin(2 * Math.PI * cycles * t + 1) + 0.2 * noise;
  }
  return { u, y, error, straight, n, step: 1e-4, parts: (each) => Array.from({ length: Math.floor(n / each) }, (_, k) => [k * each, (k + 1) * each]) };
};
globalThis.timeFigure = ({ u, y, error, step }) => ({
  title: "Record over time", x: { label: "Time", unit: "s" }, panels: [
    { y: { label: "Input", unit: "V" }, series: [{ name: "u", y: u, step, colour: 7 }] },
    { y: { label: "Output", unit: "um" }, series: [{ name: "y", y, step }] },
    { y: { label: "Error", unit: "um" }, series: [{ name: "error", y: error, step, colour: 1 }] },
  ] });
globalThis.loopFigure = ({ u, y, step }, more = {}) => ({
  title: "Loop", x: { label: "Input", unit: "V" }, loops: true,
  panels: [{ y: { label: "Output", unit: "um" }, series: [{ name: "measured", x: u, y, at: { start: 0, step }, colour: 1, ...more }] }] });
globalThis.host = (width, height, name = "plot") => {
  const element = document.createElement("div");
  element.id = name;
  element.style.cssText = "--height: " + height + "px; width: " + width;
  document.querySelector("main").append(element);
  return element;
};
globalThis.drawn = async (...all) => {
  while (!all.every((plot) => plot.svg().includes("<path"))) await frame();
};
globalThis.frame = () => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
`;

/** A page in which plots are made; what it told that it should not have is in `faults`. */
export async function plotPage(browser, options = {}) {
  const { outputFiles } = await build({
    stdin: { contents, resolveDir: new URL("../src/plot", import.meta.url).pathname, loader: "ts" },
    bundle: true, format: "iife", globalName: "plots", target: "es2022", write: false,
  });
  const page = await browser.newPage({ viewport: { width: 1280, height: 900 }, ...options });
  const faults = [];
  // Tests read what is drawn, which the browser finds slow.
  page.on("console", (message) => message.text().includes("willReadFrequently") || faults.push(message.text()));
  page.on("pageerror", (error) => faults.push(error.message));
  const style = readFileSync(new URL("../style.css", import.meta.url), "utf8");
  await page.setContent(`<!doctype html><html lang="en"><title>Plots</title><style>${style}</style>
    <body><main style="padding: 0 1rem"><h1>Plots</h1></main></body></html>`);
  await page.addScriptTag({ content: outputFiles[0].text + RECORD });
  return { page, faults };
}
