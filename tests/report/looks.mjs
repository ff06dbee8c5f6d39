// Trials of a page beside its numbers: views, files, the cell, and named numbers against observables.csv.
import { spawnSync } from "node:child_process";
import { existsSync, readFileSync, readdirSync, rmSync, statSync, writeFileSync } from "node:fs";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";

export const readData = (browser, what) => browser.ask(`JSON.parse(document.getElementById("data").textContent).${what}`);

const press = (browser, key) => browser.ask(`document.body.dispatchEvent(new KeyboardEvent("keydown", { key: "${key}", bubbles: true }))`);

/** The largest coordinate of the ends of rods and of the paths of supports in the picture, whose edges have 1, and how much of it they span. */
export const measureFill = (browser) => browser.ask(`(() => {
  tanorPage.camera.updateMatrixWorld();
  const { a, b } = tanorPage.scene.getObjectByName("rods").geometry.attributes, p = tanorPage.camera.position.clone(), least = [9, 9], most = [-9, -9], paths = [];
  tanorPage.scene.getObjectByName("supports").traverse((each) => each.isLine && paths.push(each.geometry.attributes.position));
  for (const places of [a, b, ...paths]) for (let k = 0; k < places.count; ++k)
    p.fromBufferAttribute(places, k).project(tanorPage.camera).toArray().slice(0, 2).forEach((x, axis) => {
      least[axis] = Math.min(least[axis], x); most[axis] = Math.max(most[axis], x);
    });
  return { largest: Math.max(...most, -least[0], -least[1]), span: Math.max(most[0] - least[0], most[1] - least[1]) / 2 };
})()`);

/** Buttons and keys look from where they say, and the mechanism fills the picture. */
export async function tryLooks(browser) {
  const looks = [[0, -1, 0], [1, 0, 0], [0, 0, 1], [1, -1, 1]];
  for (const [k, [dx, dy, dz]] of looks.entries())
    for (const by of ["key", "button"]) {
      await press(browser, looks.length - k); // from elsewhere
      if (by === "key") await press(browser, k + 1); else await browser.ask(`document.querySelectorAll("#looks button")[${k}].click()`);
      const [vx, vy, vz] = await browser.ask(`tanorPage.camera.getWorldDirection(tanorPage.camera.position.clone()).toArray()`);
      const cosine = -(vx * dx + vy * dy + vz * dz) / Math.hypot(dx, dy, dz), { largest } = await measureFill(browser);
      browser.expect(cosine > 0.999, `${by} ${k + 1} looks along ${[vx, vy, vz]}`);
      browser.expect(largest < 1, `${by} ${k + 1} leaves ${largest} of half the picture`);
    }
  await browser.ask(`document.getElementById("reset").click()`);
}

/** A click on a support, a rod and a rope draws its force over time, which is that of observables.csv. */
export async function tryClicks(browser, folder) {
  await browser.ask(`document.getElementById("fit").click(); scrollTo(0, 0)`);
  const [names, ...rows] = readTable(folder), column = (name) => names.findIndex((each) => each.startsWith(name));
  const things = [["point", "rods", 0, 0, "load of hook (point 0)", column("load(hook).z"), 4], ["rod", "rods", 1, 0.5, "tension of links[1] (2–3)", column("tension(links): links[1]"), 1],
    ["tie", "ropes", 0, 0.4, "tension of the rope winch[0]", column("tension(winch)"), 1]];
  for (const [kind, drawn, number, part, title, at, curve] of things) {
    const [x, y] = await browser.ask(`(() => {
      const { a, b } = tanorPage.scene.getObjectByName("${drawn}").geometry.attributes, box = document.getElementById("view").getBoundingClientRect(), p = tanorPage.camera.position.clone();
      p.fromBufferAttribute(a, ${number}).lerp(p.clone().fromBufferAttribute(b, ${number}), ${part}).project(tanorPage.camera);
      return [box.x + (box.width * (p.x + 1)) / 2, box.y + (box.height * (1 - p.y)) / 2];
    })()`);
    for (const type of ["mousePressed", "mouseReleased"]) await browser.call("Input.dispatchMouseEvent", { type, x, y, button: "left", clickCount: 1 });
    const isChosen = await browser.wait(`tanorPage.chosen.kind === "${kind}" && tanorPage.chosen.number === ${number}`, 5);
    browser.expect(isChosen, `a click on ${title} chooses ${JSON.stringify(await browser.ask("tanorPage.chosen"))}`);
    const shown = await browser.ask(`document.querySelector("#chosen h3").textContent`);
    browser.expect(shown === title, `the chart is of the ${shown}, not of the ${title}`);
    const data = await browser.ask("tanorPage.plots.at(-1).data");
    compareCurve(browser, title, data[0], data[curve], rows.map((row) => [row[0], row[at]]), 1e-4);
  }
}

