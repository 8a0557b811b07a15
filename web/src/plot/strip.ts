// The whole record in a low strip, with the span that the plots of a link show as a window in it.
//
// Drag the window to move it, its ends to change it, and beside it for another one. Double click: all. Keys: arrows move,
// + and - zoom, 0 and Home show all.

import { sized } from "./around.ts";
import { curve } from "./curve.ts";
import type { Figure, Span } from "./figure.ts";
import { LEFT, RIGHT } from "./frame.ts";
import type { Link } from "./link.ts";
import { CanvasPen } from "./pens.ts";
import { spansY, spanX } from "./spans.ts";
import { darkness, themed, themeOf } from "./theme.ts";
import { short, unit } from "./ticks.ts";

/** How near to an end of the window a pointer takes hold of it [pixels]. */
const HOLD = 8;
const NOBODY = new Set<string>();

/** The first panel of a figure, over all of its x. */
export class Strip {
  readonly #host: HTMLElement;
  readonly #link: Link;
  readonly #track = document.createElement("div");
  readonly #canvas = document.createElement("canvas");
  readonly #window = document.createElement("div");
  readonly #resized = new ResizeObserver(() => this.#draw());
  readonly #leave: () => void;
  #figure: Figure;
  #whole: Span = { from: 0, to: 1 };

  constructor(host: HTMLElement, figure: Figure, link: Link) {
    [this.#host, this.#figure, this.#link] = [host, figure, link];
    host.classList.add("strip");
    this.#track.style.margin = `0 ${RIGHT}px 0 ${LEFT}px`;
    this.#canvas.setAttribute("aria-hidden", "true");
    this.#window.tabIndex = 0;
    this.#window.setAttribute("role", "slider");
    this.#track.append(this.#canvas, this.#window);
    host.replaceChildren(this.#track);
    this.#listen();
    this.#resized.observe(this.#track);
    darkness.addEventListener("change", this.#draw);
    themed.add(this.#draw);
    this.#leave = link.join({ redraw: () => this.#place(), point: () => {} });
    this.set(figure);
  }

  /** Shows another record. */
  set(figure: Figure): void {
    this.#figure = figure;
    this.#whole = spanX(figure, NOBODY);
    this.#window.setAttribute("aria-label", `Shown span of ${figure.x.label.toLowerCase()}`);
    this.#draw();
  }

  /** Ends the strip. */
  close(): void {
    this.#leave();
    this.#resized.disconnect();
    darkness.removeEventListener("change", this.#draw);
    themed.delete(this.#draw);
  }

  get #shown(): Span {
    return this.#link.span ?? this.#whole;
  }

  readonly #draw = (): void => {
    const { clientWidth: width, clientHeight: height } = this.#track;
    const [x, panel] = [this.#whole, this.#figure.panels[0]];
    if (width < 10 || !panel) return;
    const pen = new CanvasPen(sized(this.#canvas, width, height));
    const frame = { panel, x, y: spansY(this.#figure, x, NOBODY)[0]!, area: { x: 0, y: 2, width, height: height - 4 } };
    for (const series of panel.series) curve(pen, this.#figure, frame, series, themeOf(this.#host));
    this.#place();
  };

  /** Puts the window where the shown span is. */
  #place(): void {
    const { from, to } = this.#shown;
    const all = this.#whole.to - this.#whole.from;
    this.#window.style.left = `${(100 * (from - this.#whole.from)) / all}%`;
    this.#window.style.width = `${(100 * (to - from)) / all}%`;
    const values = { valuemin: this.#whole.from, valuemax: this.#whole.to, valuenow: (from + to) / 2,
      valuetext: `${short(from)} to ${short(to)} ${unit(this.#figure.x.unit)}` };
    for (const [name, value] of Object.entries(values)) this.#window.setAttribute(`aria-${name}`, String(value));
  }

  /** Shows a span, moved into the record; all if it is as long as the record. */
  #show(from: number, to: number): void {
    const whole = this.#whole;
    if (!(to - from < whole.to - whole.from)) return this.#link.zoom(undefined);
    const moved = Math.max(whole.from - from, Math.min(0, whole.to - to));
    if (to - from > 1e-7 * (whole.to - whole.from)) this.#link.zoom({ from: from + moved, to: to + moved });
  }

  #listen(): void {
    const track = this.#track;
    const value = (event: MouseEvent) => {
      const { x, width } = track.getBoundingClientRect();
      return this.#whole.from + ((event.clientX - x) / width) * (this.#whole.to - this.#whole.from);
    };
    /** What a hand does that went so far. */
    let act: ((to: number) => void) | undefined;
    track.addEventListener("pointerdown", (event) => {
      track.setPointerCapture(event.pointerId);
      const [start, before] = [value(event), this.#shown];
      const hold = (HOLD * (this.#whole.to - this.#whole.from)) / track.clientWidth;
      const between = (a: number, b: number) => this.#show(Math.min(a, b), Math.max(a, b));
      if (Math.abs(start - before.to) < hold) act = (now) => between(before.from, now);
      else if (Math.abs(start - before.from) < hold) act = (now) => between(now, before.to);
      else if (this.#link.span && start > before.from && start < before.to) {
        act = (now) => this.#show(before.from + now - start, before.to + now - start);
      } else act = (now) => Math.abs(now - start) > hold / 2 && between(start, now);
    });
    track.addEventListener("pointermove", (event) => act?.(Math.max(this.#whole.from, Math.min(this.#whole.to, value(event)))));
    for (const end of ["pointerup", "pointercancel"]) track.addEventListener(end, () => (act = undefined));
    track.addEventListener("dblclick", () => this.#link.zoom(undefined));
    this.#window.addEventListener("keydown", (event) => {
      const { from, to } = this.#shown;
      const size = to - from;
      const by = (share: number) => this.#show(from + share * size, to + share * size);
      const grown = (share: number) => this.#show(from - share * size, to + share * size);
      const all = () => this.#link.zoom(undefined);
      const keys: Record<string, () => void> = {
        ArrowLeft: () => by(-0.1), ArrowRight: () => by(0.1), ArrowDown: () => by(-0.1), ArrowUp: () => by(0.1),
        "+": () => grown(-0.1), "=": () => grown(-0.1), "-": () => grown(0.125), "0": all, Home: all,
      };
      const key = keys[event.key];
      if (!key || event.ctrlKey || event.metaKey) return;
      event.preventDefault();
      key();
    });
  }
}
