// Drawing a figure: into a canvas, or as SVG. Both take the same strokes.

import { type Figure, type Panel, place, type Series, type Span, within } from "./figure.ts";
import { ticks, unit, written } from "./ticks.ts";

/** What draws: a canvas, or a writer of SVG. Its names are those of a canvas. */
export interface Pen {
  stroke(points: Float64Array, count: number, style: Stroke): void;
  dots(points: Float64Array, count: number, colour: string, radius: number, opacity?: number): void;
  /** The inside of an outline, pale. */
  inside(points: Float64Array, count: number, colour: string): void;
  rectangle(x: number, y: number, width: number, height: number, colour: string): void;
  text(text: string, x: number, y: number, colour: string, align: "left" | "center" | "right", upright?: boolean): void;
  clipped(area: Area, draw: () => void): void;
}

/** How a line looks. */
export interface Stroke {
  colour: string;
  width: number;
  dash?: number[];
}

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

/** A rectangle in pixels. */
export interface Area {
  x: number;
  y: number;
  width: number;
  height: number;
}

/** A panel with its place and the span of its axes. */
export interface Frame {
  panel: Panel;
  area: Area;
  x: Span;
  y: Span;
}

const FONT = 12;
const LEFT = 70;
const RIGHT = 12;
const BOTTOM = 40;
const TOP = 8;
const BETWEEN = 14;

/** Where the panels are in a picture of this size. */
export function areas(figure: Figure, width: number, height: number): Area[] {
  const n = figure.panels.length;
  const each = (height - TOP - BOTTOM - (n - 1) * BETWEEN) / n;
  return figure.panels.map((_, k) => ({
    x: LEFT,
    y: TOP + k * (each + BETWEEN),
    width: Math.max(20, width - LEFT - RIGHT),
    height: Math.max(20, each),
  }));
}

const scale = (value: number, { from, to }: Span, log: boolean | undefined): number =>
  log ? Math.log(value / from) / Math.log(to / from) : (value - from) / (to - from);

const unscale = (share: number, { from, to }: Span, log: boolean | undefined): number =>
  log ? from * (to / from) ** share : from + share * (to - from);

/** The pixel of a place on the x axis, and on the y axis. */
export const pixelX = (figure: Figure, { area, x }: Frame, value: number): number =>
  area.x + area.width * scale(value, x, figure.x.log);
export const pixelY = ({ area, y, panel }: Frame, value: number): number =>
  area.y + area.height * (1 - scale(value, y, panel.y.log));

/** The place of a pixel on the x axis, and on the y axis. */
export const valueX = (figure: Figure, { area, x }: Frame, pixel: number): number =>
  unscale((pixel - area.x) / area.width, x, figure.x.log);
export const valueY = ({ area, y, panel }: Frame, pixel: number): number =>
  unscale(1 - (pixel - area.y) / area.height, y, panel.y.log);

/** Draws the figure with these frames. */
export function draw(pen: Pen, figure: Figure, frames: Frame[], theme: Theme, hidden: Set<string>): void {
  const last = frames.length - 1;
  frames.forEach((frame, k) => {
    axes(pen, figure, frame, theme, k === last);
    pen.clipped(frame.area, () => {
      if (figure.span) {
        const from = pixelX(figure, frame, figure.span.from);
        const to = pixelX(figure, frame, figure.span.to);
        pen.rectangle(from, frame.area.y, to - from, frame.area.height, theme.span);
      }
      for (const { from, to } of figure.marks ?? []) {
        const [left, right] = [pixelX(figure, frame, from), pixelX(figure, frame, to)];
        pen.rectangle(left - 1, frame.area.y, Math.max(3, right - left + 2), frame.area.height, theme.mark);
      }
      const shown = frame.panel.series.filter((series) => !hidden.has(series.name));
      // What is pale stands below.
      const order = [...shown.filter((one) => one.style === "pale"), ...shown.filter((one) => one.style !== "pale")];
      for (const series of order) curve(pen, figure, frame, series, theme);
      for (const level of frame.panel.levels ?? []) {
        const at = pixelY(frame, level.at);
        pen.stroke(Float64Array.of(frame.area.x, at, frame.area.x + frame.area.width, at), 2, limit(theme));
        pen.text(level.label, frame.area.x + frame.area.width - 4, beside(at, frame.area), theme.text, "right");
      }
      for (const { at: x, label } of frame.panel.places ?? []) {
        const at = pixelX(figure, frame, x);
        pen.stroke(Float64Array.of(at, frame.area.y, at, frame.area.y + frame.area.height), 2, limit(theme));
        pen.text(label, at + 4, frame.area.y + 12, theme.text, "left");
      }
      for (const { from, to } of k === 0 ? (figure.lines ?? []) : []) {
        const ends = [from, to].flatMap(([x, y]) => [pixelX(figure, frame, x), pixelY(frame, y)]);
        pen.stroke(Float64Array.from(ends), 2, limit(theme));
      }
    });
  });
}

