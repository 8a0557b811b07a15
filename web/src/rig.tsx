// The line of a record about the files that look like its own: read in the same way, as files of one rig.

import { useId } from "preact/hooks";
import { common, described, type Kin, kinOf, Looks, ofRig, profileName, readAs, rigName } from "./alike.ts";
import { download } from "./plot/download.ts";
import type { Project, RecordEntry } from "./project.ts";
import { Entry, useOutcome, useShared } from "./ui.tsx";
import { spoken } from "./words.ts";

/** Offers to read files that look alike in the same way, and says that a file is read as those of its rig. */
export function RigLine({ entry }: { entry: RecordEntry }) {
  const { workspace, lists } = useShared();
  const { records, rigs } = workspace.project;
  const key = JSON.stringify([entry.file, records.map(({ file, columns }) => [file, ofRig(columns)]), rigs.map(({ layout, columns }) => [layout, columns])]);
  const looks = useOutcome(key, () => Looks.over(workspace, entry)).value;
  const kin = looks && kinOf(entry, workspace.project, looks);
  const id = useId();
  if (!kin || !(kin.rig || kin.offer)) return null;
  const { rig, isRig, members, offer } = kin;
  const offered = async () => {
    const names = await workspace.store.names();
    const proposed = common([offer!.from, ...offer!.to].map(({ file }) => file)) || String(JSON.parse(kin.layout)[0]);
    workspace.change((project) => described(project, kin, rigName(proposed, project, names)));
  };
  const rename = async (proposed: string) => {
    if (proposed.trim() === "" || proposed.trim() === rig!.name) return workspace.changed();
    const names = (await workspace.store.names()).filter((name) => name !== profileName(rig!));
    workspace.change((project) => {
      const others = project.rigs.filter((one) => one.layout !== rig!.layout);
      const name = rigName(proposed, { ...project, rigs: others }, names);
      return { ...project, rigs: project.rigs.map((one) => (one.layout === rig!.layout ? { ...one, name } : one)) };
    });
  };
  const forget = (project: Project) => ({ ...project, rigs: project.rigs.filter((one) => one.layout !== rig!.layout) });
  const profile = isRig ? looks.of(entry)?.profile : undefined;
  const read = (columns: RecordEntry["columns"]) => workspace.tell(readAs(entry, columns));
  return (
    <div class="wide rig" role="group" aria-label="Files that look alike">
      <div class="row">
        {rig && isRig && (
          <>
            <label for={id}>Read as rig</label>
            <Entry id={id} value={rig.name} size={14} entered={(text) => void rename(text).catch((error) => workspace.failed(error))} />
            <span>like {members.length === 0 ? "no other file" : members.length === 1 ? "one other file" : `${members.length} other files`}; files that are added later are read so too</span>
            <button type="button" onClick={() => read({})}>Read it on its own</button>
            {profile && <button type="button" onClick={() => download(profileName(rig), profile, "application/toml")}>Download {profileName(rig)}</button>}
          </>
        )}
        {rig && !isRig && (
          <>
            <span>This file looks like those of the rig {rig.name}, but is read in another way.</span>
            <button type="button" onClick={() => read(rig.columns)}>Read it as rig {rig.name}</button>
          </>
        )}
        {offer && <button type="button" class={isRig ? "" : "main"} onClick={() => void offered().catch((error) => workspace.failed(error))}>{offerOf(kin, entry)}</button>}
      </div>
      <details>
        <summary>{offer ? "Which files, and how" : "How files of the rig are read"}</summary>
        {offer && <p>{offer.to.map(({ file }) => file).join(", ")}</p>}
        <p>{spokenColumns(offer ? offer.from.columns : rig!.columns, lists.columns.map(({ name }) => name))}. Each file keeps its part in time and its preparation.</p>
        {rig && <button type="button" onClick={() => workspace.change(forget)}>Forget the rig {rig.name}</button>}
      </details>
    </div>
  );
}

/** What the button of an offer says. */
function offerOf({ offer, rig, isRig }: Kin, entry: RecordEntry): string {
  const { from, to } = offer!;
  const [more, those] = [to.length - 1, to.length];
  if (from.file !== entry.file) return more === 0 ? `Read this file as ${from.file} is read` : `Read this file and ${more} ${more === 1 ? "other" : "others"} as ${from.file} is read`;
  const which = those === 1 ? "the other file that looks" : `the ${those} other files that look`;
  return `Read ${which} alike in the same way${rig && !isRig ? `: change the rig ${rig.name}` : ""}`;
}

/** What is said of columns, in the order of the library. */
function spokenColumns(columns: RecordEntry["columns"], order: string[]): string {
  const named = Object.entries(ofRig(columns)).sort(([a], [b]) => order.indexOf(a) - order.indexOf(b));
  return named.length === 0 ? "As names and units say" : named.map(([name, value]) => `${spoken(name)}: ${String(value)}`).join("; ");
}
