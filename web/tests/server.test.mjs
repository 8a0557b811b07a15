// What the page does with the answers of `piezoid serve`, whose place another server takes here.
import assert from "node:assert/strict";
import { createHmac } from "node:crypto";
import { createServer } from "node:http";
import { after, before, test } from "node:test";
import { setTimeout as pause } from "node:timers/promises";
import { Server, ServerLibrary, ServerStore } from "../dist/parts/server.js";

const INSPECT = { call: "inspect" };

/** The answer in bytes. */
function packed(document, samples) {
  const head = new TextEncoder().encode(JSON.stringify(document).padEnd(100));
  return Buffer.concat([Buffer.from(new Uint32Array([head.length]).buffer), head, Buffer.from(new Float64Array(samples).buffer)]);
}

let web, root;
let answer = () => {};
/** True while the server has the key. */
let proves = true;

before(async () => {
  web = createServer((request, response) => {
    const nonce = request.url.match(/^\/api\/health\?nonce=([0-9a-f]{32})$/)?.[1];
    if (!nonce || !proves) return answer(request, response);
    response.end(JSON.stringify({ proof: createHmac("sha256", "secret").update(nonce).digest("hex") }));
  });
  await new Promise((resolve) => web.listen(0, "127.0.0.1", resolve));
  root = `http://127.0.0.1:${web.address().port}`;
});
after(() => {
  web.closeAllConnections();
  web.close();
});

const library = () => new ServerLibrary(new Server(root, "secret"));
const store = () => new ServerStore(new Server(root, "secret"));

test("progress is told and the answer read, however they are cut", async () => {
  const bytes = packed({ result: { a: 1 }, series: [["u", 2]], bytes: [] }, [0.5, 5.25]);
  const whole = Buffer.concat([Buffer.from('{"what":"x µ","done":1,"total":2,"figures":{"c":0.5}}\n{"what":"y","done":2,"total":2,"figures":{}}\n\n'), bytes]);
  for (const size of [1, 7, 40, whole.length]) {
    answer = async (request, response) => {
      assert.equal(request.headers.authorization, "Bearer secret");
      assert.equal(request.headers["content-type"], "application/octet-stream");
      for (let at = 0; at < whole.length; at += size) {
        response.write(whole.subarray(at, at + size));
        if (size > 1) await pause(1);
      }
      response.end();
    };
    const stages = [];
    const { result, series } = await library().call(INSPECT, [], (stage) => stages.push(stage));
    assert.deepEqual([result, Array.from(series.get("u"))], [{ a: 1 }, [0.5, 5.25]]);
    assert.deepEqual(stages, [{ what: "x µ", done: 1, total: 2, figures: { c: 0.5 } }, { what: "y", done: 2, total: 2, figures: {} }]);
  }
});

test("a program that only listens gets neither the key nor any content", async () => {
  proves = false;
  const heard = [];
  for (const text of ["{}", '{"proof":"00"}', "<html>", JSON.stringify({ proof: createHmac("sha256", "another").update("x").digest("hex") })]) {
    answer = (request, response) => {
      heard.push(request);
      response.end(text);
    };
    await assert.rejects(store().write("project.json", new Uint8Array(9)), { name: "Gone", message: /another server answers/ });
    await assert.rejects(library().call(INSPECT, []), { name: "Gone" });
  }
  assert.equal(heard.length, 8);
  assert.ok(heard.every(({ method, url, headers }) => method === "GET" && url.startsWith("/api/health?nonce=") && !headers.authorization));
  proves = true;
});

test("a program that never answers is given up, and does not keep a call from being cancelled", async () => {
  proves = false;
  answer = () => {};
  const requested = performance.now();
  const cancelled = new AbortController();
  setTimeout(() => cancelled.abort(), 20);
  await assert.rejects(library().call(INSPECT, [], () => {}, cancelled.signal), { message: "cancelled" });
  assert.ok(performance.now() - requested < 1000);
  await assert.rejects(store().names(), { name: "Gone", message: /does not answer/ });
  proves = true;
});

test("without a key nothing of the user is sent", async () => {
  let sent;
  answer = async (request, response) => {
    sent = [];
    for await (const piece of request) sent.push(piece);
    response.writeHead(401).end(JSON.stringify({ error: "the key is missing" }));
  };
  const write = new ServerStore(new Server(root, "")).write("project.json", new Uint8Array(9));
  await assert.rejects(write, { message: "the key is missing" });
  assert.deepEqual(sent, []);
});