/** The first row of observables.csv: names; the others: numbers, NaN where they are not known. */
export function readTable(folder) {
  const [head, ...rows] = readFileSync(join(folder, "observables.csv"), "utf8").trim().split("\n");
  return [head.match(/"([^"]|"")*"|[^,]+/g).map((name) => name.replace(/^"|"$/g, "")), ...rows.map((row) => row.split(",").map((cell) => (cell ? Number(cell) : NaN)))];
}

/** A curve goes through the rows of a table, time and number, at its own times, up to a part of the largest number. */
function compareCurve(browser, title, times, numbers, rows, part) {
  const wanted = new Map(rows), largest = Math.max(...rows.map(([, number]) => Math.abs(number)));
  const at = times.map((t, k) => [t, numbers[k]]).filter(([t]) => wanted.has(t));
  const worst = Math.max(...at.map(([t, number]) => Math.abs(number - wanted.get(t))));
  browser.expect(at.length > 10 && worst <= part * largest, `the curve of the ${title} differs by ${worst} of ${largest} at ${at.length} instants`);
}

/** The curve of a named number, as it is drawn, goes through the rows of observables.csv. */
export async function tryCurve(browser, folder) {
  const [[, name], ...rows] = readTable(folder), title = await browser.ask(`document.querySelector("#histories h3").textContent`);
  browser.expect(name.startsWith(title), `the first curve is of the ${title}, the first column is ${name}`);
  const [times, numbers] = await browser.ask("tanorPage.plots[0].data.slice(0, 2)");
  compareCurve(browser, title, times, numbers, rows, 1e-8);
  const places = rows.filter((_, k) => k % 5 === 2).map(([t, number]) => [t, number]), apart = 12;
  // The curve is blue; the axes, the grid and the bar of the time, which stands at the end, are not blue there.
  const strength = await browser.ask(`(() => {
    tanorPage.seek(tanorPage.end);
    const plot = tanorPage.plots[0], look = (x, y) => {
      const { data } = plot.ctx.getImageData(Math.round(x) - 2, Math.round(y) - 2, 5, 5);
      let most = 0;
      for (let k = 0; k < data.length; k += 4) most = Math.max(most, data[k + 3] ? data[k + 2] - data[k] : 0);
      return most;
    };
    return ${JSON.stringify(places)}.map(([t, number]) => { const x = plot.valToPos(t, "x", true), y = plot.valToPos(number, "y", true); return [look(x, y), Math.min(look(x, y - ${apart}), look(x, y + ${apart}))]; });
  })()`);
  browser.expect(places.length > 5 && strength.every(([on, off]) => on > 60 && off < on / 2), `the drawn curve of the ${title} is as blue as ${strength.join("; ")} at and beside its rows`);
}

