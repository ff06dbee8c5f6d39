/** A number; null if it was not computed or is not finite. */
type Figure = number | null;

/** The facts of a run that the page shows, out of those that src/report/html_page.cpp writes. Times are in s. */
export interface Run {
  scene: string;
  version: string;
  method: string;
  threads: number;
  points: number;
  equations: number;
  islands: number;
  steps: number;
  rejected: number;
  has_started: boolean; // false: no start was found, and nothing is known of the motion
  t_start: number;
  t_resumed: number | null;
  t_end: number;
  t_reached: number;
  certificate: { checks: { identity: string; error: Figure }[] };
  certificate_line: string;
  certified_to: Figure;
  certificate_passed: boolean | null; // null if there is none
  wants_certificate: boolean;
  warnings: string[];
  left_out: string[];
  drift: Figure;
  position_violation: Figure;
  velocity_violation: Figure;
  wall: { total: number } & Record<string, number>; // by phase
  is_running: boolean;
  text: string; // empty while the run goes on
}

/** A run of `tanor error-time`. */
export interface ErrorTimeRow {
  method: string;
  wall_s: number | null;
  error_m: number | null; // null if t_end was not reached
}

/** The data that src/report/html_page.cpp puts into the page. */
export interface PageData {
  run: Run;
  motion: Motion;
  colours: Colours;
  history: Record<string, Figure[]>;
  events: { t: number; kind: string; what: string }[]; // the first ones of each kind
  events_seen: Record<string, number>; // number of each kind
  error_time: ErrorTimeRow[];
}

/** The colours of src/report/colours.hpp, as "#rrggbb". */
export interface Colours {
  tensions: [number, number]; // N, ends of the scale; 0 and 0 without rods
  pulled: string[]; // from no tension to the end, evenly spaced
  pushed: string[];
  bead: string;
  support: string;
  normal: string;
  tangent: string;
  guide: string;
  ground: string;
  ink: string;
}

export interface Guide {
  kind: string;
  name: string;
  rows: number[][]; // one, or one for each frame
}

export interface Motion {
  points: number;
  rods: number;
  times: number[];
  frames_seen: number;
  supports: number[];
  images: number[][]; // point, offset
  guides: Guide[];
  without_picture: string[];
  has_friction: boolean;
  up: number[];
  ranges: Record<"positions" | "tensions" | "normal" | "tangent", [number, number][]>; // one, or one for each frame
  arrays: { name: string; type: string; at: number; count: number; columns: number }[];
}

/**
 * Returns the weights of rows `frame` - 1 to `frame` + 2 at `part` of the way from row `frame` to the next one. The interpolation is
 * cubic, with the slopes of parabolas through three rows at their times, or of the straight line if the third row is missing or much
 * nearer than the second.
 */
export function weighRows(times: number[], frame: number, part: number): number[] {
  const span = (k: number) => (k >= 0 && k + 1 < times.length ? times[k + 1] - times[k] : 0);
  const ratio = (k: number) => (span(k) > span(frame) / 8 ? span(frame) / span(k) : 0);
  const r = ratio(frame - 1), s = ratio(frame + 1);
  const u = part, end = u * u * (3 - 2 * u), first = u * (1 - u) * (1 - u), second = -u * u * (1 - u); // Hermite's
  const [a, b, c, d] = [(r * r) / (1 + r), 1 / (1 + r), 1 / (1 + s), (s * s) / (1 + s)];
  return [-a * first, 1 - end + (a - b) * first - c * second, end + b * first + (c - d) * second, d * second];
}

/** Rows of numbers in 65536 steps between two ends, which are those of all rows or of each row. */
export class Rows {
  constructor(private steps: Uint16Array, readonly columns: number, private ranges: [number, number][]) {}

  private least = (frame: number) => this.ranges[Math.min(frame, this.ranges.length - 1)][0];

  /** Returns the smallest difference of two numbers. */
  step(frame: number): number {
    const [least, most] = this.ranges[Math.min(frame, this.ranges.length - 1)];
    return (most - least) / 65535;
  }

  get(frame: number, column: number): number {
    return this.least(frame) + this.step(frame) * this.steps[frame * this.columns + column];
  }

  /** Reads row `frame` plus `part` of the way to the next one, with the weights of four rows (weighRows). */
  read(frame: number, weights: number[], into: Float32Array): void {
    if (this.columns === 0) return;
    const last = this.steps.length / this.columns - 1, s = this.steps;
    const rows = [frame - 1, frame, frame + 1, frame + 2].map((k) => Math.min(Math.max(k, 0), last));
    const least = rows.reduce((sum, row, k) => sum + weights[k] * this.least(row), 0);
    const [wa, wb, wc, wd] = rows.map((row, k) => weights[k] * this.step(row));
    const [a, b, c, d] = rows.map((row) => row * this.columns);
    for (let k = 0; k < this.columns; ++k)
      into[k] = least + (wa * s[a + k] + wb * s[b + k] + wc * s[c + k] + wd * s[d + k]);
  }
}

export interface Arrays {
  rods: Int32Array;
  held: Int32Array;
  positions: Rows;
  tensions: Rows;
  normal: Rows;
  tangent: Rows;
}

export function readPage(page: Document): { data: PageData; packed: string } {
  const text = (id: string) => page.getElementById(id)!.textContent!;
  return { data: JSON.parse(text("data")), packed: text("motion").trim() };
}

/** Unpacks the arrays that src/report/packed_bytes.cpp packed. */
export async function unpack(motion: Motion, packed: string): Promise<Arrays> {
  const text = atob(packed), letters = new Uint8Array(text.length);
  for (let k = 0; k < text.length; ++k) letters[k] = text.charCodeAt(k);
  const stream = new Blob([letters]).stream().pipeThrough(new DecompressionStream("deflate"));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  const find = (name: string) => motion.arrays.find((array) => array.name === name)!;
  const whole = (name: string) => {
    const { at, count } = find(name);
    return new Int32Array(bytes.slice(at, at + 4 * count).buffer);
  };
  const rows = (name: "positions" | "tensions" | "normal" | "tangent") => {
    const { at, count, columns } = find(name);
    const steps = new Uint16Array(count);
    for (let k = 0; k < count; ++k)
      steps[k] = (k >= columns ? steps[k - columns] : 0) + bytes[at + k] + (bytes[at + count + k] << 8);
    return new Rows(steps, count > 0 ? columns : 0, motion.ranges[name]);
  };
  return { rods: whole("rods"), held: whole("held"), positions: rows("positions"), tensions: rows("tensions"),
    normal: rows("normal"), tangent: rows("tangent") };
}

/** Returns "1.23e-7 N" and the like, rounded to `digits` digits. */
export function words(number: Figure | undefined, unit = "", digits = 4): string {
  if (number === null || number === undefined || !Number.isFinite(number)) return "not known";
  const size = Math.abs(number);
  const text = size !== 0 && (size < 1e-3 || size >= 1e5) ? number.toExponential(digits - 1) : String(+number.toPrecision(digits));
  return unit ? `${text} ${unit}` : text;
}

/** Returns a computing time as "45.2 ms". */
export function wait(time: number): string {
  const [factor, unit] = time >= 1 ? [1, "s"] : time >= 1e-3 ? [1e3, "ms"] : [1e6, "µs"];
  return words(factor * time, unit, 3);
}
