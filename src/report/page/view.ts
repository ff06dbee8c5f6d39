import { Group, Line, Mesh, Object3D, PerspectiveCamera, Points, Scene, Vector3, WebGLRenderer } from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { weighRows, type Arrays, type Colours, type Motion } from "./data";
import { Beads, Ribbons, drawGuide, makeHaze, type Haze } from "./shapes";

type Rgb = [number, number, number]; // sRGB, 0 … 1

const readColour = (text: string) => [1, 3, 5].map((at) => parseInt(text.slice(at, at + 2), 16) / 255) as Rgb;

/** Returns the largest size below the top 3 %, so that outliers do not grey the others. */
function typicalLargest(read: (k: number) => number, count: number): number {
  const sizes: number[] = [], stride = Math.max(1, Math.floor(count / 20000));
  for (let k = 0; k < count; k += stride) sizes.push(Math.abs(read(k)));
  sizes.sort((x, y) => x - y);
  return sizes.length ? sizes[Math.floor(0.97 * (sizes.length - 1))] : 0;
}

/** The canvas, the camera and its controls, which outlive the views of one run. */
export class Stage {
  readonly renderer: WebGLRenderer;
  readonly camera = new PerspectiveCamera(35, 1, 0.01, 1000);
  controls: OrbitControls;
  resized: (width: number, height: number) => void = () => {};

  constructor(readonly host: HTMLElement, private changed: () => void) {
    this.renderer = new WebGLRenderer({ antialias: true, alpha: true });
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio));
    host.appendChild(this.renderer.domElement);
    this.controls = this.makeControls();
    new ResizeObserver(() => { this.resize(); changed(); }).observe(host);
  }

  /** Sets the direction around which a hand turns the picture. OrbitControls read it only when they are made. */
  setUp(up: Vector3): void {
    this.camera.up.copy(up);
    this.controls.dispose();
    this.controls = this.makeControls();
  }

  private makeControls(): OrbitControls {
    const controls = new OrbitControls(this.camera, this.renderer.domElement);
    controls.addEventListener("change", this.changed);
    return controls;
  }

  resize(): void {
    const width = this.host.clientWidth, height = this.host.clientHeight, ratio = this.renderer.getPixelRatio();
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.resized(width * ratio, height * ratio);
  }
}

/** Releases the graphics memory of everything drawn in an object. */
function release(drawn: Object3D): void {
  drawn.traverse((child) => {
    if (!(child instanceof Mesh || child instanceof Line || child instanceof Points)) return;
    child.geometry.dispose();
    for (const material of [child.material].flat()) material.dispose();
  });
}

const most_shades = 256; // from no tension to the end of the scale

/** The motion in 3-D. */
export class View {
  readonly scale: number; // N, the end of the colours
  readonly newtonsPerSize: number; // N, force of an arrow as long as a sixth of the picture
  readonly tensions: Float32Array; // now
  tensionStep = 0; // N, resolution of the packed tensions
  chosen = 0;
  shows = { points: true, rods: true, guides: true, normal: true, tangent: true };
  private shades: Float32Array; // of tensions from -scale to scale
  readonly scene = new Scene(); // tests find rods, arrows and guides in it by their names
  private places: Float32Array;
  private normal: Float32Array;
  private tangent: Float32Array;
  private haze: Haze;
  private beads: Beads;
  private beadRadius: number; // m
  private rods: Ribbons;
  private mark: Ribbons; // around the chosen rod, which keeps its colour
  private normalArrows: Ribbons;
  private tangentArrows: Ribbons;
  private guides = new Group();
  private guideFrame = -1;
  private middle = new Vector3();
  size = 1; // m, size of all that is shown
  private frame = 0;

