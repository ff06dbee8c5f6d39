/** A number; null if it was not computed or is not finite. */
export type Figure = number | null;

/** The letters behind numbers; empty where a scene has none. */
export const units = { length: "m", force: "N", time: "s", energy: "J", rate: "1/s", angular_velocity: "rad/s" };

/** Returns "t, s" or "t". */
export const measure = (name: string, unit: string) => (unit ? `${name}, ${unit}` : name);

/** The facts of a run that the page shows, out of those that src/program/report/html_page.cpp writes. Times are in s. */
export interface Run {
  scene: string;
  version: string;
  method: string;
  threads: number;
  points: number;
  rods: number;
  equations: number;
  islands: number;
  steps: number;
  rejected: number;
  has_started: boolean; // false: no start was found, and nothing is known of the motion
  t_start: number;
  t_resumed: number | null;
  t_end: number;
  t_reached: number;
  certificate: { passed: boolean | null; certified_to: Figure; verdict: string | null; checks: { words: string; identity: string; error: Figure }[] }; // null if there is none
  wants_certificate: boolean;
  warnings: string[];
  left_out: string[];
  drift: Figure;
  position_violation: Figure;
  velocity_violation: Figure;
  wall: { total: number } & Record<string, number>; // by phase
  is_running: boolean;
  text: string; // empty while the run goes on
  is_at_rest?: boolean; // an equilibrium, or modes about one: many of these facts are missing
}

/** A run of `tanor error-time`. */
export interface ErrorTimeRow {
  method: string;
  wall_s: number | null;
  error: number | null; // null if t_end was not reached
}

interface Extreme { value: Figure; t: Figure; member: string }

/** A named number over time, or the parts of a vector, of one thing or of several members. */
export interface Observable {
  name: string;
  unit: string;
  parts: string[]; // empty for a number
  members: string[]; // empty for one thing alone
  least: Extreme[]; // of each part, or one
  largest: Extreme[];
  t: number[];
  unknown: string | null; // why there are none among its numbers
  rows: Figure[][]; // one for each time: the parts of each member, member by member
}

/** The data that src/program/report/html_page.cpp puts into the page. */
export interface PageData {
  run: Run;
  units?: Partial<typeof units>;
  observables?: Observable[];
  modes?: { omega: number[]; decay: number[] }; // rad/s, 1/s; of small vibrations about the one frame
  motion: Motion;
  colours: Colours;
  history: Record<string, Figure[]>;
  events: { t: number; kind: string; what: string }[]; // the first ones of each kind
  events_seen: Record<string, number>; // number of each kind
  error_time: ErrorTimeRow[];
}

/** The colours of src/program/report/colours.hpp, as "#rrggbb". */
export interface Colours {
  tensions: [number, number]; // N, ends of the scale; 0 and 0 without rods
  pulled: string[]; // from no tension to the end, evenly spaced
  pushed: string[];
  unknown: string; // of a tension that is not known
  bead: string;
  support: string;
  earth: string;
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

/** A rope, formula or spring between points, and the places of the sheaves that it passes on its way from the first point. */
export interface Tie {
  kind: string;
  name: string;
  points: number[];
  sheaves: number[][];
  lengths?: number[]; // of a rope: one, or one for each frame
  coefficients?: number[]; // of its segments
}

/** How many of the ties have a multiplier: ropes, pulleys and formulas, which come first. */
export const countRopes = ({ ties }: Motion) => ties.filter(({ kind }) => kind !== "spring" && kind !== "bond").length;

/** A group of rods, of which all or some members are shown. */
export interface RodGroup {
  name: string;
  first: number; // its first rod among those that are shown
  members: number[]; // number of each rod in the group; empty if all are shown
}

export interface Motion {
  points: number;
  numbers: number[]; // of each point in the scene; empty if all are shown
  rods: number;
  rod_groups: RodGroup[];
  times: number[];
  frames_seen: number;
  supports: number[];
  support_names: string[]; // of the entries that hold them
  pivots: number[][]; // point, place: the middle of the circle on which a support moves
  gone: Record<"rods" | "ties" | "supports" | "guides", [number, number][]>; // number, time since which events have taken it out
  images: number[][]; // point, offset
  guides: Guide[];
  ties: Tie[];
  cell: { edges: number[][]; origin: number[] | null } | null; // of a periodic sample; around the middle if no origin is known
  without_picture: string[];
  has_friction: boolean;
  up: number[]; // 0 without gravity
  ranges: Record<NameOfRows, [number, number][]>; // one, or one for each row
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

/** Numbers for each frame. */
export interface Frames {
  columns: number;
  get(frame: number, column: number): number;
  step(frame: number): number; // the smallest difference of two numbers
  read(frame: number, weights: number[], into: Float32Array): void;
}

const unknown = 65535;

/** Rows of numbers in 65535 steps between two ends, which are those of all rows or of each row. */
export class Rows implements Frames {
  constructor(private steps: Uint16Array, readonly columns: number, private ranges: [number, number][]) {}

  private least = (frame: number) => this.ranges[Math.min(frame, this.ranges.length - 1)][0];

  step(frame: number): number {
    const [least, most] = this.ranges[Math.min(frame, this.ranges.length - 1)];
    return (most - least) / (unknown - 1);
  }

