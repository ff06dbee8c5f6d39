import uPlot from "uplot";
import { words, type ErrorTimeRow, type PageData } from "./data";
import { find } from "./dom";

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
const colourOfEvent: Record<string, string> = { contact: "--warn", rank: "--accent", singular: "--tangent" };
/** The curves also differ in their dashes. */
const strokes = ["#2a7fc9", "#d9730d", "#0f9d78", "#b0398b", "#8a8f2a", "#7a5bd0", "#5c6773"];
const dashes = [[], [7, 3], [2, 3], [9, 3, 2, 3]];

const lineOf = (k: number) => ({ stroke: strokes[k % strokes.length], dash: dashes[k % dashes.length], width: 1.6 });
const tell = (_: uPlot, number: number | null) => (number === null ? "–" : words(number));

/** Draws histories over the time of the motion. All charts share the time of the view, and a click selects a time. */
export class Charts {
  private plots: uPlot[] = [];
  private watches: ResizeObserver[] = [];
  private time = 0;
  private index = 0; // last step before this time

  constructor(private host: HTMLElement, private data: PageData, private seek: (time: number) => void) {
    const h = data.history;
    this.add("Energy drift", [["drift / scale", "drift"]], "", false);
    this.add("Energy", [["kinetic + potential", "energy"], ["kinetic", "kinetic"], ["potential", "potential"]], "J", false);
    this.add("Violation", [["positions", "position_violation"], ["velocities", "velocity_violation"], ["accelerations", "acceleration_violation"]], "relative", true);
    this.add("Conditioning", [["reciprocal condition", "reciprocal_condition"]], "", true);
    this.add("Step", [["step", "step"]], "s", true);
    if (h.friction_iterations.some((count) => (count ?? 0) > 0)) this.add("Friction iterations", [["an instant", "friction_iterations"]], "", false);
    this.addErrorTime(data.error_time);
  }

  dispose(): void {
    for (const watch of this.watches) watch.disconnect();
    for (const plot of this.plots) plot.destroy();
    this.host.replaceChildren();
  }

  /** Puts the bar of the view at a time, and the values of that time into the legends. */
  stand(time: number): void {
    this.time = time;
    const times = this.data.history.t as number[];
    this.index = 0;
    while (this.index + 1 < times.length && times[this.index + 1] <= time) ++this.index;
    for (const plot of this.plots) {
      plot.redraw(false, false);
      plot.setLegend({ idx: this.index });
    }
  }

  private card(title: string): HTMLElement {
    const card = document.createElement("div");
    card.className = "card";
    const head = document.createElement("h2");
    head.textContent = title;
    card.append(head);
    this.host.append(card);
    return card;
  }

  /** Keeps a plot as wide as its card; `tellAgain` fills the legend, which a resize empties. */
  private fit(plot: uPlot, card: HTMLElement, tellAgain = () => {}): void {
    const watch = new ResizeObserver(() => { plot.setSize({ width: card.clientWidth - 34, height: 190 }); tellAgain(); });
    watch.observe(card);
    this.watches.push(watch);
  }

  private axes(isLog: boolean): uPlot.Axis[] {
    const common = { stroke: style("--soft"), grid: { stroke: style("--line"), width: 1 }, ticks: { stroke: style("--line"), width: 1 }, font: "11px system-ui, sans-serif" };
    // Grid lines are drawn at powers of ten only.
    const filter = (_: uPlot, splits: number[]) => splits.map((y) => (!isLog || (y > 0 && Number.isInteger(+Math.log10(y).toFixed(9))) ? y : null));
    // Ticks are rounded: 0.30000000000000004 becomes 0.3. Small numbers such as 0.0000025 would not fit beside the axis.
    const isLong = (tick: number) => tick !== 0 && (Math.abs(tick) < 1e-3 || Math.abs(tick) >= 1e5);
    const short = (tick: number) => (isLog || isLong(tick) ? (+tick.toPrecision(3)).toExponential() : String(+tick.toPrecision(6)));
    return [{ ...common, size: 30 }, { ...common, grid: { ...common.grid, filter }, size: 64, values: (_, ticks) => ticks.map((tick) => (tick === null ? "" : short(tick))) }];
  }

  private add(title: string, series: [string, string][], unit: string, isLog: boolean): void {
    const times = this.data.history.t as number[];
    if (!times || times.length < 2) return;
    const columns = series.map(([, key]) => this.data.history[key].map((y) => (isLog && !(y! > 0) ? null : y)));
    if (columns.every((column) => column.every((y) => y === null))) return;
    const card = this.card(unit ? `${title} (${unit})` : title);
    const plot = new uPlot({
      width: card.clientWidth - 34, height: 190, pxAlign: 0,
      cursor: { sync: { key: "time" }, y: false, drag: { x: false, y: false } },
      scales: { x: { time: false }, y: isLog ? logarithmic : linear },
      axes: this.axes(isLog),
      series: [{ label: "t / s", value: tell },
        ...series.map(([label], k) => ({ label, ...lineOf(k), points: { show: false }, value: tell }))],
      hooks: { draw: [(drawn) => this.drawMarks(drawn)] },
    }, [times, ...columns] as uPlot.AlignedData, card);
    plot.over.addEventListener("click", (event) => this.seek(plot.posToVal(event.offsetX, "x")));
    this.plots.push(plot);
    const tellAgain = () => plot.setLegend({ idx: this.index });
    plot.over.addEventListener("mouseleave", () => setTimeout(tellAgain)); // which empties the legend, too
    this.fit(plot, card, tellAgain);
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
    for (const event of this.data.events) bar(event.t, colours[event.kind], 1.5 * devicePixelRatio, 7 * devicePixelRatio);
    bar(this.time, style("--accent"), 1.5 * devicePixelRatio, bbox.height);
    ctx.restore();
  }

  /** Draws error against wall time from the table of `tanor error-time`, with one curve for each method. */
  private addErrorTime(rows: ErrorTimeRow[]): void {
    find("errors-line").hidden = rows.length > 0;
    const methods = [...new Set(rows.map((row) => row.method))];
    const points = rows.map((row) => ({ method: row.method, wall: row.wall_s ?? 0, error: row.error_m ?? 0 }))
      .filter((point) => point.wall > 0 && point.error > 0).sort((p, q) => p.wall - q.wall);
    if (!points.length) return;
    const card = this.card("Error against run time (m, s), by method");
    const plot = new uPlot({
      width: card.clientWidth - 34, height: 190, scales: { x: { time: false, ...logarithmic }, y: logarithmic }, axes: this.axes(true).map((axis) => ({ ...axis, values: (_: uPlot, ticks: number[]) => ticks.map((tick) => (tick === null ? "" : tick.toExponential(0))) })),
      cursor: { drag: { x: false, y: false } },
      series: [{ label: "run time / s", value: tell }, ...methods.map((label, k) => ({ label, ...lineOf(k), spanGaps: true, points: { show: true, size: 6 }, value: tell }))],
    }, [points.map((p) => p.wall), ...methods.map((method) => points.map((p) => (p.method === method ? p.error : null)))] as uPlot.AlignedData, card);
    this.fit(plot, card);
  }
}