/** What stands over the picture: texts with their places, and whether a pixel is painted. */
export const readOverlay = (browser) => browser.ask(`(() => {
  const texts = [], canvas = document.getElementById("overlay"), context = canvas.getContext("2d");
  context.fillText = (text, x, y) => { texts.push({ text, x, y }); CanvasRenderingContext2D.prototype.fillText.call(context, text, x, y); };
  tanorPage.render();
  delete context.fillText;
  const { clientWidth: width, clientHeight: height } = canvas, ratio = canvas.width / width, { data } = context.getImageData(0, 0, canvas.width, canvas.height);
  const pixel = (x, y) => { const at = 4 * (Math.floor(y * ratio) * canvas.width + Math.floor(x * ratio)); return Array.from(data.slice(at, at + 4)); };
  const column = (x, y) => { let k = 0; while (pixel(x, y - k)[3] > 127) ++k; return k; };
  const row = (x, y) => { let k = 0; while (pixel(x - k, y)[3] > 60) ++k; return k; };
  const { camera, target } = tanorPage, p = target.clone(), screen = (place) => { place.project(camera); return [(place.x * width) / 2, (-place.y * height) / 2]; };
  const right = p.clone().setFromMatrixColumn(camera.matrixWorld, 0), away = p.clone().copy(camera.position).distanceTo(target), step = 1e-4 * away;
  const middle = screen(target.clone()), moved = (axis) => screen(target.clone().addScaledVector(axis, step)).map((x, k) => (x - middle[k]) / step);
  return {
    texts, width, height, bar: row(width - 17, height - 16.5), pixelsPerMetre: moved(right)[0],
    bins: Array.from({ length: 25 }, (_, k) => column(16 + (Math.min(210, width - 32) * (k + 0.5)) / 25, 67)),
    axes: [0, 1, 2].map((axis) => moved(p.clone().set(0, 0, 0).setComponent(axis, 1))),
    colours: [0, 1, 2].map((axis) => { const [x, y] = moved(p.clone().set(0, 0, 0).setComponent(axis, 1)).map((each) => (14 * each) / moved(right)[0]); return pixel(44 + x, height - 44 + y); }),
  };
})()`);

/** The scale bar is as long as it says in the middle of the picture, and the axes point where those of the picture do. */
export async function tryOverlay(browser) {
  for (const key of [4, 1, 4]) {
    await press(browser, key);
    const { texts, bar, pixelsPerMetre, axes, colours, height } = await readOverlay(browser);
    const { length } = await readData(browser, "units"), { text } = texts.at(-1), metres = parseFloat(text);
    browser.expect(text.endsWith(length ? ` ${length}` : "") && /^[125]$/.test(String(metres.toExponential()).split("e")[0]), `the scale bar says ${text}`);
    browser.expect(Math.abs(bar - metres * pixelsPerMetre) < 4, `the scale bar of ${text} has ${bar} pixels, ${metres * pixelsPerMetre} are right`);
    for (const [axis, name] of ["x", "y", "z"].entries()) {
      const [dx, dy] = axes[axis].map((each) => (33 * each) / pixelsPerMetre), { x, y } = texts.find((each) => each.text === name);
      browser.expect(Math.hypot(x - 44 - dx, y - (height - 44) - dy - 4) < 1, `the letter ${name} stands at ${[x, y]}`);
      const strongest = colours[axis].slice(0, 3).indexOf(Math.max(...colours[axis].slice(0, 3)));
      browser.expect(Math.hypot(dx, dy) < 12 || (colours[axis][3] > 20 && strongest === axis), `the axis ${name} has the colour ${colours[axis]}`);
    }
    // And again nearer.
    await browser.ask(`tanorPage.camera.position.lerp(tanorPage.target, 0.4)`);
  }
  await browser.ask(`document.getElementById("fit").click()`);
}

