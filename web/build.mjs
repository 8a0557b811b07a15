// Bundles the page's scripts: `npm run build` writes dist/.
import { build } from "esbuild";

await build({
  entryPoints: { worker: "src/worker.ts", library: "src/library.ts", module: "src/module.ts", packet: "src/packet.ts" },
  bundle: true,
  format: "esm",
  target: "es2022",
  minify: true,
  sourcemap: false,
  outdir: "dist",
  logLevel: "warning",
});
