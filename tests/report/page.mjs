// page.mjs CHROMIUM FOLDER:SWITCHES:SCENE:BEGIN …: loads the report.html of each folder in headless Chromium and tries it.
//
// FOLDER:~WEIGHT, of an equilibrium or of modes: looks for the loads, N or unknown, for tensions and for modes that swing.
// FOLDER:+TITLES, of a run that shows some of its points: looks for the titles of its second rod and of its first point.
// FOLDER:?TENSION, of a run in which two rods share a load: looks for tensions that are not told, and for that of the third.
// FOLDER:_, of a run in which a ball falls until its string of 1 m is taut: looks for the string, first sagging, then straight.
// FOLDER:!, of a run in which a rod breaks and a crank is let go: looks for what is drawn before and after.
// FOLDER:=FACTS, of a run that has nothing to move or ended before its time: looks for the facts in the headline, and why it ended.
// Finds drawn pixels and no error on the console, orbits, switches (SWITCHES are those that the page must offer), looks
// for its histories and events and for its begin (BEGIN s, or nothing: that of the motion), scrubs to the end, and compares what is shown there with summary.json: tensions (scenes
// whose constraints are rods alone), arrows of reactions (scenes whose guides hold points that no rod holds, and
// supports; friction under gravity alone, of points of one mass), and the curves and surfaces that points stay on. At
// most 12 MB.
// Limits of time are wide, since machines differ: what takes ten times longer than on a slow one fails.
// TANOR_PAGE_PICTURES=1 leaves picture.png in each folder, TANOR_PAGE_DARK=1 looks by night.
import { existsSync, readFileSync, readdirSync, rmSync, statSync, writeFileSync } from "node:fs";
import { basename, join, resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { Browser, tryInBrowser } from "./browser.mjs";
import { compareFixtures, compareObservables, measureFill, readData, readOverlay, readTable, tryCell, tryClicks, tryCurve, tryFiles, tryFullScreen, tryGone, tryHistogram, tryLooks, tryNarrow, tryObservables, tryOverlay } from "./looks.mjs";

const [chromium, ...trials] = process.argv.slice(2);
const takesPictures = !!process.env.TANOR_PAGE_PICTURES;
const mostBytes = 12e6;
const parts = ["points", "rods", "guides", "normal", "tangent", "cell"];

async function tryPage(browser, { folder, switches, scene, begin: toBegin }) {
  const page = join(folder, "report.html"), { final, contact_changes: events } = JSON.parse(readFileSync(join(folder, "summary.json"), "utf8"));
  await browser.open(pathToFileURL(resolve(page)).href);
  const motion = await readData(browser, "motion"), isLarge = motion.points > 3000;
  const first = await browser.ask("tanorPage.firstPicture"), mostForFirst = isLarge ? 30_000 : 15_000;
  browser.expect(first < mostForFirst, `the first picture comes after ${first} ms`);
  const begin = await browser.countPixels();
  browser.expect(begin.drawn > 200, `only ${begin.drawn} pixels are drawn`);
  const { largest, span } = motion.rods ? await measureFill(browser) : { largest: 0.9, span: 1 };
  browser.expect((await browser.ask(`document.querySelector(".keys").textContent`)).match(/space play.* v video.* g full screen.* p picture/), "the keys are not listed");
  browser.expect(largest < 1 && span > 0.3, `the page opens with ${span} of the picture filled, up to ${largest}`);
  if (!isLarge) await orbit(browser, begin); // each picture of many beads takes a second without a GPU
  await browser.ask(`document.getElementById("computed").open = true`);
  await browser.wait(`document.querySelector("#charts .card")`, 20);
  await trySwitches(browser, switches);
  await readOrder(browser, motion);
  await readErrorTime(browser, folder);
  await readTimes(browser, final, motion, toBegin);
  await tryEvents(browser, events);
  await readCharts(browser);
  await compareObservables(browser, folder);

  // Scrub as a hand does, to the end: what is shown there is the end of the run.
  await browser.ask(`(() => { const bar = document.getElementById("time"); bar.value = 1; bar.dispatchEvent(new Event("input")); })()`);
  const turnsRound = basename(folder) === "four_bar_motor"; // back to its start
  browser.expect(turnsRound || (await browser.countPixels()).sum !== begin.sum, "the picture at the end is that of the start");
  if (motion.rods && !isLarge) {
    const followed = await measureFill(browser);
    await browser.ask(`tanorPage.camera.position.lerp(tanorPage.target, -5); document.getElementById("fit").click()`); // from far away
    const fitted = await measureFill(browser);
    browser.expect(followed.largest < 1, `what has moved stands at ${followed.largest} of half the picture`);
    browser.expect(fitted.largest < 1 && fitted.span > 0.3, `Fit fills ${fitted.span} of the picture, up to ${fitted.largest}`);
  }
  const clock = await browser.ask(`document.getElementById("clock").textContent`);
  const { time } = await readData(browser, "units");
  browser.expect(clock.startsWith(`${+final.t.toPrecision(4)} ${time}`), `the clock shows ${clock}`);
  await compareFixtures(browser, motion, readArray(folder, final, "positions"));
  await compareSizes(browser, motion, readArray(folder, final, "positions"));
  if (motion.rods) {
    await tryHistogram(browser, readArray(folder, final, "multipliers").slice(0, motion.rods).map((x) => -x));
    await compareTensions(browser, motion, readArray(folder, final, "multipliers").slice(0, motion.rods)); // rods come first
    await compareColours(browser, folder);
  }
  await compareArrows(browser, findEndForces(folder, final, motion, scene));
  await compareGuides(browser, motion, readArray(folder, final, "positions"), scene);
  await compareForces(browser, motion, readArray(folder, final, "multipliers"), readArray(folder, final, "support_forces"));

  const hide = () => isLarge && browser.ask(switches.map((part) => `document.getElementById("show-${part}").click()`).join(";")); // drawing takes seconds
  await hide();
  await tryWidths(browser);
  await hide();
  if (basename(folder) === "crane") {
    await tryCurve(browser, folder);
    await tryLooks(browser);
    await tryClicks(browser, folder);
    await tryOverlay(browser);
    await tryFullScreen(browser);
    await tryFiles(browser, folder);
  }
  if (basename(folder) === "box") await tryCell(browser);

  const placed = await timeInstants(browser);
  browser.expect(placed < 1000, `an instant is placed in ${placed} ms`);
  await play(browser);
  const bytes = statSync(page).size;
  browser.expect(bytes < mostBytes, `the page has ${bytes} bytes`);
  console.log(`${basename(folder)}: ${(bytes / 1e6).toFixed(2)} MB, first picture after ${first.toFixed(0)} ms, ${begin.drawn} pixels, ` +
    `an instant placed in ${placed.toFixed(1)} ms`);
  if (takesPictures) await browser.takePicture(join(folder, "picture.png"));
}

/** A run that ended before its time says so, and why, and claims nothing that it does not know. */
async function tryStoppedPage(browser, folder, facts) {
  await browser.open(pathToFileURL(resolve(join(folder, "report.html"))).href);
  const { stopped_by: why, t_reached: reached, certificate, violation } = JSON.parse(readFileSync(join(folder, "summary.json"), "utf8"));
  const text = (id) => browser.ask(`document.getElementById("${id}").textContent`);
  if (why) browser.expect((await text("warnings")).includes(why), `the warnings are ${await text("warnings")}, not ${why}`);
  const headline = await text("headline");
  for (const fact of facts) browser.expect(headline.includes(fact), `the headline ${headline} has no ${fact}`);
  browser.expect(headline.includes("no start was found") === (violation.position_max === null), `the headline is ${headline}`);
  await readWords(browser);
  browser.expect((certificate.verdict === null) === (await text("certificate")).startsWith("None was made"), await text("certificate"));
  const isShown = await browser.ask(`document.getElementById("moving").offsetParent !== null`);
  browser.expect(isShown === (reached > 0), `the motion is ${isShown ? "" : "not "}shown`);
  const hasHistories = await browser.ask(`document.getElementById("histories-part").offsetParent !== null`);
  browser.expect(hasHistories === isShown, `histories are ${hasHistories ? "" : "not "}headed`);
  await tryWidths(browser);
  console.log(`${basename(folder)}: ${facts.join(", ")}`);
}

/** Of summary.json, or of numpy's file beside it: a header of some lines, then doubles. */
function readArray(folder, final, key) {
  if (Array.isArray(final[key])) return final[key].flat();
  const bytes = readFileSync(join(folder, `final_${key}.npy`)), begins = 10 + bytes.readUInt16LE(8);
  return Array.from({ length: (bytes.length - begins) / 8 }, (_, k) => bytes.readDoubleLE(begins + 8 * k));
}

/**
 * What guides and supports do to the points at the end (3n, N), and what friction does there: what Newton's law leaves
 * of it, m w = m g + reaction + friction.
 */
function findEndForces(folder, final, motion, scene) {
  const reactions = readArray(folder, final, "reactions"), carried = readArray(folder, final, "support_forces");
  const normal = reactions.map((force, k) => (motion.supports.includes(Math.floor(k / 3)) ? -carried[k] : force));
  if (!motion.has_friction) return { normal, tangent: normal.map(() => 0) };
  const { points, forces } = JSON.parse(readFileSync(scene, "utf8"));
  const tangent = readArray(folder, final, "accelerations").map((w, k) => points.masses * (w - forces[0].acceleration[k % 3]) - reactions[k]);
  return { normal, tangent };
}

/** What is switched off is not drawn: each switch changes the picture, and all of them together bring it back. */
async function trySwitches(browser, switches) {
  const offered = await browser.ask(`${JSON.stringify(parts)}.filter((part) => !document.getElementById("show-" + part).parentElement.hidden)`);
  browser.expect(offered.join() === switches.join(), `the switches ${offered} are offered, not ${switches}`);
  await browser.ask("tanorPage.seek(tanorPage.begin + 0.4 * (tanorPage.end - tanorPage.begin))");
  const whole = await browser.countPixels();
  let before = whole;
  for (const part of offered) {
    await browser.ask(`document.getElementById("show-${part}").click()`);
    const without = await browser.countPixels();
    browser.expect(without.sum !== before.sum, `without ${part} the picture is the same`);
    before = without;
  }
  browser.expect(before.drawn === 0, `${before.drawn} pixels are drawn where all is switched off`);
  await browser.ask(offered.map((part) => `document.getElementById("show-${part}").click()`).join(";"));
  browser.expect((await browser.countPixels()).sum === whole.sum, "parts do not come back as they were");
  await browser.ask("tanorPage.seek(tanorPage.begin)");
}

/** A hand drags the picture around what is up, and a button brings it back. */
async function orbit(browser, before) {
  const look = "({ height: tanorPage.camera.position.dot(tanorPage.camera.up), size: tanorPage.size })", { height, size } = await browser.ask(look);
  const [x, y] = await browser.ask(`(() => { const box = document.getElementById("view").getBoundingClientRect(); return [box.x + box.width / 2, box.y + box.height / 2]; })()`);
  const move = (type, dx, buttons) => browser.call("Input.dispatchMouseEvent", { type, x: x + dx, y, button: "left", buttons, clickCount: 1 });
  await move("mousePressed", 0, 1);
  for (const dx of [60, 120]) await move("mouseMoved", dx, 1);
  await move("mouseReleased", 120, 0);
  browser.expect((await browser.countPixels()).sum !== before.sum, "the picture does not turn with the mouse");
  const risen = (await browser.ask(look)).height - height;
  browser.expect(Math.abs(risen) < 1e-6 * size, `the eye rises by ${risen} m of ${size} m as it goes around`);
  await browser.ask(`document.getElementById("reset").click()`);
  browser.expect((await browser.countPixels()).sum === before.sum, "Reset does not bring the view back");
}

/** Warnings come first, then the picture and the histories of the mechanism, then how well it was computed, which is folded. */
async function readOrder(browser, motion) {
  const order = await browser.ask(`Array.from(document.querySelectorAll("#warnings, #scene, #headline, #left-out-line, #view, #histories, #charts, #phases"), (each) => each.id).join(" ")`);
  browser.expect(order === "warnings scene view histories headline left-out-line charts phases", `the page has ${order}`);
  const words = await browser.ask(`document.getElementById("headline").textContent`);
  for (const word of ["certified", "error of the motion", "run time", "violation"]) browser.expect(words.includes(word), `the headline has no ${word}`);
  const leftOut = await browser.ask(`document.getElementById("left-out-line").textContent`);
  browser.expect(/^Left out/.test(leftOut) && !/Gamma|xi_t|r_t|[A-Z]\b|form/.test(leftOut), `the headline says ${leftOut}`);
  await readWords(browser);
  const titles = await browser.ask(`Array.from(document.querySelectorAll("#charts h3"), (each) => each.textContent).join("; ")`);
  const wanted = ["Energy drift", "Violation", "Conditioning"];
  if (motion.has_friction) wanted.push("Friction iterations");
  for (const title of wanted) browser.expect(titles.includes(title), `no history ${title} among ${titles}`);
}

/** What is not known is said in words. */
async function readWords(browser) {
  const odd = (await browser.ask("document.body.innerText")).match(/[^\n]*\b(undefined|NaN|Infinity|null)\b[^\n]*/);
  browser.expect(!odd, `the page says: ${odd?.[0]}`);
}

/** Everything fits into the width of a phone, as of a wide screen. */
async function tryWidths(browser) {
  for (const width of [320, 414, 1200, 1920]) {
    await browser.setWidth(width);
    const beyond = `Array.from(document.querySelectorAll("body *")).filter((each) => each.getBoundingClientRect().right > ${width} + 0.5).map((each) => each.id || each.className || each.tagName)`;
    const fits = await browser.wait(`${beyond}.length === 0 && document.documentElement.scrollWidth <= ${width}`, 10);
    if (!fits) browser.fail(`beyond ${width} pixels are ${await browser.ask(`${beyond}.join()`)}`);
  }
  await browser.setWidth();
}

/** The colours of the rods and their legend are those of `tanor picture`, which has told its scale. */
async function compareColours(browser, folder) {
  const { tensions: [least, most], pulled, pushed } = await readData(browser, "colours"), scale = Math.max(most, -least);
  const file = join(folder, "picture.json");
  if (existsSync(file)) browser.expect(JSON.parse(readFileSync(file, "utf8")).tension_scale === scale, `the colours end at ${scale} N`);
  const ends = await browser.ask(`Array.from(document.querySelectorAll("#legend .ends span"), (each) => parseFloat(each.textContent.replace("−", "-").replace(/^[<>] /, ""))).join()`);
  const marks = await browser.ask(`document.getElementById("legend").textContent.match(/[<>] /g)?.join("") ?? ""`), all = (await readData(browser, "motion.ranges.tensions")).flat();
  browser.expect(marks === (Math.min(...all) < least && least < 0 ? "< " : "") + (Math.max(...all) > most && most > 0 ? "> " : ""), `the ends of ${least} … ${most} N have the marks "${marks}"`);
  browser.expect(ends === (least < 0 && most > 0 ? [least, 0, most] : [least, most]).join(), `the bar of ${least} … ${most} N has ${ends}`);
  browser.expect(pulled.at(-1) === "#701c08" && pushed.at(-1) === "#0a2161", `the colours end in ${pulled.at(-1)}, ${pushed.at(-1)}`);
  const read = (text) => [1, 3, 5].map((at) => parseInt(text.slice(at, at + 2), 16) / 255);
  const { tensions, tints } = await browser.ask(`(() => {
    const tints = Array.from(tanorPage.scene.getObjectByName("rods").geometry.attributes.tint.array);
    return { tints, tensions: tints.slice(0, tints.length / 3).map((_, k) => tanorPage.tension(k)) };
  })()`);
  const worst = tensions.reduce((most, tension, rod) => {
    const stops = (tension < 0 ? pushed : pulled).map(read), place = 3 * Math.min(1, Math.abs(tension) / scale), k = Math.min(2, Math.floor(place));
    const wanted = stops[k].map((x, part) => x + (place - k) * (stops[k + 1][part] - x));
    return Math.max(most, ...wanted.map((x, part) => Math.abs(x - tints[3 * rod + part])));
  }, 0);
  browser.expect(worst < 0.01, `colours of rods differ by ${worst} from those of their tensions`);
}

/** The table of tanor error-time beside the page is a curve for each method, with the name of the scene where that is another one;
    without a table one line says how to get one. */
async function readErrorTime(browser, folder) {
  const table = join(folder, "error_time.csv"), hasTable = existsSync(table);
  const card = `Array.from(document.querySelectorAll("#charts .card")).find((each) => each.querySelector("h3").textContent.startsWith("Error against run time"))`;
  browser.expect((await browser.ask(`document.getElementById("errors-line").hidden`)) === hasTable && (await browser.ask(`!!${card}`)) === hasTable,
    "a card shows errors or a line says how they are measured, not both and not neither");
  if (!hasTable) return;
  const [head, ...rows] = readFileSync(table, "utf8").trim().split("\n").map((row) => row.split(","));
  const { scene } = await readData(browser, "run");
  const nameOf = (row) => {
    const measured = row[head.indexOf("scene")].replaceAll('"', "");
    return row[head.indexOf("method")] + (measured === scene ? "" : ` (${measured})`);
  };
  const methods = [...new Set(rows.map(nameOf))].join(" ");
  const shown = await browser.ask(`Array.from(${card}.querySelectorAll(".u-series .u-label"), (each) => each.textContent).slice(1).join(" ")`);
  browser.expect(shown === methods, `the errors of ${shown} are shown, the table has ${methods}`);
}

/** How long the motion is that was simulated, and where its picture and its histories begin. */
async function readTimes(browser, final, motion, toBegin) {
  const { t_start } = await readData(browser, "run"), { time } = await readData(browser, "units"), wanted = toBegin ? Number(toBegin) : t_start;
  const simulated = await browser.ask(`Array.from(document.querySelectorAll("#headline dt")).find((each) => each.textContent === "simulated").nextSibling.textContent`);
  browser.expect(simulated === `${+(final.t - t_start).toPrecision(4)} ${time}`, `${simulated} are simulated, from ${t_start} s to ${final.t} s`);
  const begin = await browser.ask("tanorPage.begin"), notes = await browser.ask(`document.getElementById("view-notes").textContent`);
  const first = await readData(browser, "history.t[0]"); // after a step
  browser.expect(begin === wanted && first >= wanted && first - wanted < 0.2 * (final.t - wanted), `the picture begins at ${begin} s, the histories at ${first} s`);
  browser.expect(notes.includes(`begin at t = ${+begin.toPrecision(4)} ${time}`) === wanted > t_start, `beside the picture stands: ${notes}`);
  browser.expect(notes.includes("Not drawn") === motion.without_picture.length > 0, `${motion.guides.length} guides, and beside the picture stands: ${notes}`);
}

/** Each event is a mark on the line of time and a row; both lead the view there. What is not listed is counted. */
async function tryEvents(browser, events) {
  const times = await readData(browser, "events.map((event) => event.t)");
  for (const part of ["#marks i", "#events li"]) {
    const count = await browser.ask(`document.querySelectorAll("${part}").length`);
    browser.expect(count === times.length, `${count} of ${times.length} events are shown as ${part}`);
    if (count === 0) continue;
    const shown = await browser.ask(`(() => { document.querySelectorAll("${part}")[${count - 1}].click(); return tanorPage.time; })()`);
    browser.expect(shown === times[count - 1], `an event at ${times[count - 1]} s leads to ${shown} s`);
  }
  const named = await readData(browser, `events.filter((event) => event.kind === "contact").map((event) => event.what)`), contacts = named.length;
  browser.expect(named.every((what) => /^(.+ at .+\[\d+\], point \d+ (sticks|slips)(, and others)?|the equations have a corner)$/.test(what)), `contacts are ${named.slice(0, 5).join("; ")}`);
  const words = await browser.ask(`document.getElementById("events-left-out").textContent`);
  browser.expect(words.includes(`${contacts} of ${events} contact`) === contacts < events && (contacts < events || !words),
    `${contacts} of ${events} contact switches are listed, and under them stands: ${words}`);
}

/** Every history tells the values of a time. */
async function readCharts(browser) {
  const { time } = await readData(browser, "units");
  const words = await browser.ask(`Array.from(document.querySelectorAll(".charts .u-series:first-child"), (each) => [each.querySelector(".u-label").textContent, each.querySelector(".u-value").textContent]).filter(([label]) => label === "t, ${time}").map(([, value]) => value)`);
  browser.expect(words.length >= 4 && words.every((each) => Number.isFinite(Number(each))), `the charts tell the times ${words}`);
}

/** The name of each rod that is shown: its group and its number there. */
const nameRods = ({ rods, rod_groups }) => rod_groups.flatMap(({ name, first, members }, k) =>
  Array.from({ length: (rod_groups[k + 1]?.first ?? rods) - first }, (_, rod) => `${name}[${members.length ? members[rod] : rod}]`));

/** The tension that is written, and all that colours show, against -lambda. */
async function compareTensions(browser, motion, multipliers) {
  const largest = multipliers.reduce((most, x) => Math.max(most, Math.abs(x)), 0);
  const shown = Number(await browser.ask(`document.getElementById("tension").textContent.split(" ")[0]`));
  const rod = Number(await browser.ask(`document.getElementById("rod").value`));
  // 16 bits between the least and the largest of the end, and four digits
  const allowed = 1e-3 * Math.abs(multipliers[rod]) + 1e-4 * largest;
  browser.expect(Math.abs(shown + multipliers[rod]) <= allowed, `rod ${rod} shows ${shown} N, summary.json has ${-multipliers[rod]} N`);
  const all = await browser.ask(`Array.from({ length: ${multipliers.length} }, (_, k) => tanorPage.tension(k))`);
  const worst = multipliers.reduce((most, x, k) => Math.max(most, Math.abs(x + all[k])), 0);
  const step = motion.ranges.tensions.at(-1).reduce((a, b) => b - a) / 65534;
  browser.expect(worst <= 1.01 * step + 1e-6 * largest, `tensions differ by ${worst} N, a step of 16 bits is ${step} N`);
  // Rods in compression are listed, the most pushed one first.
  const names = nameRods(motion), listed = (await browser.ask(`Array.from(document.querySelectorAll("#pushed li span:first-child"), (each) => each.textContent)`)).map((name) => names.indexOf(name.split(" (")[0]));
  const pushed = multipliers.filter((x) => x > 3 * step).length;
  browser.expect(listed.length >= Math.min(40, pushed) && listed.every((rod, k) => multipliers[rod] > 0 && (k === 0 || multipliers[listed[k - 1]] >= multipliers[rod] - 2 * step)),
    `${listed.length} rods are listed as pushed, ${pushed} are`);
}

/** Each arrow, as the picture has it, against the force at its point: where it points, and how long it is. */
async function compareArrows(browser, forces) {
  const newtons = Number((await browser.ask(`document.getElementById("arrow-scale").textContent`)).match(/picture is ([^ ]+) N/)?.[1]);
  for (const part of ["normal", "tangent"]) {
    const { arrows, points, size } = await browser.ask(`(() => {
      const { a, b } = tanorPage.scene.getObjectByName("${part}").geometry.attributes;
      return { arrows: Array.from(b.array, (end, k) => end - a.array[k]), points: Array.from(tanorPage.held), size: tanorPage.size };
    })()`);
    const wanted = points.flatMap((point) => forces[part].slice(3 * point, 3 * point + 3)).map((force) => (0.16 * size * force) / newtons);
    const longest = wanted.reduce((most, x) => Math.max(most, Math.abs(x)), 0);
    const worst = wanted.reduce((most, x, k) => Math.max(most, Math.abs(x - arrows[k])), 0);
    // The scale is told to three digits.
    browser.expect(arrows.length === wanted.length && worst <= 6e-3 * longest, `arrows of the ${part} part differ by ${worst} m of ${longest} m`);
  }
}

/** Each guide is drawn, and the points that it holds are on what is drawn: on a line, or on the edge of a triangle. */
async function compareGuides(browser, motion, positions, scene) {
  if (!motion.guides.length) return;
  const { constraints } = JSON.parse(readFileSync(scene, "utf8"));
  const everywhere = Array.from({ length: motion.points }, (_, k) => positions.slice(3 * k, 3 * k + 3));
  const places = motion.guides.map((guide) => {
    const { points } = constraints.find(({ name }) => name === guide.name);
    return points === "all" ? everywhere : points.flat().map((k) => everywhere[k]);
  });
  const drawn = await browser.ask(`(() => {
    ${findDistance}
    const list = ({ isLineSegments, isLine, geometry: { index, attributes: { position } } }) => { // of pairs of vertices
      const pairs = [], count = index ? index.count : position.count;
      const add = (i, k) => pairs.push(index ? [index.array[i], index.array[k]] : [i, k]);
      if (isLineSegments) for (let k = 0; k < count; k += 2) add(k, k + 1);
      else if (isLine) for (let k = 1; k < count; ++k) add(k - 1, k);
      else for (let k = 0; k < count; k += 3) { add(k, k + 1); add(k + 1, k + 2); add(k + 2, k); }
      return pairs;
    };
    const places = ${JSON.stringify(places)};
    return tanorPage.scene.getObjectByName("guides").children.map((guide, k) => {
      const distances = places[k].map(() => Infinity);
      guide.updateMatrixWorld();
      guide.traverse((each) => {
        if (!each.geometry) return;
        const place = (k) => each.position.clone().fromBufferAttribute(each.geometry.attributes.position, k).applyMatrix4(each.matrixWorld).toArray();
        for (const [a, b] of list(each).map((pair) => pair.map(place)))
          places[k].forEach((point, p) => (distances[p] = Math.min(distances[p], findDistance(point, a, b))));
      });
      return { name: guide.name, distance: Math.max(...distances) };
    });
  })()`);
  const names = drawn.map(({ name }) => name).join(), wanted = motion.guides.map(({ name }) => name).join();
  browser.expect(names === wanted, `the guides ${names} are drawn, not ${wanted}`);
  const size = await browser.ask("tanorPage.size");
  for (const [k, { distance }] of drawn.entries()) {
    // A plane has lines of a net alone, a tenth of the sheet apart, and a ball faces of a thirtieth of its size.
    const { kind } = motion.guides[k], allowed = { line: 1e-6, circle: 1e-3, helix: 1e-3, plane: 0.07 }[kind] ?? 0.01;
    browser.expect(distance < allowed * size, `a point is ${distance} m from the ${kind} as drawn, where all has ${size} m`);
  }
}

/** The loads of supports and the tensions of ropes at the end, as they are written where one chooses them. */
async function compareForces(browser, motion, multipliers, loads) {
  const tell = async (kind, number) => {
    await browser.ask(`(() => { document.getElementById("kind").value = "${kind}"; const number = document.getElementById("rod"); number.value = ${number}; number.dispatchEvent(new Event("input")); })()`);
    await browser.wait(`Array.from(document.querySelectorAll("#chosen .u-value")).every((each) => each.textContent)`, 5);
    return { title: await browser.ask(`document.querySelector("#chosen h3").textContent`), shown: await browser.ask(`document.getElementById("tension").textContent`),
      curves: await browser.ask(`Array.from(document.querySelectorAll("#chosen .u-series"), (each) => [each.querySelector(".u-label").textContent, parseFloat(each.querySelector(".u-value").textContent)]).slice(1)`) };
  };
  const largest = loads.concat(multipliers).reduce((most, x) => Math.max(most, Math.abs(x)), 0);
  for (const [k, point] of motion.supports.slice(0, 3).entries()) {
    const { title, shown, curves } = await tell("point", point), [x, y, z] = loads.slice(3 * point, 3 * point + 3), wanted = [Math.hypot(x, y, z), x, y, z];
    browser.expect(title === `load of ${motion.support_names[k]} (point ${point})` && shown.endsWith(" N"), `support ${point} has ${title}, ${shown}`);
    browser.expect(curves.length === 4 && curves.every(([, number], k) => Math.abs(number - wanted[k]) < (wanted[k] ? 2e-3 * largest : 1e-300)), `support ${point} carries ${wanted}, not ${curves}`);
  }
  const ropes = motion.ties.filter(({ kind }) => kind !== "spring"); // which has no multiplier
  for (const [k, { kind, name }] of [...ropes.entries()].filter(([k]) => k < 3 || k === ropes.length - 1)) {
    const { title, shown } = await tell("tie", k), row = multipliers.length - ropes.length + k; // the last ones of their scenes
    browser.expect(title.endsWith(name) && Math.abs(parseFloat(shown) + multipliers[row]) < 1e-3 * largest, `${title} shows ${shown}, not ${-multipliers[row]} N (${kind})`);
  }
}

/** A scene at rest: its loads carry its weight, its rods are listed, its modes swing. */
async function tryRestPage(browser, folder, weight) {
  await browser.open(pathToFileURL(resolve(join(folder, "report.html"))).href);
  const { modes } = JSON.parse(readFileSync(join(folder, "summary.json"), "utf8")), { drawn } = await browser.countPixels();
  browser.expect(drawn > 200, `only ${drawn} pixels are drawn`);
  await readWords(browser);
  const cells = (table) => browser.ask(`Array.from(document.querySelectorAll("#${table} tr"), (row) => Array.from(row.children, (cell) => cell.textContent))`);
  const [, sum] = await cells("loads"), tensions = await cells("tensions"), { rods } = await readData(browser, "motion");
  browser.expect(weight === "unknown" ? sum[4] === "not known" : Math.abs(parseFloat(sum[4]) + Number(weight)) < 1e-3 * weight, `the supports carry ${sum}, the weight is ${weight} N`);
  browser.expect(tensions.length === rods + 1, `${tensions.length - 1} of ${rods} rods are listed`);
  browser.expect(tensions.slice(1).map(([name]) => name).sort().join() === "links[0] (0–1),links[1] (1–2)", `the rods are ${tensions}`);
  const [, numbers] = readTable(folder), observed = (await cells("observed")).slice(1).map(([, value]) => parseFloat(value));
  browser.expect(observed.length === numbers.length - 1 && observed.every((each, k) => Number.isNaN(numbers[k + 1]) ? Number.isNaN(each) : Math.abs(each - numbers[k + 1]) <= 1e-3 * Math.abs(numbers[k + 1])), `${observed} are observed, not ${numbers.slice(1)}`);
  if (weight !== "unknown") await compareColours(browser, folder);
  const hasKeys = await browser.ask(`document.getElementById("keys-of-time").offsetParent !== null`);
  browser.expect(hasKeys === !!modes, `keys of time are ${hasKeys ? "" : "not "}listed`);
  if (modes) {
    const listed = (await cells("modes")).slice(1).map((row) => parseFloat(row[1]));
    browser.expect(listed.length === modes.count && listed.every((each, k) => Math.abs(each - modes.frequency_hz[k]) < 1e-3 * each), `the modes have ${listed} Hz, not ${modes.frequency_hz}`);
    const places = `Array.from(tanorPage.scene.getObjectByName("rods").geometry.attributes.a.array)`, at = (part) => browser.ask(`tanorPage.play(false); tanorPage.seek(${part} * tanorPage.end); ${places}`);
    const [rest, there, back] = [await at(0.25), await at(0), await at(0.5)];
    browser.expect(there.some((x, k) => Math.abs(x - rest[k]) > 0.01) && there.every((x, k) => Math.abs(x + back[k] - 2 * rest[k]) < 1e-3), "the mode does not swing about rest");
  }
  await tryWidths(browser);
  await tryFiles(browser, folder);
  console.log(`${basename(folder)}: ${weight} N`);
}

/** Points are as large as in pictures: 0.3 of a rod, but at most 0.015 of all that there is. */
async function compareSizes(browser, motion, positions) {
  if (motion.points > 3000 || motion.images.length) return;
  const [size, radius, ends] = await browser.ask(`[tanorPage.size, tanorPage.scene.getObjectByName("points").material.uniforms.radius.value, Array.from(tanorPage.rods)]`);
  const place = (k) => positions.slice(3 * k, 3 * k + 3), lengths = Array.from({ length: motion.rods }, (_, k) => Math.hypot(...place(ends[2 * k]).map((x, axis) => x - place(ends[2 * k + 1])[axis])));
  const typical = motion.rods ? 0.3 * lengths.sort((x, y) => x - y)[motion.rods >> 1] : (0.12 * size) / Math.sqrt(motion.points), wanted = Math.min(0.015 * size, typical);
  browser.expect(Math.abs(radius - wanted) < 0.02 * wanted, `points have a radius of ${radius} m, not ${wanted} m`);
}

/** From a point to a stretch of a line. */
function findDistance(point, a, b) {
  const along = b.map((x, axis) => x - a[axis]), to = point.map((x, axis) => x - a[axis]);
  const dot = (u, v) => u[0] * v[0] + u[1] * v[1] + u[2] * v[2], square = dot(along, along);
  const part = square > 0 ? Math.min(1, Math.max(0, dot(to, along) / square)) : 0;
  return Math.hypot(...to.map((x, axis) => x - part * along[axis]));
}

/** Rods and points have the names and the numbers that they have in the scene. */
async function tryNames(browser, folder, titles) {
  await browser.open(pathToFileURL(resolve(join(folder, "report.html"))).href);
  for (const [k, choice] of [`{ kind: "rod", number: 1 }`, `{ kind: "point", number: 0 }`].entries()) {
    const title = await browser.ask(`(tanorPage.choose(${choice}), document.querySelector("#chosen h3").textContent)`);
    browser.expect(title === titles[k], `the chart is of the ${title}, not of the ${titles[k]}`);
  }
  const what = await browser.ask(`document.getElementById("what").textContent`);
  browser.expect(what.startsWith("4 points, 3 rods, "), `${what} is not all of the scene`);
}

async function tryShared(browser, folder, tension) {
  await browser.open(pathToFileURL(resolve(join(folder, "report.html"))).href);
  const told = await browser.ask(`[0, 1, 2].map((rod) => String(tanorPage.tension(rod)))`);
  browser.expect(told[0] === "NaN" && told[1] === "NaN" && Math.abs(told[2] - tension) < 1e-3 * tension, `the tensions are ${told}`);
  const known = await Promise.all([0, 2].map((rod) => browser.ask(`(tanorPage.choose({ kind: "rod", number: ${rod} }), document.getElementById("chosen").textContent)`)));
  browser.expect(known[0].includes("not known") && !known[1].includes("not known"), `of the rods it says ${known}`);
  const tints = await browser.ask(`Array.from(tanorPage.scene.getObjectByName("rods").geometry.attributes.tint.array)`);
  browser.expect([0, 3].every((at) => tints[at] < 0) && tints[6] > 0, `the tints are ${tints}, negative ones are dashed`);
  const legend = await browser.ask(`document.getElementById("legend").textContent`);
  browser.expect(legend.includes("dashed: not known"), `the legend says ${legend}`);
  const { bins } = await readOverlay(browser);
  browser.expect(bins.filter((each) => each > 0).length === 1, `the histogram has the bars ${bins}`);
}

async function trySlack(browser, folder) {
  await browser.open(pathToFileURL(resolve(join(folder, "report.html"))).href);
  const look = (time) => browser.ask(`(() => {
    tanorPage.seek(tanorPage.${time});
    const parts = (name) => { const { a, b } = tanorPage.scene.getObjectByName(name).geometry.attributes; return [Array.from(a.array), Array.from(b.array)]; };
    const length = ([a, b]) => a.reduce((sum, _, k) => (k % 3 ? sum : sum + Math.hypot(...[0, 1, 2].map((axis) => b[k + axis] - a[k + axis]))), 0);
    return { slack: length(parts("slack")), taut: length(parts("ropes")), lowest: Math.min(...parts("slack")[1].filter((_, k) => k % 3 === 2)) };
  })()`);
  const first = await look("begin"), last = await look("end");
  browser.expect(Math.abs(first.slack - 1) < 0.03 && first.taut === 0 && first.lowest < -0.35, `at first the string is ${JSON.stringify(first)}`);
  browser.expect(Math.abs(last.taut - 1) < 1e-3 && last.slack === 0, `at the end the string is ${JSON.stringify(last)}`);
}

/** Milliseconds to place what an instant shows, without drawing it. */
const timeInstants = (browser) => browser.ask(`(() => {
  const count = 5, before = performance.now();
  for (let k = 0; k < count; ++k) tanorPage.seek(tanorPage.begin + (k / count) * (tanorPage.end - tanorPage.begin));
  return (performance.now() - before) / count;
})()`);

async function play(browser) {
  const before = await browser.ask("tanorPage.seek(tanorPage.begin); tanorPage.play(true); tanorPage.frames");
  const isSeen = await browser.wait(`tanorPage.frames >= ${before} + 3 && tanorPage.time > tanorPage.begin`, 60);
  browser.expect(isSeen, "three pictures take more than a minute while it plays");
  await browser.ask("tanorPage.play(false)");
}

const scale = takesPictures ? 1 : 0.5;
const browser = new Browser(chromium, { width: takesPictures ? 1440 : 960, height: takesPictures ? 1000 : 640, scale, isDark: !!process.env.TANOR_PAGE_DARK });
await tryInBrowser(browser, async () => {
  for (const trial of trials) {
    const [folder, switches, scene, begin] = trial.split(":");
    browser.about = `${basename(folder)}: `;
    if (switches.startsWith("~")) await tryRestPage(browser, folder, switches.slice(1));
    else if (switches === "!") {
      await tryGone(browser, folder);
      await browser.ask(`tanorPage.seek(tanorPage.begin), tanorPage.choose({ kind: "rod", number: 0 }, tanorPage.begin)`); // a long unit
      await tryWidths(browser);
      await tryNarrow(browser);
    }
    else if (switches === "_") await trySlack(browser, folder);
    else if (switches.startsWith("?")) await tryShared(browser, folder, Number(switches.slice(1)));
    else if (switches.startsWith("+")) await tryNames(browser, folder, switches.slice(1).split(","));
    else if (switches.startsWith("=")) await tryStoppedPage(browser, folder, switches.slice(1).split(","));
    else await tryPage(browser, { folder, switches: switches.split(","), scene, begin });
    if (basename(folder) === "pendulum") await tryObservables(browser, folder);
  }
}, 90 * trials.length);