  constructor(private stage: Stage, private motion: Motion, private arrays: Arrays, private colours: Colours, looksAnew: boolean) {
    this.places = new Float32Array(arrays.positions.columns);
    this.tensions = new Float32Array(arrays.tensions.columns);
    this.normal = new Float32Array(arrays.normal.columns);
    this.tangent = new Float32Array(arrays.tangent.columns);
    const frames = motion.times.length;
    const over = (rows: Arrays["tensions"]) => typicalLargest((k) => rows.get(Math.floor(k / rows.columns), k % rows.columns), frames * rows.columns);
    this.scale = Math.max(colours.tensions[1], -colours.tensions[0]);
    this.shades = this.mixShades();
    this.measure();
    const held = arrays.held.length, many = motion.points > 3000;
    const bead = many ? 0.0017 * this.size : Math.min(0.016, 0.06 / Math.sqrt(motion.points)) * this.size;
    this.haze = makeHaze(readColour(colours.ground), many ? 0.85 : 0.35);
    this.beadRadius = bead * (many ? 1.3 : 1);
    this.beads = new Beads(motion.points, this.beadRadius, many ? 1.5 : 4, this.haze);
    this.rods = new Ribbons(motion.rods, bead * (many ? 1.0 : 0.7), many ? 1 : 2, this.haze);
    this.mark = new Ribbons(1, bead * (many ? 2.5 : 1.4), many ? 5 : 7, this.haze, { isBehind: true });
    this.normalArrows = new Ribbons(held, 0, 3, this.haze, { hasHeads: true });
    this.tangentArrows = new Ribbons(held, 0, 3, this.haze, { hasHeads: true });
    this.newtonsPerSize = Math.max(over(arrays.normal), arrays.tangent.columns ? over(arrays.tangent) : 0);
    this.scene.add(this.guides, this.rods.mesh, this.mark.mesh, this.beads.mesh, this.normalArrows.mesh, this.tangentArrows.mesh);
    [this.rods.mesh.name, this.normalArrows.mesh.name, this.tangentArrows.mesh.name, this.guides.name] = ["rods", "normal", "tangent", "guides"];
    this.paint();
    stage.resized = (width, height) => {
      for (const each of [this.rods, this.mark, this.normalArrows, this.tangentArrows]) each.resize(width, height);
      this.beads.resize(height);
    };
    stage.resize();
    if (looksAnew) this.lookFrom();
  }

  dispose(): void {
    release(this.scene);
  }

  /** Returns the rod that pulls or pushes most at a time. */
  findStrongest(time: number): number {
    this.stand(time);
    return this.tensions.reduce((best, tension, rod) => (Math.abs(tension) > Math.abs(this.tensions[best]) ? rod : best), 0);
  }

  /** Measures the middle and the size of all that is shown over the whole motion, including round guides that are not much larger. */
  private measure(): void {
    const least = new Vector3(Infinity, Infinity, Infinity), most = new Vector3(-Infinity, -Infinity, -Infinity), p = new Vector3();
    const frames = this.motion.times.length, each = Math.max(1, Math.floor(frames / 12));
    for (let f = 0; f < frames; f += each)
      for (let k = 0; k < this.motion.points; ++k) {
        p.set(this.arrays.positions.get(f, 3 * k), this.arrays.positions.get(f, 3 * k + 1), this.arrays.positions.get(f, 3 * k + 2));
        least.min(p); most.max(p);
      }
    const size = most.distanceTo(least);
    for (const { kind, rows: [row] } of this.motion.guides) {
      const radius = kind === "sphere" ? row[3] : kind === "circle" ? row[6] : kind === "ellipsoid" ? Math.max(row[3], row[4], row[5]) : 0;
      if (!(radius > 0) || radius > 2 * size) continue;
      least.min(p.set(row[0] - radius, row[1] - radius, row[2] - radius));
      most.max(p.set(row[0] + radius, row[1] + radius, row[2] + radius));
    }
    this.middle.addVectors(least, most).multiplyScalar(0.5);
    this.size = Math.max(1e-12, most.clone().sub(least).length());
    this.extent = most.sub(least);
  }
  private extent = new Vector3();

  /** Looks from a corner, or straight at a motion in a plane. */
  lookFrom(): void {
    const up = new Vector3(...(this.motion.up as [number, number, number])).normalize();
    const flat = [0, 1, 2].find((axis) => this.extent.getComponent(axis) < 0.02 * this.size);
    const sideways = Math.abs(up.x) < 0.7 ? new Vector3(1, 0, 0) : new Vector3(0, 1, 0);
    const right = sideways.addScaledVector(up, -sideways.dot(up)).normalize(), front = right.clone().cross(up);
    const from = flat === undefined || Math.abs(up.getComponent(flat)) > 0.7
      ? front.clone().multiplyScalar(1).addScaledVector(right, 0.55).addScaledVector(up, 0.4)
      : new Vector3().setComponent(flat, flat === 1 ? -1 : 1);
    this.stage.setUp(up);
    const { camera, controls } = this.stage;
    camera.position.copy(this.middle).addScaledVector(from.normalize(), this.size);
    camera.position.copy(this.middle).addScaledVector(from, this.findDistance(from));
    camera.near = 0.002 * this.size;
    camera.far = 40 * this.size;
    camera.updateProjectionMatrix();
    controls.target.copy(this.middle);
    controls.update();
  }