/** The histogram counts the tensions of all rods between the ends of the colours, beyond which they belong to the last bars. */
export async function tryHistogram(browser, tensions) {
  const [least, most] = await readData(browser, "colours.tensions"), counts = new Array(25).fill(0), { bins, texts, width } = await readOverlay(browser);
  for (const tension of tensions) ++counts[Math.min(24, Math.max(0, Math.floor((25 * (tension - least)) / (most - least))))];
  const largest = Math.max(...counts), wanted = counts.map((count) => (40 * count) / largest);
  const { force } = await readData(browser, "units"), title = `tension of ${tensions.length === 1 ? "the rod" : `${tensions.length} rods`}${force ? `, ${force}` : ""}`;
  browser.expect(texts[0].text === title, `over the histogram stands ${texts[0].text}, not ${title}`);
  // Below the ends of the bar and, where it has both signs, below its middle stand their numbers.
  const all = (await readData(browser, "motion.ranges.tensions")).flat(), write = (x) => String(+x.toPrecision(4)).replace("-", "−"), wide = Math.min(210, width - 32);
  const labels = [[16, (Math.min(...all) < least && least < 0 ? "< " : "") + write(least)], ...(least < 0 && most > 0 ? [[16 + wide / 2, "0"]] : []), [16 + wide, (Math.max(...all) > most && most > 0 ? "> " : "") + write(most)]];
  const below = texts.slice(1, 1 + labels.length).map(({ text, x, y }) => [x, text, y > texts[0].y + 50]);
  browser.expect(JSON.stringify(below) === JSON.stringify(labels.map((each) => [...each, true])), `below the colours stand ${JSON.stringify(below)}, not ${JSON.stringify(labels)}`);
  // Packed numbers may fall into the neighbouring bar.
  const near = (k) => Math.abs(bins[k] - wanted[k]) < 3 + 0.02 * 40;
  browser.expect(counts.every((_, k) => near(k)), `the bars have ${bins} pixels, not ${wanted.map((each) => each.toFixed(1))}`);
}

/** What broke is drawn and chosen no more after its instant; what was let go is no support or guide from then on, and has no path and no arm. */
export async function tryGone(browser, folder) {
  await browser.open(pathToFileURL(resolve(join(folder, "report.html"))).href);
  const { rods: [[rod, broken]], supports: [[support, free]], guides, ties } = await readData(browser, "motion.gone"), { colours, motion } = await readData(browser, "run && JSON.parse(document.getElementById('data').textContent)");
  const rgb = (colour) => [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16) / 255), isNear = (x, y) => Math.hypot(...x.map((each, k) => each - y[k])) < 1e-2;
  browser.expect(motion.pivots.length === 1 && isNear(motion.pivots[0], [support, -0.5, 0, 0]), `the crank turns about ${JSON.stringify(motion.pivots)}`);
  const marks = await browser.ask(`Array.from(document.querySelectorAll("#marks .event"), (each) => getComputedStyle(each).backgroundColor)`);
  browser.expect(marks.length === 8 && marks.every((colour) => /^rgb\(/.test(colour)), `events are marked by ${marks}`);
  const times = await readData(browser, "events.map((event) => event.t)");
  browser.expect(times.length >= marks.length && times.every((time, k) => k === 0 || time >= times[k - 1]), `events are listed at ${times} s`);
  const see = (time) => browser.ask(`(() => {
    tanorPage.choose({ kind: "rod", number: ${rod} });
    tanorPage.seek(${time});
    tanorPage.render();
    const part = (name) => tanorPage.scene.getObjectByName(name).geometry.attributes, length = ({ a, b }, k) => Math.hypot(...[0, 1, 2].map((axis) => b.array[3 * k + axis] - a.array[3 * k + axis]));
    const fixed = []; tanorPage.scene.getObjectByName("supports").traverse((each) => (each.isLine || each.count) && fixed.push(each.isLine ? "path" : "foot"));
    const guides = tanorPage.scene.getObjectByName("guides").children.map(({ name }) => name).join(), ropes = part("ropes");
    return { ropes: Array.from({ length: ropes.a.count }, (_, k) => length(ropes, k)), rods: Array.from({ length: ${motion.rods} }, (_, k) => length(part("rods"), k)), arm: length(part("arms"), 0), fixed: fixed.join(), guides,
      tint: Array.from(part("points").tint.array.slice(${3 * support}, ${3 * support + 3})), words: document.getElementById("tension").textContent };
  })()`);
  browser.expect(ties.length === 3 && guides.length === 3, `${ties.length} ties and ${guides.length} guides go`);
  for (const time of [broken, free, ...[...ties, ...guides].map(([, since]) => since)].flatMap((since) => [since - 1e-3, since + 1e-3])) {
    const seen = await see(time), [isThere, isHeld] = [time < broken, time < free], at = `at ${time} s, where the rod breaks at ${broken} s and the crank is free at ${free} s,`;
    browser.expect(seen.rods.every((length, k) => (length > 0.1) === (k !== rod || isThere)), `${at} the rods are ${seen.rods} m long`);
    browser.expect(seen.words.startsWith("gone since") === !isThere && Number.isFinite(parseFloat(seen.words)) === isThere, `${at} stands ${seen.words}`);
    const holding = (list, gone) => list.map(({ name }) => name).filter((_, k) => !gone.some(([number, since]) => number === k && since <= time));
    browser.expect(seen.guides === holding(motion.guides, guides).join(), `${at} the guides ${seen.guides} are drawn, ${JSON.stringify(guides)} go`);
    // The ribbons of each tie stand one after the other: its course, and the wheels of its sheaves.
    const drawn = motion.ties.filter(({ kind, points, sheaves }) => seen.ropes.splice(0, kind === "spring" ? 16 : points.length + sheaves.length - 1 + 32 * sheaves.length).some((length) => length > 0));
    browser.expect(drawn.map(({ name }) => name).join() === holding(motion.ties, ties).join(), `${at} ${drawn.map(({ name }) => name)} are drawn, ${JSON.stringify(ties)} go`);
    browser.expect(isNear(seen.tint, rgb(isHeld ? colours.support : colours.bead)), `${at} the crank is painted ${seen.tint}`);
    browser.expect((Math.abs(seen.arm - 0.5) < 1e-3) === isHeld && seen.fixed.includes("path") === isHeld, `${at} the arm has ${seen.arm} m, and there are ${seen.fixed}`);
  }
}

