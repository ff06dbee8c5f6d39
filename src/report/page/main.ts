import { Charts } from "./charts";
import { readPage, unpack, words, type Arrays, type PageData } from "./data";
import { find, fillList, make } from "./dom";
import { fillDetails, fillHeadline } from "./facts";
import { follow } from "./follow";
import { Stage, View } from "./view";

const most_listed = 40;
const parts = ["points", "rods", "guides", "normal", "tangent"] as const;

/** Returns how many numbers are below a bound, and the positions of the smallest ones in increasing order of the numbers. */
function findLeast(numbers: Float32Array, bound: number, most: number): { count: number; first: number[] } {
  const first: number[] = [];
  let count = 0;
  for (let k = 0; k < numbers.length; ++k) {
    if (!(numbers[k] < bound)) continue;
    ++count;
    if (first.length === most && numbers[k] >= numbers[first[most - 1]]) continue;
    let place = first.length;
    while (place > 0 && numbers[first[place - 1]] > numbers[k]) --place;
    first.splice(place, 0, k);
    first.length = Math.min(most, first.length);
  }
  return { count, first };
}

/** The page of one run, which is shown again for each newer state of the run. */
class Page {
  private stage: Stage | null = null; // null if the browser cannot draw
  private view: View | null = null;
  private charts: Charts | null = null;
  private data!: PageData;
  private arrays!: Arrays;
  private begin = 0;
  private end = 0;
  private time = 0;
  private timeOfNumbers = NaN; // time of the words beside the picture
  private plays = false;
  private speed = 1;
  private before = 0; // ms, time of the last picture while it plays
  private isDirty = true;
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

  /** Shows a state of the run. The eye, the chosen rod and the time stay, except that a view at the end moves to the new end. */
  async show(data: PageData, packed: string): Promise<void> {
    const isFirst = !this.data, wasAtEnd = !isFirst && this.time >= this.end && !this.plays;
    const arrays = await unpack(data.motion, packed);
    const { times } = data.motion;
    this.data = data;
    this.arrays = arrays;
    [this.begin, this.end] = times.length ? [times[0], times[times.length - 1]] : [0, 0];
    const { normal, tangent, ground: paper } = data.colours;
    for (const [name, colour] of Object.entries({ normal, tangent, paper })) document.documentElement.style.setProperty(`--${name}`, colour);
    fillHeadline(data);
    fillDetails(data, (time) => this.seek(time));
    find("moving").hidden = times.length === 0; // the warnings say why
    if (times.length === 0) return;
    if (this.stage) {
      const chosen = this.view?.chosen;
      this.view?.dispose();
      this.view = new View(this.stage, data.motion, arrays, data.colours, isFirst);
      this.view.chosen = chosen ?? this.view.findStrongest(this.end);
      for (const part of parts) this.view.shows[part] = find<HTMLInputElement>(`show-${part}`).checked;
      this.fillLegend();
    }
    this.fillAside();
    this.fillMarks();
    this.charts?.dispose();
    this.charts = null;
    this.choose(this.view?.chosen ?? 0, isFirst ? (data.run.is_running ? this.end : this.begin) : wasAtEnd ? this.end : this.time);
    this.view?.render();
    if (isFirst) this.firstPicture = performance.now();
    this.charts = new Charts(find("charts"), data, (time) => this.seek(time));
    this.charts.stand(this.time);
  }

  /** Draws what has changed; called for every picture of the screen. */
  tick(now: number): void {
    if (this.plays) {
      const passed = this.before > 0 ? now - this.before : 0;
      this.before = now;
      this.stand(this.time + (this.natural() * this.speed * passed) / 1000);
      if (Math.abs(this.time - this.timeOfNumbers) > 0.15 * this.natural() * this.speed) this.settle();
      if (this.time >= this.end) this.play(false);
    }
    if (this.isDirty) this.draw();
  }

  private draw(): void {
    this.isDirty = false;
    this.view?.render();
    ++this.frames;
  }

  seek(time: number): void { this.stand(time); this.settle(); }