  /** Returns the distance at which the box around all that is shown fills the picture without being cut off. */
  private findDistance(from: Vector3): number {
    const { camera } = this.stage, margin = 1.12, corner = new Vector3();
    camera.lookAt(this.middle);
    camera.updateMatrixWorld();
    const [right, up] = [new Vector3(), new Vector3()];
    camera.matrixWorld.extractBasis(right, up, new Vector3());
    const high = Math.tan((camera.fov * Math.PI) / 360), wide = high * camera.aspect;
    let distance = 0;
    for (let k = 0; k < 8; ++k) {
      corner.set(k & 1 ? 0.5 : -0.5, k & 2 ? 0.5 : -0.5, k & 4 ? 0.5 : -0.5).multiply(this.extent);
      const needed = Math.max(Math.abs(corner.dot(right)) / wide, Math.abs(corner.dot(up)) / high);
      distance = Math.max(distance, corner.dot(from) + margin * needed);
    }
    return Math.max(distance, 0.1 * this.size);
  }

  private paint(): void {
    const count = this.motion.points, tint = this.beads.tint;
    const [bead, support, normal, tangent, ink] = [this.colours.bead, this.colours.support, this.colours.normal, this.colours.tangent, this.colours.ink].map(readColour);
    for (let k = 0; k < count; ++k) tint.set(bead, 3 * k);
    this.mark.tint.set(ink);
    for (const k of this.motion.supports) tint.set(support, 3 * k);
    for (let k = 0; k < this.arrays.held.length; ++k) {
      this.normalArrows.tint.set(normal, 3 * k);
      this.tangentArrows.tint.set(tangent, 3 * k);
    }
  }

  /** Shows a time between the frames: positions follow curves, forces straight lines. */
  stand(time: number): void {
    const times = this.motion.times;
    let low = 0, high = times.length - 1;
    while (high - low > 1) { const half = (low + high) >> 1; if (times[half] <= time) low = half; else high = half; }
    const span = high > low ? times[high] - times[low] : 0;
    const part = span > 0 ? Math.min(1, Math.max(0, (time - times[low]) / span)) : 0;
    this.frame = part < 0.5 ? low : high;
    const straight = [0, 1 - part, part, 0];
    this.arrays.positions.read(low, weighRows(times, low, part), this.places);
    this.arrays.tensions.read(low, straight, this.tensions);
    this.arrays.normal.read(low, straight, this.normal);
    this.arrays.tangent.read(low, straight, this.tangent);
    this.tensionStep = this.tensions.length ? Math.max(this.arrays.tensions.step(low), this.arrays.tensions.step(high)) : 0;
    this.beads.positions.set(this.places);
    this.beads.update();
    this.placeRods();
    this.placeArrows(this.normalArrows, this.normal);
    this.placeArrows(this.tangentArrows, this.tangent);
    this.placeGuides();
  }

  /** Returns the colours of evenly spaced tensions. */
  private mixShades(): Float32Array {
    const shades = new Float32Array(3 * (2 * most_shades + 1));
    for (const [sign, stops] of [[-1, this.colours.pushed.map(readColour)], [1, this.colours.pulled.map(readColour)]] as const)
      for (let shade = 0; shade <= most_shades; ++shade) {
        const place = ((stops.length - 1) * shade) / most_shades, k = Math.min(Math.floor(place), stops.length - 2);
        for (let part = 0; part < 3; ++part)
          shades[3 * (most_shades + sign * shade) + part] = stops[k][part] + (place - k) * (stops[k + 1][part] - stops[k][part]);
      }
    return shades;
  }

