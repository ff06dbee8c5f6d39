import { Matrix4, Vector3, type PerspectiveCamera } from "three";
import { measure, units, words, type Colours } from "./data";

const ink = "#3d4752", font = '12px system-ui, "Segoe UI", "DejaVu Sans", sans-serif';
const bins = 25, bar_width = 210, bar_height = 9, most_height = 40;

/** Returns 1, 2 or 5 times a power of ten, at most `most`. */
function roundDown(most: number): number {
  const power = 10 ** Math.floor(Math.log10(most));
  return power * [5, 2, 1].find((digit) => digit * power <= most * (1 + 1e-9))!;
}

/** What stands over the picture and in its files: colours with the histogram of tensions, a scale bar, the axes, the time. */
export class Overlay {
  readonly bounds: string[]; // of the colours, in words
  private hasColours: boolean;

  /** `extremes`: the tensions of all frames, N. */
  constructor(private colours: Colours, extremes: [number, number]) {
    const [least, most] = colours.tensions, of = (tension: number) => words(tension).replace("-", "−");
    this.hasColours = least < most;
    this.bounds = [(extremes[0] < least && least < 0 ? "< " : "") + of(least), (extremes[1] > most && most > 0 ? "> " : "") + of(most)];
    if (least < 0 && most > 0) this.bounds.splice(1, 0, "0");
  }

  paint(c: CanvasRenderingContext2D, width: number, height: number, now: { time: string; tensions: Float32Array; hasUnknown: boolean; camera: PerspectiveCamera; pixelsPerMetre: number }): void {
    c.font = font;
    c.lineCap = "round";
    const title = this.hasColours ? measure(`tension of ${now.tensions.length === 1 ? "the rod" : `${now.tensions.length} rods`}`, units.force) : "";
    if (title) this.paintTensions(c, Math.min(bar_width, width - 32), title, now.tensions);
    if (now.hasUnknown) this.paintUnknown(c, ...(!title ? [16, 22] as const : bar_width + 140 < width ? [32 + bar_width, 30 + most_height + bar_height] as const : [16, 66 + most_height + bar_height] as const));
    const isBeside = c.measureText(title).width + c.measureText(now.time).width + 44 < width;
    c.fillStyle = ink;
    c.textAlign = "right";
    c.fillText(now.time, width - 14, isBeside ? 26 : 72 + most_height + bar_height);
    this.paintAxes(c, 44, height - 44, now.camera);
    this.paintScale(c, width - 16, height - 16, Math.min(150, width / 3), now.pixelsPerMetre);
  }

  private paintTensions(c: CanvasRenderingContext2D, wide: number, title: string, tensions: Float32Array): void {
    const { tensions: [least, most], pushed, pulled } = this.colours, left = 16, foot = 30 + most_height;
    const stops = least < 0 ? [...pushed].reverse().concat(most > 0 ? pulled.slice(1) : []) : pulled;
    const shade = c.createLinearGradient(left, 0, left + wide, 0), counts = new Array<number>(bins).fill(0);
    stops.forEach((colour, k) => shade.addColorStop(k / (stops.length - 1), colour));
    for (const tension of tensions) if (Number.isFinite(tension)) ++counts[Math.min(bins - 1, Math.max(0, Math.floor((bins * (tension - least)) / (most - least))))];
    const largest = Math.max(1, ...counts);
    c.fillStyle = shade;
    counts.forEach((count, k) => c.fillRect(left + (wide * k) / bins, foot - 2, wide / bins - 1, -Math.max(count ? 1.5 : 0, (most_height * count) / largest)));
    c.fillRect(left, foot, wide, bar_height);
    c.fillStyle = ink;
    c.textAlign = "left";
    c.fillText(title, left, 22);
    this.bounds.forEach((bound, k) => {
      const part = k / (this.bounds.length - 1);
      c.textAlign = part === 0 ? "left" : part === 1 ? "right" : "center";
      c.fillText(bound, left + part * wide, foot + bar_height + 14);
    });
  }

  private paintUnknown(c: CanvasRenderingContext2D, left: number, foot: number): void {
    c.fillStyle = this.colours.unknown;
    for (const dash of [0, 10, 20]) c.fillRect(left + dash, foot - 6, 5, 4);
    c.fillStyle = ink;
    c.textAlign = "left";
    c.fillText("not known", left + 32, foot);
  }

  private paintAxes(c: CanvasRenderingContext2D, x: number, y: number, camera: PerspectiveCamera): void {
    const toEye = new Matrix4().extractRotation(camera.matrixWorldInverse);
    const axes = [["x", "#c0392b"], ["y", "#1e8449"], ["z", "#2a6fb0"]].map(([name, colour], k) => ({ name, colour, tip: new Vector3().setComponent(k, 1).applyMatrix4(toEye) }));
    c.textAlign = "center";
    c.lineWidth = 2;
    for (const { name, colour, tip } of axes.sort((a, b) => a.tip.z - b.tip.z)) {
      c.strokeStyle = c.fillStyle = colour;
      c.beginPath();
      c.moveTo(x, y);
      c.lineTo(x + 24 * tip.x, y - 24 * tip.y);
      c.stroke();
      c.fillText(name, x + 33 * tip.x, y - 33 * tip.y + 4);
    }
  }

  /** The bar is right in the middle of the picture, since nearer things look larger. */
  private paintScale(c: CanvasRenderingContext2D, right: number, bottom: number, most: number, pixelsPerMetre: number): void {
    const length = roundDown(most / pixelsPerMetre), pixels = length * pixelsPerMetre;
    c.strokeStyle = c.fillStyle = ink;
    c.lineWidth = 1.5;
    c.beginPath();
    c.moveTo(right - pixels, bottom - 5);
    c.lineTo(right - pixels, bottom);
    c.lineTo(right, bottom);
    c.lineTo(right, bottom - 5);
    c.stroke();
    c.textAlign = "center";
    c.fillText(words(length, units.length), right - pixels / 2, bottom - 7);
  }
}
