// The options of the calls, from the lists of the library.

import type { CallName, CallOptions, Lists, OptionRow } from "./catalogue.ts";

export type { Lists, Member, OptionRow } from "./catalogue.ts";

/** The options of a call. */
export const optionsOf = <Call extends CallName>(lists: Lists, call: Call): OptionRow<keyof CallOptions[Call] & string>[] =>
  (lists.calls.find((one) => one.name === call)?.options ?? []) as OptionRow<keyof CallOptions[Call] & string>[];
