// What will move, to which the user agrees before anything does.

import { useEffect, useRef } from "preact/hooks";
import type { Answer } from "../packet.ts";
import { short } from "../plot/ticks.ts";

interface Props {
  agenda: Answer;
  agree(agenda: Answer): void;
  refuse(): void;
}

/** A time as it is said: 94 s, 4 min. */
export const spokenTime = (seconds: number): string =>
  seconds < 100 ? `${Math.ceil(seconds)} s` : `${Math.ceil(seconds / 60)} min`;

export function Agreement({ agenda, agree, refuse }: Props) {
  const dialog = useRef<HTMLDialogElement>(null);
  useEffect(() => dialog.current?.showModal(), []);
  const { identity, axis, servo, range: [low, high], seconds, resumed, plan } = agenda.result;
  const missing = plan.drives.map(({ name }: { name: string }) => name).filter((name: string) => !resumed.includes(name));
  return (
    <dialog ref={dialog} aria-labelledby="agreement" onClose={refuse}>
      <h2 id="agreement">The actuator will move</h2>
      <p>
        Axis <b>{axis}</b> of {identity} moves between <b>{short(low)} and {short(high)} V</b>, for about <b>{spokenTime(seconds)}</b>,
        and while data are sent and read.
      </p>
      <p>
        {missing.length > 0 && <>Records: {missing.join(", ")}. </>}Then a path, with a straight line and compensated.
        {resumed.length > 0 && <> Measured earlier, and not again: {resumed.join(", ")}.</>}
        {servo === true && <> The servo is on, and is switched off.</>}
      </p>
      <p class="help">Keep a hand at the switch. Stop holds the voltage where it is.</p>
      <div class="row">
        <button type="button" class="main" onClick={() => agree(agenda)}>Move the actuator</button>
        <button type="button" autofocus onClick={() => dialog.current?.close()}>Do not move</button>
      </div>
    </dialog>
  );
}
