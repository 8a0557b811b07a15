// The spectrum that the page draws, against the plain sums of the discrete Fourier transform.
import assert from "node:assert/strict";
import { test } from "node:test";
import { LONGEST, spectrum, transform } from "../dist/parts/spectrum.js";

/** Numbers from -1 to 1, always the same. */
function numbers(count) {
  let state = 1;
  return Float64Array.from({ length: count }, () => (state = (state * 48271) % 2147483647) / 1073741823.5 - 1);
}

/** The transform as it is defined. */
function plain(re, im) {
  const n = re.length;
  const sum = (m, of) => re.reduce((all, _, k) => all + of(k, (-2 * Math.PI * ((k * m) % n)) / n), 0);
  return [
    re.map((_, m) => sum(m, (k, angle) => re[k] * Math.cos(angle) - im[k] * Math.sin(angle))),
    re.map((_, m) => sum(m, (k, angle) => im[k] * Math.cos(angle) + re[k] * Math.sin(angle))),
  ];
}

const close = (got, wanted, within) =>
  got.forEach((value, k) => assert.ok(Math.abs(value - wanted[k]) < within, `${k}: ${value}, not ${wanted[k]}`));

for (const n of [1, 2, 8, 256]) {
  test(`${n} samples are transformed as by the plain sums`, () => {
    const [re, im] = [numbers(n), numbers(2 * n).slice(n)];
    const wanted = plain(re, im);
    transform(re, im);
    close(re, wanted[0], 1e-12 * n);
    close(im, wanted[1], 1e-12 * n);
  });
}

test("the spectrum of any number of samples is that of the plain sums, with window and zeros", () => {
  const [u, step] = [numbers(100).map((value) => value + 3), 0.01];
  const mean = u.reduce((sum, value) => sum + value, 0) / 100;
  const padded = new Float64Array(128);
  const weight = (k) => Math.sin((Math.PI * k) / 100) ** 2;
  u.forEach((value, k) => (padded[k] = (value - mean) * weight(k)));
  const sum = u.reduce((all, _, k) => all + weight(k), 0);
  const [re, im] = plain(padded, new Float64Array(128));
  const { hz, amplitude } = spectrum(u, step);
  assert.equal(hz.length, 63);
  close(hz, hz.map((_, m) => (m + 1) / 1.28), 1e-12);
  close(amplitude, hz.map((_, m) => (2 * Math.hypot(re[m + 1], im[m + 1])) / sum), 1e-12);
});

test("a sine has its amplitude at its frequency, whatever its mean", () => {
  const u = Float64Array.from({ length: 4096 }, (_, k) => 40 + 2.5 * Math.sin((2 * Math.PI * 64 * k) / 4096));
  const { hz, amplitude } = spectrum(u, 1 / 4096);
  const highest = amplitude.indexOf(Math.max(...amplitude));
  assert.equal(hz[highest], 64);
  assert.ok(Math.abs(amplitude[highest] - 2.5) < 1e-9);
});

test("of a long signal only its beginning is transformed, and of none nothing", () => {
  const long = new Float64Array(LONGEST + 5);
  long[LONGEST + 2] = 1;
  const { amplitude } = spectrum(long, 1);
  assert.equal(amplitude.length, LONGEST / 2 - 1);
  assert.ok(amplitude.every((value) => value === 0));
  assert.equal(spectrum(Float64Array.of(1, 2, 3), 1).hz.length, 0);
});
