// Bundles the page into dist/, and the plots of reports into the crate that writes them: `npm run build`.
import { copyFileSync, mkdirSync, writeFileSync } from "node:fs";
import { build } from "esbuild";
import { FIGURES, figures } from "./figures.mjs";

const common = { bundle: true, format: "esm", target: "es2022", minify: true, outdir: "dist", logLevel: "warning" };

await build({
  ...common,
  entryPoints: { main: "src/main.tsx", worker: "src/worker.ts", library: "src/library.ts", module: "src/module.ts", packet: "src/packet.ts" },
  splitting: true,
  chunkNames: "[name]-[hash]",
  jsx: "automatic",
  jsxImportSource: "preact",
});
mkdirSync("dist", { recursive: true });
for (const file of ["index.html", "style.css", "icon.svg"]) copyFileSync(file, `dist/${file}`);
writeFileSync(FIGURES, await figures());