/** Where the label of a level stands: on the side that is away from the middle, if there is room. */
function beside(at: number, { y, height }: Area): number {
  const [above, below] = [at - 4, at + 14];
  const room = at > y + height / 2 ? below + 4 < y + height : above - 12 < y;
  return room ? below : above;
}

const limit = (theme: Theme): Stroke => ({ colour: theme.line, width: 1.5, dash: [6, 4] });

function axes(pen: Pen, figure: Figure, frame: Frame, theme: Theme, named: boolean): void {
  const { area, x, y, panel } = frame;
  const [low, right] = [area.y + area.height, area.x + area.width];
  const xs = ticks(x, area.width / 90, figure.x.log);
  const ys = ticks(y, Math.max(2, area.height / 42), panel.y.log);
  const grid = { colour: theme.grid, width: 1 };
  for (const value of xs) {
    const at = Math.round(pixelX(figure, frame, value)) + 0.5;
    pen.stroke(Float64Array.of(at, area.y, at, low), 2, grid);
    if (!named) continue;
    // The last number does not reach over the edge of the picture.
    const text = written(value, gap(xs, value, figure.x.log));
    const over = at + 3.5 * text.length > right + RIGHT;
    pen.text(text, over ? right + RIGHT : at, low + 16, theme.text, over ? "right" : "center");
  }
  for (const value of ys) {
    const at = Math.round(pixelY(frame, value)) + 0.5;
    pen.stroke(Float64Array.of(area.x, at, right, at), 2, grid);
    pen.text(written(value, gap(ys, value, panel.y.log)), area.x - 6, at + 4, theme.text, "right");
  }
  if (named) pen.text(label(figure.x), area.x + area.width / 2, low + 34, theme.text, "center");
  pen.text(label(panel.y), 12, area.y + area.height / 2, theme.text, "center", true);
}

/** The distance from a tick to its neighbour; on a logarithmic axis, the tick's own power of ten. */
const gap = (all: number[], value: number, log: boolean | undefined): number => {
  if (log) return 10 ** Math.floor(Math.log10(value) + 1e-9);
  const k = all.indexOf(value);
  const other = all[k + 1] ?? all[k - 1];
  return other === undefined ? value || 1 : Math.min(Math.abs(other - value), Math.abs(value) || Infinity);
};

const label = (axis: { label: string; unit: string }) => (axis.unit ? `${axis.label} [${unit(axis.unit)}]` : axis.label);

let room = new Float64Array(4096);

/** A room for so many numbers, used again. */
function roomFor(count: number): Float64Array {
  if (room.length < count) room = new Float64Array(2 * count);
  return room;
}

function curve(pen: Pen, figure: Figure, frame: Frame, series: Series, theme: Theme): void {
  const colour = theme.series[(series.colour ?? 0) % theme.series.length]!;
  if (series.lower) return band(pen, figure, frame, series, colour);
  const cloud = series.style === "dots";
  const points = cloud || series.style === "points";
  const [first, last] = figure.loops ? [0, series.y.length] : within(series, frame.x);
  const dense = !figure.loops && !points && last - first > 4 * frame.area.width;
  const count = dense ? columns(figure, frame, series, first, last) : all(figure, frame, series, first, last);
  if (points) return pen.dots(room, count, colour, cloud ? 1.4 : 3, cloud ? 0.5 : 1);
  const pale = series.style === "pale";
  const dash = series.dash ?? (series.style === "dashed" ? [6, 4] : undefined);
  pen.stroke(room, count, { colour: pale ? theme.pale : colour, width: dense ? 1 : pale ? 5 : 1.5, ...(dash && { dash }) });
  if (series.style === "marks") pen.dots(room, count, colour, 3.5);
}

