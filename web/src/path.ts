// A path drawn by hand: points, joined by moves of minimum jerk.

/** The height of a path at samples `ts` apart; the points are evenly spread over the duration. */
export function drawn(points: number[], duration: number, ts: number): Float64Array {
  const samples = Math.max(2, Math.round(duration / ts));
  const pieces = Math.max(1, points.length - 1);
  return Float64Array.from({ length: samples }, (_, k) => {
    const at = (k / (samples - 1)) * pieces;
    const piece = Math.min(pieces - 1, Math.floor(at));
    const s = at - piece;
    const [from, to] = [points[piece] ?? 0, points[piece + 1] ?? points[piece] ?? 0];
    // Flash and Hogan 1985, doi:10.1523/JNEUROSCI.05-07-01688.1985.
    return from + (to - from) * s ** 3 * (10 - 15 * s + 6 * s ** 2);
  });
}

/** A path as a file that the library reads to the bit. */
export function csv(name: string, unit: string, ts: number, path: Float64Array): { name: string; bytes: Uint8Array } {
  const rows = Array.from(path, (value, k) => `${k * ts},${value}`);
  return { name, bytes: new TextEncoder().encode(`t_s,y_${unit}\n${rows.join("\n")}\n`) };
}
