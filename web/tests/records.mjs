// Records as instruments write them.
import { call } from "./modules.mjs";

/** A record of the simulated bender for a rising sine: input and output. */
export function measured(frequency, amplitude = 28, duration = 2) {
  const drive = call({ call: "excite", options: { kind: "rising-sine", frequency, amplitude, ts: 5e-4, duration } }).files;
  const { series } = call({ call: "simulate", options: { plant: "pl140" }, files: { input: ["signal.csv"] } }, drive);
  return { ts: 5e-4, u: series.get("u"), y: series.get("y") };
}

const bytes = (text) => Buffer.from(text);

/** The record as a plain CSV. */
export const csv = ({ ts, u, y }) => bytes(`t_s,u_V,y_um\n${Array.from(u, (v, k) => `${k * ts},${v},${y[k]}`).join("\n")}\n`);

/** The record as an oscilloscope exports it: a preamble, seconds, the drive in V, and a sensor of 100 um/V. */
export function scope({ ts, u, y }) {
  const head = ["Model,MDO3014", "Firmware Version,1.22", "Waveform Type,ANALOG", "Horizontal Units,s", "Vertical Units,V,V", "", "TIME,CH1,CH2"];
  return bytes([...head, ...Array.from(u, (v, k) => `${(k * ts).toExponential(6)},${v},${y[k] / 100}`)].join("\n"));
}

/** The record as MATLAB's version 4 writes it. */
export function mat({ ts, u, y }) {
  const matrix = (name, values) => {
    const head = Buffer.alloc(20);
    [0, values.length, 1, 0, name.length + 1].forEach((value, k) => head.writeInt32LE(value, 4 * k));
    return Buffer.concat([head, Buffer.from(`${name}\0`), Buffer.from(Float64Array.from(values).buffer)]);
  };
  return Buffer.concat([matrix("t_s", u.map((_, k) => k * ts)), matrix("u_V", u), matrix("y_um", y)]);
}
