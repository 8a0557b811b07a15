// What a hand does on a canvas: wheel, drag, pinch, keys.

import type { Point } from "./frame.ts";

/** What a gesture asks for. Places are in pixels of the canvas. */
export interface Gestured {
  /** Zoomed by a factor about a place, and moved by shares of the panel there. */
  change(factor: number, at: Point, move?: Point): void;
  /** Moved by a hand that began at `start`; `way` is from `now` back to where it was before. */
  drag(start: Point, now: Point, way: Point): void;
  /** A box is being drawn. */
  box(start: Point, now: Point): void;
  /** A box was drawn. */
  boxed(start: Point, now: Point): void;
  /** Pointed at, without a button, or tapped. */
  point(at: Point): void;
  /** No longer pointed at. */
  leave(): void;
  /** All is to be shown. */
  all(): void;
  /** A wheel was turned that scrolls the page. */
  scrolled(): void;
}

/** How far a finger moves at most that taps [pixels]. */
const TAP = 5;

/** Tells what is done on this canvas; keys act about `middle`. */
export function listen(canvas: HTMLCanvasElement, on: Gestured, middle: () => Point | undefined): void {
  const at = (event: MouseEvent): Point => {
    const box = canvas.getBoundingClientRect();
    return { x: event.clientX - box.x, y: event.clientY - box.y };
  };
  const held = new Map<number, Point>();
  let start: Point | undefined;
  canvas.addEventListener("wheel", (event) => {
    // A page is scrolled over its plots, unless a plot has the focus or a key is held.
    if (!event.ctrlKey && document.activeElement !== canvas) return on.scrolled();
    event.preventDefault();
    on.change(1.0015 ** event.deltaY, at(event));
  }, { passive: false });
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    held.set(event.pointerId, at(event));
    start = at(event);
  });
  canvas.addEventListener("pointermove", (event) => {
    const now = at(event);
    const before = held.get(event.pointerId);
    if (!before || !start) return on.point(now);
    held.set(event.pointerId, now);
    if (held.size === 2) {
      const other = [...held].find(([id]) => id !== event.pointerId)![1];
      const apart = (p: Point) => Math.hypot(p.x - other.x, p.y - other.y) || 1;
      on.change(apart(before) / apart(now), other);
    } else if (event.pointerType === "touch" || event.shiftKey) {
      on.drag(start, now, { x: before.x - now.x, y: before.y - now.y });
    } else {
      on.box(start, now);
    }
  });
  canvas.addEventListener("pointerup", (event) => {
    if (start && held.size === 1) {
      const now = at(event);
      if (event.pointerType !== "touch") event.shiftKey || on.boxed(start, now);
      else if (Math.hypot(now.x - start.x, now.y - start.y) < TAP) on.point(now);
    }
    held.delete(event.pointerId);
    if (held.size === 0) start = undefined;
  });
  canvas.addEventListener("pointercancel", () => {
    held.clear();
    start = undefined;
    on.leave();
  });
  // A finger that is lifted has left; what it pointed at stays.
  canvas.addEventListener("pointerleave", (event) => held.size === 0 && event.pointerType !== "touch" && on.leave());
  canvas.addEventListener("dblclick", () => on.all());
  canvas.addEventListener("keydown", (event) => {
    const place = middle();
    if (!place || event.ctrlKey || event.metaKey) return;
    const moves: Record<string, () => void> = {
      ArrowLeft: () => on.change(1, place, { x: -0.1, y: 0 }),
      ArrowRight: () => on.change(1, place, { x: 0.1, y: 0 }),
      ArrowUp: () => on.change(1, place, { x: 0, y: -0.1 }),
      ArrowDown: () => on.change(1, place, { x: 0, y: 0.1 }),
      "+": () => on.change(0.8, place),
      "=": () => on.change(0.8, place),
      "-": () => on.change(1.25, place),
      "0": () => on.all(),
      Home: () => on.all(),
    };
    const move = moves[event.key];
    if (!move) return;
    event.preventDefault();
    move();
  });
}