  /** A row that lasts stands for all later ones. What is less than half a step from 0 is 0. */
  get(frame: number, column: number): number {
    const row = Math.min(frame, this.steps.length / this.columns - 1);
    const step = this.steps[row * this.columns + column];
    const number = this.least(row) + this.step(row) * step;
    return step === unknown ? NaN : Math.abs(number) < 0.5 * this.step(row) ? 0 : number;
  }

  /** Reads row `frame` plus `part` of the way to the next one, with the weights of four rows (weighRows). What is not known in the next one stays. */
  read(frame: number, weights: number[], into: Float32Array): void {
    if (this.columns === 0) return;
    const last = this.steps.length / this.columns - 1, s = this.steps;
    const rows = [frame - 1, frame, frame + 1, frame + 2].map((k) => Math.min(Math.max(k, 0), last));
    const least = rows.reduce((sum, row, k) => sum + weights[k] * this.least(row), 0);
    const [wa, wb, wc, wd] = rows.map((row, k) => weights[k] * this.step(row));
    const [a, b, c, d] = rows.map((row) => row * this.columns);
    for (let k = 0; k < this.columns; ++k)
      into[k] = s[c + k] === unknown && wc ? this.get(rows[1], k) : s[b + k] === unknown ? NaN : least + (wa * s[a + k] + wb * s[b + k] + wc * s[c + k] + wd * s[d + k]);
  }
}

/** Number of pictures of a period of a mode. */
export const frames_of_period = 48;

/** Places of points that swing in a mode: r + a q cos(2 pi k / frames_of_period) at frame k. */
export class Swing implements Frames {
  readonly columns: number;
  private moves: Float32Array;

  /** The largest move is a sixteenth of the size of all that there is. */
  constructor(private rest: Rows, shapes: Rows, mode: number) {
    this.columns = rest.columns;
    this.moves = new Float32Array(this.columns);
    const least = [Infinity, Infinity, Infinity], most = [-Infinity, -Infinity, -Infinity];
    let square = 0;
    for (let k = 0; k < this.columns; k += 3) {
      for (let axis = 0; axis < 3; ++axis) {
        this.moves[k + axis] = shapes.get(mode, k + axis);
        least[axis] = Math.min(least[axis], rest.get(0, k + axis));
        most[axis] = Math.max(most[axis], rest.get(0, k + axis));
      }
      square = Math.max(square, this.moves[k] ** 2 + this.moves[k + 1] ** 2 + this.moves[k + 2] ** 2);
    }
    const size = Math.hypot(...most.map((x, axis) => x - least[axis])) || 1;
    if (square > 0) for (let k = 0; k < this.columns; ++k) this.moves[k] *= size / 16 / Math.sqrt(square);
  }
  step = () => this.rest.step(0);
  private phase = (frame: number) => Math.cos((2 * Math.PI * frame) / frames_of_period);
  get(frame: number, column: number): number { return this.rest.get(0, column) + this.phase(frame) * this.moves[column]; }
  read(frame: number, weights: number[], into: Float32Array): void {
    const part = weights.reduce((sum, weight, k) => sum + weight * this.phase(frame - 1 + k), 0);
    for (let k = 0; k < this.columns; ++k) into[k] = this.rest.get(0, k) + part * this.moves[k];
  }
}

const names_of_rows = ["positions", "tensions", "normal", "tangent", "ties", "shapes"] as const;
type NameOfRows = (typeof names_of_rows)[number];

export interface Arrays extends Record<Exclude<NameOfRows, "positions">, Rows> {
  rods: Int32Array;
  held: Int32Array;
  positions: Frames;
}

export function readPage(page: Document): { data: PageData; packed: string } {
  const text = (id: string) => page.getElementById(id)!.textContent!;
  return { data: JSON.parse(text("data")), packed: text("motion").trim() };
}

/** Unpacks the arrays that src/program/report/packed_bytes.cpp packed. */
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
  const rows = (name: NameOfRows) => {
    const { at, count, columns } = find(name) ?? { at: 0, count: 0, columns: 1 };
    const steps = new Uint16Array(count);
    for (let k = 0; k < count; ++k)
      steps[k] = (k >= columns ? steps[k - columns] : 0) + bytes[at + k] + (bytes[at + count + k] << 8);
    return new Rows(steps, count > 0 ? columns : 0, motion.ranges[name]);
  };
  return { rods: whole("rods"), held: whole("held"), ...(Object.fromEntries(names_of_rows.map((name) => [name, rows(name)])) as Record<NameOfRows, Rows>) };
}

/** Returns "1.23e-7 N" and the like, rounded to `digits` digits. */
export function words(number: Figure | undefined, unit = "", digits = 4): string {
  if (number === null || number === undefined || !Number.isFinite(number)) return "not known";
  const size = Math.abs(number);
  const text = size !== 0 && (size < 1e-3 || size >= 1e5) ? number.toExponential(digits - 1) : String(+number.toPrecision(digits));
  return unit ? `${text}${/^[0-9]/.test(unit) ? " x" : ""} ${unit}` : text;
}

/** Returns a computing time as "45.2 ms". */
export function wait(time: number): string {
  const [factor, unit] = time >= 1 ? [1, "s"] : time >= 1e-3 ? [1e3, "ms"] : [1e6, "µs"];
  return words(factor * time, unit, 3);
}
