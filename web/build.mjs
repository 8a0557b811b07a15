// Bundles the page into dist/, what `piezoid serve` needs of it into its crate, and the plots of reports into the crate
// that writes them: `npm run build`.
import { copyFileSync, mkdirSync, rmSync, writeFileSync } from "node:fs";
import { build } from "esbuild";
import { FIGURES, figures } from "./figures.mjs";

const common = {
  bundle: true, format: "esm", target: "es2022", minify: true, outdir: "dist", logLevel: "warning", charset: "utf8",
  jsx: "automatic", jsxImportSource: "preact",
};
const PAGE = ["index.html", "style.css", "icon.svg"];
const SERVED = "../crates/piezoid-serve/page";

await build({ ...common, entryPoints: { main: "src/main.tsx" } });
// A worker of the old kind: one file.
await build({ ...common, format: "iife", entryPoints: { worker: "src/worker.ts" } });
// For the tests.
const parts = ["archive", "library", "module", "packet", "plot/download", "project", "remaining", "server", "words", "workspace"];
const entryPoints = Object.fromEntries(parts.map((name) => [name, `src/${name}.ts`]));
await build({ ...common, outdir: "dist/parts", minify: false, entryPoints });
for (const file of PAGE) copyFileSync(file, `dist/${file}`);

rmSync(SERVED, { recursive: true, force: true });
mkdirSync(SERVED);
for (const file of [...PAGE, "main.js"]) copyFileSync(`dist/${file}`, `${SERVED}/${file}`);
writeFileSync(FIGURES, await figures());