/** Where the time has no room beside the title of the colours, it stands below them. */
export async function tryNarrow(browser) {
  await browser.setWidth(320);
  const { texts } = await readOverlay(browser), time = texts.find(({ text }) => text.startsWith("t = "));
  browser.expect(time.y - texts[0].y > 60, `"${time.text}" stands ${time.y - texts[0].y} pixels below "${texts[0].text}"`);
  await browser.setWidth();
}

/** The picture fills the screen, and comes back. */
export async function tryFullScreen(browser) {
  const size = () => browser.ask(`[document.querySelector("#view canvas").clientWidth, document.querySelector("#view canvas").clientHeight]`), [, before] = await size();
  const toggle = (expression) => browser.call("Runtime.evaluate", { expression, userGesture: true, awaitPromise: true });
  for (const expression of [`document.getElementById("full").click()`, `document.body.dispatchEvent(new KeyboardEvent("keydown", { key: "g", bubbles: true }))`]) {
    await toggle(expression);
    const isFull = await browser.wait(`document.fullscreenElement?.id === "stage" && document.querySelector("#view canvas").clientHeight > innerHeight - 140`, 10);
    browser.expect(isFull, `${expression}: the picture has ${await size()} pixels, not the screen (${before} before)`);
    await toggle(expression);
    browser.expect(await browser.wait(`!document.fullscreenElement && document.querySelector("#view canvas").clientHeight === ${before}`, 10), `the picture stays ${await size()}`);
  }
}

