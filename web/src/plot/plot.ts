// A plot that answers to the hand: zoom, cursor, legend, handles, download. The same in the page and in reports.
//
// Ctrl and wheel, or pinch: zoom about the pointer; a plot with the focus needs no Ctrl. Drag: zoom to a box; with Shift, or with a finger, move. Double click or 0: all.
// Keys on the plot: arrows move, + and - zoom, 0 and Home show all.

import { bar, description, hint, legend, names, sized } from "./around.ts";
import { mark, pointed, type Reading, readingAt, readingLoop, readingThen } from "./cursor.ts";
import { draw } from "./draw.ts";
import type { Figure, Span } from "./figure.ts";
import { areas, type Frame, frameAt, grid, type Point, valueX, valueY } from "./frame.ts";
import { listen } from "./gestures.ts";
import { Handles } from "./handles.ts";
import type { Link } from "./link.ts";
import { CanvasPen, SvgPen } from "./pens.ts";
import { spansY, spanX } from "./spans.ts";
import { darkness, light, type Theme, themed, themeOf } from "./theme.ts";

/** How a plot looks, and what it belongs to. */
export interface Look {
  /** False if the names of the series stand elsewhere: `hide` shows and hides them. */
  legend?: boolean;
  /** Plots that share the span of x and the cursor. Loops share the time of their samples instead. */
  link?: Link | undefined;
}

/** Draws a figure in an element, and draws it anew when the figure, the size or the theme changes. */
export class Plot {
  readonly #host: HTMLElement;
  readonly #canvas = document.createElement("canvas");
  readonly #cursor = document.createElement("canvas");
  readonly #legend = document.createElement("div");
  readonly #readout = document.createElement("output");
  readonly #stage = document.createElement("div");
  readonly #look: Look;
  readonly #resized: ResizeObserver;
  readonly #scrolled: IntersectionObserver;
  readonly #hidden = new Set<string>();
  #figure: Figure;
  #frames: Frame[] = [];
  #x: Span | undefined;
  #y: (Span | undefined)[] = [];
  readonly #handles = new Handles(this.#stage);
  readonly #leave: (() => void) | undefined;
  #theme: Theme | undefined;
  #drawing = 0;
  #near = false;

