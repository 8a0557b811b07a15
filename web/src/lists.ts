// The lists of the library: what forms and menus are made of.

/** An option of a verb. */
export interface OptionRow {
  name: string;
  kind: "switch" | "integer" | "number" | "pair" | "numbers" | "choice" | "text" | "texts";
  choices: [string, string][] | null;
  unit: string | null;
  help: string;
  group: string | null;
  usual: string | null;
  rule: string;
  required: boolean;
}

/** A member of a family: its name, and what it is. */
export interface Member {
  name: string;
  summary: string;
}

/** A verb. */
export interface CallRow extends Member {
  options: OptionRow[];
  roles: { name: string; least: number; many: boolean }[];
}

/** All lists. */
export interface Lists {
  calls: CallRow[];
  /** What can be said of the columns of a data file. */
  columns: OptionRow[];
  operators: Member[];
  excitations: (Member & { options: OptionRow[] })[];
  plants: Member[];
  drivers: Member[];
  actuators: Member[];
  controllers: Member[];
  references: Member[];
  /** With what each makes of a model, by its operator: nothing if it does not serve that operator; and which it takes
   * of the options that not all take. */
  targets: (Member & { operators: Record<string, string[]>; takes: string[] })[];
  estimators: Member[];
}

/** The options of a verb. */
export const optionsOf = (lists: Lists, call: string): OptionRow[] =>
  lists.calls.find((one) => one.name === call)?.options ?? [];
