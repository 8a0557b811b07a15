// Ticks of axes, and numbers as they are written beside them.

import type { Span } from "./figure.ts";

/** The values that are marked on an axis: about `count` of 1, 2 or 5 times a power of ten. */
export function ticks({ from, to }: Span, count: number, log = false): number[] {
  if (log) return decades(from, to, count);
  const rough = (to - from) / Math.max(1, count);
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * ([1, 2, 5, 10].find((factor) => factor * power >= rough * 0.999) ?? 10);
  const first = Math.ceil(from / step - 1e-9);
  const last = Math.floor(to / step + 1e-9);
  // One number has no scale.
  if (last <= first && count < 8) return ticks({ from, to }, 2 * Math.max(1, count));
  return Array.from({ length: Math.max(0, last - first + 1) }, (_, k) => (first + k) * step);
}

function decades(from: number, to: number, count: number): number[] {
  const all = (factors: number[]) => {
    const found = [];
    for (let power = Math.floor(Math.log10(from)); power <= Math.ceil(Math.log10(to)); power++) {
      for (const factor of factors) {
        const value = factor * 10 ** power;
        if (value >= from * 0.999 && value <= to * 1.001) found.push(value);
      }
    }
    return found;
  };
  const choices = [[1, 2, 3, 4, 5, 6, 7, 8, 9], [1, 2, 5], [1, 3], [1]].map(all);
  const powers = choices.at(-1)!;
  // Over many decades, only every second, third or further one is marked.
  const every = Math.ceil(powers.length / (count + 2));
  return choices.find((found) => found.length <= count + 2) ?? powers.filter((_, k) => k % every === 0);
}

const MINUS = "\u2212";

/** A number with so many digits as tell `step` apart. */
export function written(value: number, step: number): string {
  const size = Math.max(Math.abs(value), Math.abs(step));
  if (value === 0 || Math.abs(value) < 1e-9 * Math.abs(step)) return "0";
  if (size >= 1e6 || size < 1e-4) {
    const digits = Math.max(0, Math.floor(Math.log10(Math.abs(value))) - Math.floor(Math.log10(Math.abs(step) * 1.001)));
    const [mantissa, exponent] = value.toExponential(Math.min(6, digits)).split("e");
    return `${mantissa}e${Number(exponent)}`.replaceAll("-", MINUS);
  }
  const decimals = Math.max(0, Math.min(12, -Math.floor(Math.log10(Math.abs(step) * 1.001))));
  return value.toFixed(decimals).replace("-", MINUS);
}

/** A number with four significant digits. */
export function short(value: number): string {
  if (!Number.isFinite(value)) return "\u2013";
  if (value === 0) return "0";
  const size = Math.abs(value);
  const text = size >= 1e5 || size < 1e-3 ? value.toExponential(3) : String(Number(value.toPrecision(4)));
  return text.replace(/\.?0+e/, "e").replace("e+", "e").replaceAll("-", MINUS);
}

/** A number with so many significant digits: two, as errors are known. */
export const rough = (value: number, digits = 2): string => short(Number(value.toPrecision(digits)));

const PREFIXES: [number, string][] = [[1e9, "G"], [1e6, "M"], [1e3, "k"], [1, ""], [1e-3, "m"], [1e-6, "\u00b5"], [1e-9, "n"]];

/** A value of a unit without prefix, with the prefix that reads best: 0.5 ms. */
export function si(value: number, name: string): string {
  const size = Math.abs(value);
  const [factor, prefix] = PREFIXES.find(([factor]) => size >= factor * 0.9999) ?? (size === 0 ? [1, ""] : [1e-9, "n"]);
  return `${short(value / factor)} ${prefix}${name}`;
}

/** A unit as it is written: µm for um. */
export const unit = (name: string): string => name.replace(/^u(?=[mVAsF]\b)/, "\u00b5");

/** A sentence of the library as it is typeset: \u00b5m for um, \u00b1 for +-, \u00b2 for ^2. */
export const prose = (text: string): string =>
  text.replace(/\bum(?=\b|\/|\^)/g, "\u00b5m").replace(/\+-/g, "\u00b1").replace(/\^2\b/g, "\u00b2").replace(/(^|[\s(])-(?=\d)/g, "$1\u2212");
