// Bundles the page into dist/: `npm run build`.
import { copyFileSync, mkdirSync } from "node:fs";
import { build } from "esbuild";

const common = { bundle: true, format: "esm", target: "es2022", minify: true, outdir: "dist", logLevel: "warning" };

await build({
  ...common,
  entryPoints: { main: "src/main.tsx", worker: "src/worker.ts", library: "src/library.ts", module: "src/module.ts", packet: "src/packet.ts", server: "src/server.ts" },
  splitting: true,
  chunkNames: "[name]-[hash]",
  jsx: "automatic",
  jsxImportSource: "preact",
});
mkdirSync("dist", { recursive: true });
for (const file of ["index.html", "style.css", "icon.svg"]) copyFileSync(file, `dist/${file}`);
