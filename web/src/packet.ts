// Requests and answers as bytes: crates/piezoid-operations/src/packet.rs has the layout.

/** A named content. */
export interface File {
  name: string;
  bytes: Uint8Array;
}

/** How a record is made of its file. */
export interface Reading {
  columns?: Record<string, unknown>;
  /** What is done to the record, in this order. */
  preparation?: { prepare: Record<string, unknown> }[];
  /** Where the record comes from, if the file was made of another one. */
  origin?: unknown;
}

/** What is requested of the library. */
export interface Request {
  /** Name of the verb. */
  call: string;
  /** Its options by name. */
  options?: Record<string, unknown>;
  /** What is said of the columns of data files. */
  columns?: Record<string, unknown>;
  /** How records are made of files, by the names of the files. */
  records?: Record<string, Reading>;
  /** Names of files by their roles. */
  files?: Record<string, string[]>;
}

/** What the library answers. */
export interface Answer {
  result: any;
  series: Map<string, Float64Array>;
  files: File[];
}

/** An error of the library, in words for the user, and the options that resolve it. */
export class Refused extends Error {
  readonly advice: Record<string, unknown>;

  constructor(message: string, advice: Record<string, unknown> = {}) {
    super(message);
    this.advice = advice;
  }
}

/** What an error says. */
export const message = (error: unknown): string => (error instanceof Error ? error.message : String(error));

/** The user ended the work. */
export class Cancelled extends Error {}

/** Everything begins at a multiple of so many bytes. */
const ALIGN = 8;

const aligned = (length: number) => Math.ceil(length / ALIGN) * ALIGN;

/** The bytes of a request with its files. */
export function packed(request: Request, files: File[]): Uint8Array {
  const head = new TextEncoder().encode(
    JSON.stringify({ ...request, bytes: files.map((file) => [file.name, file.bytes.length]) }),
  );
  const start = aligned(4 + head.length);
  const bytes = new Uint8Array(start + files.reduce((sum, file) => sum + aligned(file.bytes.length), 0));
  new DataView(bytes.buffer).setUint32(0, start - 4, true);
  bytes.fill(0x20, 4, start);
  bytes.set(head, 4);
  let at = start;
  for (const file of files) {
    bytes.set(file.bytes, at);
    at += aligned(file.bytes.length);
  }
  return bytes;
}

/** The answer in bytes, which begin at a multiple of 8 in their buffer. Its series and files are views of them. */
export function unpacked(bytes: Uint8Array): Answer {
  const length = new DataView(bytes.buffer, bytes.byteOffset).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(bytes.subarray(4, 4 + length)));
  if (head.cancelled) throw new Cancelled(head.error);
  if (head.error !== undefined) throw new Refused(head.error, head.advice);
  let at = bytes.byteOffset + 4 + length;
  const series = new Map<string, Float64Array>();
  for (const [name, count] of head.series as [string, number][]) {
    series.set(name, new Float64Array(bytes.buffer, at, count));
    at += ALIGN * count;
  }
  const files = (head.bytes as [string, number][]).map(([name, size]) => {
    const file = { name, bytes: new Uint8Array(bytes.buffer, at, size) };
    at += aligned(size);
    return file;
  });
  return { result: head.result, series, files };
}
