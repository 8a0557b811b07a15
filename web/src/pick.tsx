// What is picked from a list that says in a line what each is for, with its picture.

import type { JSX } from "preact";
import type { Lists, Member } from "./lists.ts";
import { prose } from "./plot/ticks.ts";

/** A member of a list, with its picture where there is one. */
export interface Pickable extends Pick<Member, "name" | "summary"> {
  picture?: JSX.Element;
}

/** The list below a field: a click picks one, or, of several, adds or removes it. */
export function PickList({ members, picked, pick, open }: { members: Pickable[]; picked: string[]; pick(name: string): void; open: boolean }) {
  return (
    <details class="pick" open={open}>
      <summary>Pick from the list</summary>
      <ul>
        {members.map(({ name, summary, picture }) => (
          <li key={name}>
            <button type="button" class="card choice" aria-pressed={picked.includes(name)} onClick={() => pick(name)}>
              <b>{name}</b>
              {picture}
              <span>{prose(summary)}</span>
            </button>
          </li>
        ))}
      </ul>
    </details>
  );
}

/** The operators, each with the loop of a typical one; what may be taken in place of one first. */
export const operatorsOf = (lists: Lists): Pickable[] => [
  { name: "auto", summary: "all that suit the records" },
  ...lists.operators.map(({ name, summary, picture }) => ({
    name,
    summary,
    picture: <svg viewBox="0 0 192 128" aria-hidden="true"><path d={picture} /></svg>,
  })),
];

/** What the block of a feed-forward holds, and that of a feedback. */
const FORWARD: Record<string, string> = { "gain": "1/k", "feed-forward": "H\u207b\u00b9", "learning": "H\u207b\u00b9\u21ba" };
const BACK: Record<string, string> = {
  "pi": "PI", "pid": "PID", "integral-notch": "I\u00b7N", "positive-position": "I+PPF", "disturbance-observer": "DOB", "predictive": "MPC",
};

/** The block diagram of a scheme such as `feed-forward+pi`: from the reference to the actuator P, which a sensor watches. */
function SchemePicture({ scheme }: { scheme: string }) {
  const parts = scheme.split("+");
  const forward = parts.find((part) => part in FORWARD);
  const back = parts.find((part) => !(part in FORWARD));
  // Both meet before the actuator: the feed-forward above, the feedback in the middle.
  const level = back ? 12 : 28;
  const block = (x: number, y: number, text: string) => (
    <g>
      <rect x={x} y={y - 9} width="34" height="18" rx="2" />
      <text x={x + 17} y={y + 4}>{text}</text>
    </g>
  );
  return (
    <svg viewBox="0 0 128 64" aria-hidden="true" class="scheme">
      {back && <path d="M4 34H16M16 34m-4 0a4 4 0 1 0 8 0a4 4 0 1 0 -8 0M20 34H28M62 34H82M120 34V56H16V38" />}
      {back && block(28, 34, BACK[back] ?? back)}
      {forward && <path d={back ? "M8 34V12H28M62 12H74V34" : "M4 28H28M62 28H82"} />}
      {forward && block(28, level, FORWARD[forward]!)}
      {block(82, back ? 34 : 28, "P")}
      <path d={back ? "M116 34H126" : "M116 28H126"} />
    </svg>
  );
}

/** Schemes, each with its block diagram. */
export const withSchemes = (members: Pick<Member, "name" | "summary">[]): Pickable[] =>
  members.map(({ name, summary }) => ({ name, summary, picture: <SchemePicture scheme={name} /> }));
