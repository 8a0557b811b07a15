// A campaign under way: what is measured now and what remains, the actuator as it moves, and the button that stops it.

import { useEffect, useRef, useState } from "preact/hooks";
import type { Answer } from "../packet.ts";
import { prose } from "../plot/ticks.ts";
import { Section, useShared } from "../ui.tsx";
import { spokenTime } from "./agreement.tsx";
import { type Live, LivePlots } from "./live.tsx";

interface Props {
  live: Live;
  agenda: Answer;
  stop(): void;
}

/** The part that is no measurement. */
const IDENTIFICATION = "identification";

export function Running({ live, agenda, stop }: Props) {
  const { workspace } = useShared();
  const { plan, resumed, range, seconds } = agenda.result;
  const button = useRef<HTMLButtonElement>(null);
  const [, tick] = useState(0);
  useEffect(() => {
    button.current?.focus();
    const clock = setInterval(() => tick((count) => count + 1), 1000);
    // What is measured is lost with the page.
    const leaves = (event: BeforeUnloadEvent) => event.preventDefault();
    addEventListener("beforeunload", leaves);
    return () => {
      clearInterval(clock);
      removeEventListener("beforeunload", leaves);
    };
  }, []);
  const parts: string[] = [...plan.drives.map(({ name }: { name: string }) => `record ${name}`), IDENTIFICATION, "straight line", "compensated path"];
  const at = reached(parts, live);
  const job = workspace.jobs.find(({ name }) => name === "campaign");
  const state = (part: string, k: number) =>
    resumed.includes(part.replace("record ", "")) ? "earlier" : k < at ? "done" : k === at ? "now" : "later";
  const drive = plan.drives.find(({ name }: { name: string }) => live.part === `record ${name}`);
  const span = drive ? { from: drive.usage.lowest.value, to: drive.usage.highest.value } : { from: range[0], to: range[1] };
  const now = live.part || (at < 0 ? "Connection" : parts[at] ?? "Rest");
  return (
    <Section title="The actuator moves" wide>
      <div class="stop">
        <button ref={button} type="button" class="stop" disabled={live.stopping} onClick={stop}>{live.stopping ? "Stopping" : "Stop"}</button>
        <p>
          <b>{capital(now)}</b>
          <span>{prose(live.step)}</span>
          <progress aria-label="The present step" max={job?.total || 1} value={job?.total ? job.done : undefined} />
          <small>{spokenTime((Date.now() - live.begin) / 1000)} passed; it moves for about {spokenTime(seconds)} in all</small>
        </p>
      </div>
      <ol class="parts" aria-label="Parts of the campaign">
        {parts.map((part, k) => (
          <li key={part} class={state(part, k)} aria-current={k === at ? "step" : undefined}>
            {part}{state(part, k) === "earlier" && <small>earlier</small>}
          </li>
        ))}
      </ol>
      <LivePlots live={live} range={span} title={`Displacement over voltage: ${live.of || "outside the drives"}`} />
    </Section>
  );
}

const capital = (text: string) => text.charAt(0).toUpperCase() + text.slice(1);

/** The place of the part that is under way. What has no part is the connection, the identification, or the move to rest. */
function reached(parts: string[], { part, step, last }: Live): number {
  const place = (name: string) => parts.findIndex((one) => name === one || name.startsWith(`${one}, `));
  if (part) return place(part);
  if (last === parts.at(-1)) return parts.length;
  return step === "" || step.startsWith("connection") ? -1 : parts.indexOf(IDENTIFICATION);
}