/** The area between a series and its lower edge. */
function band(pen: Pen, figure: Figure, frame: Frame, series: Series, colour: string): void {
  const n = series.y.length;
  const at = (k: number, y: number) => [pixelX(figure, frame, place(series, k)), pixelY(frame, y)];
  const upper = Array.from(series.y, (y, k) => at(k, y));
  const lower = Array.from(series.lower!, (y, k) => at(k, y)).reverse();
  pen.inside(Float64Array.from([...upper, ...lower].flat()), 2 * n, colour);
}

/** The points of a series whose x rises: of each column of pixels the first, lowest, highest and last. */
function columns(figure: Figure, frame: Frame, series: Series, first: number, last: number): number {
  const out = roomFor(8 * (frame.area.width + 4) + 16);
  const { y } = series;
  let used = 0;
  let k = first;
  const put = (at: number, value: number) => {
    out[used++] = at;
    out[used++] = pixelY(frame, value);
  };
  const perPixel = (last - first) / frame.area.width;
  // Samples that are evenly apart in pixels are counted; others are measured.
  const uneven = series.x !== undefined || figure.x.log;
  const counted = (column: number) => Math.min(last, Math.max(k + 1, first + Math.round((column + 1) * perPixel)));
  const measured = () => {
    const next = pixelX(figure, frame, place(series, k)) + 1;
    let end = k + 1;
    while (end < last && pixelX(figure, frame, place(series, end)) < next) end++;
    return end;
  };
  for (let column = 0; k < last; column++) {
    const end = uneven ? measured() : counted(column);
    let [low, high] = [Infinity, -Infinity];
    for (let j = k; j < end; j++) {
      const value = y[j]!;
      if (value < low) low = value;
      if (value > high) high = value;
    }
    const at = pixelX(figure, frame, place(series, k));
    put(at, y[k]!);
    if (low < high) {
      put(at, low);
      put(at, high);
      put(at, y[end - 1]!);
    }
    k = end;
  }
  return used / 2;
}

/** The points of a series in their order, without those in the pixel of the one before. */
function all(figure: Figure, frame: Frame, series: Series, first: number, last: number): number {
  const out = roomFor(2 * (last - first));
  let used = 0;
  let [before, beforeY] = [NaN, NaN];
  for (let k = first; k < last; k++) {
    const x = pixelX(figure, frame, place(series, k));
    const y = pixelY(frame, series.y[k]!);
    if (Math.abs(x - before) < 0.4 && Math.abs(y - beforeY) < 0.4) continue;
    out[used++] = before = x;
    out[used++] = beforeY = y;
  }
  return used / 2;
}

/** A pen for a canvas whose pixels are those of CSS. */
export class CanvasPen implements Pen {
  constructor(readonly context: CanvasRenderingContext2D) {
    context.font = `${FONT}px system-ui, sans-serif`;
  }

  stroke(points: Float64Array, count: number, { colour, width, dash }: Stroke): void {
    const { context } = this;
    context.beginPath();
    let pen = false;
    for (let k = 0; k < count; k++) {
      const [x, y] = [points[2 * k]!, points[2 * k + 1]!];
      // A canvas draws nothing of a line whose ends are too far away.
      const far = !(Math.abs(x) < 1e6 && Math.abs(y) < 1e6);
      if (far) pen = false;
      else if (pen) context.lineTo(x, y);
      else {
        context.moveTo(x, y);
        pen = true;
      }
    }
    context.strokeStyle = colour;
    context.lineWidth = width;
    context.lineJoin = "bevel";
    context.setLineDash(dash ?? []);
    context.stroke();
  }

  dots(points: Float64Array, count: number, colour: string, radius: number, opacity = 1): void {
    const { context } = this;
    context.fillStyle = colour;
    context.globalAlpha = opacity;
    context.beginPath();
    for (let k = 0; k < count; k++) {
      const [x, y] = [points[2 * k]!, points[2 * k + 1]!];
      context.moveTo(x + radius, y);
      context.arc(x, y, radius, 0, 2 * Math.PI);
    }
    context.fill();
    context.globalAlpha = 1;
  }

