import uPlot from "uplot";
import { measure, units, words, type ErrorTimeRow, type Figure, type Observable, type PageData } from "./data";
import { make } from "./dom";

const style = (name: string) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
// uPlot has ticks down to 1e-24 and would search for smaller ones without end.
const least_shown = 1e-20;

/** A logarithmic scale between two different powers of ten. */
const logarithmic: uPlot.Scale = {
  distr: 3,
  range: (_, least, most) => {
    if (!(least > 0 && most >= least_shown)) return [0.1, 1];
    const low = Math.floor(Math.log10(Math.max(least, least_shown)) + 1e-9), high = Math.ceil(Math.log10(most) - 1e-9);
    return [10 ** low, 10 ** Math.max(high, low + 1)];
  },
};

/** A linear scale. Numbers that differ by rounding alone appear as equal, because there are no ticks between them. */
const linear: uPlot.Scale = {
  range: (_, least, most) => {
    const size = Math.max(Math.abs(least), Math.abs(most)), margin = Math.max(1e-3 * size, 1e-15);
    return most - least > Math.max(1e-12 * size, least_shown) ? uPlot.rangeNum(least, most, 0.1, true) : [least - margin, most + margin];
  },
};

/** The same colours as in page.css for the time line of the view. */
const colourOfEvent: Record<string, string> = { contact: "--warn", singular: "--tangent", event: "--ink" };
/** The curves also differ in their dashes. */
const strokes = ["#2a7fc9", "#d9730d", "#0f9d78", "#b0398b", "#8a8f2a", "#7a5bd0", "#5c6773"];
const dashes = [[], [7, 3], [2, 3], [9, 3, 2, 3]];

const lineOf = (k: number) => ({ stroke: strokes[k % strokes.length], dash: dashes[k % dashes.length], width: 1.6 });
const tell = (_: uPlot, number: number | null) => (number === null ? "–" : words(number));

/** Curves over time in one card. */
export interface Chart {
  title: string;
  unit: string;
  times: number[];
  curves: { label: string; numbers: Figure[] }[];
  isLog?: boolean;
  note?: string;
  unknown?: string; // what stands in place of curves of which no number is known; without it there is no chart
}

/** Draws charts over the time of the motion. They share the time of the view, and a click selects a time. */
export class Charts {
  plots: uPlot[] = [];
  private watches: ResizeObserver[] = [];
  private time = 0;

  constructor(private host: HTMLElement, private events: PageData["events"], private seek: (time: number) => void, private height = 190) {}

  dispose(): void {
    for (const watch of this.watches) watch.disconnect();
    for (const plot of this.plots) plot.destroy();
    [this.watches, this.plots] = [[], []];
    this.host.replaceChildren();
  }

  /** Puts the bar of the view at a time, and the values of that time into the legends. */
  stand(time: number): void {
    this.time = time;
    for (const plot of this.plots) {
      plot.redraw(false, false);
      this.tell(plot);
    }
  }

  /** Fills the legend with the values of the last instant before the time of the view. */
  private tell(plot: uPlot): void {
    const [times] = plot.data;
    let low = 0, high = times.length;
    while (high - low > 1) { const half = (low + high) >> 1; if (times[half] <= this.time) low = half; else high = half; }
    plot.setLegend({ idx: low });
  }

  private card(title: string): HTMLElement {
    const card = make("div", "", "card chart");
    card.append(make("h3", title));
    this.host.append(card);
    return card;
  }

  /** Keeps a plot as wide as its card; `tellAgain` fills the legend, which a resize empties. */
  private fit(plot: uPlot, card: HTMLElement, tellAgain = () => {}): void {
    const watch = new ResizeObserver(() => { plot.setSize({ width: this.width(card), height: this.height }); tellAgain(); });
    watch.observe(card);
    this.watches.push(watch);
  }
  private width = (card: HTMLElement) => Math.max(120, card.clientWidth - 2 * parseFloat(getComputedStyle(card).paddingLeft));

