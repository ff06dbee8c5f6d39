// page.mjs PAGE SUMMARY CHROMIUM [PICTURE.png]: loads a report.html in headless Chromium and tries it.
//
// Finds drawn pixels and no error on the console, scrubs to the end, and compares the tensions shown there with those of
// summary.json (scenes whose constraints are rods alone). At most 12 MB.
// Times are printed, not judged: they depend on the machine.
import { spawn } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, statSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join, resolve } from "node:path";
import { pathToFileURL } from "node:url";

const [pagePath, summaryPath, chromium, picture] = process.argv.slice(2);
const mostBytes = 12e6;
const profile = mkdtempSync(join(tmpdir(), "tanor-page-"));
const browser = spawn(chromium, ["--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--use-angle=swiftshader",
  "--enable-unsafe-swiftshader", "--remote-debugging-pipe", `--user-data-dir=${profile}`, "--no-first-run",
  "--window-size=1440,1000", ...(process.env.TANOR_PAGE_DARK ? ["--force-dark-mode"] : [])],
  { stdio: ["ignore", "ignore", "ignore", "pipe", "pipe"], detached: true });
const failures = [], answers = new Map();
const expect = (holds, what) => { if (!holds) failures.push(what); };
let next = 0, rest = "", heard = () => {};

browser.stdio[4].on("data", (bytes) => {
  const messages = (rest + bytes.toString("utf8")).split("\0");
  rest = messages.pop();
  for (const message of messages.map((text) => JSON.parse(text))) {
    if (message.id) answers.get(message.id)?.(message);
    else heard(message);
  }
});

function call(method, params = {}, sessionId = undefined) {
  const id = ++next;
  browser.stdio[3].write(`${JSON.stringify({ id, method, params, sessionId })}\0`);
  return new Promise((resolveCall, reject) => answers.set(id, (message) =>
    message.error ? reject(new Error(`${method}: ${message.error.message}`)) : resolveCall(message.result)));
}

/** Pixels of the picture that differ from an empty one, counted right after it is drawn. */
const countPixels = `(() => {
  tanorPage.render();
  const view = document.querySelector("#view canvas"), copy = document.createElement("canvas");
  copy.width = view.width; copy.height = view.height;
  const context = copy.getContext("2d");
  context.drawImage(view, 0, 0);
  const pixels = context.getImageData(0, 0, copy.width, copy.height).data;
  let drawn = 0, sum = 0;
  for (let k = 3; k < pixels.length; k += 4) if (pixels[k] > 0) { ++drawn; sum = (sum * 31 + pixels[k - 1] + k) % 1e9; }
  return { drawn, sum };
})()`;

async function tryPage() {
  const { targetId } = await call("Target.createTarget", { url: "about:blank" });
  const { sessionId } = await call("Target.attachToTarget", { targetId, flatten: true });
  const page = (method, params) => call(method, params, sessionId);
  const ask = async (expression) => {
    const { result, exceptionDetails } = await page("Runtime.evaluate", { expression, returnByValue: true, awaitPromise: true });
    if (exceptionDetails) throw new Error(exceptionDetails.exception?.description ?? exceptionDetails.text);
    return result.value;
  };
  heard = ({ method, params }) => {
    if (method === "Runtime.exceptionThrown") failures.push(`exception: ${params.exceptionDetails.exception?.description}`);
    if (method === "Runtime.consoleAPICalled" && params.type === "error") failures.push(`console: ${params.args.map((a) => a.value ?? a.description).join(" ")}`);
    if (method === "Log.entryAdded" && params.entry.level === "error") failures.push(`log: ${params.entry.text}`);
    if (method === "Network.requestWillBeSent" && /^(https?|wss?):/.test(params.request.url)) failures.push(`network: ${params.request.url}`);
  };
  for (const domain of ["Runtime", "Log", "Page", "Network"]) await page(`${domain}.enable`);
  await page("Page.navigate", { url: pathToFileURL(resolve(pagePath)).href });
  for (let k = 0; k < 300 && !(await ask("!!window.tanorPage").catch(() => false)); ++k) await new Promise((go) => setTimeout(go, 100));
  const first = await ask("tanorPage.firstPicture");
  const begin = await ask(countPixels);
  expect(begin.drawn > 500, `only ${begin.drawn} pixels are drawn`);

  // Scrub as a hand does, to the end: what is shown there is the end of the run.
  await ask(`(() => { const bar = document.getElementById("time"); bar.value = 1; bar.dispatchEvent(new Event("input")); })()`);
  const end = await ask(countPixels);
  expect(end.sum !== begin.sum, "the picture at the end is that of the start");
  const clock = await ask(`document.getElementById("clock").textContent`);
  const summary = JSON.parse(readFileSync(summaryPath, "utf8")), { final } = summary;
  expect(clock.startsWith(`${+final.t.toPrecision(4)} s`), `the clock shows ${clock}`);
  let multipliers = final.multipliers;
  if (!Array.isArray(multipliers)) {  // a file of numpy's beside it: a header of some lines, then doubles
    const bytes = readFileSync(join(dirname(summaryPath), "final_multipliers.npy"));
    const begins = 10 + bytes.readUInt16LE(8);
    multipliers = Array.from({ length: (bytes.length - begins) / 8 }, (_, k) => bytes.readDoubleLE(begins + 8 * k));
  }
  if (await ask(`JSON.parse(document.getElementById("data").textContent).motion.rods`)) await compareTensions(ask, multipliers);
  await play(page, ask);
  const bytes = statSync(pagePath).size;
  expect(bytes < mostBytes, `the page has ${bytes} bytes`);
  console.log(`${(bytes / 1e6).toFixed(2)} MB, first picture after ${first.toFixed(0)} ms, ${begin.drawn} pixels`);
}

