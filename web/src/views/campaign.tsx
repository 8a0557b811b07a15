// Campaign: from a controller to a model, and to a path that is measured with and without compensation.

import { useState } from "preact/hooks";
import { Form } from "../form.tsx";
import { optionsOf } from "../lists.ts";
import { operatorsOf } from "../pick.tsx";
import type { Answer, File } from "../packet.ts";
import type { Options } from "../project.ts";
import { Fault, Section, Stale, useKept, useSettings, useShared } from "../ui.tsx";
import { spoken } from "../words.ts";
import type { Workspace } from "../workspace.ts";
import { Agreement } from "./agreement.tsx";
import { earlier, kept, measuredBefore } from "./campaign-files.ts";
import { CampaignResult } from "./campaign-result.tsx";
import { Running } from "./campaign-run.tsx";
import { those, useController } from "./controller.tsx";
import { Live } from "./live.tsx";

/** Name of the work among the jobs. */
const JOB = "campaign";

/** The name under which the library gets the path of the user. */
const REFERENCE = "reference.csv";

/** What is reported of the campaign under way, which goes on while another view is shown. */
let under: { live: Live; agenda: Answer } | undefined;

export function CampaignView() {
  const { workspace, lists } = useShared();
  const [values, change] = useSettings("campaign");
  const rows = optionsOf(lists, "campaign");
  const options = those(lists, "campaign", values);
  const before = measuredBefore(workspace);
  const continues = before.length > 0 && values["continue"] !== false;
  const controller = useController("campaign controller", values);
  const request = { options, reference: values["reference"], continues };
  const agenda = useKept<Answer>("agenda", request);
  const result = useKept<Answer>("campaign", request, true);
  const [isPlanned, setPlanned] = useState(false);
  const lacks = rows.filter((row) => row.required && !(row.name in values)).map((row) => spoken(row.name));
  const busy = controller.busy || agenda.busy || result.busy;

  const ask = () => agenda.start(async () => {
    const files = continues ? await earlier(workspace) : [];
    const answer = await workspace.run({ name: "agenda", request: { call: "agenda", options, files: { earlier: namesOf(files) } }, files });
    setPlanned(true);
    return answer;
  });
  const run = (agreed: Answer) => {
    setPlanned(false);
    const live = new Live();
    under = { live, agenda: agreed };
    result.start(async () => {
      const files = continues ? await earlier(workspace) : [];
      const reference = await referenceOf(workspace, values);
      const answer = await workspace.run({
        name: JOB,
        request: { call: "campaign", options, files: { earlier: namesOf(files), ...(reference && { reference: [REFERENCE] }) } },
        files: [...files, ...(reference ? [reference] : [])],
        onStage: ({ what, figures }) => live.take(what, figures),
      });
      await kept(workspace, answer, continues).catch((error) => workspace.failed(error));
      return answer;
    });
  };
  const stop = () => {
    if (!under) return;
    under.live.stopping = true;
    workspace.jobs.find(({ name }) => name === JOB)?.cancel?.();
    workspace.changed();
  };
  return (
    <>
      <Fault text={result.error} />
      {result.value && !result.busy && (
        <>
          <Stale stale={result.stale && !result.value.result.failed} />
          <CampaignResult answer={result.value} />
        </>
      )}
      {result.busy && under ? <Running {...under} stop={stop} /> : (
        <Section title="Measure, identify and straighten an actuator" wide
          help="A controller plays the drives of a plan in open loop and records. A model is identified, and a path is measured with the voltages of a straight line and with those of the model. The actuator moves over the whole range, once you have agreed.">
          <Form rows={rows} values={values} change={change}
            names={{ operator: operatorsOf(lists) }}
            first={["host", "port", "axis", "actuator", "driver", "range", "bandwidth", "wait"]} />
          <Choices values={values} change={change} before={before} continues={continues} />
          <div class="row">
            {controller.button(busy)}
            <button type="button" class="main" disabled={busy || lacks.length > 0} onClick={ask}>Start</button>
            {lacks.length > 0 && <span class="missing">Give {lacks.join(", ")}.</span>}
            {agenda.busy && <span role="status">The drives are planned. Nothing moves.</span>}
          </div>
          {controller.report}
          <Fault text={agenda.error} />
        </Section>
      )}
      {isPlanned && agenda.value && !agenda.stale && !result.busy && (
        <Agreement agenda={agenda.value} agree={run} refuse={() => setPlanned(false)} />
      )}
    </>
  );
}

const namesOf = (files: File[]) => files.map(({ name }) => name);

/** The record whose displacement is the path, if one is chosen. */
async function referenceOf(workspace: Workspace, values: Options): Promise<File | undefined> {
  const entry = workspace.project.records.find(({ file }) => file === values["reference"]);
  return entry && { ...(await workspace.ready(entry)), name: REFERENCE };
}

interface ChoicesProps {
  values: Options;
  change(values: Options): void;
  before: string[];
  continues: boolean;
}

/** The path to follow, and whether an earlier campaign is continued. */
function Choices({ values, change, before, continues }: ChoicesProps) {
  const { workspace } = useShared();
  return (
    <>
      <div class="row">
        <label>
          Path to follow
          <select value={String(values["reference"] ?? "")} onChange={(event) => change({ ...values, reference: event.currentTarget.value })}>
            <option value="">sines up to the bandwidth</option>
            {workspace.project.records.map(({ file }) => <option key={file} value={file}>displacement of {file}</option>)}
          </select>
        </label>
      </div>
      {before.length > 0 && (
        <div class="row">
          <label>
            <input type="checkbox" checked={continues} onChange={(event) => change({ ...values, continue: event.currentTarget.checked })} />
            Go on with what an earlier campaign has measured, as far as the drives are the same: {before.join(", ")}
          </label>
        </div>
      )}
    </>
  );
}
