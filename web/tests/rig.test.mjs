// The files of one rig: what is said of one is said of all, on the page, in the saved project and on the command line.
import assert from "node:assert/strict";
import { mkdtempSync, readdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { unzipSync } from "fflate";
import { download, launched, opened, skip as noBrowser } from "./browser.mjs";
import { piezoid, skip as noPiezoid, started } from "./piezoid.mjs";
import { fill, written } from "./steps.mjs";

const skip = noBrowser || noPiezoid;
const folder = mkdtempSync(join(tmpdir(), "piezoid-rig-"));
let browser, running, url, measured;

before(async () => {
  if (skip) return;
  browser = await launched();
  const cwd = mkdtempSync(join(tmpdir(), "piezoid-record-"));
  piezoid(cwd, ..."excite rising-sine --amplitude 28V --frequency 5Hz --ts 0.5ms --duration 2s -o u.csv".split(" "));
  piezoid(cwd, ..."simulate u.csv --plant pl140 -o y.csv".split(" "));
  measured = readFileSync(join(cwd, "y.csv"), "utf8").trim().split("\n").slice(1).map((row) => row.split(",").map(Number));
  rmSync(cwd, { recursive: true });
  const server = await started(["serve", folder, "--port", "0"], /http:\/\/\S+/);
  [running, url] = [server.running, server.found];
});
after(async () => {
  await browser?.close();
  running?.kill("SIGKILL");
  rmSync(folder, { recursive: true });
});

/** A file of a scope with channels 1 and 2, of which none is called an input: a bender behind an amplifier of gain 20 and
 * a sensor of 50 um/V. Each file has another length. */
function scope(k) {
  const rows = measured.slice(0, 3000 + 100 * k).map(([t, u, y]) => `${t},${u / 20},${y / 50}`);
  return { name: `scope_${k}.csv`, mimeType: "text/csv", buffer: Buffer.from(`x-axis,1,2\nsecond,Volt,Volt\n${rows.join("\n")}\n`) };
}

test("what is said of one file of a scope is said of all, saved, and read by the command line", { skip, timeout: 300_000 }, async () => {
  const { page, faults, context } = await opened(browser, url);
  const button = (name) => page.getByRole("button", { name, exact: true });
  const column = page.getByRole("list", { name: "Records and their use" }).locator("li > small");
  const states = async () => (await column.allInnerTexts()).map((text) => text.replace(/; \d+ problems?$/, ""));
  const until = async (expected) => {
    for (let k = 0; k < 100 && (await states()).join() !== expected.join(); k++) await page.waitForTimeout(100);
    assert.deepEqual(await states(), expected);
  };
  const [undecided, read] = ["roles not decided", "read"];
  await page.getByLabel("Data files").setInputFiles([1, 2, 3, 4, 5].map(scope));
  await until(Array(5).fill(undecided));
  assert.equal(await page.getByRole("group", { name: "Files that look alike" }).count(), 0);

  const field = async (name, text) => {
    await page.getByLabel(name, { exact: true }).fill(text);
    await page.getByLabel(name, { exact: true }).blur();
  };
  await page.getByLabel("Role of 1", { exact: true }).selectOption("input");
  await page.getByLabel("Role of 2", { exact: true }).selectOption("output");
  await fill(page, "input_scale", "20");
  await fill(page, "output_scale", "50um/V");
  await fill(page, "from", "0.01");
  await until([...Array(4).fill(undecided), read]);
  await button("Read the 4 other files that look alike in the same way").click();
  await until(Array(5).fill(read));
  await button("Undo").click();
  await until([...Array(4).fill(undecided), read]);
  await button("Redo").click();
  await until(Array(5).fill(read));
  assert.equal(await page.getByLabel("Read as rig", { exact: true }).inputValue(), "scope");
  await field("Read as rig", "bender bench");

  // A file that is added later is read at once, with another one that does not look alike.
  const other = { name: "other.csv", mimeType: "text/csv", buffer: Buffer.from(scope(6).buffer.toString().replace("Volt,Volt", "Volt,mV")) };
  await page.getByLabel("Data files").setInputFiles([other, scope(6)]);
  await until([...Array(5).fill(read), undecided, read]);
  assert.equal(await page.locator("input[name=output_scale]").inputValue(), "50um/V");
  assert.equal(await page.locator("input[name=from]").inputValue(), "");
  await page.getByText("like 5 other files").waitFor();
  await button("Read it on its own").click();
  await until([...Array(5).fill(read), undecided, undecided]);
  await button("Read it as rig bender bench").click();
  await until([...Array(5).fill(read), undecided, read]);

  // A rig that is changed at one of its files is changed for all.
  await fill(page, "output_scale", "60um/V");
  await button("Read the 5 other files that look alike in the same way: change the rig bender bench").click();
  await page.getByText("like 5 other files").waitFor();

  const files = unzipSync(await download(page, () => button("Save").click()));
  const profile = Buffer.from(files["bender bench.toml"]).toString();
  assert.match(profile, /input_col = "1"/);
  assert.match(profile, /output_scale = "60um\/V"/);
  assert.doesNotMatch(profile, /from/);
  await written(() => assert.equal(readFileSync(join(folder, "bender bench.toml"), "utf8"), profile));
  await written(() => assert.ok(!readdirSync(folder).includes("scope.toml"), "the profile under the earlier name is gone"));

  const bench = mkdtempSync(join(tmpdir(), "piezoid-bench-"));
  for (const name of ["bender bench.toml", ...[1, 2, 3, 4, 5, 6].map((k) => `scope_${k}.csv`)]) writeFileSync(join(bench, name), files[name]);
  const scopes = [1, 2, 3, 4, 5, 6].map((k) => `scope_${k}.csv`);
  piezoid(bench, "identify", ...scopes, "--profile", "bender bench.toml", "--operator", "proportional", "--order", "1", "-o", "model.json");
  const { fit, units } = JSON.parse(readFileSync(join(bench, "model.json")));
  assert.deepEqual([fit.files.length, units.y], [6, "um"]);
  rmSync(bench, { recursive: true });
  assert.deepEqual(faults, []);
  await context.close();
});

test("a rig is kept with the project; a file that was added undecided is read as one that is decided", { skip, timeout: 240_000 }, async () => {
  const { page, faults, context } = await opened(browser, url);
  const button = (name) => page.getByRole("button", { name, exact: true });
  await page.getByLabel("Read as rig", { exact: true }).waitFor();
  await page.getByText("How files of the rig are read").click();
  await page.getByText("Role input: 1; Role output: 2; Input scale: 20; Output scale: 60um/V").waitFor();
  await button("Forget the rig bender bench").click();
  await page.getByLabel("Data files").setInputFiles([scope(7), scope(8)]);
  await button("Read this file and 1 other as scope_6.csv is read").click();
  await page.getByText("like 7 other files").waitFor();
  assert.deepEqual(faults, []);
  await context.close();
});

test("reading alike is offered only where something would change", { skip, timeout: 240_000 }, async (t) => {
  const empty = mkdtempSync(join(tmpdir(), "piezoid-rig-"));
  const server = await started(["serve", empty, "--port", "0"], /http:\/\/\S+/);
  t.after(() => {
    server.running.kill("SIGKILL");
    rmSync(empty, { recursive: true });
  });
  const { page, faults, context } = await opened(browser, server.found);
  const plain = (name) => ({ name, mimeType: "text/csv", buffer: Buffer.from(`t_s,u_V,y_um\n${measured.slice(0, name.length * 300).map((row) => row.join()).join("\n")}\n`) });
  const offers = page.getByRole("button", { name: /^Read (the|this)/ });
  const show = async (name) => {
    await page.getByRole("button", { name, exact: true }).click();
    await page.getByRole("heading", { name, exact: true }).waitFor();
    await page.waitForTimeout(700);
  };
  await page.getByLabel("Data files").setInputFiles([plain("a.csv"), plain("bb.csv")]);
  await page.getByText(/samples/).first().waitFor();
  await fill(page, "input_scale", "1");
  await page.waitForTimeout(700);
  assert.equal(await offers.count(), 0, "nothing would change");
  await fill(page, "output_unit", "nm");
  await offers.waitFor();
  // The other file is set up by hand too: it stays.
  await show("a.csv");
  await fill(page, "output_unit", "mm");
  for (const name of ["bb.csv", "a.csv"]) {
    await show(name);
    assert.equal(await offers.count(), 0, `both are set up, ${name}`);
  }
  assert.deepEqual(faults, []);
  await context.close();
});