/** The tension that is written, and all that colours show, against -lambda. */
async function compareTensions(ask, multipliers) {
  const largest = multipliers.reduce((most, x) => Math.max(most, Math.abs(x)), 0);
  const shown = Number(await ask(`document.getElementById("tension").textContent.split(" ")[0]`));
  const rod = Number(await ask(`document.getElementById("rod").value`));
  // 16 bits between the least and the largest of the run, and four digits
  const allowed = 1e-3 * Math.abs(multipliers[rod]) + 1e-4 * largest;
  expect(Math.abs(shown + multipliers[rod]) <= allowed, `rod ${rod} shows ${shown} N, summary.json has ${-multipliers[rod]} N`);
  const all = await ask(`Array.from({ length: ${multipliers.length} }, (_, k) => tanorPage.tension(k))`);
  const worst = multipliers.reduce((most, x, k) => Math.max(most, Math.abs(x + all[k])), 0);
  const step = (await ask(`JSON.parse(document.getElementById("data").textContent).motion.ranges.tensions`)).reduce((a, b) => b - a) / 65535;
  expect(worst <= 1.01 * step + 1e-6 * largest, `tensions differ by ${worst} N, a step of 16 bits is ${step} N`);

}

async function play(page, ask) {
  const before = await ask("tanorPage.frames()");
  await ask("tanorPage.seek(tanorPage.begin); tanorPage.play(true); new Promise((go) => setTimeout(go, 1500))");
  const frames = (await ask("tanorPage.frames()")) - before;
  await ask("tanorPage.play(false); tanorPage.seek(tanorPage.begin + 0.6 * (tanorPage.end - tanorPage.begin))");
  expect(frames > 0, "no picture was drawn while it played");
  console.log(`${(frames / 1.5).toFixed(1)} pictures a second without a GPU`);
  if (!picture) return;
  const { data } = await page("Page.captureScreenshot", { format: "png", captureBeyondViewport: true });
  writeFileSync(picture, Buffer.from(data, "base64"));
}

/** Ends the browser with all its processes, and removes its profile. */
async function endBrowser() {
  const ended = new Promise((go) => browser.once("exit", go));
  process.kill(-browser.pid, "SIGKILL");
  await ended;
  // Its other processes write a moment longer, so that a folder just emptied may not be empty.
  for (let k = 0; k < 50; ++k) {
    try {
      rmSync(profile, { recursive: true, force: true });
      return;
    } catch {
      await new Promise((go) => setTimeout(go, 100));
    }
  }
  console.error(`${profile} could not be removed`);
}

const giveUp = setTimeout(() => { console.error("the browser does not answer"); process.kill(-browser.pid, "SIGKILL"); process.exit(1); }, 120000);
try {
  await tryPage();
} catch (error) {
  failures.push(String(error));
}
clearTimeout(giveUp);
await endBrowser();
for (const failure of failures) console.error(failure);
process.exit(failures.length ? 1 : 0);
