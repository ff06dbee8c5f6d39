import { Charts, addDiagnostics, addHistories } from "./charts";
import { admit, chartOf, fillKinds, fillTable, listForces, listObserved, tellPushed } from "./chosen";
import { Swing, countRopes, frames_of_period, measure, readPage, units, unpack, words, type Arrays, type PageData, type Rows } from "./data";
import { find, make } from "./dom";
import { fillDetails, fillHeadline } from "./facts";
import { Film, save } from "./files";
import { follow } from "./follow";
import { Overlay } from "./overlay";
import { Stage, type Look } from "./stage";
import { View, parts, type Chosen } from "./view";

const looks: [Look, string][] = [["front", "Front"], ["side", "Side"], ["top", "Top"], ["isometric", "Isometric"]];

/** The page of one run, which is shown again for each newer state of the run. */
class Page {
  private stage: Stage | null = null; // null if the browser cannot draw
  private view: View | null = null;
  private overlay!: Overlay;
  private charts: Charts[] = []; // of the mechanism, of the computation once they are looked at
  private chosenChart: Charts | null = null;
  private data!: PageData;
  private arrays!: Arrays;
  private chosen: Chosen | null = null;
  private mode = 0;
  private time = 0;
  private timeOfNumbers = NaN; // time of the words beside the picture
  private plays = false;
  private speed = 1;
  private before = 0; // ms, time of the last picture while it plays
  private isDirty = true;
  private film: { film: Film; canvas: HTMLCanvasElement } | null = null;
  private frames = 0;
  firstPicture = 0; // ms

  constructor() {
    try {
      this.stage = new Stage(find("view"), () => (this.isDirty = true));
    } catch {
      find("view").append(make("p", "This browser offers no WebGL 2, so the motion cannot be drawn here. All numbers below are complete; trajectory.pvd beside this page opens in ParaView, trajectory.xyz in OVITO.", "missing"));
    }
    this.listen();
  }

  /** Shows a state of the run. The eye, what is chosen and the time stay, except that a view at the end moves to the new end. */
  async show(data: PageData, packed: string): Promise<void> {
    const isFirst = !this.data, wasAtEnd = !isFirst && this.time >= this.end && !this.plays;
    this.arrays = await unpack(data.motion, packed);
    this.data = data;
    Object.assign(units, data.units);
    const { normal, tangent, ground: paper } = data.colours;
    for (const [name, colour] of Object.entries({ normal, tangent, paper })) document.documentElement.style.setProperty(`--${name}`, colour);
    fillHeadline(data);
    fillDetails(data, (time) => this.seek(time));
    const hasMotion = data.motion.times.length > 0;
    find("moving").hidden = find("histories-part").hidden = !hasMotion; // the warnings say why
    if (!hasMotion) return;
    if (data.modes) this.fillModes(data.modes);
    this.fillAside();
    this.showMotion(isFirst ? (data.run.is_running ? Infinity : -Infinity) : wasAtEnd ? Infinity : this.time, isFirst);
    if (isFirst) this.firstPicture = performance.now();
    this.fillCharts();
  }

  /** Shows the frames, or the period of a mode about the one frame, at a time. */
  private showMotion(time: number, looksAnew: boolean): void {
    const { data: { motion, modes, colours }, arrays } = this;
    if (modes) {
      const omega = modes.omega[this.mode], period = omega > 0 ? (2 * Math.PI) / omega : 1;
      motion.times = Array.from({ length: frames_of_period + 1 }, (_, k) => (k * period) / frames_of_period);
      arrays.positions = new Swing(this.rest ??= arrays.positions as Rows, arrays.shapes, this.mode);
    }
    this.overlay = new Overlay(colours, [Math.min(...motion.ranges.tensions.map(([least]) => least)), Math.max(...motion.ranges.tensions.map(([, most]) => most))]);
    if (this.stage) {
      this.view?.dispose();
      this.view = new View(this.stage, motion, arrays, colours);
      for (const part of parts) this.view.shows[part] = find<HTMLInputElement>(`show-${part}`).checked;
    }
    this.fillMarks();
    this.fillSpeed();
    this.choose(this.chosen ?? { kind: motion.rods ? "rod" : countRopes(motion) ? "tie" : "point", number: this.view?.findStrongest(this.end) ?? 0 }, time);
    this.slice();
    if (looksAnew) this.view?.look("best");
    this.draw();
  }
  private rest: Rows | null = null;