  inside(points: Float64Array, count: number, colour: string): void {
    const { context } = this;
    context.beginPath();
    for (let k = 0; k < count; k++) context.lineTo(points[2 * k]!, points[2 * k + 1]!);
    context.fillStyle = colour;
    context.globalAlpha = 0.2;
    context.fill();
    context.globalAlpha = 1;
  }

  rectangle(x: number, y: number, width: number, height: number, colour: string): void {
    this.context.fillStyle = colour;
    this.context.fillRect(x, y, width, height);
  }

  text(text: string, x: number, y: number, colour: string, align: CanvasTextAlign, upright = false): void {
    const { context } = this;
    context.fillStyle = colour;
    context.textAlign = align;
    context.save();
    context.translate(x, y);
    if (upright) context.rotate(-Math.PI / 2);
    context.fillText(text, 0, 0);
    context.restore();
  }

  clipped({ x, y, width, height }: Area, draw: () => void): void {
    const { context } = this;
    context.save();
    context.beginPath();
    context.rect(x, y, width, height);
    context.clip();
    draw();
    context.restore();
  }
}

const escaped = (text: string) => text.replace(/[<>&"]/g, (c) => `&#${c.charCodeAt(0)};`);

/** A pen that writes SVG. */
export class SvgPen implements Pen {
  #parts: string[] = [];
  #clips = 0;

  stroke(points: Float64Array, count: number, { colour, width, dash }: Stroke): void {
    let path = "";
    let pen = false;
    for (let k = 0; k < count; k++) {
      const [x, y] = [points[2 * k]!, points[2 * k + 1]!];
      const near = Math.abs(x) < 1e5 && Math.abs(y) < 1e5;
      if (near) path += `${pen ? "L" : "M"}${x.toFixed(2)} ${y.toFixed(2)}`;
      pen = near;
    }
    const dashes = dash ? ` stroke-dasharray="${dash.join(" ")}"` : "";
    this.#parts.push(`<path d="${path}" fill="none" stroke="${colour}" stroke-width="${width}"${dashes}/>`);
  }

  dots(points: Float64Array, count: number, colour: string, radius: number, opacity = 1): void {
    this.#parts.push(`<g fill="${colour}" fill-opacity="${opacity}">`);
    for (let k = 0; k < count; k++) {
      const [x, y] = [points[2 * k]!, points[2 * k + 1]!];
      if (Number.isFinite(x + y)) this.#parts.push(`<circle cx="${x.toFixed(2)}" cy="${y.toFixed(2)}" r="${radius}"/>`);
    }
    this.#parts.push("</g>");
  }

  inside(points: Float64Array, count: number, colour: string): void {
    const corners = Array.from(points.subarray(0, 2 * count), (value) => value.toFixed(2)).join(" ");
    this.#parts.push(`<polygon points="${corners}" fill="${colour}" fill-opacity="0.2"/>`);
  }

  rectangle(x: number, y: number, width: number, height: number, colour: string): void {
    const [left, top] = [x.toFixed(2), y.toFixed(2)];
    this.#parts.push(`<rect x="${left}" y="${top}" width="${width.toFixed(2)}" height="${height}" fill="${colour}"/>`);
  }

  text(text: string, x: number, y: number, colour: string, align: string, upright = false): void {
    const anchor = { left: "start", center: "middle", right: "end" }[align];
    const turn = upright ? ` transform="rotate(-90 ${x} ${y})"` : "";
    this.#parts.push(`<text x="${x}" y="${y}" fill="${colour}" text-anchor="${anchor}"${turn}>${escaped(text)}</text>`);
  }

  clipped({ x, y, width, height }: Area, draw: () => void): void {
    const id = `clip${this.#clips++}`;
    this.#parts.push(`<clipPath id="${id}"><rect x="${x}" y="${y}" width="${width}" height="${height}"/></clipPath>`);
    this.#parts.push(`<g clip-path="url(#${id})">`);
    draw();
    this.#parts.push("</g>");
  }

  /** The picture, on its background, with a legend below it. */
  picture(width: number, height: number, title: string, background: string): string {
    const head = `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${width} ${height}" width="${width}" height="${height}"`;
    const font = `font-family="system-ui, sans-serif" font-size="${FONT}"`;
    const ground = `<rect width="${width}" height="${height}" fill="${background}"/>`;
    return `${head} ${font}><title>${escaped(title)}</title>${ground}${this.#parts.join("")}</svg>\n`;
  }
}
