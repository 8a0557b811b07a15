// The library as a WebAssembly module: crates/piezoid-wasm lists its functions.

/** How far long work is. */
export interface Stage {
  what: string;
  done: number;
  total: number;
  /** What was found last, by name; null for what is no number. */
  figures: Record<string, number | null>;
  /** The text of the file of the model of a finished fit; in an identification, `what` is its operator. */
  model?: string;
  /** True if this model is better than those before. */
  best?: boolean;
}

/** Progress of long work. */
export type Progress = (stage: Stage) => void;

interface Exports {
  memory: WebAssembly.Memory;
  reserve(length: number): number;
  release(address: number, length: number): void;
  answer(address: number, length: number): number;
  length(): number;
}

/** The library in this thread. */
export class Module {
  #exports: Exports;
  #progress: Progress = () => {};

  private constructor(instance: (imports: WebAssembly.Imports) => WebAssembly.Instance) {
    const text = new TextDecoder();
    const progress = (address: number, length: number) => {
      this.#progress(JSON.parse(text.decode(new Uint8Array(this.#exports.memory.buffer, address, length))));
      return 1;
    };
    this.#exports = instance({ env: { progress } }).exports as unknown as Exports;
  }

  /** The library of a compiled module. */
  static of(module: WebAssembly.Module): Module {
    return new Module((imports) => new WebAssembly.Instance(module, imports));
  }

  /** The packed answer to a packed request. */
  answer(request: Uint8Array, progress: Progress): Uint8Array {
    const { memory, reserve, answer } = this.#exports;
    const address = reserve(request.length);
    if (address === 0) throw new Error("the browser gives no memory for a file of this size");
    new Uint8Array(memory.buffer).set(request, address);
    this.#progress = progress;
    return this.#taken(answer(address, request.length));
  }

  /** A copy of what stands at an address, which is released. */
  #taken(address: number): Uint8Array {
    const { memory, release, length } = this.#exports;
    if (address === 0) throw new Error("the browser gives no memory for the answer");
    const bytes = new Uint8Array(memory.buffer).slice(address, address + length());
    release(address, length());
    return bytes;
  }
}