  private get begin(): number { return this.data.motion.times[0] ?? 0; }
  private get end(): number { return this.data.motion.times.at(-1) ?? 0; }

  /** Draws what has changed; called for every picture of the screen. */
  tick(now: number): void {
    if (this.plays) {
      const passed = this.before > 0 ? now - this.before : 0;
      this.before = now;
      this.stand(this.time + (this.natural() * this.speed * passed) / 1000);
      if (Math.abs(this.time - this.timeOfNumbers) > 0.15 * this.natural() * this.speed) this.settle();
      if (this.time >= this.end) this.arrive();
    }
    if (this.isDirty) this.draw();
  }

  /** A mode swings on, a motion ends. */
  private arrive(): void {
    if (this.data.modes && !this.film) return this.stand(this.begin);
    this.play(false);
    this.roll(false);
  }

  private draw(): void {
    this.isDirty = false;
    ++this.frames;
    if (!this.view || !this.stage) return;
    this.view.render();
    const over = find<HTMLCanvasElement>("overlay"), { clientWidth: width, clientHeight: height } = this.stage.host, { domElement: drawn } = this.stage.renderer;
    if (over.width !== drawn.width || over.height !== drawn.height) [over.width, over.height] = [drawn.width, drawn.height];
    const context = over.getContext("2d")!;
    context.setTransform(over.width / width, 0, 0, over.height / height, 0, 0);
    context.clearRect(0, 0, width, height);
    this.overlay.paint(context, width, height, { time: this.end > this.begin && !this.data.modes ? `t = ${words(this.time, units.time)}` : "", tensions: this.view.tensions, hasUnknown: this.view.hasUnknown, camera: this.stage.camera, pixelsPerMetre: this.stage.pixelsPerMetre });
    if (this.film) this.compose(this.film.canvas);
  }

  /** Puts the picture and what stands over it into a canvas; only right after it is drawn. */
  private compose(canvas: HTMLCanvasElement): HTMLCanvasElement {
    const context = canvas.getContext("2d")!, { domElement: drawn } = this.stage!.renderer;
    context.fillStyle = this.data.colours.ground;
    context.fillRect(0, 0, canvas.width, canvas.height);
    for (const layer of [drawn, find<HTMLCanvasElement>("overlay")]) context.drawImage(layer, 0, 0, canvas.width, canvas.height);
    return canvas;
  }

  private makeCanvas(): HTMLCanvasElement {
    const { width, height } = this.stage!.renderer.domElement;
    return Object.assign(document.createElement("canvas"), { width: width & ~1, height: height & ~1 }); // videos have even sides
  }

  private get fileName(): string { return this.data.run.scene.replace(/[^\p{L}\p{N}]+/gu, "-").slice(0, 60) || "tanor"; }

  private savePicture(): void {
    if (!this.stage) return;
    this.draw();
    this.compose(this.makeCanvas()).toBlob((png) => png && save(png, `${this.fileName}.png`));
  }

  /** Begins a video of the motion from its begin, or ends it. */
  private roll(on: boolean): void {
    if (!this.stage || on === !!this.film || find("film").hidden) return;
    find("film").textContent = on ? "Stop" : "Video";
    if (on) {
      const canvas = this.makeCanvas();
      this.seek(this.begin);
      this.film = { canvas, film: new Film(canvas, this.fileName) };
      this.play(true);
    } else {
      this.film!.film.stop();
      this.film = null;
      this.play(false);
    }
  }

  seek(time: number): void { this.stand(time); this.settle(); }

  choose(wanted: Chosen, time = this.time): void {
    const { motion, events } = this.data, chosen = admit(wanted, motion, this.arrays);
    this.chosen = chosen;
    if (this.view) this.view.chosen = chosen;
    find<HTMLSelectElement>("kind").value = chosen.kind;
    find<HTMLInputElement>("rod").value = String(chosen.number);
    this.chosenChart?.dispose();
    this.chosenChart = new Charts(find("chosen"), events, (to) => this.seek(to), 150);
    if (!find("chosen-part").hidden && !this.data.modes) this.chosenChart.add(chartOf(chosen, motion, this.arrays));
    this.seek(time);
  }

