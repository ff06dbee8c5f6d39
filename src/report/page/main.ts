import { Charts } from "./charts";
import { readData, unpack, words, type PageData } from "./data";
import { View, chooseTheme } from "./view";

const find = <T extends HTMLElement>(id: string) => document.getElementById(id) as T;
const make = (tag: string, text = "", className = "") => Object.assign(document.createElement(tag), { textContent: text, className });

function fillHeadline({ run, motion }: PageData): void {
  document.title = `${run.scene} – tanor`;
  find("scene").textContent = run.scene;
  find("what").textContent = `${run.points} points, ${motion.rods} rods, ${run.equations} equations, ${run.islands} islands · ${run.method} · tanor ${run.version}`;
  const digits = run.certified_to > 0 ? Math.min(16, -Math.log10(run.certified_to)) : null;
  const passed = run.certified_to !== null && run.certificate_line.startsWith("certified");
  const facts: [string, string][] = [
    ["certified", passed ? `${digits === null ? "exact" : digits.toFixed(1) + " digits"}` : run.certified_to === null ? "not asked for" : "failed"],
    ["run time", words(run.wall.total, "s")],
    ["steps", `${run.steps}` + (run.rejected ? ` (+${run.rejected})` : "")],
    ["simulated", words(run.t_reached, "s")],
    ["energy drift", words(run.drift)],
    ["threads", String(run.threads)],
  ];
  for (const [name, text] of facts) {
    const pair = make("div");
    pair.append(make("dt", name), make("dd", text));
    find("headline").append(pair);
  }
  find("warnings").hidden = run.warnings.length === 0;
  for (const warning of run.warnings) find("warnings").append(make("p", warning));
}

function fillDetails({ run }: PageData): void {
  const phases = Object.entries(run.wall as Record<string, number>).filter(([name, time]) => name !== "total" && time > 0);
  const most = Math.max(...phases.map(([, time]) => time));
  for (const [name, time] of phases) {
    const row = make("div", "", "phase"), bar = make("i");
    bar.style.width = `${(100 * time) / most}%`;
    row.append(make("span", name), bar, make("span", words(time, "s")));
    find("phases").append(row);
  }
  find("certificate").textContent = run.certificate_line || "No certificate was asked for.";
  for (const check of run.certificate?.checks ?? []) {
    const row = make("tr");
    row.append(make("td", check.identity), make("td", words(check.error)));
    find("checks").append(row);
  }
  for (const what of run.left_out) find("left-out").append(make("li", what));
  if (!run.left_out.length) find("left-out").append(make("li", "nothing"));
  find("text").textContent = run.text;
}

function fillLegend(view: View, hasRods: boolean): void {
  if (!hasRods) return;
  const stops = Array.from({ length: 21 }, (_, k) => `rgb(${view.colourOf((k / 10 - 1) * view.scale).map((x) => Math.round(255 * x)).join(",")})`);
  const bar = make("div", "", "bar"), ends = make("div", "", "ends");
  bar.style.background = `linear-gradient(to right, ${stops.join(",")})`;
  ends.append(make("span", `−${words(view.scale)}`), make("span", "0"), make("span", `${words(view.scale)} N`));
  find("legend").append(make("div", "tension of rods: pushed … pulled"), bar, ends);
}

