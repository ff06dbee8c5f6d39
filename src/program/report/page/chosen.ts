import { labelsOf, type Chart } from "./charts";
import { countRopes, measure, units, words, type Arrays, type Motion, type PageData } from "./data";
import { fillList, find, make } from "./dom";
import type { Chosen, View } from "./view";

const most_listed = 40;

/** Returns the number in the scene of a point that is shown, or of the point of an image. */
function pointOf({ points, images, numbers }: Motion, end: number): number {
  const shown = end < points ? end : images[end - points][0];
  return numbers[shown] ?? shown;
}

/** Returns "links[3] (4–5)": the rod's group and its number there, and the points that it joins. */
export function nameRod(motion: Motion, { rods }: Arrays, rod: number): string {
  const { name, first, members } = motion.rod_groups.findLast((group) => group.first <= rod)!;
  return `${name}[${members[rod - first] ?? rod - first}] (${pointOf(motion, rods[2 * rod])}–${pointOf(motion, rods[2 * rod + 1])})`;
}

/** Returns "hook (point 0)": the support's entry and its point. */
const nameSupport = (motion: Motion, point: number) => `${motion.support_names[motion.supports.indexOf(point)] || "support"} (point ${pointOf(motion, point)})`;

/** Fills the kinds of things that can be chosen. */
export function fillKinds(motion: Motion, { held }: Arrays): void {
  const kinds = [["rod", "rod", motion.rods], ["point", held.length > motion.supports.length ? "held point" : "support", held.length], ["tie", "rope", countRopes(motion)]] as const;
  const there = kinds.filter(([, , count]) => count);
  find("kind").replaceChildren(...there.map(([kind, label]) => new Option(label, kind)));
  find("chosen-part").hidden = there.length === 0;
}

/** Returns what is there and nearest to what is wanted. */
export function admit({ kind, number }: Chosen, motion: Motion, { held }: Arrays): Chosen {
  const wanted = Math.max(0, Math.floor(number) || 0);
  if (kind === "point") return { kind, number: held.find((point) => point >= wanted) ?? held[held.length - 1] ?? 0 };
  return { kind, number: Math.min(wanted, Math.max(0, (kind === "rod" ? motion.rods : countRopes(motion)) - 1)) };
}

/** Returns the force on what is chosen at all frames: tension of a rod or rope, load of a support, force of guides on a point. */
export function chartOf({ kind, number }: Chosen, motion: Motion, arrays: Arrays): Chart {
  const over = (read: (frame: number) => number) => motion.times.map((_, frame) => read(frame)).map((each) => (Number.isNaN(each) ? null : each)), chart = { unit: units.force, times: motion.times, unknown: "not known" };
  if (kind === "rod") return { ...chart, title: `tension of ${nameRod(motion, arrays, number)}`, curves: [{ label: "tension", numbers: over((frame) => arrays.tensions.get(frame, number)) }] };
  if (kind === "tie") {
    const { name, kind: of } = motion.ties[number], isRope = of === "pulley" || of === "rope";
    return { ...chart, title: `${isRope ? "tension of the rope" : "multiplier of the formula"} ${name}`, unit: isRope ? units.force : "",
      curves: [{ label: isRope ? "tension" : "−lambda", numbers: over((frame) => arrays.ties.get(frame, number)) }] };
  }
  const row = arrays.held.indexOf(number), isSupport = motion.supports.includes(number), sign = isSupport ? -1 : 1;
  const part = (axis: number) => (frame: number) => sign * (arrays.normal.get(frame, 3 * row + axis) + (arrays.tangent.columns ? arrays.tangent.get(frame, 3 * row + axis) : 0));
  const curves = ["x", "y", "z"].map((label, axis) => ({ label, numbers: over(part(axis)) }));
  const size = { label: "size", numbers: over((frame) => Math.hypot(part(0)(frame), part(1)(frame), part(2)(frame))) };
  return { ...chart, title: isSupport ? `load of ${nameSupport(motion, number)}` : `force of guides on point ${pointOf(motion, number)}`, curves: [size, ...curves] };
}

