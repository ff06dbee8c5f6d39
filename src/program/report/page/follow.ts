import { readPage, type PageData } from "./data";
import { find } from "./dom";

const interval = 1500; // ms
const pause = (time: number) => new Promise((go) => setTimeout(go, time));

/**
 * Shows every newer page that the run writes if `tanor view` serves this one. A page that was opened as a file stays as
 * it is.
 */
export async function follow(isRunning: boolean, show: (next: { data: PageData; packed: string }) => Promise<void>): Promise<void> {
  if (!location.protocol.startsWith("http")) return;
  // While the run goes on, another page may have been written since this one was read.
  let runs = isRunning, shown = isRunning ? "" : await ask("HEAD").then((answer) => answer.headers.get("ETag"), () => "");
  for (;;) {
    await pause(interval);
    try {
      const { headers } = await ask("HEAD"), tag = headers.get("ETag");
      // A run that ends by itself writes its page before it releases its folder.
      const isKilled = runs && tag === shown && headers.get("X-Tanor-Run") === "ended";
      say(isKilled ? "The run ended without a word: it was killed, or its machine stopped. tanor run with --resume goes on at its checkpoint." : "");
      if (isKilled) find("running").hidden = true;
      if (tag === shown) continue;
      const answer = await ask("GET");
      const next = readPage(new DOMParser().parseFromString(await answer.text(), "text/html"));
      await show(next);
      runs = next.data.run.is_running;
      shown = answer.headers.get("ETag");
    } catch {
      say("The server of this page has ended. What it sent last is shown.");
    }
  }
}

function say(what: string): void {
  find("gone").hidden = !what;
  find("gone").textContent = what;
}

async function ask(method: string): Promise<Response> {
  const answer = await fetch(location.pathname, { method, cache: "no-store" });
  if (!answer.ok) throw new Error(answer.statusText);
  return answer;
}