test("a page goes on with the key of a server that was started later", async () => {
  const server = new Server(root, "former", () => "secret");
  answer = (request, response) => response.end(JSON.stringify([request.headers.authorization]));
  assert.deepEqual(await (await server.ask("/api/lists")).json(), ["Bearer secret"]);
});

test("a refusal is told in the words of the server, and one of the library in its words", async () => {
  answer = (_, response) => response.writeHead(503).end('{"error":"32 calls wait"}');
  await assert.rejects(library().call(INSPECT, []), { message: "32 calls wait" });
  await assert.rejects(library().lists(), { message: "32 calls wait" });
  answer = (_, response) => response.end(Buffer.concat([Buffer.from("\n"), packed({ error: "no such verb" }, [])]));
  await assert.rejects(library().call(INSPECT, []), { message: "no such verb" });
});

test("a server that is gone, or goes, is told with what to do", async () => {
  const sentence = { message: /^piezoid serve does not answer: start it again in the same folder/ };
  const nobody = new Server("http://127.0.0.1:9", "secret");
  await assert.rejects(new ServerLibrary(nobody).call(INSPECT, []), sentence);
  await assert.rejects(new ServerStore(nobody).names(), sentence);
  for (const start of ["", '{"what":"x","done":1,"total":2}\n', "\nhalf"]) {
    answer = (_, response) => response.write(start || " ", () => response.destroy());
    await assert.rejects(library().call(INSPECT, []), sentence);
  }
});

test("a call that is cancelled ends, before and after it begins", async () => {
  let closed;
  const ended = new Promise((resolve) => (closed = resolve));
  answer = (_, response) => {
    response.on("close", closed);
    response.write('{"what":"x","done":1,"total":2}\n');
  };
  const stop = new AbortController();
  const call = library().call(INSPECT, [], () => stop.abort(), stop.signal);
  await assert.rejects(call, { message: "cancelled" });
  await ended;
  await assert.rejects(library().call(INSPECT, [], undefined, stop.signal), { message: "cancelled" });
});

test("a call that moves an instrument is stopped by its id, once it is at work, and still answers", async () => {
  const requested = [];
  let answers;
  answer = (request, response) => {
    requested.push([request.method, request.url === "/api/call" ? request.headers["piezoid-call"] : request.url.split("/").at(-1)]);
    if (request.method === "POST") {
      response.write('{"what":"x","done":1,"total":2}\n');
      answers = () => response.end(Buffer.concat([Buffer.from("\n"), packed({ result: { failed: "axis 1 is at 3 V" }, series: [], bytes: [] }, [])]));
    } else if (requested.length < 4) {
      // It waits for its turn.
      response.writeHead(404).end('{"error":"no call of this id is at work that can be stopped"}');
    } else {
      response.writeHead(204).end();
      setTimeout(answers, 30);
    }
  };
  for (const call of ["acquire", "campaign"]) {
    requested.length = 0;
    const stop = new AbortController();
    const { result } = await library().call({ call }, [], () => stop.abort(), stop.signal);
    assert.equal(result.failed, "axis 1 is at 3 V");
    const [[, id]] = requested;
    assert.deepEqual(requested, [["POST", id], ["DELETE", id], ["DELETE", id], ["DELETE", id]]);
  }
});

test("a file is written in place of the version that was read, or of none", async () => {
  const inspection = [];
  answer = (request, response) => {
    inspection.push([request.method, request.url, request.headers["if-match"], request.headers["if-none-match"]]);
    response.writeHead(200, { etag: `"${inspection.length}"` }).end("content");
  };
  const files = store();
  // The second needs the version of the first, though it is asked for at once.
  await Promise.all([0, 1].map(() => files.write("µ 1/2.csv", new Uint8Array(3))));
  assert.equal(new TextDecoder().decode(await files.read("b")), "content");
  await files.write("b", new Uint8Array(3));
  await files.remove("b");
  const path = "/api/files/%C2%B5%201%2F2.csv";
  assert.deepEqual(inspection, [
    ["PUT", path, undefined, "*"],
    ["PUT", path, '"1"', undefined],
    ["GET", "/api/files/b", undefined, undefined],
    ["PUT", "/api/files/b", '"3"', undefined],
    ["DELETE", "/api/files/b", '"4"', undefined],
  ]);
});
