// Where panels are in a picture, and where values are in a panel.

import type { Figure, Panel, Span } from "./figure.ts";

/** A rectangle in pixels. */
export interface Area {
  x: number;
  y: number;
  width: number;
  height: number;
}

/** A place on the canvas. */
export interface Point {
  x: number;
  y: number;
}

/** A panel with its place and the span of its axes. */
export interface Frame {
  panel: Panel;
  area: Area;
  x: Span;
  y: Span;
  /** The time whose samples are drawn of loops, all without it. */
  only?: Span | undefined;
}

export const LEFT = 70;
export const RIGHT = 12;
const BOTTOM = 40;
const TOP = 8;
const BETWEEN = 14;
/** Height of a title of a panel, and the room between panels side by side. */
const HEAD = 18;
const BESIDE = 26;
/** The least width of panels side by side. */
const NARROW = 150;

/** How many panels stand side by side in this width, and in how many rows. */
export function grid({ columns = 1, panels }: Figure, width: number): { columns: number; rows: number } {
  const fit = Math.max(1, Math.floor((width - LEFT - RIGHT + BESIDE) / (NARROW + BESIDE)));
  const across = Math.max(1, Math.min(columns, fit, panels.length));
  return { columns: across, rows: Math.ceil(panels.length / across) };
}

/** Where the panels are in a picture of this size. */
export function areas(figure: Figure, width: number, height: number): Area[] {
  const { columns, rows } = grid(figure, width);
  const head = figure.panels.some(({ title }) => title) ? HEAD : 0;
  const wide = (width - LEFT - RIGHT - (columns - 1) * BESIDE) / columns;
  const each = (height - TOP - BOTTOM - rows * head - (rows - 1) * BETWEEN) / rows;
  return figure.panels.map((_, k) => ({
    x: LEFT + (k % columns) * (wide + BESIDE),
    y: TOP + head + Math.floor(k / columns) * (each + head + BETWEEN),
    width: Math.max(20, wide),
    height: Math.max(20, each),
  }));
}

/** The frame at a place, or the nearest one. */
export function frameAt(frames: Frame[], at: Point): number {
  const away = ({ area }: Frame) => Math.hypot(
    Math.max(area.x - at.x, at.x - area.x - area.width, 0), Math.max(area.y - at.y, at.y - area.y - area.height, 0));
  const all = frames.map(away);
  return all.indexOf(Math.min(...all));
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
