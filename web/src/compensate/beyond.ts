// A voltage that changes faster than that of the records: nothing proves an error there.

import { short, unit } from "../plot/ticks.ts";

/** The rates of a voltage and of the records of its model, as the library states them of one that is faster. */
export interface Faster {
  slew: number;
  identified_slew: number;
}

export const beyondMeasured = ({ slew, identified_slew }: Faster, u: string): string =>
  `Beyond what was measured: the voltage changes by up to ${short(slew)} ${unit(u)}/s, that of the records by ${short(identified_slew)} ${unit(u)}/s. ` +
  "No record proves an error there, and the actuator may be much further off.";
