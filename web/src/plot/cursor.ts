// What the series are under the cursor.

import { type Frame, pixelX, pixelY, valueX, valueY } from "./draw.ts";
import { type Figure, place, type Series, within } from "./figure.ts";
import { short, unit } from "./ticks.ts";

/** A place on the canvas. */
export interface Point {
  x: number;
  y: number;
}

/** What is shown, and what marks it: a line through all panels, or a ring. */
export interface Reading {
  text: string;
  line?: number;
  ring?: Point;
}

/** How far a sample of a loop may be from the cursor [pixels]. */
const NEAR = 24;

/** What is read at a place in this frame. */
export function reading(figure: Figure, frames: Frame[], frame: Frame, hidden: Set<string>, at: Point): Reading {
  const shown = (one: Frame) => one.panel.series.filter((series) => !hidden.has(series.name));
  if (figure.loops) {
    const found = sample(figure, frame, shown(frame), at);
    const [x, y] = found
      ? [place(found.series, found.k), found.series.y[found.k]!]
      : [valueX(figure, frame, at.x), valueY(frame, at.y)];
    const name = found?.series.name ? `${found.series.name} ` : "";
    return {
      text: `${name}${short(x)} ${unit(figure.x.unit)}, ${short(y)} ${unit(frame.panel.y.unit)}`,
      ...(found && { ring: { x: pixelX(figure, frame, x), y: pixelY(frame, y) } }),
    };
  }
  // At a sample, so that all that is shown belongs together.
  const samples = (x: number) =>
    frames.flatMap((one) =>
      shown(one).flatMap((series) => {
        const k = nearest(series, x);
        return k === undefined ? [] : [{ panel: one.panel, series, k }];
      }),
    );
  const under = valueX(figure, frame, at.x);
  const away = (x: number) => Math.abs(pixelX(figure, frame, x) - at.x);
  const places = samples(under).map(({ series, k }) => place(series, k));
  const next = places.sort((a, b) => away(a) - away(b)).find((x) => x >= frame.x.from && x <= frame.x.to);
  const x = next ?? under;
  const values = samples(x).map(({ panel, series, k }) => `${series.name} ${short(series.y[k]!)} ${unit(panel.y.unit)}`);
  return { text: [`${short(x)} ${unit(figure.x.unit)}`, ...values].join(" \u00b7 "), line: pixelX(figure, frame, x) };
}

/** The sample that is drawn nearest to a place, if one is near. */
function sample(figure: Figure, frame: Frame, shown: Series[], at: Point): { series: Series; k: number } | undefined {
  let best: { series: Series; k: number } | undefined;
  let least = NEAR ** 2;
  for (const series of shown) {
    for (let k = 0; k < series.y.length; k++) {
      const [dx, dy] = [pixelX(figure, frame, place(series, k)) - at.x, pixelY(frame, series.y[k]!) - at.y];
      if (dx * dx + dy * dy < least) [best, least] = [{ series, k }, dx * dx + dy * dy];
    }
  }
  return best;
}

/** The sample of a series whose x rises that is nearest to x. */
function nearest(series: Series, x: number): number | undefined {
  const n = series.y.length;
  const [first, last] = within(series, { from: x, to: x });
  let best: number | undefined;
  for (let k = first; k < Math.min(last, n); k++) {
    if (best === undefined || Math.abs(place(series, k) - x) < Math.abs(place(series, best) - x)) best = k;
  }
  return best;
}
