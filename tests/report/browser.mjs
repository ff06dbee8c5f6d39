// A page in headless Chromium, over the pipe of its developer tools: what it says, what it draws, what it complains of.
import { spawn } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

// Without a GPU only the picture in 3-D is drawn as by one: around it, that would take most of the time.
const flags = ["--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--use-angle=swiftshader",
  "--enable-unsafe-swiftshader", "--disable-gpu-rasterization", "--disable-gpu-compositing", "--remote-debugging-pipe",
  "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-extensions", "--disable-sync"];
const pause = (time) => new Promise((go) => setTimeout(go, time));

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

export class Browser {
  failures = []; // complaints of a page, and of those who expect something
  about = ""; // the page that is tried, before each of them
  #profile = mkdtempSync(join(tmpdir(), "tanor-page-"));
  #process;
  #answers = new Map();
  #next = 0;
  #session;
  #target;
  #screen;

  /**
   * `network`: the addresses that the page may ask for begin so; none: no address at all. `scale`: pixels drawn a pixel
   * of the page; without a GPU each of them takes time.
   */
  constructor(chromium, { width = 1440, height = 1000, scale = 1, isDark = false, network = null } = {}) {
    this.network = network;
    this.#screen = { width, height, deviceScaleFactor: scale, mobile: false };
    this.#process = spawn(chromium, [...flags, `--user-data-dir=${this.#profile}`, `--window-size=${width},${height}`,
      ...(isDark ? ["--force-dark-mode"] : [])], { stdio: ["ignore", "ignore", "ignore", "pipe", "pipe"], detached: true });
    let rest = "";
    this.#process.stdio[4].on("data", (bytes) => {
      const messages = (rest + bytes.toString("utf8")).split("\0");
      rest = messages.pop();
      for (const message of messages.map((text) => JSON.parse(text))) {
        if (message.id) this.#answers.get(message.id)?.(message);
        else this.#hear(message);
      }
    });
  }

  /** Gives the page another width, as a phone has it; without one, that of before. What is drawn follows two frames later. */
  async setWidth(width = this.#screen.width) {
    await this.call("Emulation.setDeviceMetricsOverride", { ...this.#screen, width });
    await this.ask("new Promise((go) => requestAnimationFrame(() => requestAnimationFrame(go)))");
  }

  expect(holds, what) { if (!holds) this.fail(what); }
  fail(what) { this.failures.push(`${this.about}${what}`); }

  /** Opens a page, in the place of one before it, and waits until it shows its first picture. */
  async open(url) {
    if (this.#target) {
      this.#session = undefined;
      await this.call("Target.closeTarget", { targetId: this.#target });
    }
    this.#target = (await this.call("Target.createTarget", { url: "about:blank" })).targetId;
    this.#session = (await this.call("Target.attachToTarget", { targetId: this.#target, flatten: true })).sessionId;
    for (const domain of ["Runtime", "Log", "Page", "Network"]) await this.call(`${domain}.enable`);
    await this.call("Emulation.setDeviceMetricsOverride", this.#screen);
    await this.call("Page.navigate", { url });
    if (!(await this.wait("!!window.tanorPage", 60))) throw new Error("the page shows nothing within a minute");
  }

  call(method, params = {}) {
    const id = ++this.#next;
    this.#process.stdio[3].write(`${JSON.stringify({ id, method, params, sessionId: this.#session })}\0`);
    return new Promise((resolve, reject) => this.#answers.set(id, (message) =>
      message.error ? reject(new Error(`${method}: ${message.error.message}`)) : resolve(message.result)));
  }

  async ask(expression) {
    const { result, exceptionDetails } = await this.call("Runtime.evaluate", { expression, returnByValue: true, awaitPromise: true });
    if (exceptionDetails) throw new Error(exceptionDetails.exception?.description ?? exceptionDetails.text);
    return result.value;
  }

  /** Waits until something holds; the answer, or false after so many seconds. */
  async wait(expression, seconds) {
    for (const end = performance.now() + 1000 * seconds; performance.now() < end; await pause(20)) {
      const answer = await this.ask(expression).catch(() => false);
      if (answer) return answer;
    }
    return false;
  }

  countPixels() { return this.ask(countPixels); }

  async takePicture(file) {
    const { data } = await this.call("Page.captureScreenshot", { format: "png", captureBeyondViewport: true });
    writeFileSync(file, Buffer.from(data, "base64"));
  }

  /** Ends the browser with all its processes, and removes its profile. */
  async end() {
    const ended = new Promise((go) => this.#process.once("exit", go));
    process.kill(-this.#process.pid, "SIGKILL");
    await ended;
    // Its other processes write a moment longer, so that a folder just emptied may not be empty.
    for (let k = 0; k < 50; ++k) {
      try { return rmSync(this.#profile, { recursive: true, force: true }); } catch { await pause(100); }
    }
    console.error(`${this.#profile} could not be removed`);
  }

  #hear({ method, params }) {
    if (method === "Runtime.exceptionThrown") this.fail(`exception: ${params.exceptionDetails.exception?.description}`);
    if (method === "Runtime.consoleAPICalled" && params.type === "error") this.fail(`console: ${params.args.map((a) => a.value ?? a.description).join(" ")}`);
    if (method === "Log.entryAdded" && params.entry.level === "error") this.fail(`log: ${params.entry.text}`);
    if (method === "Network.requestWillBeSent" && /^(https?|wss?):/.test(params.request.url) && !(this.network && params.request.url.startsWith(this.network)))
      this.fail(`network: ${params.request.url}`);
  }
}

/**
 * Runs a trial of pages, prints what failed and ends the process; a browser that does not answer for so many seconds is
 * no success.
 */
export async function tryInBrowser(browser, trial, seconds = 180) {
  const giveUp = setTimeout(async () => {
    console.error("the browser does not answer");
    await browser.end();
    process.exit(1);
  }, 1000 * seconds);
  try {
    await trial(browser);
  } catch (error) {
    browser.fail(error.stack);
  }
  clearTimeout(giveUp);
  await browser.end();
  for (const failure of browser.failures) console.error(failure);
  process.exit(browser.failures.length ? 1 : 0);
}
