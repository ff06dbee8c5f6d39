// page.mjs PAGE SUMMARY CHROMIUM [PICTURE.png]: loads a report.html in headless Chromium and tries it.
//
// Finds drawn pixels and no error on the console, orbits, switches, looks for its histories and events, scrubs to the end,
// and compares the tensions shown there with those of summary.json (scenes whose constraints are rods alone). At most
// 12 MB.
// Times are printed, not judged: they depend on the machine.
import { existsSync, readFileSync, statSync } from "node:fs";
import { dirname, join, resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { Browser, tryInBrowser } from "./browser.mjs";

const [pagePath, summaryPath, chromium, picture] = process.argv.slice(2);
const mostBytes = 12e6;

async function tryPage(browser) {
  await browser.open(pathToFileURL(resolve(pagePath)).href);
  const first = await browser.ask("tanorPage.firstPicture");
  const begin = await browser.countPixels();
  browser.expect(begin.drawn > 500, `only ${begin.drawn} pixels are drawn`);
  await trySwitches(browser);
  await orbit(browser);
  await readOrder(browser);
  await tryEvents(browser);
  const words = await browser.ask(`Array.from(document.querySelectorAll("#charts .u-series:first-child"), (each) => [each.querySelector(".u-label").textContent, each.querySelector(".u-value").textContent]).filter(([label]) => label === "t / s").map(([, value]) => value)`);
  browser.expect(words.length >= 4 && words.every((each) => Number.isFinite(Number(each))), `the charts tell the times ${words}`);

  // Scrub as a hand does, to the end: what is shown there is the end of the run.
  await browser.ask(`(() => { const bar = document.getElementById("time"); bar.value = 1; bar.dispatchEvent(new Event("input")); })()`);
  const end = await browser.countPixels();
  browser.expect(end.sum !== begin.sum, "the picture at the end is that of the start");
  const clock = await browser.ask(`document.getElementById("clock").textContent`);
  const { final } = JSON.parse(readFileSync(summaryPath, "utf8"));
  browser.expect(clock.startsWith(`${+final.t.toPrecision(4)} s`), `the clock shows ${clock}`);
  if (await browser.ask(`JSON.parse(document.getElementById("data").textContent).motion.rods`))
    await compareTensions(browser, readMultipliers(final));
  await play(browser);
  const bytes = statSync(pagePath).size;
  browser.expect(bytes < mostBytes, `the page has ${bytes} bytes`);
  console.log(`${(bytes / 1e6).toFixed(2)} MB, first picture after ${first.toFixed(0)} ms, ${begin.drawn} pixels`);
}

/** Of summary.json, or of numpy's file beside it: a header of some lines, then doubles. */
function readMultipliers({ multipliers }) {
  if (Array.isArray(multipliers)) return multipliers;
  const bytes = readFileSync(join(dirname(summaryPath), "final_multipliers.npy")), begins = 10 + bytes.readUInt16LE(8);
  return Array.from({ length: (bytes.length - begins) / 8 }, (_, k) => bytes.readDoubleLE(begins + 8 * k));
}

/** What is switched off is not drawn: each switch that is offered changes the picture, and comes back. */
async function trySwitches(browser) {
  await browser.ask("tanorPage.seek(tanorPage.begin + 0.4 * (tanorPage.end - tanorPage.begin))");
  const before = await browser.countPixels();
  for (const part of ["points", "rods", "guides", "normal", "tangent"]) {
    const click = `(() => { const box = document.getElementById("show-${part}"); if (box.parentElement.hidden) return false; box.click(); return true; })()`;
    if (!(await browser.ask(click))) continue;
    browser.expect((await browser.countPixels()).sum !== before.sum, `without ${part} the picture is the same`);
    await browser.ask(click);
    browser.expect((await browser.countPixels()).sum === before.sum, `${part} do not come back as they were`);
  }
  await browser.ask("tanorPage.seek(tanorPage.begin)");
}

/** A hand drags the picture around, and a key brings it back. */
async function orbit(browser) {
  await browser.ask("tanorPage.seek(tanorPage.begin)");
  const before = await browser.countPixels();
  const [x, y] = await browser.ask(`(() => { const box = document.getElementById("view").getBoundingClientRect(); return [box.x + box.width / 2, box.y + box.height / 2]; })()`);
  const move = (type, dx, buttons) => browser.call("Input.dispatchMouseEvent", { type, x: x + dx, y, button: "left", buttons, clickCount: 1 });
  await move("mousePressed", 0, 1);
  for (const dx of [40, 80, 120]) await move("mouseMoved", dx, 1);
  await move("mouseReleased", 120, 0);
  browser.expect((await browser.countPixels()).sum !== before.sum, "the picture does not turn with the mouse");
  await browser.ask(`document.getElementById("reset").click()`);
  browser.expect((await browser.countPixels()).sum === before.sum, "Reset does not bring the view back");
}

/** Warnings come first, then what ran, then what was left out, then the picture; and the histories are there. */
async function readOrder(browser) {
  const order = await browser.ask(`Array.from(document.querySelectorAll("#warnings, #scene, #headline, #left-out-line, #view, #charts, #phases"), (each) => each.id).join(" ")`);
  browser.expect(order === "warnings scene headline left-out-line view charts phases", `the page has ${order}`);
  const words = await browser.ask(`document.getElementById("headline").textContent`);
  for (const word of ["certified", "run time", "violation"]) browser.expect(words.includes(word), `the headline has no ${word}`);
  const titles = await browser.ask(`Array.from(document.querySelectorAll("#charts h2"), (each) => each.textContent).join("; ")`);
  const wanted = ["Energy drift", "Violation", "Conditioning", "Error against run time"];
  if (await browser.ask(`JSON.parse(document.getElementById("data").textContent).motion.has_friction`)) wanted.push("Friction iterations");
  for (const title of wanted) browser.expect(titles.includes(title), `no history ${title} among ${titles}`);
  await readErrorTime(browser);
  await readTimes(browser);
}

/** The table of tanor error-time beside the page is a curve for each method; without it the page says how to get one. */
async function readErrorTime(browser) {
  const table = join(dirname(pagePath), "error_time.csv");
  const card = `Array.from(document.querySelectorAll("#charts .card")).find((each) => each.querySelector("h2").textContent.startsWith("Error against run time"))`;
  if (!existsSync(table)) {
    browser.expect(await browser.ask(`!!${card}.querySelector(".hint")`), "nothing says how errors are measured");
    return;
  }
  const [head, ...rows] = readFileSync(table, "utf8").trim().split("\n").map((row) => row.split(","));
  const methods = [...new Set(rows.map((row) => row[head.indexOf("method")]))].join(" ");
  const shown = await browser.ask(`Array.from(${card}.querySelectorAll(".u-series .u-label"), (each) => each.textContent).slice(1).join(" ")`);
  browser.expect(shown === methods, `the errors of ${shown} are shown, the table has ${methods}`);
}

/** How long the motion is that was simulated, and where its picture begins. */
async function readTimes(browser) {
  const { t_start, t_resumed } = await browser.ask(`JSON.parse(document.getElementById("data").textContent).run`);
  const { final } = JSON.parse(readFileSync(summaryPath, "utf8"));
  const simulated = await browser.ask(`Array.from(document.querySelectorAll("#headline dt")).find((each) => each.textContent === "simulated").nextSibling.textContent`);
  browser.expect(simulated === `${+(final.t - t_start).toPrecision(4)} s`, `${simulated} are simulated, from ${t_start} s to ${final.t} s`);
  const begin = await browser.ask("tanorPage.begin"), notes = await browser.ask(`document.getElementById("view-notes").textContent`);
  browser.expect(begin === (t_resumed ?? t_start), `the picture begins at ${begin} s`);
  browser.expect(notes.includes("went on at t = ") === (t_resumed !== null), `beside the picture stands: ${notes}`);
  const { guides, without_picture } = await browser.ask(`JSON.parse(document.getElementById("data").textContent).motion`);
  browser.expect(notes.includes("Not drawn") === without_picture.length > 0, `${guides.length} guides, and beside the picture stands: ${notes}`);
}

/** Each event is a mark on the line of time and a row; both lead the view there. */
async function tryEvents(browser) {
  const times = await browser.ask(`JSON.parse(document.getElementById("data").textContent).events.map((event) => event.t)`);
  for (const part of ["#marks i", "#events li"]) {
    const count = await browser.ask(`document.querySelectorAll("${part}").length`);
    browser.expect(count === times.length, `${count} of ${times.length} events are shown as ${part}`);
    if (count === 0) continue;
    const shown = await browser.ask(`(() => { document.querySelectorAll("${part}")[${count - 1}].click(); return tanorPage.time; })()`);
    browser.expect(shown === times[count - 1], `an event at ${times[count - 1]} s leads to ${shown} s`);
  }
  await browser.ask("tanorPage.seek(tanorPage.begin)");
}

/** The tension that is written, and all that colours show, against -lambda. */
async function compareTensions(browser, multipliers) {
  const largest = multipliers.reduce((most, x) => Math.max(most, Math.abs(x)), 0);
  const shown = Number(await browser.ask(`document.getElementById("tension").textContent.split(" ")[0]`));
  const rod = Number(await browser.ask(`document.getElementById("rod").value`));
  // 16 bits between the least and the largest of the end, and four digits
  const allowed = 1e-3 * Math.abs(multipliers[rod]) + 1e-4 * largest;
  browser.expect(Math.abs(shown + multipliers[rod]) <= allowed, `rod ${rod} shows ${shown} N, summary.json has ${-multipliers[rod]} N`);
  const all = await browser.ask(`Array.from({ length: ${multipliers.length} }, (_, k) => tanorPage.tension(k))`);
  const worst = multipliers.reduce((most, x, k) => Math.max(most, Math.abs(x + all[k])), 0);
  const step = (await browser.ask(`JSON.parse(document.getElementById("data").textContent).motion.ranges.tensions.at(-1)`)).reduce((a, b) => b - a) / 65535;
  browser.expect(worst <= 1.01 * step + 1e-6 * largest, `tensions differ by ${worst} N, a step of 16 bits is ${step} N`);
  // Rods in compression are listed, the most pushed one first.
  const listed = await browser.ask(`Array.from(document.querySelectorAll("#pushed li"), (row) => Number(row.textContent.split(" ")[1].split("(")[0]))`);
  const pushed = multipliers.filter((x) => x > 3 * step).length;
  browser.expect(listed.length >= Math.min(40, pushed) && listed.every((rod, k) => multipliers[rod] > 0 && (k === 0 || multipliers[listed[k - 1]] >= multipliers[rod] - 2 * step)),
    `${listed.length} rods are listed as pushed, ${pushed} are`);
}

async function play(browser) {
  const before = await browser.ask("tanorPage.frames");
  const begin = performance.now();
  await browser.ask("tanorPage.seek(tanorPage.begin); tanorPage.play(true)");
  await browser.wait(`tanorPage.frames > ${before} && tanorPage.time > tanorPage.begin`, 60); // a machine may be busy
  await browser.ask("new Promise((go) => setTimeout(go, 1500))");
  const frames = (await browser.ask("tanorPage.frames")) - before, passed = (performance.now() - begin) / 1000;
  await browser.ask("tanorPage.play(false); tanorPage.seek(tanorPage.begin + 0.6 * (tanorPage.end - tanorPage.begin))");
  const moved = await browser.ask("(() => { const before = performance.now(); for (let k = 0; k < 20; ++k) tanorPage.seek(tanorPage.begin + (k / 20) * (tanorPage.end - tanorPage.begin)); return (performance.now() - before) / 20; })()");
  await browser.ask("tanorPage.seek(tanorPage.begin + 0.6 * (tanorPage.end - tanorPage.begin))");
  browser.expect(frames > 0, "no picture was drawn while it played");
  console.log(`${(frames / passed).toFixed(1)} pictures a second without a GPU, ${moved.toFixed(1)} ms to place what one shows`);
  if (picture) await browser.takePicture(picture);
}

// Without a GPU each pixel takes time: where nobody looks at a picture, fewer of them do.
const size = picture ? {} : { width: 960, height: 640 };
await tryInBrowser(new Browser(chromium, { ...size, isDark: !!process.env.TANOR_PAGE_DARK }), tryPage);