  choose(rod: number, time = this.time): void {
    const chosen = Math.min(Math.max(0, Math.floor(rod) || 0), Math.max(0, this.data.motion.rods - 1));
    if (this.view) this.view.chosen = chosen;
    find<HTMLInputElement>("rod").value = String(chosen);
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
      seek: (time: number) => page.seek(time),
      choose: (rod: number) => page.choose(rod),
      play: (on: boolean) => page.play(on),
      get held() { return page.arrays.held; },
      get camera() { return page.stage?.camera; },
      get scene() { return page.view?.scene; },
      get size() { return page.view?.size; },
      render: () => page.draw(),
      tension: (rod: number) => page.view?.tensions[rod],
    };
  }

  /** Returns the seconds of motion per second at speed "1": round, so that the whole motion takes 6 to 20 seconds or somewhat longer. */
  private natural(): number {
    const wanted = (this.end - this.begin) / Math.min(20, Math.max(6, this.data.motion.times.length / 12));
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
    find("clock").textContent = `${words(this.time)} s of ${words(this.end)} s`;
    find<HTMLInputElement>("time").value = String(this.end > this.begin ? (this.time - this.begin) / (this.end - this.begin) : 0);
    if (this.view) this.tellRods(this.view);
    this.charts?.stand(this.time);
  }

  private tellRods({ tensions, chosen, tensionStep }: View): void {
    const { motion } = this.data, { rods } = this.arrays;
    if (!motion.rods) return;
    find("tension").textContent = words(tensions[chosen], "N");
    const { count, first: pushed } = findLeast(tensions, -2 * tensionStep, most_listed);
    const listed = count > most_listed ? `, ${most_listed} listed` : "";
    find("pushed-count").textContent = count ? `${count} of ${motion.rods} rods${listed}` : "No rod is pushed.";
    const point = (k: number) => (k < motion.points ? k : motion.images[k - motion.points][0]);
    fillList("pushed", pushed.map((rod) => {
      const row = make("li");
      row.append(make("span", `rod ${rod} (${point(rods[2 * rod])}–${point(rods[2 * rod + 1])})`), make("span", words(tensions[rod], "N")));
      row.onclick = () => this.choose(rod);
      return row;
    }));
  }

  private fillLegend(): void {
    const { tensions: [least, most], pushed, pulled } = this.data.colours;
    const stops = least < 0 ? [...pushed].reverse().concat(most > 0 ? pulled.slice(1) : []) : pulled;
    find("legend").hidden = least === most;
    const bar = make("div", "", "bar"), ends = make("div", "", "ends");
    bar.style.background = `linear-gradient(to right, ${stops.join(",")})`;
    const numbers = least < 0 && most > 0 ? [least, 0, most] : [least, most];
    ends.append(...numbers.map((tension, k) => make("span", words(tension, k === numbers.length - 1 ? "N" : "").replace("-", "−"))));
    find("legend").replaceChildren(make("div", `tension of rods: ${[least < 0 ? "pushed" : "", most > 0 ? "pulled" : ""].filter((word) => word).join(" … ")}`), bar, ends);
  }

  private fillAside(): void {
    const { motion } = this.data, held = this.arrays.held.length > 0;
    const hide = (part: string, isHidden: boolean) => (find(`show-${part}`).parentElement!.hidden = isHidden);
    hide("tangent", !held || !motion.has_friction);
    hide("normal", !held);
    hide("rods", !motion.rods);
    hide("guides", !motion.guides.length);
    find("rods-part").hidden = !motion.rods;
    find<HTMLInputElement>("rod").max = String(Math.max(0, motion.rods - 1));
    find("arrow-scale").textContent = held && this.view ? `An arrow of a sixth of the picture is ${words(this.view.newtonsPerSize, "N", 3)}. Normal: what guides and supports do; tangent: friction. The pull of rods is left out.` : "";
    const notes = [`${motion.times.length} recorded instants${motion.frames_seen > motion.times.length ? ` of ${motion.frames_seen}` : ""}; between them the picture interpolates.`];
    const { t_start, t_resumed } = this.data.run;
    if (t_resumed !== null && this.begin > t_start) notes.push(`This picture and the histories begin at t = ${words(this.begin, "s")}, where the run went on from an earlier one; the trajectory has all of the motion.`);
    if (motion.without_picture.length) notes.push(`Not drawn: ${motion.without_picture.join(", ")}.`);
    find("view-notes").textContent = notes.join(" ");
    const natural = this.natural(), speed = find<HTMLSelectElement>("speed");
    speed.replaceChildren(...[0.1, 0.25, 0.5, 1, 2, 4].map((factor) =>
      new Option(`${words(natural * factor)} s in 1 s`, String(factor), factor === 1, factor === this.speed)));
  }

  private fillMarks(): void {
    find("marks").replaceChildren(...this.data.events.map((event) => {
      const mark = make("i", "", event.kind);
      mark.style.left = `${(100 * (event.t - this.begin)) / Math.max(1e-300, this.end - this.begin)}%`;
      mark.title = `t = ${words(event.t, "s")}: ${event.what}`;
      mark.onclick = () => this.seek(event.t);
      return mark;
    }));
  }

  private reset(): void {
    this.play(false);
    this.view?.lookFrom();
    this.seek(this.begin);
  }

  private listen(): void {
    find("speed").onchange = (event) => (this.speed = Number((event.target as HTMLSelectElement).value));
    find("play").onclick = () => this.play(!this.plays);
    find("reset").onclick = () => this.reset();
    find("time").oninput = (event) => {
      const part = Number((event.target as HTMLInputElement).value); // must be read before the slider is put at the time of the view
      this.play(false);
      this.seek(this.begin + part * (this.end - this.begin));
    };
    find("rod").oninput = (event) => this.choose(Number((event.target as HTMLInputElement).value));
    for (const part of parts)
      find(`show-${part}`).onchange = (event) => {
        if (this.view) this.view.shows[part] = (event.target as HTMLInputElement).checked;
        this.isDirty = true;
      };
    let down = [0, 0];
    find("view").addEventListener("pointerdown", (event) => (down = [event.clientX, event.clientY]));
    find("view").addEventListener("pointerup", (event) => {
      if (Math.hypot(event.clientX - down[0], event.clientY - down[1]) > 4) return;
      const box = find("view").getBoundingClientRect(), rod = this.view?.pick(event.clientX - box.left, event.clientY - box.top);
      if (rod !== null && rod !== undefined) this.choose(rod);
    });
    addEventListener("keydown", (event) => this.hear(event));
  }

  private hear(event: KeyboardEvent): void {
    const target = event.target as HTMLElement;
    if (target.matches("input[type=number], select") || event.ctrlKey || event.metaKey || event.altKey) return;
    const step = (this.end - this.begin) / (event.shiftKey ? 20 : 200);
    const scrub = (by: number) => { this.play(false); this.seek(this.time + by); };
    const actions: Record<string, () => void> = {
      " ": () => this.play(!this.plays), ArrowLeft: () => scrub(-step), ArrowRight: () => scrub(step),
      Home: () => scrub(-Infinity), End: () => scrub(Infinity), r: () => this.reset(),
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
  await follow(data.run.is_running, (next) => page.show(next.data, next.packed));
}

start().catch((error) => {
  find("view").append(make("p", `The motion could not be read: ${error}`, "missing"));
  throw error;
});
