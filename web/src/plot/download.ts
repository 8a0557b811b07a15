// What is handed out of a plot.

import { type Axis, type Figure, partsOf, place, type Series } from "./figure.ts";

/** The samples of all series as CSV: of each series its x and its y, of its parts one after the other. */
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
    cell([panel.title, series.name, called(panel.y)].filter(Boolean).join(": ")),
  ]);
  // Samples to the bit, empty at breaks; `start + k * step` without its last digits.
  const number = (value: number) => (Number.isNaN(value) ? "" : String(value));
  const across = (series: Series, k: number) =>
    number(series.x ? place(series, k) : Number(place(series, k).toPrecision(15)));
  // The samples of each series; -1 is a break between parts.
  const columns = all.map(({ series }) => ({
    series,
    samples: partsOf(series).flatMap(([from, to], k) => [...(k > 0 ? [-1] : []), ...Array.from({ length: to - from }, (_, n) => from + n)]),
  }));
  const longest = columns.reduce((most, { samples }) => Math.max(most, samples.length), 0);
  const rows = [head.join(",")];
  for (let row = 0; row < longest; row++) {
    const pair = ({ series, samples }: (typeof columns)[number]) => {
      const k = samples[row] ?? -1;
      return k < 0 ? "," : `${across(series, k)},${number(series.y[k]!)}`;
    };
    rows.push(columns.map(pair).join(","));
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
