// Bundles the page into dist/: `npm run build`.
import { copyFileSync, mkdirSync } from "node:fs";
import { build } from "esbuild";

const common = { bundle: true, format: "esm", target: "es2022", minify: true, outdir: "dist", logLevel: "warning" };

await build({
  ...common,
  entryPoints: {
    main: "src/main.tsx",
    // For the tests.
    library: "src/library.ts",
    module: "src/module.ts",
    packet: "src/packet.ts",
    spectrum: "src/spectrum.ts",
  },
  splitting: true,
  chunkNames: "[name]-[hash]",
  jsx: "automatic",
  jsxImportSource: "preact",
});
// A worker of the old kind: one file.
await build({ ...common, format: "iife", entryPoints: { worker: "src/worker.ts" } });
mkdirSync("dist", { recursive: true });
for (const file of ["index.html", "style.css", "icon.svg"]) copyFileSync(file, `dist/${file}`);
