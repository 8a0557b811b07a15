// Figures within views.

import { useEffect, useRef } from "preact/hooks";
import type { Figure } from "./plot/figure.ts";
import type { Link } from "./plot/link.ts";
import { Plot } from "./plot/plot.ts";
import { Strip } from "./plot/strip.ts";

/** What shows figures in an element. */
interface Shows {
  set(figure: Figure): void;
  close(): void;
}

/** An element in which a figure is shown; anew with another link. */
function useFigure(figure: Figure, link: Link | undefined, start: (host: HTMLElement) => Shows) {
  const host = useRef<HTMLDivElement>(null);
  const shows = useRef<Shows | undefined>(undefined);
  useEffect(() => {
    const now = start(host.current!);
    shows.current = now;
    return () => now.close();
  }, [link]);
  useEffect(() => shows.current?.set(figure), [figure]);
  return host;
}

/** A figure, with its caption; without it, where a heading says the same. `height` is that of a row of panels if they
 * stand side by side. Charts of one link share the span of x and the cursor. */
export function Chart(props: { figure: Figure; height?: number; bare?: boolean; link?: Link | undefined }) {
  const { figure, link } = props;
  const host = useFigure(figure, link, (element) => new Plot(element, figure, { link }));
  const size = props.height ?? (figure.panels.length > 1 && !figure.columns ? 420 : 300);
  return (
    <figure class="chart">
      <figcaption class={props.bare ? "unseen" : ""}>{figure.title}</figcaption>
      <div ref={host} style={{ "--height": `${size}px` }} />
    </figure>
  );
}

/** The whole record of a figure in a strip, with the span that the charts of a link show. */
export function Overview({ figure, link }: { figure: Figure; link: Link }) {
  return <div ref={useFigure(figure, link, (element) => new Strip(element, figure, link))} />;
}
