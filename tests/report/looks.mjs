// Trials of a page beside its numbers: views, files, the cell, and named numbers against observables.csv.
import { spawnSync } from "node:child_process";
import { existsSync, readFileSync, readdirSync, rmSync, statSync, writeFileSync } from "node:fs";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";

export const readData = (browser, what) => browser.ask(`JSON.parse(document.getElementById("data").textContent).${what}`);

/** A click on a support chooses it; buttons and keys look from where they say, and the mechanism fills the picture. */
export async function tryLooks(browser) {
  const where = `(() => {
    const { a } = tanorPage.scene.getObjectByName("rods").geometry.attributes, box = document.getElementById("view").getBoundingClientRect();
    const p = tanorPage.camera.position.clone().fromBufferAttribute(a, 0).project(tanorPage.camera);
    return [box.x + (box.width * (p.x + 1)) / 2, box.y + (box.height * (1 - p.y)) / 2];
  })()`;
  await browser.ask(`document.getElementById("fit").click(); tanorPage.choose({ kind: "rod", number: 1 }); scrollTo(0, 0)`);
  const [x, y] = await browser.ask(where);
  for (const type of ["mousePressed", "mouseReleased"]) await browser.call("Input.dispatchMouseEvent", { type, x, y, button: "left", clickCount: 1 });
  browser.expect(await browser.wait(`tanorPage.chosen.kind === "point"`, 5), `a click on a support chooses ${JSON.stringify(await browser.ask("tanorPage.chosen"))}`);
  const looks = { 1: [0, -1, 0], 2: [1, 0, 0], 3: [0, 0, 1], 4: [1, -1, 1] };
  for (const [key, [dx, dy, dz]] of Object.entries(looks)) {
    await browser.ask(`document.body.dispatchEvent(new KeyboardEvent("keydown", { key: "${key}", bubbles: true }))`);
    const [vx, vy, vz] = await browser.ask(`tanorPage.camera.getWorldDirection(tanorPage.camera.position.clone()).toArray()`);
    const cosine = -(vx * dx + vy * dy + vz * dz) / Math.hypot(dx, dy, dz);
    browser.expect(cosine > 0.999, `key ${key} looks along ${[vx, vy, vz]}`);
    const inside = await browser.ask(`(() => {
      const places = tanorPage.scene.getObjectByName("rods").geometry.attributes.a, p = tanorPage.camera.position.clone();
      return Math.max(...Array.from({ length: places.count }, (_, k) => { p.fromBufferAttribute(places, k).project(tanorPage.camera); return Math.max(Math.abs(p.x), Math.abs(p.y)); }));
    })()`);
    browser.expect(inside < 1, `key ${key} leaves ${inside} of half the picture`);
  }
  await browser.ask(`document.getElementById("reset").click()`);
}

/** The picture and the video are files that other programs read. */
export async function tryFiles(browser, folder) {
  const into = join(resolve(folder), "saved");
  rmSync(into, { recursive: true, force: true });
  await browser.call("Page.setDownloadBehavior", { behavior: "allow", downloadPath: into });
  const wait = async (ending) => {
    for (let k = 0; k < 600; ++k, await new Promise((go) => setTimeout(go, 100))) {
      const name = existsSync(into) && readdirSync(into).find((each) => each.endsWith(ending));
      if (name && statSync(join(into, name)).size > 0) return join(into, name);
    }
    throw new Error(`no file ${ending} is saved`);
  };
  await browser.ask(`document.getElementById("png").click()`);
  const png = readFileSync(await wait(".png"));
  browser.expect(png.subarray(1, 4).toString() === "PNG" && png.length > 5000, `the picture has ${png.length} bytes`);
  await browser.ask(`document.getElementById("speed").selectedIndex = 3; document.getElementById("speed").dispatchEvent(new Event("change")); document.getElementById("film").click()`);
  const video = await wait(".webm"), bytes = readFileSync(video);
  browser.expect(await browser.ask("tanorPage.time === tanorPage.end"), "the video ends before the motion");
  browser.expect(bytes.readUInt32BE(0) === 0x1a45dfa3 && bytes.length > 5000, `the video has ${bytes.length} bytes`);
  const probe = spawnSync("ffprobe", ["-v", "error", "-count_frames", "-select_streams", "v", "-show_entries", "stream=nb_read_frames", "-of", "csv=p=0", video], { encoding: "utf8" });
  browser.expect(!probe.error && probe.status === 0 && parseInt(probe.stdout) > 5, `ffprobe says: ${probe.stdout}${probe.stderr}`);
}

