import { readPage, type PageData } from "./data";
import { find } from "./dom";

const interval = 1500; // ms
const pause = (time: number) => new Promise((go) => setTimeout(go, time));

/**
 * Where `tanor view` serves the page, takes every newer one that the run writes. A page that was opened as a file stays
 * as it is.
 */
export async function follow(isRunning: boolean, show: (next: { data: PageData; packed: string }) => Promise<void>): Promise<void> {
  if (!location.protocol.startsWith("http")) return;
  // Of a run that goes on, another page may have come since this one was read.
  let shown = isRunning ? "" : await ask("HEAD").then((answer) => answer.headers.get("ETag"), () => "");
  for (;;) {
    await pause(interval);
    try {
      const tag = (await ask("HEAD")).headers.get("ETag");
      find("gone").hidden = true;
      if (tag === shown) continue;
      const answer = await ask("GET");
      await show(readPage(new DOMParser().parseFromString(await answer.text(), "text/html")));
      shown = answer.headers.get("ETag");
    } catch {
      find("gone").hidden = false;
    }
  }
}

async function ask(method: string): Promise<Response> {
  const answer = await fetch(location.pathname, { method, cache: "no-store" });
  if (!answer.ok) throw new Error(answer.statusText);
  return answer;
}
