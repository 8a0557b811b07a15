// A plot that answers to the hand: zoom, cursor, legend, handles, download. The same in the page and in reports.
//
// Wheel or pinch: zoom about the pointer. Drag: zoom to a box; with Shift, or with a finger, move. Double click or 0: all.
// Keys on the plot: arrows move, + and - zoom, 0 shows all.

import { type Point, reading } from "./cursor.ts";
import { csv, download } from "./download.ts";
import { areas, CanvasPen, draw, type Frame, SvgPen, valueX, valueY } from "./draw.ts";
import { type Figure, type Series, type Span, spanX, spanY } from "./figure.ts";
import { listen } from "./gestures.ts";
import { Handles } from "./handles.ts";
import { COLOURS, darkness, light, themed, themeOf } from "./theme.ts";

/** How a plot looks. */
export interface Look {
  /** False if the names of the series stand elsewhere: `hide` shows and hides them. */
  legend?: boolean;
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
    host.replaceChildren(this.#legend, this.#stage, this.#bar());
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
    this.set(figure);
  }

  /** Shows another figure. The zoom stays if the x axis does. */
  set(figure: Figure): void {
    const before = this.#figure;
    this.#figure = figure;
    const same = before.x.label === figure.x.label && before.panels.length === figure.panels.length;
    if (!same) [this.#x, this.#y] = [undefined, []];
    this.#canvas.setAttribute("aria-label", description(figure));
    this.#legends();
    this.#handles.set(figure.handles ?? []);
    this.redraw();
  }

  /** Ends the plot. */
  close(): void {
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
    for (const [name, colour] of this.#names()) {
      if (this.#hidden.has(name)) continue;
      pen.rectangle(x, height + 6, 16, 4, theme.series[colour % theme.series.length]!);
      pen.text(name, x + 22, height + 12, theme.text, "left");
      x += 40 + 7 * name.length;
    }
    return pen.picture(width, height + 24, this.#figure.title, "#fff");
  }

  readonly #themed = () => this.redraw();

  #draw(): void {
    const { clientWidth: width, clientHeight: height } = this.#stage;
    if (!this.#near || width < 40 || height < 40) return;
    const figure = this.#figure;
    const x = this.#x ?? spanX(figure, this.#hidden);
    const places = areas(figure, width, height);
    this.#frames = figure.panels.map((panel, k) => ({
      panel,
      area: places[k]!,
      x,
      y: this.#y[k] ?? spanY(figure, panel, x, this.#hidden),
    }));
    const pen = new CanvasPen(sized(this.#canvas, width, height));
    draw(pen, figure, this.#frames, themeOf(this.#host), this.#hidden);
    sized(this.#cursor, width, height);
    this.#handles.place(figure, this.#frames);
  }

  // The legend and the bar.

  #names(): Map<string, number> {
    const all = this.#figure.panels.flatMap((panel) => panel.series);
    return new Map(all.filter((series) => series.name).map((series) => [series.name, series.colour ?? 0]));
  }

  #legends(): void {
    const style = (one: Series) => (one.dash ? "dashed" : (one.style ?? "line"));
    const styles = new Map(this.#figure.panels.flatMap((panel) => panel.series).map((one) => [one.name, style(one)]));
    const names = this.#names();
    const buttons = [...names].map(([name, colour]) => {
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = name;
      button.className = `series-${colour % COLOURS} ${styles.get(name)}`;
      button.ariaPressed = String(!this.#hidden.has(name));
      button.title = "Show or hide";
      button.onclick = () => {
        if (!this.#hidden.delete(name)) this.#hidden.add(name);
        button.ariaPressed = String(!this.#hidden.has(name));
        this.redraw();
      };
      return button;
    });
    this.#legend.replaceChildren(...(names.size > 1 && this.#look.legend !== false ? buttons : []));
  }

  #bar(): HTMLElement {
    const bar = document.createElement("div");
    bar.className = "bar";
    const button = (text: string, title: string, act: () => void) => {
      const result = document.createElement("button");
      result.type = "button";
      result.textContent = text;
      result.title = title;
      result.onclick = act;
      return result;
    };
    const name = (ending: string) => `${this.#figure.title.replace(/[^\p{L}\p{N}]+/gu, "-")}.${ending}`;
    bar.append(
      this.#readout,
      button("All", "Show all (double click)", () => this.#zoom(undefined, [])),
      button("SVG", "Download the figure as SVG", () => download(name("svg"), this.svg(), "image/svg+xml")),
      button("CSV", "Download the samples as CSV", () => download(name("csv"), csv(this.#figure), "text/csv")),
    );
    return bar;
  }

  // Zoom and cursor.

  #zoom(x: Span | undefined, y: (Span | undefined)[]): void {
    this.#x = x;
    this.#y = y;
    this.redraw();
  }

  #frameAt(y: number): number {
    const k = this.#frames.findIndex(({ area }) => y <= area.y + area.height + 7);
    return k < 0 ? this.#frames.length - 1 : k;
  }

  /** Zooms by a factor about a point, or moves by shares of the span. */
  #change(factor: number, at: Point, move = { x: 0, y: 0 }): void {
    const frame = this.#frames[this.#frameAt(at.y)];
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
    const k = this.#frameAt(at.y);
    if (figure.loops || move.y !== 0 || y[k]) {
      y[k] = { from: valueY(frame, bottom), to: valueY(frame, top) };
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
        const area = this.#frames[this.#frameAt(start.y)]?.area;
        if (area) this.#change(1, now, { x: way.x / area.width, y: this.#figure.loops ? way.y / area.height : 0 });
      },
      box: (start, now) => this.#box(start, now),
      boxed: (start, now) => this.#boxed(start, now),
      point: (at) => this.#point(at),
      leave: () => this.#clear(),
      all: () => this.#zoom(undefined, []),
    }, middle);
  }

  #clear(): void {
    this.#cursor.getContext("2d")?.clearRect(0, 0, this.#cursor.width, this.#cursor.height);
    this.#readout.value = "";
  }

  #box(from: Point, to: Point): void {
    const context = this.#cursor.getContext("2d");
    const frame = this.#frames[this.#frameAt(from.y)];
    if (!context || !frame) return;
    this.#clear();
    const all = this.#frames.at(-1)!.area;
    const [top, height] = this.#figure.loops ? [from.y, to.y - from.y] : [8, all.y + all.height - 8];
    context.fillStyle = themeOf(this.#host).span;
    context.fillRect(from.x, top, to.x - from.x, height);
  }

  #boxed(from: Point, to: Point): void {
    this.#clear();
    const k = this.#frameAt(from.y);
    const frame = this.#frames[k];
    if (!frame || Math.abs(to.x - from.x) < 5) return;
    const xs = [valueX(this.#figure, frame, from.x), valueX(this.#figure, frame, to.x)].sort((a, b) => a - b);
    const y = [...this.#y];
    if (this.#figure.loops && Math.abs(to.y - from.y) >= 5) {
      const ys = [valueY(frame, from.y), valueY(frame, to.y)].sort((a, b) => a - b);
      y[k] = { from: ys[0]!, to: ys[1]! };
    }
    this.#zoom({ from: xs[0]!, to: xs[1]! }, y);
  }

  /** The cursor: what the series are there. */
  #point(at: Point): void {
    const context = this.#cursor.getContext("2d");
    const frame = this.#frames[this.#frameAt(at.y)];
    if (!context || !frame) return;
    this.#clear();
    const { area } = frame;
    if (at.x < area.x || at.x > area.x + area.width) return;
    const { text, line, ring } = reading(this.#figure, this.#frames, frame, this.#hidden, at);
    const [first, last] = [this.#frames[0]!.area, this.#frames.at(-1)!.area];
    context.strokeStyle = themeOf(this.#host).line;
    context.lineWidth = 1;
    context.beginPath();
    if (ring) context.arc(ring.x, ring.y, 4, 0, 2 * Math.PI);
    if (line !== undefined) {
      context.moveTo(line, first.y);
      context.lineTo(line, last.y + last.height);
    }
    context.stroke();
    this.#readout.value = text;
  }
}

/** What a screen reader says of a figure. */
function description(figure: Figure): string {
  const panels = figure.panels.map(({ y, series }) => {
    const names = series.map((one) => one.name).filter(Boolean).join(", ");
    return `${y.label} [${y.unit}]${names ? `: ${names}` : ""}`;
  });
  return `${figure.title}. ${panels.join("; ")} against ${figure.x.label} [${figure.x.unit}]`;
}

/** The drawing context of a canvas with this size in pixels of CSS, cleared. */
function sized(canvas: HTMLCanvasElement, width: number, height: number): CanvasRenderingContext2D {
  const ratio = devicePixelRatio || 1;
  const [w, h] = [Math.round(width * ratio), Math.round(height * ratio)];
  if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
  const context = canvas.getContext("2d")!;
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  return context;
}
