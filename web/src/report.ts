// The plots of a report. Beside each drawing stands its data; a plot takes its place on the screen. The drawing stays,
// for print, and if anything here fails.

import type { Figure, Series } from "./plot/figure.ts";
import { Plot } from "./plot/plot.ts";
import { themeChanged } from "./plot/theme.ts";

/** Samples as they stand in the page; null is a break. */
type Samples = (number | null)[];
type Stored = Omit<Series, "x" | "y" | "lower"> & { x?: Samples; y: Samples; lower?: Samples };
/** A plot as it stands in the page, with the line above it, and its height over its width. */
type StoredFigure = Omit<Figure, "panels"> & {
  name?: string;
  height: number;
  panels: (Omit<Figure["panels"][number], "series"> & { series: Stored[] })[];
};

const samples = (stored: Samples) => Float64Array.from(stored, (value) => value ?? NaN);

const series = ({ x, y, lower, ...rest }: Stored): Series => ({
  ...rest,
  y: samples(y),
  ...(x && { x: samples(x) }),
  ...(lower && { lower: samples(lower) }),
});

const figure = (stored: StoredFigure): Figure => ({
  ...stored,
  panels: stored.panels.map((panel) => ({ ...panel, series: panel.series.map(series) })),
});

/** The plots in place of one drawing. */
function plots(script: HTMLScriptElement, legend: boolean): Plot[] {
  const drawing = script.parentElement!;
  const stored = JSON.parse(script.textContent!) as StoredFigure[];
  const result = stored.map((one) => {
    const [name, host] = [document.createElement("p"), document.createElement("div")];
    [name.className, name.textContent] = ["plot name", one.name ?? ""];
    host.style.setProperty("--height", String(one.height));
    drawing.append(...(one.name ? [name] : []), host);
    return new Plot(host, figure(one), { legend });
  });
  drawing.classList.add("live");
  return result;
}

/** Makes the names in a legend that several drawings share to buttons. */
function shared(keys: Element | null, all: Plot[]): void {
  for (const key of keys?.children ?? []) {
    const button = document.createElement("button");
    const name = key.textContent!.trim();
    button.type = "button";
    button.title = "Show or hide";
    button.ariaPressed = "true";
    button.append(...key.childNodes);
    button.onclick = () => {
      const hidden = button.ariaPressed === "true";
      button.ariaPressed = String(!hidden);
      for (const plot of all) plot.hide(name, hidden);
    };
    key.append(button);
  }
}

for (const place of document.querySelectorAll("figure")) {
  const scripts = place.querySelectorAll<HTMLScriptElement>("script");
  const keys = place.querySelector(".keys");
  shared(keys, [...scripts].flatMap((script) => plots(script, !keys)));
}
new MutationObserver(themeChanged).observe(document.documentElement, { attributeFilter: ["data-theme"] });
