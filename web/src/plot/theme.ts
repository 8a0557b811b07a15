// The colours of plots, which come from the style sheet.

/** The colours of a theme. */
export interface Theme {
  text: string;
  grid: string;
  span: string;
  mark: string;
  pale: string;
  line: string;
  series: string[];
}

/** Number of colours of series. */
export const COLOURS = 8;
/** Whether the system is dark. */
export const darkness = matchMedia("(prefers-color-scheme: dark)");
/** What draws all plots anew. */
export const themed = new Set<() => void>();

/** Draws all plots anew after the theme was chosen by hand. */
export const themeChanged = (): void => themed.forEach((redraw) => redraw());

/** What `read` gives while the theme is light. */
export function light<T>(read: () => T): T {
  const { dataset } = document.documentElement;
  const before = dataset["theme"];
  dataset["theme"] = "light";
  const result = read();
  if (before === undefined) delete dataset["theme"];
  else dataset["theme"] = before;
  return result;
}

/** The theme of an element. */
export function themeOf(element: HTMLElement): Theme {
  const style = getComputedStyle(element);
  const colour = (name: string) => style.getPropertyValue(`--plot-${name}`).trim() || "#888";
  return {
    text: colour("text"),
    grid: colour("grid"),
    span: colour("span"),
    mark: colour("mark"),
    pale: colour("pale"),
    line: colour("line"),
    series: Array.from({ length: COLOURS }, (_, k) => colour(String(k))),
  };
}