/** Lists the rods that are pushed now, the most pushed one first. */
export function tellPushed({ tensions, tensionStep }: View, motion: Motion, arrays: Arrays, choose: (rod: number) => void): void {
  const all: number[] = [];
  tensions.forEach((tension, rod) => { if (tension < -2 * tensionStep) all.push(rod); });
  const first = all.sort((a, b) => tensions[a] - tensions[b]).slice(0, most_listed), count = all.length;
  const listed = count > most_listed ? ` (${most_listed} listed)` : "";
  find("pushed-count").textContent = count ? measure(`${count} of ${motion.rods} rods${listed}`, units.force) : "No rod is pushed.";
  fillList("pushed", first.map((rod) => {
    const row = make("li");
    row.append(make("span", nameRod(motion, arrays, rod)), make("span", words(tensions[rod])));
    row.onclick = () => choose(rod);
    return row;
  }));
}

/** Fills a table; a click on a row calls `choose`, if there is one, with its number. */
export function fillTable(id: string, head: string[], rows: string[][], choose?: (row: number) => void): void {
  const line = (cells: string[], tag: string) => { const row = make("tr"); row.append(...cells.map((cell) => make(tag, cell))); return row; };
  find(id).replaceChildren(line(head, "th"), ...rows.map((cells, k) => {
    const row = line(cells, "td");
    if (choose) { row.dataset.row = String(k); row.onclick = () => choose(k); }
    return row;
  }));
}

/** Lists what is observed at rest: each part of each member. */
export function listObserved({ observables = [] }: PageData): void {
  fillTable("observed", ["", "value"], observables.flatMap((each) => labelsOf(each).map((label, k) => {
    const { name, members, least, rows, unit, unknown } = each, of = members.length ? "" : least[k]?.member, number = rows[0]?.[k];
    const told = (number === null && unknown) || words(number, unit);
    return [label === name ? name : `${name}: ${label}`, told + (of ? ` in ${of}` : "")];
  })));
  find("observed").closest<HTMLElement>(".card")!.hidden = !observables.length;
}

/** Lists the loads and tensions at rest, the largest ones first. */
export function listForces(motion: Motion, arrays: Arrays, choose: (chosen: Chosen) => void): void {
  const most = 200, load = (point: number) => chartOf({ kind: "point", number: point }, motion, arrays).curves.map(({ numbers }) => numbers[0] ?? NaN);
  const loads = motion.supports.map((point) => ({ point, load: load(point) })).sort((a, b) => b.load[0] - a.load[0]);
  const sum = loads.reduce(([x, y, z], { load: [, dx, dy, dz] }) => [x + dx, y + dy, z + dz], [0, 0, 0]);
  const row = (name: string, numbers: number[]) => [name, ...numbers.map((number) => words(number))];
  fillTable("loads", ["support", measure("size", units.force), "x", "y", "z"],
    [row("sum", [Math.hypot(...sum), ...sum]), ...loads.slice(0, most).map(({ point, load }) => row(nameSupport(motion, point), load))],
    (k) => k && choose({ kind: "point", number: loads[k - 1].point }));
  const rods = Array.from({ length: motion.rods }, (_, rod) => ({ rod, tension: arrays.tensions.get(0, rod) })).sort((a, b) => (Math.abs(b.tension) || 0) - (Math.abs(a.tension) || 0)).slice(0, most);
  fillTable("tensions", ["rod", measure("tension", units.force)], rods.map(({ rod, tension }) => row(nameRod(motion, arrays, rod), [tension])), (k) => choose({ kind: "rod", number: rods[k].rod }));
  find("loads").closest<HTMLElement>(".card")!.hidden = !loads.length;
  find("tensions").closest<HTMLElement>(".card")!.hidden = !rods.length;
}
