// The options of the operations, from the lists of the library.

import type { CallName, CallOptions, Lists, Member, OptionRow } from "./catalogue.ts";

export type { Lists, Member, OptionRow } from "./catalogue.ts";

/** The options of an operation. */
export const optionsOf = <Call extends CallName>(lists: Lists, call: Call): OptionRow<keyof CallOptions[Call] & string>[] =>
  (lists.operations.find((one) => one.name === call)?.options ?? []) as OptionRow<keyof CallOptions[Call] & string>[];

/** The members of the list of this name. */
export const membersOf = (lists: Lists, list: string): Member[] | undefined =>
  (lists as unknown as Record<string, Member[] | undefined>)[list];
