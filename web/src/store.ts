// Where the files of a project are kept: in the browser, or in a folder by `piezoid serve`.

/** Named contents that outlast a reload. */
export interface Store {
  /** True if nothing else is kept there: what no project needs is removed. */
  readonly own: boolean;
  /** The names of all. */
  names(): Promise<string[]>;
  /** The content; an error if there is none of this name. */
  read(name: string): Promise<Uint8Array>;
  /** Writes a content whole, or keeps the old one. */
  write(name: string, bytes: Uint8Array): Promise<void>;
  remove(name: string): Promise<void>;
  /** Prepares for a write that follows soon. */
  soon?(): void;
}

/** True for the same content. */
export const equal = (a: Uint8Array, b: Uint8Array): boolean => a.length === b.length && a.every((byte, k) => byte === b[k]);

const TABLE = "files";

/** Files in the database of this browser. */
export class BrowserStore implements Store {
  readonly own = true;
  #database: Promise<IDBDatabase>;

  constructor(name = "piezoid") {
    this.#database = new Promise((resolve, reject) => {
      const opening = indexedDB.open(name, 1);
      opening.onupgradeneeded = () => opening.result.createObjectStore(TABLE);
      opening.onsuccess = () => resolve(opening.result);
      opening.onerror = () => reject(opening.error);
    });
  }

  async names(): Promise<string[]> {
    return (await this.#ask("readonly", (table) => table.getAllKeys())) as string[];
  }

  async read(name: string): Promise<Uint8Array> {
    const bytes = (await this.#ask("readonly", (table) => table.get(name))) as Uint8Array | undefined;
    if (!bytes) throw new Error(`${name} is not in this project`);
    return bytes;
  }

  async write(name: string, bytes: Uint8Array): Promise<void> {
    await this.#ask("readwrite", (table) => table.put(bytes, name));
  }

  async remove(name: string): Promise<void> {
    await this.#ask("readwrite", (table) => table.delete(name));
  }

  async #ask(mode: IDBTransactionMode, work: (table: IDBObjectStore) => IDBRequest): Promise<unknown> {
    const database = await this.#database;
    return new Promise((resolve, reject) => {
      const transaction = database.transaction(TABLE, mode);
      const request = work(transaction.objectStore(TABLE));
      const full = "the storage of this browser is full: save the project as a file and remove records";
      transaction.oncomplete = () => resolve(request.result);
      transaction.onabort = () =>
        reject(transaction.error?.name === "QuotaExceededError" ? new Error(full) : transaction.error);
    });
  }
}