  play(on: boolean): void {
    if (on && this.time >= this.end) this.stand(this.begin);
    this.plays = on;
    this.before = 0;
    find("play").textContent = on ? "Pause" : "Play";
    if (!on) this.settle();
  }

  /** The state that tests read. */
  get hooks() {
    const page = this;
    return {
      get begin() { return page.begin; },
      get end() { return page.end; },
      get time() { return page.time; },
      get firstPicture() { return page.firstPicture; },
      get frames() { return page.frames; },
      get run() { return page.data.run; },
      get chosen() { return page.chosen; },
      get plots() { return [...page.charts, page.chosenChart].flatMap((each) => each?.plots ?? []); },
      seek: (time: number) => page.seek(time),
      choose: (chosen: Chosen) => page.choose(chosen),
      play: (on: boolean) => page.play(on),
      get held() { return page.arrays.held; },
      get rods() { return page.arrays.rods; },
      get camera() { return page.stage?.camera; },
      get target() { return page.stage?.controls.target; },
      get scene() { return page.view?.scene; },
      get size() { return page.view?.size; },
      render: () => page.draw(),
      tension: (rod: number) => page.view?.tensions[rod],
    };
  }

  /** Returns the seconds of motion per second at speed "1": round, so that the whole motion takes 6 to 20 seconds or somewhat longer, a period 1.5. */
  private natural(): number {
    const wanted = (this.end - this.begin) / (this.data.modes ? 1.5 : Math.min(20, Math.max(6, this.data.motion.times.length / 12)));
    const power = 10 ** Math.floor(Math.log10(wanted));
    return wanted > 0 ? power * [5, 2, 1].find((digit) => wanted >= 0.999 * digit * power)! : 0;
  }

  private stand(time: number): void {
    this.time = Math.min(this.end, Math.max(this.begin, time));
    this.view?.stand(this.time);
    this.isDirty = true;
  }

  private settle(): void {
    this.timeOfNumbers = this.time;
    find("clock").textContent = `${words(this.time, units.time)} of ${words(this.end, units.time)}`;
    find<HTMLInputElement>("time").value = String(this.end > this.begin ? (this.time - this.begin) / (this.end - this.begin) : 0);
    if (this.view && this.chosen) {
      find("tension").textContent = this.view.tellForce(this.chosen);
      if (this.data.motion.rods) tellPushed(this.view, this.data.motion, this.arrays, (number) => this.choose({ kind: "rod", number }));
      this.tellTensions(this.view);
    }
    for (const each of [...this.charts, this.chosenChart]) each?.stand(this.time);
  }

  /** The words of the colours and of the histogram, for those who do not see them. */
  private tellTensions({ tensions, hasUnknown }: View): void {
    const least = tensions.reduce((a, b) => (b < a ? b : a), Infinity), most = tensions.reduce((a, b) => (b > a ? b : a), -Infinity), ends = make("div", "", "ends");
    ends.append(...this.overlay.bounds.map((bound) => make("span", bound)));
    find("legend").replaceChildren(make("div", `${measure("colours of tensions of rods", units.force)}, from pushed to pulled, with a histogram; now from ${words(least)} to ${words(most, units.force)}${hasUnknown ? "; dashed: not known" : ""}`), ends);
    find("legend").hidden = !tensions.length;
  }