  private placeRods(): void {
    const { rods: ends } = this.arrays, { a, b, tint } = this.rods, p = this.places, n = this.motion.points;
    for (let k = 0; k < this.motion.rods; ++k) {
      const i = 3 * ends[2 * k], j = ends[2 * k + 1];
      const image = j >= n ? this.motion.images[j - n] : null, far = 3 * (image ? image[0] : j);
      for (let axis = 0; axis < 3; ++axis) {
        a[3 * k + axis] = p[i + axis];
        b[3 * k + axis] = p[far + axis] + (image ? image[1 + axis] : 0);
      }
      const part = this.scale > 0 ? Math.max(-1, Math.min(1, this.tensions[k] / this.scale)) : 0;
      const shade = 3 * (most_shades + Math.round(most_shades * part));
      tint[3 * k] = this.shades[shade];
      tint[3 * k + 1] = this.shades[shade + 1];
      tint[3 * k + 2] = this.shades[shade + 2];
    }
    this.rods.update();
    this.mark.a.set(a.subarray(3 * this.chosen, 3 * this.chosen + 3));
    this.mark.b.set(b.subarray(3 * this.chosen, 3 * this.chosen + 3));
    this.mark.update();
  }

  private placeArrows(arrows: Ribbons, forces: Float32Array): void {
    const held = this.arrays.held, length = this.newtonsPerSize > 0 ? (0.16 * this.size) / this.newtonsPerSize : 0;
    for (let k = 0; k < held.length; ++k) {
      // The arrows begin at the surface of the point's ball.
      const size = length * Math.hypot(forces[3 * k] ?? 0, forces[3 * k + 1] ?? 0, forces[3 * k + 2] ?? 0);
      const shift = size > 0.1 * this.beadRadius ? this.beadRadius / size : 0;
      for (let axis = 0; axis < 3; ++axis) {
        const arrow = forces.length ? length * forces[3 * k + axis] : 0;
        arrows.a[3 * k + axis] = this.places[3 * held[k] + axis] + shift * arrow;
        arrows.b[3 * k + axis] = arrows.a[3 * k + axis] + arrow;
      }
    }
    arrows.update();
  }

  private placeGuides(): void {
    const moves = this.motion.guides.some((guide) => guide.rows.length > 1);
    if (this.guideFrame >= 0 && (!moves || this.guideFrame === this.frame)) return;
    this.guideFrame = this.frame;
    release(this.guides);
    this.guides.clear();
    for (const guide of this.motion.guides) {
      const row = guide.rows[Math.min(this.frame, guide.rows.length - 1)];
      const drawn = drawGuide(guide, row, this.middle, this.size, this.colours.guide);
      drawn.name = guide.name;
      this.guides.add(drawn);
    }
  }

  render(): void {
    this.mark.mesh.visible = this.shows.rods && this.motion.rods > 1;
    this.beads.mesh.visible = this.shows.points;
    this.rods.mesh.visible = this.shows.rods;
    this.guides.visible = this.shows.guides;
    this.normalArrows.mesh.visible = this.shows.normal;
    this.tangentArrows.mesh.visible = this.shows.tangent;
    const away = this.stage.camera.position.distanceTo(this.middle);
    this.haze.haze.value.set(Math.max(0, away - 0.3 * this.size), away + 0.5 * this.size, this.haze.haze.value.z);
    this.stage.renderer.render(this.scene, this.stage.camera);
  }

  /** Returns the rod nearest to a position in the picture, at most 12 pixels away. */
  pick(x: number, y: number): number | null {
    const width = this.stage.host.clientWidth, height = this.stage.host.clientHeight, p = new Vector3();
    const onScreen = (array: Float32Array, k: number) => {
      p.set(array[3 * k], array[3 * k + 1], array[3 * k + 2]).project(this.stage.camera);
      return [((p.x + 1) / 2) * width, ((1 - p.y) / 2) * height, p.z];
    };
    let best = 12, depth = Infinity, found: number | null = null;
    for (let k = 0; k < this.motion.rods; ++k) {
      const [ax, ay, az] = onScreen(this.rods.a, k), [bx, by] = onScreen(this.rods.b, k);
      const square = (bx - ax) ** 2 + (by - ay) ** 2;
      const part = square > 0 ? Math.min(1, Math.max(0, ((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / square)) : 0;
      const away = Math.hypot(ax + part * (bx - ax) - x, ay + part * (by - ay) - y);
      if (away < best - 2 || (away < best + 2 && az < depth)) { best = Math.min(best, away); depth = az; found = k; }
    }
    return found;
  }
}
