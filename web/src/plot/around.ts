// What stands around a plot: the names of its series above it, its buttons and the reading below it.

import { csv, download } from "./download.ts";
import type { Figure, Series } from "./figure.ts";
import { COLOURS, type Theme } from "./theme.ts";

const all = (figure: Figure): Series[] => figure.panels.flatMap((panel) => panel.series);

/** The names of the series, and the numbers of their colours. */
export const names = (figure: Figure): Map<string, number> =>
  new Map(all(figure).filter((series) => series.name).map((series) => [series.name, series.colour ?? 0]));

/** A button for each name, which hides and shows its series. */
export function legend(figure: Figure, hidden: Set<string>, changed: () => void): HTMLButtonElement[] {
  const style = (one: Series) => (one.dash ? "dashed" : (one.style ?? "line"));
  const styles = new Map(all(figure).map((one) => [one.name, style(one)]));
  return [...names(figure)].map(([name, colour]) => {
    const result = button(name, "Show or hide", () => {
      if (!hidden.delete(name)) hidden.add(name);
      result.ariaPressed = String(!hidden.has(name));
      changed();
    });
    result.className = `series-${colour % COLOURS} ${styles.get(name)}`;
    result.ariaPressed = String(!hidden.has(name));
    return result;
  });
}

/** Buttons that show all, and give a figure as files. */
export function bar(figure: () => Figure, svg: () => string, all: () => void): HTMLElement {
  const name = (ending: string) => `${figure().title.replace(/[^\p{L}\p{N}]+/gu, "-")}.${ending}`;
  const result = document.createElement("div");
  result.className = "bar";
  result.append(
    button("All", "Show all (double click)", all),
    button("SVG", "Download the figure as SVG", () => download(name("svg"), svg(), "image/svg+xml")),
    button("CSV", "Download the samples as CSV", () => download(name("csv"), csv(figure()), "text/csv")),
  );
  return result;
}

function button(text: string, title: string, act: () => void): HTMLButtonElement {
  const result = document.createElement("button");
  result.type = "button";
  result.textContent = text;
  result.title = title;
  result.onclick = act;
  return result;
}

/** What a screen reader says of a figure. */
export function description(figure: Figure): string {
  const panels = figure.panels.map(({ title, y, series }) => {
    const names = series.map((one) => one.name).filter(Boolean).join(", ");
    return `${title ? `${title}, ` : ""}${y.label} [${y.unit}]${names ? `: ${names}` : ""}`;
  });
  return `${figure.title}. ${panels.join("; ")} against ${figure.x.label} [${figure.x.unit}]`;
}

/** The drawing context of a canvas with this size in pixels of CSS, cleared: also of a hint. */
export function sized(canvas: HTMLCanvasElement, width: number, height: number): CanvasRenderingContext2D {
  clearTimeout(hinted.get(canvas));
  const ratio = devicePixelRatio || 1;
  const [w, h] = [Math.round(width * ratio), Math.round(height * ratio)];
  if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
  const context = canvas.getContext("2d")!;
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  return context;
}

/** How the wheel zooms, and how long that is written [ms]. */
const HINT = "Ctrl + wheel zooms";
const WRITTEN = 1200;

const hinted = new WeakMap<HTMLCanvasElement, ReturnType<typeof setTimeout>>();

/** Writes for a moment how the wheel zooms, which scrolls the page alone: into the middle of the cursor's canvas. */
export function hint(canvas: HTMLCanvasElement, { clientWidth: width, clientHeight: height }: HTMLElement, theme: Theme): void {
  const context = sized(canvas, width, height);
  context.font = "14px system-ui, sans-serif";
  context.textAlign = "center";
  const wide = context.measureText(HINT).width + 24;
  context.fillStyle = theme.grid;
  context.fillRect((width - wide) / 2, height / 2 - 16, wide, 32);
  context.fillStyle = theme.text;
  context.fillText(HINT, width / 2, height / 2 + 5);
  hinted.set(canvas, setTimeout(() => sized(canvas, width, height), WRITTEN));
}
