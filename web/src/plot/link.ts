// What plots of the same x share: the span that they show, and the cursor.

import type { Span } from "./figure.ts";

/** A plot of a link. */
export interface Linked {
  /** The span or what is shown in it has changed. */
  redraw(): void;
  /** The cursor is at this x, or nowhere. */
  point(x: number | undefined): void;
}

/** Joins plots of the same x: of one time, or of one frequency. Loops follow by the times of their samples. */
export class Link {
  /** What is shown, all without it; and where the cursor is. */
  span: Span | undefined;
  cursor: number | undefined;
  readonly #plots = new Set<Linked>();

  /** Takes up a plot; gives what lets it go. */
  join(plot: Linked): () => void {
    this.#plots.add(plot);
    return () => void this.#plots.delete(plot);
  }

  /** Shows a span in all plots, or all. */
  zoom(span: Span | undefined): void {
    this.span = span;
    for (const plot of this.#plots) plot.redraw();
  }

  /** Puts the cursor of all plots at an x, or nowhere. */
  point(x: number | undefined): void {
    this.cursor = x;
    for (const plot of this.#plots) plot.point(x);
  }
}