/** Each support that stands has ground beneath it, and one that moves has its path; ropes pass their sheaves. */
export async function compareFixtures(browser, motion, positions) {
  const { feet, paths, ropes } = await browser.ask(`(() => {
    const list = (places) => Array.from({ length: places.count }, (_, k) => [0, 1, 2].map((axis) => places.array[3 * k + axis])), all = [], supports = tanorPage.scene.getObjectByName("supports");
    supports.traverse((each) => all.push(each));
    const { a, b } = tanorPage.scene.getObjectByName("ropes").geometry.attributes;
    return { feet: all.filter((each) => each.isInstancedMesh).flatMap((each) => Array.from({ length: each.count }, (_, k) => Array.from(each.instanceMatrix.array.slice(16 * k + 12, 16 * k + 15)))),
      paths: all.filter((each) => each.isLine).map((each) => list(each.geometry.attributes.position)), ropes: [list(a), list(b)] };
  })()`);
  const size = await browser.ask("tanorPage.size"), place = (k) => positions.slice(3 * k, 3 * k + 3), away = (a, b) => Math.hypot(...a.map((x, axis) => x - b[axis]));
  browser.expect(feet.length + paths.length === motion.supports.length, `${feet.length} feet and ${paths.length} paths of ${motion.supports.length} supports are drawn`);
  for (const point of motion.supports) {
    const isOnPath = paths.some((path) => away(path.at(-1), place(point)) < 1e-3 * size);
    browser.expect(isOnPath || feet.some((foot) => away(foot, place(point)) < 0.05 * size), `neither ground nor a path is drawn at support ${point}`);
  }
  let k = 0;
  for (const { kind, name, points, sheaves } of motion.ties) {
    const [first, ...rest] = points.map(place), course = [first, ...sheaves, ...rest];
    if (kind === "spring") {
      // A coil from end to end, whose turns stand by a twentieth of its length around the line between them.
      const parts = 16, [a, b] = ropes.map((list) => list.slice(k, k + parts)), long = away(first, rest[0]), about = a.map((turn, part) => away(turn, first.map((x, axis) => x + (part / parts) * (rest[0][axis] - x))) / long);
      browser.expect(a.length === parts && away(a[0], first) + away(b.at(-1), rest[0]) < 1e-3 * size && a.slice(1).every((from, part) => away(from, b[part]) < 1e-6 * size), `the spring ${name} does not go from ${first} to ${rest[0]}`);
      browser.expect(about.slice(1).every((each) => each > 0.04 && each < 0.051), `the turns of ${name} stand ${about} of its length off`);
      k += parts;
      continue;
    }
    const worst = Math.max(...course.slice(1).map((to, part) => Math.max(away(ropes[0][k + part], course[part]), away(ropes[1][k + part], to))));
    browser.expect(worst < 1e-3 * size, `the rope ${name} is drawn ${worst} m from where it is`);
    k += course.length - 1;
    const wheels = sheaves.map((middle, sheave) => ropes[0].slice(k + 32 * sheave, k + 32 * sheave + 32).map((rim) => away(rim, middle)));
    browser.expect(wheels.every((rim) => Math.min(...rim) > 0 && Math.max(...rim) < 1.01 * Math.min(...rim)), `the sheaves of ${name} are no wheels`);
    k += 32 * sheaves.length;
  }
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
  const [screen, { drawn }] = [await browser.ask(`(({ width, height }) => [width, height])(document.querySelector("#view canvas"))`), await browser.countPixels()];
  await browser.ask(`document.getElementById("png").click()`);
  const png = await wait(".png");
  const picture = look(browser, png, "png"), [wide, high] = screen.map((side) => side & ~1);
  browser.expect(picture.width === wide && picture.height === high, `the picture has ${picture.width} x ${picture.height} pixels, the screen ${screen}`);
  const [bar] = picture.frames, paper = (byte) => byte > 250;
  browser.expect(bar && bar.filter((byte) => !paper(byte)).length > drawn, `the picture lacks some of ${drawn} pixels and of what stands over them`);
  browser.expect(bar && !paper(bar[wide * Math.round(high * (1 - 16.5 / (await heightOf(browser)))) + wide - Math.round(20 * (wide / (await widthOf(browser))))]), "the picture has no scale bar");
  if (await browser.ask(`document.getElementById("film").hidden`)) {
    // There is nothing to record, and nothing is.
    await press(browser, "v");
    await browser.ask("new Promise((go) => setTimeout(go, 1500))");
    return browser.expect(!readdirSync(into).some((each) => each.endsWith(".webm")), "a video of what never moves is saved");
  }
  await browser.ask(`document.getElementById("speed").selectedIndex = 3; document.getElementById("speed").dispatchEvent(new Event("change")); document.getElementById("film").click()`);
  const { width, height, frames } = look(browser, await wait(".webm"), "webm");
  browser.expect(await browser.ask("tanorPage.time === tanorPage.end"), "the video ends before the motion");
  browser.expect(width === wide && height === high && frames.length > 5, `the video has ${frames.length} pictures of ${width} x ${height} pixels`);
  const differ = (a, b) => a.filter((byte, k) => Math.abs(byte - b[k]) > 40).length, dark = frames.map((frame) => frame.filter((byte) => byte < 200).length);
  browser.expect(Math.min(...dark) > 0.3 * drawn, `the pictures of the video have ${dark} dark pixels, ${drawn} are drawn`);
  browser.expect(Math.max(...frames.map((frame) => differ(frame, frames[0]))) > 0.2 * drawn, "nothing moves in the video");
}

