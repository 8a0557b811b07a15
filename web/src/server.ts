// The library and the project folder of `piezoid serve`: crates/piezoid-serve has its interface.

import type { Library } from "./library.ts";
import type { Progress } from "./module.ts";
import { type Answer, Cancelled, type File, packed, Refused, type Request, unpacked } from "./packet.ts";
import type { Store } from "./store.ts";

const GONE = "piezoid serve does not answer: start it again in the same folder, then try again";

const OTHER = "another server answers at this address, not the one that this page was opened with: open the address that " +
  "`piezoid serve` printed last; this page keeps what is not stored yet";

/** How long a proof of the server holds, and how long it may take [ms]. */
const FRESH = 1000;
const PATIENCE = 5000;

/** How long an instrument may take to stop [ms]. */
const STOPPING = 10_000;

/** The calls that move an instrument, and the pause before one that is not at work yet is stopped again [ms]. */
const MOVING = ["acquire", "campaign", "moves"];
const NOT_YET = 50;

const UNKNOWN = "the instrument has not answered that it stopped: it may still move; switch it off if that is a danger";

/** Where this browser keeps the key. */
const KEY = "piezoid-key";

/** Browsers send at most 64 KiB for pages that are closed. */
const KEPT_ALIVE = 60_000;

const OCTETS = { "content-type": "application/octet-stream" };

/** The server, with the key that it asks for. */
export class Server {
  static #here: Server | undefined;
  /** When the server has proven itself last [ms]. */
  #provenAt = -Infinity;

  constructor(
    readonly root: string,
    public key: string,
    /** The key of a server that was started later, if the user has opened its address. */
    readonly latest = () => key,
  ) {}

  /** The server of this page. The key is taken out of the address, and kept for when the page is opened without. */
  static here(): Server {
    return (Server.#here ??= new Server(location.origin, Server.#opened(), () => localStorage.getItem(KEY) ?? ""));
  }

  static #opened(): string {
    const address = new URL(location.href);
    const values = address.searchParams.get("key");
    if (values === null) return localStorage.getItem(KEY) ?? "";
    localStorage.setItem(KEY, values);
    address.searchParams.delete("key");
    history.replaceState(history.state, "", address);
    return values;
  }

  /** True if the server has proven itself a moment ago. */
  get #isProven(): boolean {
    return performance.now() - this.#provenAt < FRESH;
  }

  /** Has the server prove that it has the key. Before it has, it gets neither the key nor anything else: another program
   * may listen at this address by now. */
  async prove(signal?: AbortSignal | null): Promise<void> {
    if (this.#isProven) return;
    const requested = performance.now();
    const nonce = Array.from(crypto.getRandomValues(new Uint8Array(16)), (byte) => byte.toString(16).padStart(2, "0")).join("");
    // A program that only listens never answers.
    const ends = AbortSignal.any([AbortSignal.timeout(PATIENCE), ...(signal ? [signal] : [])]);
    const init: RequestInit = { cache: "no-store", signal: ends };
    const response = await fetch(`${this.root}/api/health?nonce=${nonce}`, init).catch(() => gone(signal));
    const { proof } = await response.json().catch(() => ({}));
    const text = new TextEncoder();
    for (const one of [this.key, this.latest()].filter((key) => key !== "")) {
      const key = await crypto.subtle.importKey("raw", text.encode(one), { name: "HMAC", hash: "SHA-256" }, false, ["verify"]);
      if (!(await crypto.subtle.verify("HMAC", key, bytes(String(proof)), text.encode(nonce)))) continue;
      [this.key, this.#provenAt] = [one, requested];
      return;
    }
    throw lost(OTHER);
  }

  /** The response to a request; an error in the words of the server if it refuses. */
  async ask(path: string, init: RequestInit = {}): Promise<Response> {
    // Without a key the server only says what is missing, and needs no content for that.
    if (this.key || this.latest()) await this.prove(init.signal);
    else init = { ...init, body: null };
    const headers = { ...init.headers, authorization: `Bearer ${this.key}` };
    const response = await fetch(this.root + path, { ...init, headers, cache: "no-store" }).catch(() => gone(init.signal));
    if (response.ok) return response;
    const refusal = await response.json().catch(() => ({}));
    const refused = new Refused(refusal.error ?? `piezoid serve refuses this: ${response.status} ${response.statusText}`);
    throw response.status === 412 ? Object.assign(refused, { name: "Conflict" }) : refused;
  }
}

function bytes(hex: string): Uint8Array<ArrayBuffer> {
  return Uint8Array.from(hex.match(/../g) ?? [], (byte) => Number.parseInt(byte, 16));
}

function gone(signal?: AbortSignal | null): never {
  if (signal?.aborted) throw new Cancelled("cancelled");
  throw lost(GONE);
}

function lost(why: string): Error {
  return Object.assign(new Error(why), { name: "Gone" });
}

/** The library in processes of this machine. A signal that is aborted ends the call there too. */
export class ServerLibrary implements Library {
  readonly readsAll = true;
  #lists: Promise<any> | undefined;

  constructor(readonly server = Server.here()) {}

  lists(): Promise<any> {
    this.#lists ??= this.server
      .ask("/api/lists")
      .then((response) => response.json())
      .catch((error) => {
        this.#lists = undefined;
        throw error;
      });
    return this.#lists;
  }

  async call(request: Request, files: File[], progress: Progress = () => {}, signal?: AbortSignal): Promise<Answer> {
    const body = packed(request, files) as BodyInit;
    const init = { method: "POST", headers: OCTETS, body };
    if (MOVING.includes(request.call)) return this.#moving(init, progress, signal);
    return this.#answer({ ...init, ...(signal && { signal }) }, progress);
  }

  async #answer(init: RequestInit, progress: Progress): Promise<Answer> {
    const response = await this.server.ask("/api/call", init);
    const reader = response.body!.getReader();
    return unpacked(await answered(() => reader.read().catch(() => gone(init.signal)), progress));
  }

  /** A call that moves an instrument is stopped by its id, and still answers where the instrument was left. It ends
   * without an answer only if none comes. */
  async #moving(init: RequestInit & { headers: Record<string, string> }, progress: Progress, signal?: AbortSignal): Promise<Answer> {
    if (signal?.aborted) throw new Cancelled("cancelled");
    const id = Array.from(crypto.getRandomValues(new Uint8Array(16)), (byte) => byte.toString(16).padStart(2, "0")).join("");
    const end = new AbortController();
    let isOver = false;
    let limit: ReturnType<typeof setTimeout> | undefined;
    const stop = async () => {
      limit = setTimeout(() => end.abort(), STOPPING);
      while (!isOver && !end.signal.aborted) {
        const error = await this.server.ask(`/api/calls/${id}`, { method: "DELETE" }).then(() => undefined, (error) => error);
        if (error === undefined) return;
        // A call that waits for its turn cannot be stopped before it begins; one that has ended still hands its answer on.
        if (error instanceof Refused) await new Promise((passed) => setTimeout(passed, NOT_YET));
        else end.abort();
      }
    };
    const requested = () => void stop();
    signal?.addEventListener("abort", requested, { once: true });
    try {
      return await this.#answer({ ...init, headers: { ...init.headers, "piezoid-call": id }, signal: end.signal }, progress);
    } catch (error) {
      throw end.signal.aborted ? new Error(UNKNOWN) : error;
    } finally {
      isOver = true;
      clearTimeout(limit);
      signal?.removeEventListener("abort", requested);
    }
  }
}

