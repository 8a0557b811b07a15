// The plots of reports, as one script.
import { build } from "esbuild";

/** The file of this script; it is committed, so that reports are built without Node.js. */
export const FIGURES = new URL("../crates/piezoid-report/src/page/figures.js", import.meta.url);

/** The text of this script. */
export async function figures() {
  const { outputFiles } = await build({
    absWorkingDir: import.meta.dirname,
    entryPoints: ["src/report.ts"],
    bundle: true,
    format: "iife",
    target: "es2022",
    minify: true,
    charset: "utf8",
    legalComments: "none",
    write: false,
  });
  return outputFiles[0].text;
}