  constructor(host: HTMLElement, figure: Figure, look: Look = {}) {
    this.#host = host;
    this.#figure = figure;
    this.#look = look;
    host.classList.add("plot");
    this.#stage.className = "stage";
    this.#legend.className = "legend";
    this.#readout.className = "readout";
    this.#canvas.tabIndex = 0;
    this.#canvas.setAttribute("role", "img");
    this.#cursor.className = "cursor";
    this.#cursor.setAttribute("aria-hidden", "true");
    this.#stage.append(this.#canvas, this.#cursor);
    const buttons = bar(() => this.#figure, () => this.svg(), () => this.#all());
    buttons.prepend(this.#readout);
    host.replaceChildren(this.#legend, this.#stage, buttons);
    this.#listen();
    this.#resized = new ResizeObserver(() => this.redraw());
    this.#resized.observe(this.#stage);
    // Only what is near the screen has pixels: phones have little room for them.
    this.#scrolled = new IntersectionObserver((entries) => {
      this.#near = entries.at(-1)!.isIntersecting;
      if (this.#near) this.redraw();
      else for (const canvas of [this.#canvas, this.#cursor]) canvas.width = canvas.height = 0;
    }, { rootMargin: "3000px" });
    this.#scrolled.observe(this.#stage);
    darkness.addEventListener("change", this.#themed);
    themed.add(this.#themed);
    this.#leave = look.link?.join({ redraw: () => this.redraw(), point: (x) => this.#follow(x) });
    this.set(figure);
  }

  /** Shows another figure. The zoom stays if the x axis does. */
  set(figure: Figure): void {
    const before = this.#figure;
    this.#figure = figure;
    const same = before.x.label === figure.x.label && before.panels.length === figure.panels.length;
    if (!same) [this.#x, this.#y] = [undefined, []];
    this.#canvas.setAttribute("aria-label", description(figure));
    const shown = names(figure).size > 1 && this.#look.legend !== false;
    this.#legend.replaceChildren(...(shown ? legend(figure, this.#hidden, () => this.redraw()) : []));
    this.#handles.set(figure.handles ?? []);
    this.redraw();
  }

  /** Ends the plot. */
  close(): void {
    this.#leave?.();
    this.#resized.disconnect();
    this.#scrolled.disconnect();
    darkness.removeEventListener("change", this.#themed);
    themed.delete(this.#themed);
    cancelAnimationFrame(this.#drawing);
  }

  /** Hides or shows the series of this name. */
  hide(name: string, hidden: boolean): void {
    if (hidden) this.#hidden.add(name);
    else this.#hidden.delete(name);
    this.redraw();
  }

  /** Draws at the next frame of the screen. */
  redraw(): void {
    if (this.#drawing) return;
    this.#drawing = requestAnimationFrame(() => {
      this.#drawing = 0;
      this.#draw();
    });
  }

  /** The figure as it is shown, as SVG in the colours of paper. */
  svg(): string {
    const { clientWidth: width, clientHeight: height } = this.#stage;
    const pen = new SvgPen();
    const theme = light(() => themeOf(this.#host));
    draw(pen, this.#figure, this.#frames, theme, this.#hidden);
    let x = 70;
    for (const [name, colour] of names(this.#figure)) {
      if (this.#hidden.has(name)) continue;
      pen.rectangle(x, height + 6, 16, 4, theme.series[colour % theme.series.length]!);
      pen.text(name, x + 22, height + 12, theme.text, "left");
      x += 40 + 7 * name.length;
    }
    return pen.picture(width, height + 24, this.#figure.title, "#fff");
  }

  readonly #themed = () => this.redraw();

  #draw(): void {
    if (!this.#near || !this.#place()) return;
    const { clientWidth: width, clientHeight: height } = this.#stage;
    const [figure, frames] = [this.#figure, this.#frames];
    this.#theme = themeOf(this.#host);
    draw(new CanvasPen(sized(this.#canvas, width, height)), figure, frames, this.#theme, this.#hidden);
    sized(this.#cursor, width, height);
    this.#handles.place(figure, frames);
    const { link } = this.#look;
    if (link?.cursor !== undefined) this.#follow(link.cursor);
  }

  /** Finds the places of the panels and the spans of their axes; false if there is no room. */
  #place(): boolean {
    const { clientWidth: width, clientHeight: height } = this.#stage;
    if (width < 40 || height < 40) return false;
    const [figure, { link }] = [this.#figure, this.#look];
    const only = figure.loops ? link?.span : undefined;
    const x = (link && !figure.loops ? link.span : this.#x) ?? spanX(figure, this.#hidden, only);
    const places = areas(figure, width, height);
    const ys = spansY(figure, x, this.#hidden, only);
    this.#frames = figure.panels.map((panel, k) => ({ panel, area: places[k]!, x, y: this.#y[this.#row(k)] ?? ys[k]!, only }));
    this.#stage.style.setProperty("--rows", String(figure.columns ? grid(figure, width).rows : 1));
    return true;
  }

  /** The place of a panel among the spans of y; panels side by side share one. */
  readonly #row = (k: number) => (this.#figure.columns ? 0 : k);

  // Zoom and cursor.

  #zoom(x: Span | undefined, y: (Span | undefined)[]): void {
    const { link } = this.#look;
    this.#y = y;
    if (link && !this.#figure.loops) return link.zoom(x);
    this.#x = x;
    this.redraw();
  }

  /** Shows all, and all times of a linked loop. */
  #all(): void {
    this.#zoom(undefined, []);
    this.#look.link?.zoom(undefined);
  }

  /** Zooms by a factor about a point, or moves by shares of the span. */
  #change(factor: number, at: Point, move = { x: 0, y: 0 }): void {
    // Several changes may come before the next drawing.
    if (this.#drawing) this.#place();
    const k = frameAt(this.#frames, at);
    const frame = this.#frames[k];
    if (!frame) return;
    const figure = this.#figure;
    const { area } = frame;
    const spanned = (from: number, size: number, middle: number, moved: number): [number, number] => {
      const low = middle + (from - middle) * factor + moved * size;
      return [low, low + size * factor];
    };
    const [left, right] = spanned(area.x, area.width, at.x, move.x);
    const [top, bottom] = spanned(area.y, area.height, at.y, move.y);
    const x = { from: valueX(figure, frame, left), to: valueX(figure, frame, right) };
    if (!(x.to - x.from > 1e-12 * Math.abs(x.to))) return;
    const y = [...this.#y];
    if (figure.loops || move.y !== 0 || y[this.#row(k)]) {
      y[this.#row(k)] = { from: valueY(frame, bottom), to: valueY(frame, top) };
    }
    this.#zoom(x, y);
  }

  #listen(): void {
    const middle = () => {
      const area = this.#frames[0]?.area;
      return area && { x: area.x + area.width / 2, y: area.y + area.height / 2 };
    };
    listen(this.#canvas, {
      change: (factor, at, move) => this.#change(factor, at, move),
      drag: (start, now, way) => {
        const area = this.#frames[frameAt(this.#frames, start)]?.area;
        if (area) this.#change(1, now, { x: way.x / area.width, y: this.#figure.loops ? way.y / area.height : 0 });
      },
      box: (start, now) => this.#box(start, now),
      boxed: (start, now) => this.#boxed(start, now),
      point: (at) => this.#point(at),
      leave: () => this.#left(),
      all: () => this.#all(),
      scrolled: () => this.#theme && hint(this.#cursor, this.#stage, this.#theme),
    }, middle);
  }

  #clear(): void {
    this.#cursor.getContext("2d")?.clearRect(0, 0, this.#cursor.width, this.#cursor.height);
    this.#readout.value = "";
  }

  #left(): void {
    this.#clear();
    this.#look.link?.point(undefined);
  }

  #box(from: Point, to: Point): void {
    const context = this.#cursor.getContext("2d");
    const frame = this.#frames[frameAt(this.#frames, from)];
    if (!context || !frame || !this.#theme) return;
    this.#clear();
    context.fillStyle = this.#theme.span;
    if (this.#figure.loops) return context.fillRect(from.x, from.y, to.x - from.x, to.y - from.y);
    for (const { area } of this.#frames.filter(({ area }) => area.x === frame.area.x)) {
      context.fillRect(from.x, area.y, to.x - from.x, area.height);
    }
  }

  #boxed(from: Point, to: Point): void {
    this.#clear();
    const k = frameAt(this.#frames, from);
    const frame = this.#frames[k];
    if (!frame || Math.abs(to.x - from.x) < 5) return;
    const xs = [valueX(this.#figure, frame, from.x), valueX(this.#figure, frame, to.x)].sort((a, b) => a - b);
    const y = [...this.#y];
    if (this.#figure.loops && Math.abs(to.y - from.y) >= 5) {
      const ys = [valueY(frame, from.y), valueY(frame, to.y)].sort((a, b) => a - b);
      y[this.#row(k)] = { from: ys[0]!, to: ys[1]! };
    }
    this.#zoom({ from: xs[0]!, to: xs[1]! }, y);
  }

  /** The cursor: what the series are there. */
  #point(at: Point): void {
    const frame = this.#frames[frameAt(this.#frames, at)];
    if (!frame) return;
    const [figure, { link }] = [this.#figure, this.#look];
    const { area } = frame;
    if (at.x < area.x || at.x > area.x + area.width) return this.#left();
    if (!figure.loops) {
      const x = pointed(figure, this.#frames, frame, this.#hidden, at);
      return link ? link.point(x) : this.#show(readingAt(figure, this.#frames, this.#hidden, x));
    }
    const reading = readingLoop(figure, frame, this.#hidden, at);
    link?.point(reading.time);
    if (!link || reading.time === undefined) this.#show(reading);
  }

  /** Puts the cursor where that of the link is. */
  #follow(x: number | undefined): void {
    if (x === undefined) return this.#clear();
    const read = this.#figure.loops ? readingThen : readingAt;
    this.#show(read(this.#figure, this.#frames, this.#hidden, x));
  }

  #show(reading: Reading): void {
    const context = this.#cursor.getContext("2d");
    if (!context || !this.#theme) return;
    this.#clear();
    mark(context, this.#figure, this.#frames, reading, this.#theme);
    this.#readout.value = reading.text;
  }
}