/** Wrapped, all points are in the cell, and rods stay as long as they are; a slice leaves some of what is drawn. */
export async function tryCell(browser) {
  const look = `(() => { const { a, b } = tanorPage.scene.getObjectByName("rods").geometry.attributes;
    const length = (k) => Math.hypot(...[0, 1, 2].map((axis) => a.array[3 * k + axis] - b.array[3 * k + axis]));
    const spread = (axis) => { const all = Array.from({ length: a.count }, (_, k) => a.array[3 * k + axis]); return Math.max(...all) - Math.min(...all); };
    return { longest: Math.max(...Array.from({ length: a.count }, (_, k) => length(k))), spread: [0, 1, 2].map(spread) }; })()`;
  const [[side]] = await readData(browser, "motion.cell.edges"), wrapped = await browser.ask(look);
  browser.expect(wrapped.spread.every((each) => each <= side), `wrapped points are spread over ${wrapped.spread} in a cell of ${side}`);
  await browser.ask(`document.getElementById("show-wrapped").click()`);
  const free = await browser.ask(look);
  browser.expect(free.spread[0] > side && Math.abs(free.longest - wrapped.longest) < 1e-3 * side, `unwrapped: ${JSON.stringify(free)}, wrapped: ${JSON.stringify(wrapped)}`);
  const before = await browser.countPixels();
  await browser.ask(`(() => { const axis = document.getElementById("slice"); axis.value = "0"; axis.dispatchEvent(new Event("input")); })()`);
  const { drawn } = await browser.countPixels();
  browser.expect(drawn > 0 && drawn < before.drawn, `a slice has ${drawn} of ${before.drawn} pixels`);
}

/** Named numbers stand before all other histories, with their values at the time of the view. */
export async function tryObservables(browser, folder) {
  const page = readFileSync(join(folder, "report.html"), "utf8"), copy = join(folder, "observed.html");
  const t = Array.from({ length: 50 }, (_, k) => 10 * k / 49), rows = t.map((each) => [each * each, -each]);
  const extremes = { least: [{ value: 0, t: 0, member: "links[3]" }], largest: [{ value: 100, t: 10, member: "" }] };
  const observables = [{ name: "torque of <the motor>", observable: "moment(crank, z)", unit: "N m", parts: [], members: [], ...extremes, t, rows: rows.map(([each]) => [each]) },
    { name: "tension(links)", observable: "tension(links)", unit: "", parts: [], members: ["links[0]", "links[1]"], ...extremes, t, rows }];
  writeFileSync(copy, page.replace('"events_seen":', `"observables":${JSON.stringify(observables).replaceAll("<", "\\u003c")},"events_seen":`));
  await browser.open(pathToFileURL(resolve(copy)).href);
  await browser.ask("tanorPage.seek(tanorPage.end)");
  const cards = await browser.ask(`Array.from(document.querySelectorAll("#histories .card"), (card) => [card.querySelector("h3").textContent, ...Array.from(card.querySelectorAll(".u-value, .hint"), (each) => each.textContent)].join(" "))`);
  browser.expect(cards[0] === "torque of <the motor> 10 100 least 0 N m at 0 s in links[3], largest 100 N m at 10 s" && cards[1].startsWith("tension(links) 10 100 -10 least") && cards[2].startsWith("Energy"), `the histories are ${cards.join("; ")}`);
  browser.expect(await browser.ask(`!document.getElementById("csv").hidden && !document.getElementById("computed").open`), "observables.csv is not named, or the computation is not folded");
}

/** Curves of named numbers are at the frames those of observables.csv (between few frames there are steps, too), and the first card tells the one at the time of the view. */
export async function compareObservables(browser, folder) {
  const table = join(folder, "observables.csv");
  if (!existsSync(table)) return;
  const [, ...rows] = readFileSync(table, "utf8").trim().split("\n").map((row) => row.split(",").map(Number));
  const wanted = new Map(rows.map(([t, ...numbers]) => [t, numbers])), curves = await readData(browser, "observables");
  const frames = [...curves[0].t.entries()].filter(([, t]) => wanted.has(t));
  browser.expect(frames.length > 1, `${frames.length} frames of observables.csv are in the page`);
  for (const [k, t] of frames) {
    const shown = curves.flatMap((curve) => curve.rows[k].flat()), numbers = wanted.get(t);
    const largest = Math.max(...numbers.map(Math.abs));
    browser.expect(shown.length === numbers.length && shown.every((number, i) => Math.abs(number - numbers[i]) <= 1e-8 * largest), `at ${t} s the page has ${shown}, observables.csv ${numbers}`);
  }
  const [t, number] = rows[rows.length >> 1];
  await browser.ask(`tanorPage.seek(${t})`);
  const told = Number(await browser.ask(`document.querySelectorAll("#histories .card .u-value")[1].textContent`));
  browser.expect(Math.abs(told - number) <= 1e-3 * Math.abs(number), `the first card tells ${told} at ${t} s, observables.csv ${number}`);
}
