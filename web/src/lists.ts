// The lists of the library: what forms and menus are made of.

/** An option of a verb. */
export interface OptionRow {
  name: string;
  kind: "switch" | "integer" | "number" | "pair" | "numbers" | "choice" | "text" | "texts";
  choices: [string, string][] | null;
  unit: string | null;
  /** What it is: `{name}` is another option, `{list}` its list. */
  help: string;
  group: string | null;
  /** The list that its names are from, such as `drivers`; empty if there is none. */
  list: string;
  usual: string | null;
  rule: string;
  required: boolean;
}

/** A member of a family: its name, and what it is. */
export interface Member {
  name: string;
  summary: string;
}

/** An operation: a verb with its files and options. */
export interface OperationRow extends Member {
  options: OptionRow[];
  module: string;
  roles: { name: string; least: number; many: boolean }[];
}

/** All lists. */
export interface Lists {
  operations: OperationRow[];
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

/** The options of an operation. */
export const optionsOf = (lists: Lists, call: string): OptionRow[] =>
  lists.operations.find((one) => one.name === call)?.options ?? [];

/** The members of the list of this name. */
export const membersOf = (lists: Lists, list: string): Member[] | undefined =>
  (lists as unknown as Record<string, Member[] | undefined>)[list];