const widthOf = (browser) => browser.ask(`document.getElementById("view").clientWidth`), heightOf = (browser) => browser.ask(`document.getElementById("view").clientHeight`);

/** Pictures of a file in grey, as ffmpeg reads them; ffprobe tells their size and number. */
function look(browser, file, kind) {
  const probe = spawnSync("ffprobe", ["-v", "error", "-count_frames", "-select_streams", "v", "-show_entries", "stream=width,height,nb_read_frames", "-of", "csv=p=0", file], { encoding: "utf8" });
  browser.expect(!probe.error && probe.status === 0, `ffprobe says of the ${kind}: ${probe.error ?? probe.stderr}`);
  const [width, height, count] = (probe.stdout ?? "").split(",").map(Number);
  const read = spawnSync("ffmpeg", ["-v", "error", "-i", file, "-vsync", "passthrough", "-f", "rawvideo", "-pix_fmt", "gray", "-"], { maxBuffer: 2 ** 30 });
  const frames = Array.from({ length: read.stdout.length / (width * height) }, (_, k) => read.stdout.subarray(k * width * height, (k + 1) * width * height));
  browser.expect(frames.length === count, `ffmpeg reads ${frames.length} of ${count} pictures of the ${kind}`);
  return { width, height, frames };
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
  await browser.ask(`document.getElementById("show-wrapped").click(); document.getElementById("show-cell").click(); tanorPage.seek(tanorPage.begin)`);
  const whole = (await browser.countPixels()).drawn;
  const cut = async (axis, middle, width) => {
    await browser.ask(`for (const [id, value] of Object.entries({ slice: "${axis}", "slab-at": ${middle}, "slab-width": ${width} })) { const field = document.getElementById(id); field.value = value; field.dispatchEvent(new Event("input")); }`);
    return (await browser.countPixels()).drawn;
  };
  // Rows of dumbbells along x stand at y = 0.3, 1.3, 2.3 and at z = 0.5 of 3 m, around the middle of all of them.
  const [low, high] = await browser.ask(`(() => { const { b, a } = tanorPage.scene.getObjectByName("rods").geometry.attributes, all = Array.from(a.array).concat(Array.from(b.array)).filter((_, k) => k % 3 === 1); return [Math.min(...all), Math.max(...all)]; })()`);
  const [row, gap, level, all] = [await cut(1, (1.3 - low) / (high - low), 0.1), await cut(1, (0.8 - low) / (high - low), 0.1), await cut(2, 0.5, 0.1), await cut(1, 0.5, 1)];
  browser.expect(row > 0.15 * whole && row < 0.6 * whole, `a slice along a row has ${row} of ${whole} pixels`);
  browser.expect(gap === 0, `a slice between two rows has ${gap} pixels`);
  browser.expect(level === whole && all > 0.9 * whole, `slices of all there is have ${level} and ${all} of ${whole} pixels`);
  browser.expect(await cut("", 0.5, 1) === whole, "without a slice some is left out");
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
  browser.expect(cards[0] === "torque of <the motor> 10 100 least 0 N m at 0 s in links[3], largest 100 N m at 10 s" && cards[1].startsWith("tension(links) 10 100 -10 at output times: least") && cards[2].startsWith("Energy"), `the histories are ${cards.join("; ")}`);
  browser.expect(await browser.ask(`!document.getElementById("csv").hidden && !document.getElementById("computed").open`), "observables.csv is not named, or the computation is not folded");
}

/** Curves of named numbers are at the frames those of observables.csv (between few frames there are steps, too), and the first card tells the one at the time of the view. */
export async function compareObservables(browser, folder) {
  if (!existsSync(join(folder, "observables.csv"))) return;
  const [, ...rows] = readTable(folder);
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
