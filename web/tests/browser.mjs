// A static server for the built page, and a browser.
import { createServer } from "node:http";
import { existsSync, readFileSync } from "node:fs";
import { basename, extname } from "node:path";
import { after, before } from "node:test";
import { chromium } from "playwright-core";

const DIST = new URL("../dist/", import.meta.url);
const TYPES = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml", ".wasm": "application/wasm", ".json": "application/json" };

/** The browser of the tests; `CHROMIUM` names another than Debian's. */
export const CHROMIUM = process.env.CHROMIUM ?? "/usr/bin/chromium";

/** Why the tests in a browser are left out, which `cargo xtask test` counts; never in CI. */
export function lacking(name, path) {
  if (existsSync(path) || process.env.CI) return false;
  const why = `no browser ${path}, name one by ${name}`;
  console.log(`SKIPPED: ${basename(process.argv[1])}: ${why}`);
  return why;
}

export const skip = lacking("CHROMIUM", CHROMIUM);

/** Serves dist/ as any static server does; `PIEZOID_PAGE` is the address of a page that another one serves. */
export async function served() {
  if (process.env.PIEZOID_PAGE) return { url: process.env.PIEZOID_PAGE, close() {} };
  const server = createServer((request, response) => {
    const name = new URL(request.url, "http://x").pathname.slice(1) || "index.html";
    const file = new URL(name, DIST);
    if (!file.href.startsWith(DIST.href) || !existsSync(file)) return response.writeHead(404).end();
    response.writeHead(200, { "content-type": TYPES[extname(name)] ?? "application/octet-stream" }).end(readFileSync(file));
  });
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  return { url: `http://127.0.0.1:${server.address().port}/`, close: () => server.close() };
}

/** A browser without what needs a network. */
export const launched = () =>
  chromium.launch({
    executablePath: CHROMIUM,
    args: ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"],
  });

/** The static server and the browser of the tests of a file, from before the first to after the last. */
export function fixture() {
  const all = {};
  before(async () => {
    if (!skip) [all.server, all.browser] = await Promise.all([served(), launched()]);
  });
  after(async () => {
    await all.browser?.close();
    all.server?.close();
  });
  return all;
}

/** True for a request to anywhere else than the page's own server. */
export const isForeign = (requested, url) => !["blob:", "data:", new URL(url).origin].some((start) => requested.startsWith(start));

/** A page in a context of its own, with what it told and asked that it should not have. */
export async function opened(browser, url, options = {}) {
  const context = options.context ?? (await browser.newContext({ viewport: { width: 1280, height: 900 }, acceptDownloads: true, ...options }));
  const page = await context.newPage();
  const faults = [];
  page.on("console", (message) => ["error", "warning"].includes(message.type()) && faults.push(message.text()));
  page.on("pageerror", (error) => faults.push(error.message));
  page.on("request", (request) => {
    if (isForeign(request.url(), url)) faults.push(`asked ${request.url()}`);
  });
  await page.goto(url);
  return { page, faults, context };
}

/** What a download holds. */
export async function download(page, start) {
  const [got] = await Promise.all([page.waitForEvent("download"), start()]);
  return readFileSync(await got.path());
}