  private axes(isLog: boolean, below: string, beside: string): uPlot.Axis[] {
    const label = { labelSize: 16, labelGap: 0, labelFont: "11px system-ui, sans-serif" };
    const common = { stroke: style("--soft"), grid: { stroke: style("--line"), width: 1 }, ticks: { stroke: style("--line"), width: 1 }, font: "11px system-ui, sans-serif" };
    // Grid lines are drawn at powers of ten only.
    const filter = (_: uPlot, splits: number[]) => splits.map((y) => (!isLog || (y > 0 && Number.isInteger(+Math.log10(y).toFixed(9))) ? y : null));
    // Ticks are rounded: 0.30000000000000004 becomes 0.3. Small numbers such as 0.0000025 would not fit beside the axis.
    const isLong = (tick: number) => tick !== 0 && (Math.abs(tick) < 1e-3 || Math.abs(tick) >= 1e5);
    const short = (tick: number) => (isLog || isLong(tick) ? (+tick.toPrecision(3)).toExponential() : String(+tick.toPrecision(6)));
    return [{ ...common, ...label, size: 28, label: below },
      { ...common, ...label, grid: { ...common.grid, filter }, size: 54, label: beside || " ", values: (_, ticks) => ticks.map((tick) => (tick === null ? "" : short(tick))) }];
  }

  add({ title, unit, times, curves, isLog = false, note, unknown }: Chart): void {
    if (!times || times.length < 2) return;
    const columns = curves.map(({ numbers }) => numbers.map((y) => (isLog && !(y! > 0) ? null : y)));
    const isKnown = columns.some((column) => column.some((y) => y !== null));
    if (!isKnown && !unknown) return;
    const card = this.card(title);
    if (!isKnown) return card.append(make("p", unknown!, "hint"));
    const plot = new uPlot({
      width: this.width(card), height: this.height, pxAlign: 0,
      cursor: { sync: { key: "time" }, y: false, drag: { x: false, y: false } },
      scales: { x: { time: false }, y: isLog ? logarithmic : linear },
      axes: this.axes(isLog, measure("t", units.time), unit),
      series: [{ label: measure("t", units.time), value: tell },
        ...curves.map(({ label }, k) => ({ label, ...lineOf(k), points: { show: false }, value: tell }))],
      hooks: { ready: [(drawn) => this.tell(drawn)], draw: [(drawn) => this.drawMarks(drawn)] },
    }, [times, ...columns] as uPlot.AlignedData, card);
    plot.over.addEventListener("click", (event) => this.seek(plot.posToVal(event.offsetX, "x")));
    this.plots.push(plot);
    const tellAgain = () => this.tell(plot);
    plot.over.addEventListener("mouseleave", () => setTimeout(tellAgain)); // which empties the legend, too
    this.fit(plot, card, tellAgain);
    if (note) card.append(make("p", note, "hint"));
  }

  /** Draws the events and the time of the view. */
  private drawMarks(plot: uPlot): void {
    const { ctx, bbox } = plot;
    const bar = (time: number, colour: string, width: number, height: number) => {
      const x = plot.valToPos(time, "x", true);
      if (x < bbox.left || x > bbox.left + bbox.width) return;
      ctx.fillStyle = colour;
      ctx.fillRect(x - width / 2, bbox.top + bbox.height - height, width, height);
    };
    const colours = Object.fromEntries(Object.entries(colourOfEvent).map(([kind, name]) => [kind, style(name)]));
    ctx.save();
    for (const event of this.events) bar(event.t, colours[event.kind], 1.5 * devicePixelRatio, 7 * devicePixelRatio);
    bar(this.time, style("--accent"), 1.5 * devicePixelRatio, bbox.height);
    ctx.restore();
  }