async function start(): Promise<void> {
  const data = readData(), { motion } = data;
  fillHeadline(data);
  fillDetails(data);
  if (motion.times.length === 0) { find("view").append(make("p", "No state of the motion is known.", "missing")); return; }
  const arrays = await unpack(motion);
  const begin = motion.times[0], end = motion.times[motion.times.length - 1];
  let time = begin, plays = false, speed = 1, before = 0, isDirty = true, firstPicture = 0;

  let view: View;
  try {
    view = new View(find("view"), motion, arrays, chooseTheme(matchMedia("(prefers-color-scheme: dark)").matches), () => (isDirty = true));
  } catch {
    find("view").append(make("p", "This browser offers no WebGL 2, so the motion cannot be drawn here. All numbers below are complete; trajectory.pvd beside this page opens in ParaView, trajectory.xyz in OVITO.", "missing"));
    new Charts(find("charts"), data, () => {});
    return;
  }
  fillLegend(view, motion.rods > 0);
  let charts: Charts | null = null;

  const showNumbers = () => {
    find("clock").textContent = `${words(time)} s of ${words(end)} s`;
    find<HTMLInputElement>("time").value = String(end > begin ? (time - begin) / (end - begin) : 0);
    const k = view.chosen;
    find("tension").textContent = motion.rods ? words(view.tensions[k], "N") : "no rods";
    const pushed: number[] = [];
    const noise = 3e-5 * (motion.ranges.tensions[1] - motion.ranges.tensions[0]);
    for (let rod = 0; rod < view.tensions.length; ++rod) if (view.tensions[rod] < -noise) pushed.push(rod);
    find("pushed-count").textContent = motion.rods ? `${pushed.length} of ${motion.rods} rods are pushed.` : "There are no rods.";
    pushed.sort((p, q) => view.tensions[p] - view.tensions[q]);
    find("pushed").replaceChildren(...pushed.slice(0, 40).map((rod) => {
      const row = make("li");
      row.append(make("span", `rod ${rod} (${arrays.rods[2 * rod]}–${arrays.rods[2 * rod + 1] < motion.points ? arrays.rods[2 * rod + 1] : motion.images[arrays.rods[2 * rod + 1] - motion.points][0]})`), make("span", words(view.tensions[rod], "N")));
      row.onclick = () => choose(rod);
      return row;
    }));
  };
  let numbersShown = -1;
  const stand = (now: number) => { time = Math.min(end, Math.max(begin, now)); view.stand(time); isDirty = true; };
  const settle = () => { numbersShown = time; showNumbers(); charts?.stand(time); };
  const seek = (now: number) => { stand(now); settle(); };
  const choose = (rod: number) => {
    view.chosen = Math.min(Math.max(0, Math.floor(rod) || 0), Math.max(0, motion.rods - 1));
    find<HTMLInputElement>("rod").value = String(view.chosen);
    seek(time);
  };
  const play = (on: boolean) => {
    if (on && time >= end) stand(begin);
    plays = on;
    before = 0;
    find("play").textContent = on ? "Pause" : "Play";
    if (!on) settle();
  };

  // A tenth of the motion a second or so, at "1".
  const natural = (end - begin) / Math.min(20, Math.max(6, motion.times.length / 12));
  for (const factor of [0.1, 0.25, 0.5, 1, 2, 4]) find<HTMLSelectElement>("speed").append(new Option(`${words(natural * factor)} s/s`, String(factor), factor === 1, factor === 1));
  find("speed").onchange = (event) => (speed = Number((event.target as HTMLSelectElement).value));
  find("play").onclick = () => play(!plays);
  const reset = () => { play(false); view.lookFrom(); seek(begin); };
  find("reset").onclick = reset;
  find("time").oninput = (event) => {
    const part = Number((event.target as HTMLInputElement).value);  // before the slider is put where the view stands
    play(false);
    seek(begin + part * (end - begin));
  };
  find("rod").oninput = (event) => choose(Number((event.target as HTMLInputElement).value));
  find<HTMLInputElement>("rod").max = String(Math.max(0, motion.rods - 1));
  for (const what of ["points", "rods", "guides", "normal", "tangent"] as const)
    find(`show-${what}`).onchange = (event) => { view.shows[what] = (event.target as HTMLInputElement).checked; isDirty = true; };
  if (!motion.has_friction) find("show-tangent").parentElement!.hidden = true;
  if (!arrays.held.length) for (const what of ["normal", "tangent"]) find(`show-${what}`).parentElement!.hidden = true;
  else find("arrow-scale").textContent = `Arrows: ${words(view.newtonsPerSize, "N")} is a sixth of the picture. Normal: what guides and supports do; tangent: friction. Rods are left out.`;
  if (!motion.rods) {
    find("rods-part").hidden = true;
    find("show-rods").parentElement!.hidden = true;
  }
  if (!motion.guides.length) find("show-guides").parentElement!.hidden = true;
  const notes = [`${motion.times.length} recorded instants${motion.frames_seen > motion.times.length ? ` of ${motion.frames_seen}` : ""}; between them the picture interpolates.`];
  if (motion.without_picture.length) notes.push(`Not drawn: ${motion.without_picture.join(", ")}.`);
  find("view-notes").textContent = notes.join(" ");
  for (const event of data.events) {
    const mark = make("i");
    mark.style.left = `${(100 * (event.t - begin)) / Math.max(1e-300, end - begin)}%`;
    mark.title = `t = ${words(event.t, "s")}: ${event.what}`;
    find("marks").append(mark);
  }
  let down = [0, 0];
  find("view").addEventListener("pointerdown", (event) => (down = [event.clientX, event.clientY]));
  find("view").addEventListener("pointerup", (event) => {
    if (Math.hypot(event.clientX - down[0], event.clientY - down[1]) > 4) return;
    const box = find("view").getBoundingClientRect(), rod = view.pick(event.clientX - box.left, event.clientY - box.top);
    if (rod !== null) choose(rod);
  });
  addEventListener("keydown", (event) => {
    const target = event.target as HTMLElement;
    if (target.matches("input[type=number], select") || event.ctrlKey || event.metaKey || event.altKey) return;
    const step = (end - begin) / (event.shiftKey ? 20 : 200);
    const actions: Record<string, () => void> = { " ": () => play(!plays), ArrowLeft: () => { play(false); seek(time - step); }, ArrowRight: () => { play(false); seek(time + step); }, r: reset };
    if (!actions[event.key]) return;
    event.preventDefault();
    actions[event.key]();
  });

  let frames = 0;
  const tick = (now: number) => {
    if (plays) {
      if (before > 0) stand(time + (natural * speed * (now - before)) / 1000);
      before = now;
      if (Math.abs(time - numbersShown) > natural * speed * 0.15) settle();
      if (time >= end) play(false);
    }
    if (isDirty) { isDirty = false; view.render(); ++frames; }
    requestAnimationFrame(tick);
  };
  let strongest = 0;
  view.stand(end);
  for (let rod = 1; rod < motion.rods; ++rod) if (Math.abs(view.tensions[rod]) > Math.abs(view.tensions[strongest])) strongest = rod;
  choose(strongest);
  seek(begin);
  view.render();
  firstPicture = performance.now();
  // What a test asks for.
  (window as any).tanorPage = { seek, choose, play, begin, end, firstPicture, render: () => view.render(), frames: () => frames, tension: (rod: number) => view.tensions[rod] };
  requestAnimationFrame(tick);
  charts = new Charts(find("charts"), data, seek);
  charts.stand(time);
}

start().catch((error) => {
  find("view").append(make("p", `The motion could not be read: ${error}`, "missing"));
  throw error;
});
