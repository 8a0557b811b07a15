// A form from the rows of options: one field a row, groups that fold.

import { useId } from "preact/hooks";
import { membersOf, type OptionRow } from "./lists.ts";
import { prose, unit } from "./plot/ticks.ts";
import { type Pickable, PickList } from "./pick.tsx";
import type { Options } from "./project.ts";
import { Entry, useShared } from "./ui.tsx";
import { helpOf, spoken } from "./words.ts";

interface Props {
  rows: OptionRow[];
  values: Options;
  change(values: Options): void;
  /** Names that are offered for options of this name, in place of the members of their lists. */
  names?: Record<string, Pickable[]>;
  /** Options that are shown outside their groups, which are closed otherwise. */
  first?: string[];
  /** Options whose lists are shown at once. */
  open?: string[];
}

/** Lists of which one member is chosen, and nothing else can be given. */
const CLOSED = ["drivers", "controllers", "actuators"];

/** The fields of options. What is empty is left out: then the library decides. */
export function Form({ rows, values, change, names = {}, first, open = [] }: Props) {
  const { lists } = useShared();
  const set = (name: string, value: unknown) => {
    const { [name]: _, ...others } = values;
    change(value === "" || value === undefined ? others : { ...others, [name]: value });
  };
  const field = (row: OptionRow) => (
    <Field key={row.name} row={row} value={values[row.name]} set={(value) => set(row.name, value)}
      names={names[row.name] ?? membersOf(lists, row.list)} open={open.includes(row.name)} />
  );
  const isFirst = (row: OptionRow) => (first ? first.includes(row.name) : !row.group);
  const groups = [...new Set(rows.filter((row) => !isFirst(row)).map((row) => row.group || "More"))];
  return (
    <div class="form">
      {rows.filter(isFirst).map(field)}
      {groups.map((group) => {
        const members = rows.filter((row) => !isFirst(row) && (row.group || "More") === group);
        const input = members.filter((row) => row.name in values).length;
        return (
          <details key={group}>
            <summary>{group}{input > 0 && ` (${input} set)`}</summary>
            <div class="form">{members.map(field)}</div>
          </details>
        );
      })}
    </div>
  );
}

interface FieldProps {
  row: OptionRow;
  value: unknown;
  set(value: unknown): void;
  names?: Pickable[] | undefined;
  open: boolean;
}

function Field({ row, value, set, names, open }: FieldProps) {
  const id = useId();
  const of = row.unit ? ` [${row.unit === "degrees" ? "°" : unit(row.unit)}]` : "";
  const label = <label for={id}>{spoken(row.name)}{of}{row.required && <span aria-hidden="true"> *</span>}</label>;
  const usual = row.usual ?? "";
  // What is too long for the field stands below it.
  const long = usual.length > 20;
  const chosen = names?.find(({ name }) => name === value);
  const help = (
    <p class="help" id={`${id}-help`}>
      {helpOf(row)}{long && `; default: ${usual}`}{chosen && <b>{prose(chosen.summary)}</b>}
    </p>
  );
  const common = { id, "aria-describedby": `${id}-help`, name: row.name };
  if (row.kind === "switch") {
    const on = value === undefined ? usual === "true" : value === true;
    return (
      <div class="field switch">
        <input {...common} type="checkbox" checked={on} onChange={(event) => set(event.currentTarget.checked)} />
        {label}
        {help}
      </div>
    );
  }
  if (row.kind === "choice") {
    return (
      <div class="field">
        {label}
        <select {...common} value={String(value === usual ? "" : value ?? "")} onChange={(event) => set(event.currentTarget.value)}>
          <option value="">{usual || "none"}</option>
          {row.choices?.filter(([name]) => name !== usual).map(([name]) => <option key={name} value={name}>{name}</option>)}
        </select>
        {help}
      </div>
    );
  }
  if (row.kind === "text" && names && CLOSED.includes(row.list)) {
    const isOther = value !== undefined && !chosen;
    return (
      <div class="field">
        {label}
        <select {...common} value={String(value ?? "")} onChange={(event) => set(event.currentTarget.value)}>
          <option value="">{usual || "none"}</option>
          {isOther && <option value={String(value)}>{String(value)}</option>}
          {names.map(({ name, summary }) => <option key={name} value={name}>{name}: {prose(summary)}</option>)}
        </select>
        {help}
      </div>
    );
  }
  const picked = (Array.isArray(value) ? value : [value ?? usual]).map(String);
  const pick = (name: string) => {
    if (row.kind !== "texts") return set(name === usual ? undefined : name);
    const others = (Array.isArray(value) ? value : []).filter((one) => one !== name);
    set(picked.includes(name) ? (others.length > 0 ? others : undefined) : [...others, name]);
  };
  const shown = Array.isArray(value) ? value.join(row.kind === "pair" ? " to " : ", ") : String(value ?? "");
  return (
    <div class="field">
      {label}
      <Entry
        {...common}
        value={shown}
        placeholder={long ? "" : usual}
        required={row.required}
        inputMode={row.kind === "number" || row.kind === "integer" ? "decimal" : "text"}
        list={names ? `${id}-names` : undefined}
        entered={(text) => set(valueOf(row, text.trim()))}
      />
      {names && (
        <datalist id={`${id}-names`}>
          {names.map(({ name, summary }) => <option key={name} value={name}>{summary}</option>)}
        </datalist>
      )}
      {help}
      {names?.some(({ picture }) => picture) && <PickList members={names} picked={picked} pick={pick} open={open} />}
    </div>
  );
}

/** What the library takes for a text in a field. It reads numbers with units itself. */
export function valueOf(row: OptionRow, text: string): unknown {
  if (text === "") return undefined;
  const number = Number(text.replaceAll("\u2212", "-"));
  switch (row.kind) {
    case "integer":
    case "number":
      return Number.isFinite(number) ? number : text;
    case "pair": {
      const two = text.replaceAll("\u2212", "-").split(/\s*(?:to|;|,|\s)\s*/).filter(Boolean).map(Number);
      return two.length === 2 && two.every(Number.isFinite) ? two : text;
    }
    case "numbers": {
      const several = text.replaceAll("\u2212", "-").split(/[;,\s]+/).filter(Boolean).map(Number);
      return several.every(Number.isFinite) ? several : text;
    }
    case "texts":
      return text.split(",").map((part) => part.trim()).filter(Boolean);
    default:
      return text;
  }
}
