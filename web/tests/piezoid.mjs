// The command line, as `cargo build -p piezoid-cli` builds it.
import { execFileSync, spawn } from "node:child_process";
import { existsSync } from "node:fs";
import { connect, createServer } from "node:net";
import { join } from "node:path";

const target = process.env.CARGO_TARGET_DIR ?? new URL("../../target", import.meta.url).pathname;
export const PIEZOID = join(target, "debug/piezoid");

/** Why tests that need it are skipped, if they are. */
export const skip = existsSync(PIEZOID) || process.env.CI ? false : `no ${PIEZOID}: cargo build -p piezoid-cli`;

/** Runs it in a folder; what it prints. */
export const piezoid = (cwd, ...words) =>
  execFileSync(PIEZOID, words, { cwd, encoding: "utf8", stdio: ["ignore", "pipe", "ignore"] });

/** Starts it, and waits until it prints this: the process, and what it printed. */
export async function started(words, expected) {
  const running = spawn(PIEZOID, words, { stdio: ["ignore", "pipe", "inherit"] });
  let all = "";
  for await (const piece of running.stdout) {
    all += piece;
    const found = all.match(expected)?.[0];
    if (found) return { running, found };
  }
  throw new Error(`the program ended: ${all}`);
}

/** A line to a controller that was started, at a port of its own; it is given what clients send. */
export async function overheard({ found }, hears) {
  const line = createServer((client) => {
    const there = connect(Number(found.split(" ")[1]), "127.0.0.1");
    client.on("data", (piece) => hears(String(piece)));
    for (const stream of [client, there]) stream.setNoDelay(true).on("error", () => {});
    client.pipe(there).pipe(client);
  });
  await new Promise((listens) => line.listen(0, "127.0.0.1", listens));
  return line;
}
