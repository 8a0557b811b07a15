// The operators by their errors: as they are fitted, and in the end. A click draws the fit of one over the data.

import { rough } from "../plot/ticks.ts";
import { useShared } from "../ui.tsx";
import { errorOf, type Search, type Trial } from "./search.ts";

/** So many operators are shown at once; the others on demand. */
const FIRST = 6;

/** Operators by their larger error. Those whose fits are at hand can be drawn. */
export function Ranking({ trials, search }: { trials: Trial[]; search: Search | undefined }) {
  const { workspace, lists } = useShared();
  const sorted = [...trials].sort((a, b) => errorOf(a) - errorOf(b));
  const known = sorted.map(errorOf).filter((error) => Number.isFinite(error) && error > 0);
  const [least, most] = [Math.log(Math.min(...known) / 2), Math.log(Math.max(...known))];
  const share = (error: number) => (most > least ? (Math.log(error) - least) / (most - least) : 1);
  const toggle = (operator: string) => {
    const drawn = search!.drawn;
    search!.drawn = drawn.includes(operator) ? drawn.filter((one) => one !== operator) : [...drawn, operator];
    workspace.changed();
  };
  const row = (trial: Trial) => {
    const error = errorOf(trial);
    const text = Number.isFinite(error) ? `${rough(error)} %` : "\u2013";
    const name = <span title={lists.operators.find((one) => one.name === trial.operator)?.summary}>{trial.operator}</span>;
    return (
      <li key={trial.operator} class={trial.verdict === "taken" ? "marked" : ""} style={{ "--share": Number.isFinite(error) ? share(error) : 0 }}>
        {search?.fits.has(trial.operator)
          ? <button type="button" class="link" aria-pressed={search.drawn.includes(trial.operator)} onClick={() => toggle(trial.operator)}>{name}</button>
          : name}
        <b>{text}</b>
        {trial.verdict && trial.verdict !== "taken" && <small>{trial.verdict}</small>}
      </li>
    );
  };
  const others = sorted.slice(FIRST);
  return (
    <div class="ranking">
      <h3>Operators by their larger error</h3>
      <ol>{sorted.slice(0, FIRST).map(row)}</ol>
      {others.length > 0 && (
        <details>
          <summary>{others.length} more {others.length === 1 ? "operator" : "operators"}</summary>
          <ol start={FIRST + 1}>{others.map(row)}</ol>
        </details>
      )}
      <p class="help">In % of the stroke: the larger of held-out and free-run error, bars on a logarithmic scale.{search && " A click draws a fit over the data."}</p>
    </div>
  );
}
