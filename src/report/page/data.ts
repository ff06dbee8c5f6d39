/** What src/report/html_page.cpp puts into the page. */
export interface PageData {
  run: any;
  motion: Motion;
  history: Record<string, (number | null)[]>;
  events: { t: number; kind: string; what: string }[];
  error_time: string;
}

export interface Guide {
  kind: string;
  name: string;
  rows: number[][]; // one, or one a frame
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
  ranges: Record<"positions" | "tensions" | "normal" | "tangent", [number, number]>;
  arrays: { name: string; type: string; at: number; count: number; columns: number }[];
}

/** Rows of numbers in 65536 steps between two ends. */
export class Rows {
  constructor(private steps: Uint16Array, readonly columns: number, private range: [number, number]) {}

  get(frame: number, column: number): number {
    const [least, most] = this.range;
    return least + ((most - least) / 65535) * this.steps[frame * this.columns + column];
  }

  /** Row `frame` plus `part` of the way to the next one, linear, or along Catmull and Rom's curve through four rows. */
  read(frame: number, part: number, isCurve: boolean, into: Float32Array): void {
    const frames = this.steps.length / this.columns, last = frames - 1;
    const [least, most] = this.range, scale = (most - least) / 65535;
    const row = (k: number) => Math.min(Math.max(k, 0), last) * this.columns;
    const [a, b, c, d] = [row(frame - 1), row(frame), row(frame + 1), row(frame + 2)];
    const u = part, s = this.steps;
    const curved = isCurve && frames > 3;
    const wa = curved ? 0.5 * u * (-1 + u * (2 - u)) : 0, wb = curved ? 0.5 * (2 + u * u * (-5 + 3 * u)) : 1 - u;
    const wc = curved ? 0.5 * u * (1 + u * (4 - 3 * u)) : u, wd = curved ? 0.5 * u * u * (u - 1) : 0;
    for (let k = 0; k < this.columns; ++k)
      into[k] = least + scale * (wa * s[a + k] + wb * s[b + k] + wc * s[c + k] + wd * s[d + k]);
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

/** Unpacks what src/report/packed_bytes.cpp packed. */
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

/** "1.23e-7 N" and the like, to four digits. */
export function words(number: number | null | undefined, unit = ""): string {
  if (number === null || number === undefined || !Number.isFinite(number)) return "undefined";
  const size = Math.abs(number);
  const text = size !== 0 && (size < 1e-3 || size >= 1e5) ? number.toExponential(3) : String(+number.toPrecision(4));
  return unit ? `${text} ${unit}` : text;
}