  /** Draws error against wall time from the table of `tanor error-time`, with one curve for each method. */
  addErrorTime(rows: ErrorTimeRow[]): void {
    const methods = [...new Set(rows.map((row) => row.method))];
    const points = rows.map((row) => ({ method: row.method, wall: row.wall_s ?? 0, error: row.error ?? 0 }))
      .filter((point) => point.wall > 0 && point.error > 0).sort((p, q) => p.wall - q.wall);
    if (!points.length) return;
    const card = this.card("Error against run time, by method");
    const powers = (_: uPlot, ticks: number[]) => ticks.map((tick) => (tick === null ? "" : tick.toExponential(0)));
    const plot = new uPlot({
      width: this.width(card), height: this.height, scales: { x: { time: false, ...logarithmic }, y: logarithmic },
      axes: this.axes(true, "run time, s", measure("error", units.length)).map((axis) => ({ ...axis, values: powers })),
      cursor: { drag: { x: false, y: false } },
      series: [{ label: "run time, s", value: tell }, ...methods.map((label, k) => ({ label, ...lineOf(k), spanGaps: true, points: { show: true, size: 6 }, value: tell }))],
    }, [points.map((p) => p.wall), ...methods.map((method) => points.map((p) => (p.method === method ? p.error : null)))] as uPlot.AlignedData, card);
    this.fit(plot, card);
  }
}

/** Returns the names of the numbers of an observable: those of its members, of its parts, of the parts of its members, or its own. */
export function labelsOf({ name, parts, members }: Observable): string[] {
  if (!members.length) return parts.length ? parts : [name];
  return members.flatMap((member) => (parts.length ? parts.map((part) => `${member}.${part}`) : [member]));
}

/** The histories of the mechanism: what was observed, then its energy. */
export function addHistories(charts: Charts, { history, observables = [] }: PageData): void {
  const most = 28; // curves that can be told from one another
  for (const each of observables) {
    const { name, unit, parts, least, largest, t, rows } = each, labels = labelsOf(each);
    const extreme = ({ value, t: at, member }: (typeof least)[0]) => `${words(value, unit)}${at === null ? "" : ` at ${words(at, units.time)}`}${member ? ` in ${member}` : ""}`;
    const range = (from: (typeof least)[0], to: typeof from) => (words(from.value, unit) === words(to.value, unit) ? words(to.value, unit) : `least ${extreme(from)}, largest ${extreme(to)}`);
    const rounding = 1e-8, exceeds = (x: Figure, end: Figure) => x !== null && end !== null && x > end + rounding * Math.abs(end), minus = (x: Figure) => x && -x;
    const isBeyond = (x: Figure, k: number) => exceeds(x, largest[k].value) || exceeds(minus(x), minus(least[k].value));
    const told = rows.some((row) => row.some((x, k) => isBeyond(x, k % least.length))) ? "at output times: " : ""; // between them the curve goes further
    charts.add({ title: name + (labels.length > most ? ` (${most} of ${labels.length} curves)` : ""), unit, times: t,
      unknown: each.unknown ?? "not known",
      note: told + least.map((each, k) => `${parts[k] ? `${parts[k]}: ` : ""}${range(each, largest[k])}`).join("; "),
      curves: labels.slice(0, most).map((label, k) => ({ label, numbers: rows.map((row) => row[k]) })) });
  }
  const energies: [string, string][] = [["kinetic + potential", "energy"], ["kinetic", "kinetic"], ["potential", "potential"]];
  addHistory(charts, history, "Energy", units.energy, energies);
}

function addHistory(charts: Charts, history: PageData["history"], title: string, unit: string, curves: [string, string][], isLog = false): void {
  charts.add({ title, unit, isLog, times: history.t as number[], curves: curves.map(([label, key]) => ({ label, numbers: history[key] ?? [] })) });
}

/** The histories of the computation. */
export function addDiagnostics(charts: Charts, { history, error_time: errors }: PageData): void {
  const add = (title: string, unit: string, curves: [string, string][], isLog = true) => addHistory(charts, history, title, unit, curves, isLog);
  add("Energy drift", "drift / scale", [["drift / scale", "drift"]], false);
  add("Violation of the constraints", "relative", [["positions", "position_violation"], ["velocities", "velocity_violation"], ["accelerations", "acceleration_violation"]]);
  add("Conditioning of the equations", "reciprocal", [["reciprocal condition", "reciprocal_condition"]]);
  add("Step of the method", units.time, [["step", "step"]]);
  if (history.friction_iterations?.some((count) => (count ?? 0) > 0)) add("Friction iterations", "count", [["an instant", "friction_iterations"]], false);
  charts.addErrorTime(errors);
}
