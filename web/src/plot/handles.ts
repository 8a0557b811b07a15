// Points that are dragged: buttons over the canvas, so that keys and screen readers reach them.

import type { Figure, Handle } from "./figure.ts";
import { type Frame, pixelX, pixelY, valueX, valueY } from "./frame.ts";
import { short } from "./ticks.ts";

/** How far beyond the span that is shown a handle stands at its edge, over the span. */
const SLACK = 0.005;

/** The handles of a plot, on its stage. */
export class Handles {
  readonly #stage: HTMLElement;
  #handles: Handle[] = [];
  #buttons: HTMLButtonElement[] = [];
  #figure: Figure | undefined;
  #frames: Frame[] = [];

  constructor(stage: HTMLElement) {
    this.#stage = stage;
  }

  /** Takes up the handles of a figure. */
  set(handles: Handle[]): void {
    this.#handles = handles;
    while (this.#buttons.length > handles.length) this.#buttons.pop()!.remove();
    while (this.#buttons.length < handles.length) {
      const button = document.createElement("button");
      button.type = "button";
      button.className = "handle";
      button.setAttribute("role", "slider");
      // Until it has its place and name.
      button.hidden = true;
      const k = this.#buttons.length;
      this.#stage.append(button);
      this.#buttons.push(button);
      this.#drag(button, () => this.#handles[k]);
    }
  }

  /** Puts them where they are in these frames. */
  place(figure: Figure, frames: Frame[]): void {
    [this.#figure, this.#frames] = [figure, frames];
    this.#handles.forEach((handle, k) => {
      const frame = this.#frames[handle.panel ?? 0];
      const button = this.#buttons[k];
      if (!frame || !button) return;
      const { area } = frame;
      // What is out of the span that is shown is not at its edge; the end of a record is a period after its last sample.
      const slack = SLACK * (frame.x.to - frame.x.from);
      button.hidden = handle.moves === "x" && (handle.x < frame.x.from - slack || handle.x > frame.x.to + slack);
      const clamp = (value: number, low: number, size: number) => Math.max(low, Math.min(low + size, value));
      button.style.left = `${clamp(pixelX(figure, frame, handle.x), area.x, area.width)}px`;
      const y = handle.moves === "x" ? area.y + area.height / 2 : pixelY(frame, handle.y);
      button.style.top = `${clamp(y, area.y, area.height)}px`;
      button.setAttribute("aria-label", handle.label);
      button.title = handle.label;
      button.dataset["moves"] = handle.moves;
      const value = handle.moves === "x" ? handle.x : handle.y;
      button.setAttribute("aria-valuenow", String(value));
      const span = handle.moves === "x" ? frame.x : frame.y;
      button.setAttribute("aria-valuemin", String(span.from));
      button.setAttribute("aria-valuemax", String(span.to));
      button.setAttribute("aria-valuetext", short(value));
    });
  }

  #drag(button: HTMLButtonElement, handle: () => Handle | undefined): void {
    const to = (event: PointerEvent, done: boolean) => {
      const [now, box] = [handle(), this.#stage.getBoundingClientRect()];
      const frame = this.#frames[now?.panel ?? 0];
      if (!now || !frame) return;
      const x = now.moves === "y" ? now.x : valueX(this.#figure!, frame, event.clientX - box.x);
      const y = now.moves === "x" ? now.y : valueY(frame, event.clientY - box.y);
      now.moved(x, y, done);
    };
    let moves = false;
    button.addEventListener("pointerdown", (event) => {
      button.setPointerCapture(event.pointerId);
      moves = false;
    });
    button.addEventListener("pointermove", (event) => {
      if (!button.hasPointerCapture(event.pointerId)) return;
      moves = true;
      to(event, false);
    });
    button.addEventListener("pointerup", (event) => moves && to(event, true));
    button.addEventListener("keydown", (event) => {
      const now = handle();
      const frame = this.#frames[now?.panel ?? 0];
      const ways: Record<string, [number, number]> =
        { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
      const way = ways[event.key];
      if (!now || !frame || !way) return;
      event.preventDefault();
      const step = event.shiftKey ? 0.05 : 0.005;
      const x = now.moves === "y" ? now.x : now.x + way[0] * step * (frame.x.to - frame.x.from);
      const y = now.moves === "x" ? now.y : now.y + way[1] * step * (frame.y.to - frame.y.from);
      now.moved(x, y, true);
    });
  }
}
