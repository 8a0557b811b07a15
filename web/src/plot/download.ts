// What is handed out of a plot.

import { type Axis, type Figure, place, type Series } from "./figure.ts";

/** The samples of all series as CSV: of each series its x and its y. */
export function csv(figure: Figure): string {
  const all = figure.panels.flatMap((panel) => panel.series.map((series) => ({ panel, series })));
  const { x } = figure;
  // Spreadsheets take a cell that begins like a formula for one.
  const plain = (text: string) => (/^[=+\-@\t\r]/.test(text) ? `'${text}` : text);
  const quoted = (text: string) => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
  const cell = (text: string) => quoted(plain(text));
  const called = (axis: Axis) => (axis.unit ? `${axis.label} [${axis.unit}]` : axis.label);
  const head = all.flatMap(({ panel, series }) => [
    cell(called(x)),
    cell(series.name ? `${series.name}: ${called(panel.y)}` : called(panel.y)),
  ]);
  // Samples to the bit, empty at breaks; `start + k * step` without its last digits.
  const number = (value: number) => (Number.isNaN(value) ? "" : String(value));
  const across = (series: Series, k: number) =>
    number(series.x ? place(series, k) : Number(place(series, k).toPrecision(15)));
  const longest = Math.max(0, ...all.map(({ series }) => series.y.length));
  const rows = [head.join(",")];
  for (let k = 0; k < longest; k++) {
    const pair = ({ series }: { series: Series }) =>
      k < series.y.length ? `${across(series, k)},${number(series.y[k]!)}` : ",";
    rows.push(all.map(pair).join(","));
  }
  return `${rows.join("\n")}\n`;
}

/** Offers bytes or text as a file. */
export function download(name: string, content: BlobPart, type = "application/octet-stream"): void {
  const url = URL.createObjectURL(new Blob([content], { type }));
  const link = document.createElement("a");
  [link.href, link.download] = [url, name];
  link.click();
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}
