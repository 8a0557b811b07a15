// The profiles of rigs among the stored files, for the command line and Python.

import { profileName, profilesOf } from "./alike.ts";
import type { Rig } from "./project.ts";
import { equal } from "./store.ts";
import type { Workspace } from "./workspace.ts";

export class Profiles {
  /** The rigs whose profiles are stored. */
  #rigs = "[]";
  /** The profiles of this project, by name; true if they have been stored since it was opened. */
  readonly #known = new Map<string, boolean>();

  /** Takes up a project with these rigs, which was stored among files with these names. */
  opened(rigs: Rig[], names: string[]): void {
    rigs.forEach((rig) => this.#known.set(profileName(rig), false));
    if (rigs.every((rig) => names.includes(profileName(rig)))) this.#rigs = JSON.stringify(rigs);
  }

  /** Stores the profiles of rigs that have changed beside the project, and removes those of rigs that are gone. */
  async store(workspace: Workspace): Promise<void> {
    const { store } = workspace;
    const rigs = JSON.stringify(workspace.project.rigs);
    if (rigs === this.#rigs) return;
    const profiles = await profilesOf(workspace);
    const stored = new Set(await store.names());
    for (const [name, isNew] of this.#known) {
      if (!isNew || profiles.some((one) => one.name === name)) continue;
      // One that was changed elsewhere meanwhile stays.
      if (stored.has(name)) await store.remove(name).catch(() => {});
      this.#known.delete(name);
    }
    for (const { name, bytes } of profiles) {
      const isSame = stored.has(name) && equal(await store.read(name), bytes);
      if (stored.has(name) && !isSame && !this.#known.has(name)) {
        workspace.failed(new Error(`${name} is another file of this folder, and stays as it is: give the rig another name to store its profile`));
        continue;
      }
      if (!isSame) await store.write(name, bytes);
      this.#known.set(name, this.#known.get(name) === true || !isSame);
    }
    this.#rigs = rigs;
  }
}