/** What follows the lines of progress and the empty line. */
async function answered(
  read: () => Promise<ReadableStreamReadResult<Uint8Array>>,
  progress: Progress,
): Promise<Uint8Array> {
  const text = new TextDecoder();
  let pieces: Uint8Array[] = [];
  let begun = false;
  for (let { done, value } = await read(); !done; { done, value } = await read()) {
    pieces.push(value!);
    if (begun) continue;
    let rest = joined(pieces);
    for (let end = rest.indexOf(0x0a); end >= 0 && !begun; end = rest.indexOf(0x0a)) {
      begun = end === 0;
      if (!begun) progress(JSON.parse(text.decode(rest.subarray(0, end))));
      rest = rest.subarray(end + 1);
    }
    pieces = [rest];
  }
  if (!begun) gone();
  return joined(pieces);
}

/** The pieces one after the other, from the beginning of a buffer. */
function joined(pieces: Uint8Array[]): Uint8Array {
  const bytes = new Uint8Array(pieces.reduce((sum, piece) => sum + piece.length, 0));
  let at = 0;
  for (const piece of pieces) {
    bytes.set(piece, at);
    at += piece.length;
  }
  return bytes;
}

/** The files of the project folder. A file that was changed elsewhere since it was read is not overwritten. */
export class ServerStore implements Store {
  /** The folder may hold files of its user too. */
  readonly own = false;
  #tags = new Map<string, string>();
  #last: Promise<unknown> = Promise.resolve();

  constructor(readonly server = Server.here()) {}

  soon(): void {
    // A server that is gone is a fault of the write.
    this.server.prove().catch(() => {});
  }

  async names(): Promise<string[]> {
    const files: { name: string }[] = await (await this.server.ask("/api/files")).json();
    return files.map(({ name }) => name);
  }

  async read(name: string): Promise<Uint8Array> {
    const response = await this.server.ask(path(name));
    const bytes = await response.arrayBuffer().catch(() => gone());
    this.#known(name, response);
    return new Uint8Array(bytes);
  }

  write(name: string, bytes: Uint8Array): Promise<void> {
    return this.#afterwards(async () => {
      const headers = { ...OCTETS, ...this.#version(name) };
      // What is small is written even if the page is closed meanwhile.
      const init = { method: "PUT", headers, body: bytes as BodyInit, keepalive: bytes.length < KEPT_ALIVE };
      this.#known(name, await this.server.ask(path(name), init));
    });
  }

  remove(name: string): Promise<void> {
    return this.#afterwards(async () => {
      const tag = this.#tags.get(name);
      await this.server.ask(path(name), { method: "DELETE", headers: tag ? { "if-match": tag } : {} });
      this.#tags.delete(name);
    });
  }

  /** Changes are made one after the other, because each needs the version of the one before. */
  #afterwards(change: () => Promise<void>): Promise<void> {
    const result = this.#last.then(change);
    this.#last = result.catch(() => {});
    return result;
  }

  /** The version that may be replaced: the one that was read or written here last, else none. */
  #version(name: string): Record<string, string> {
    const tag = this.#tags.get(name);
    return tag ? { "if-match": tag } : { "if-none-match": "*" };
  }

  #known(name: string, response: Response): void {
    this.#tags.set(name, response.headers.get("etag") ?? "");
  }
}

const path = (name: string) => `/api/files/${encodeURIComponent(name)}`;
