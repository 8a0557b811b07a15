// Amplitude spectrum of a sampled signal: a Hann window, zeros up to a power of two, and the fast Fourier transform.
//
//   X[m] = sum over k of w[k] (u[k] - mean) exp(-2 pi i k m / n),   amplitude[m] = 2 |X[m]| / sum of w
//
// A sine whose frequency is on the grid has its amplitude there; between grid points the window takes up to 15 % off.

/** Frequencies [Hz] and the amplitudes there, in the unit of the signal. */
export interface Spectrum {
  hz: Float64Array;
  amplitude: Float64Array;
}

/** Largest number of samples that are transformed; of a longer signal, its beginning. */
export const LONGEST = 2 ** 17;

/** The spectrum of samples `step` seconds apart, without the mean; empty of fewer than four samples. */
export function spectrum(samples: Float64Array, step: number): Spectrum {
  const used = Math.min(samples.length, LONGEST);
  if (used < 4) return { hz: new Float64Array(), amplitude: new Float64Array() };
  const n = 2 ** Math.ceil(Math.log2(used));
  const [re, im] = [new Float64Array(n), new Float64Array(n)];
  let mean = 0;
  for (let k = 0; k < used; k++) mean += samples[k]! / used;
  for (let k = 0; k < used; k++) re[k] = (samples[k]! - mean) * (0.5 - 0.5 * Math.cos((2 * Math.PI * k) / used));
  transform(re, im);
  // The mean of the window is one half.
  const scale = 4 / used;
  const hz = Float64Array.from({ length: n / 2 - 1 }, (_, m) => (m + 1) / (n * step));
  return { hz, amplitude: hz.map((_, m) => scale * Math.hypot(re[m + 1]!, im[m + 1]!)) };
}

/** The discrete Fourier transform in place, by halves (radix 2); the length is a power of two. */
export function transform(re: Float64Array, im: Float64Array): void {
  const n = re.length;
  reorder(re, im);
  for (let half = 1; half < n; half *= 2) {
    for (let j = 0; j < half; j++) {
      const angle = (-Math.PI * j) / half;
      const [c, s] = [Math.cos(angle), Math.sin(angle)];
      for (let low = j; low < n; low += 2 * half) {
        const high = low + half;
        const [a, b] = [c * re[high]! - s * im[high]!, c * im[high]! + s * re[high]!];
        re[high] = re[low]! - a;
        im[high] = im[low]! - b;
        re[low] = re[low]! + a;
        im[low] = im[low]! + b;
      }
    }
  }
}

/** Puts each sample where the bits of its number, read backwards, tell. */
function reorder(re: Float64Array, im: Float64Array): void {
  const n = re.length;
  for (let k = 1, j = 0; k < n; k++) {
    let bit = n >> 1;
    for (; j & bit; bit >>= 1) j ^= bit;
    j ^= bit;
    if (k < j) {
      [re[k], re[j]] = [re[j]!, re[k]!];
      [im[k], im[j]] = [im[j]!, im[k]!];
    }
  }
}