  private fillAside(): void {
    const { motion } = this.data, held = this.arrays.held.length > 0;
    const hide = (part: string, isHidden: boolean) => (find(`show-${part}`).parentElement!.hidden = isHidden);
    hide("tangent", !held || !motion.has_friction);
    hide("normal", !held);
    hide("rods", !motion.rods);
    hide("guides", !motion.guides.length && !motion.ties.length);
    for (const part of ["cell", "wrapped"]) hide(part, !motion.cell);
    find("rods-part").hidden = !motion.rods || this.data.colours.tensions[0] === 0;
    fillKinds(motion, this.arrays);
    const isAtRest = motion.times.length === 1;
    find("histories-part").hidden = isAtRest;
    find("chosen-part").querySelector("h2")!.textContent = isAtRest ? "Force" : "Force over time";
    for (const part of [find("film"), find("keys-of-time"), find("play").closest<HTMLElement>(".transport")!]) part.hidden = isAtRest && !this.data.modes;
    find("forces-at-rest").hidden = !isAtRest;
    if (isAtRest) { listObserved(this.data); listForces(motion, this.arrays, (chosen) => this.choose(chosen)); }
    const notes = isAtRest ? [] : [`${motion.times.length} recorded instants${motion.frames_seen > motion.times.length ? ` of ${motion.frames_seen}` : ""}; between them the picture interpolates.`];
    const { t_start, t_resumed } = this.data.run, [begin] = motion.times;
    if (t_resumed !== null && begin > t_start) notes.push(`This picture and the histories begin at t = ${words(begin, units.time)}, where the run went on from an earlier one; the trajectory has all of the motion.`);
    if (motion.without_picture.length) notes.push(`Not drawn: ${motion.without_picture.join(", ")}.`);
    find("view-notes").textContent = notes.join(" ");
  }

  private fillSpeed(): void {
    const natural = this.natural();
    find("speed").replaceChildren(...[0.1, 0.25, 0.5, 1, 2, 4].map((factor) => new Option(`${words(natural * factor, units.time)} in 1 s`, String(factor), factor === 1, factor === this.speed)));
    const arrow = this.arrays.held.length > 0 && this.view ? this.view.newtonsPerSize : 0;
    find("arrow-scale").textContent = arrow ? `An arrow of a sixth of the picture is ${words(arrow, units.force, 3)}. Reactions: what guides and supports do, without the pull of rods.` : "";
  }

  /** Lists the modes; a click on one lets it swing. */
  private fillModes({ omega, decay }: NonNullable<PageData["modes"]>): void {
    find("modes-part").hidden = false;
    const swing = (mode: number) => { this.mode = mode; this.showMotion(0, false); this.fillModes(this.data.modes!); this.play(true); };
    fillTable("modes", ["mode", measure("frequency", units.rate === "1/s" ? "Hz" : units.rate), measure("omega", units.angular_velocity), ...(decay.length ? [measure("decay", units.rate)] : [])], omega.map((each, k) =>
      [String(k + 1), each > 0 ? words(each / (2 * Math.PI)) : each < 0 ? "grows" : "moves freely", words(each), ...(decay.length ? [words(decay[k])] : [])]), swing);
    find("modes").querySelectorAll("tr")[this.mode + 1]?.classList.add("chosen");
    find("modes-hint").textContent = "Click a mode to see it swing; its moves are enlarged. Tensions and loads are those at rest.";
  }

  private fillMarks(): void {
    find("marks").replaceChildren(...this.data.events.map((event) => {
      const mark = make("i", "", event.kind);
      mark.style.left = `${(100 * (event.t - this.begin)) / Math.max(1e-300, this.end - this.begin)}%`;
      mark.title = `t = ${words(event.t, units.time)}: ${event.what}`;
      mark.onclick = () => this.seek(event.t);
      return mark;
    }));
  }

  /** Draws the histories of the mechanism, and those of the computation if somebody looks at them. */
  private fillCharts(): void {
    const { data } = this, seek = (time: number) => this.seek(time);
    for (const each of this.charts) each.dispose();
    this.charts = [new Charts(find("histories"), data.events, seek)];
    addHistories(this.charts[0], data);
    find("csv").hidden = !data.observables?.length;
    find("errors-line").hidden = data.error_time.length > 0 || !data.history.t;
    if (find<HTMLDetailsElement>("computed").open) {
      this.charts.push(new Charts(find("charts"), data.events, seek));
      addDiagnostics(this.charts[1], data);
    }
    for (const each of this.charts) each.stand(this.time);
  }

  private reset(): void {
    this.play(false);
    this.seek(this.begin);
    this.view?.look("best");
  }

