// What draws: into a canvas, or as SVG. Both take the same strokes.

import type { Area } from "./frame.ts";

/** What draws: a canvas, or a writer of SVG. Its names are those of a canvas. */
export interface Pen {
  stroke(points: Float64Array, count: number, style: Stroke): void;
  dots(points: Float64Array, count: number, colour: string, radius: number, opacity?: number): void;
  /** The inside of an outline, pale. */
  inside(points: Float64Array, count: number, colour: string): void;
  /** Pixels of one colour. */
  pixels(pixels: Pixels, colour: string): void;
  rectangle(x: number, y: number, width: number, height: number, colour: string): void;
  text(text: string, x: number, y: number, colour: string, align: "left" | "center" | "right", upright?: boolean): void;
  clipped(area: Area, draw: () => void): void;
}

/** How a line looks. */
export interface Stroke {
  colour: string;
  width: number;
  dash?: number[];
  alpha?: number;
}

/** Pixels by their opacity, row by row from the top: 0 to 255, in every fourth byte, as in an image. */
export interface Pixels extends Area {
  image: ImageData;
}

const FONT = 12;

/** A canvas with these pixels in this colour. */
function coloured({ image }: Pixels, colour: string): HTMLCanvasElement {
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [image.width, image.height];
  const context = canvas.getContext("2d")!;
  context.putImageData(image, 0, 0);
  context.globalCompositeOperation = "source-in";
  context.fillStyle = colour;
  context.fillRect(0, 0, image.width, image.height);
  return canvas;
}

/** A pen for a canvas whose pixels are those of CSS. */
export class CanvasPen implements Pen {
  constructor(readonly context: CanvasRenderingContext2D) {
    context.font = `${FONT}px system-ui, sans-serif`;
  }

  stroke(points: Float64Array, count: number, { colour, width, dash, alpha = 1 }: Stroke): void {
    const { context } = this;
    context.globalAlpha = alpha;
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
    context.globalAlpha = 1;
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

  pixels(pixels: Pixels, colour: string): void {
    this.context.imageSmoothingEnabled = false;
    this.context.drawImage(coloured(pixels, colour), pixels.x, pixels.y, pixels.width, pixels.height);
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

  stroke(points: Float64Array, count: number, { colour, width, dash, alpha = 1 }: Stroke): void {
    let path = "";
    let pen = false;
    for (let k = 0; k < count; k++) {
      const [x, y] = [points[2 * k]!, points[2 * k + 1]!];
      const near = Math.abs(x) < 1e5 && Math.abs(y) < 1e5;
      if (near) path += `${pen ? "L" : "M"}${x.toFixed(2)} ${y.toFixed(2)}`;
      pen = near;
    }
    const dashes = dash ? ` stroke-dasharray="${dash.join(" ")}"` : "";
    const opacity = alpha < 1 ? ` stroke-opacity="${alpha}"` : "";
    this.#parts.push(`<path d="${path}" fill="none" stroke="${colour}" stroke-width="${width}"${opacity}${dashes}/>`);
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

  pixels(pixels: Pixels, colour: string): void {
    const { x, y, width, height } = pixels;
    const size = `x="${x}" y="${y}" width="${width}" height="${height}" preserveAspectRatio="none"`;
    this.#parts.push(`<image ${size} href="${coloured(pixels, colour).toDataURL()}"/>`);
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