  private look(from?: Look): void {
    this.view?.look(from);
    this.isDirty = true;
  }

  private slice(): void {
    const number = (id: string) => Number(find<HTMLInputElement>(id).value), axis = find<HTMLSelectElement>("slice").value;
    find("slab").hidden = axis === "";
    this.view?.slice(axis === "" ? null : Number(axis), number("slab-at"), number("slab-width"));
    this.isDirty = true;
  }

  private listen(): void {
    find("speed").onchange = (event) => (this.speed = Number((event.target as HTMLSelectElement).value));
    const press: Record<string, () => void> = {
      play: () => this.play(!this.plays), reset: () => this.reset(), fit: () => this.look(), png: () => this.savePicture(), film: () => this.roll(!this.film),
      full: () => void (document.fullscreenElement ? document.exitFullscreen() : find("stage").requestFullscreen()),
    };
    for (const [id, action] of Object.entries(press)) find(id).onclick = action;
    find("looks").append(...looks.map(([look, name], k) => Object.assign(make("button", name), { title: `look from there (${k + 1})`, onclick: () => this.look(look) })));
    find("time").oninput = (event) => {
      const part = Number((event.target as HTMLInputElement).value); // must be read before the slider is put at the time of the view
      this.play(false);
      this.seek(this.begin + part * (this.end - this.begin));
    };
    const chooseByHand = () => this.choose({ kind: find<HTMLSelectElement>("kind").value as Chosen["kind"], number: Number(find<HTMLInputElement>("rod").value) });
    for (const id of ["rod", "kind"]) find(id).oninput = chooseByHand;
    for (const id of ["slice", "slab-at", "slab-width"]) find(id).oninput = () => this.slice();
    find("computed").addEventListener("toggle", () => this.data && this.fillCharts());
    for (const part of parts)
      find(`show-${part}`).onchange = (event) => {
        if (this.view) this.view.shows[part] = (event.target as HTMLInputElement).checked;
        this.stand(this.time);
      };
    let down = [0, 0];
    find("view").addEventListener("pointerdown", (event) => (down = [event.clientX, event.clientY]));
    find("view").addEventListener("pointerup", (event) => {
      if (Math.hypot(event.clientX - down[0], event.clientY - down[1]) > 4) return;
      const box = find("view").getBoundingClientRect(), chosen = this.view?.pick(event.clientX - box.left, event.clientY - box.top);
      if (chosen) this.choose(chosen);
    });
    addEventListener("keydown", (event) => this.hear(event));
  }

  private hear(event: KeyboardEvent): void {
    const target = event.target as HTMLElement;
    if (target.matches("input[type=number], select") || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key === " " && target.matches("button, summary, input")) return; // which the key presses
    const step = (this.end - this.begin) / (event.shiftKey ? 20 : 200);
    const scrub = (by: number) => { this.play(false); this.seek(this.time + by); };
    const actions: Record<string, () => void> = {
      " ": () => this.play(!this.plays), ArrowLeft: () => scrub(-step), ArrowRight: () => scrub(step),
      Home: () => scrub(-Infinity), End: () => scrub(Infinity), r: () => this.reset(),
      ...Object.fromEntries(looks.map(([look], k) => [String(k + 1), () => this.look(look)])),
      f: () => find("fit").click(), g: () => find("full").click(), p: () => find("png").click(), v: () => find("film").click(),
    };
    if (!actions[event.key]) return;
    event.preventDefault();
    actions[event.key]();
  }
}

declare global {
  interface Window { tanorPage: Page["hooks"] }
}

async function start(): Promise<void> {
  const page = new Page(), { data, packed } = readPage(document);
  await page.show(data, packed);
  window.tanorPage = page.hooks;
  const tick = (now: number) => { page.tick(now); requestAnimationFrame(tick); };
  requestAnimationFrame(tick);
  if (data.modes && !matchMedia("(prefers-reduced-motion: reduce)").matches) page.play(true);
  await follow(data.run.is_running, (next) => page.show(next.data, next.packed));
}

start().catch((error) => {
  find("view").append(make("p", `The motion could not be read: ${error}`, "missing"));
  throw error;
});
