import { Box3, Group, Line, Matrix3, Mesh, Object3D, Points, Scene, Vector3 } from "three";
import { countRopes, units, weighRows, words, type Arrays, type Colours, type Frames, type Motion, type Tie } from "./data";
import { Ropes, courseOf, drawCell, drawSupports } from "./fixtures";
import { Beads, Ribbons, drawGuide, makeHaze, type Haze } from "./shapes";
import type { Look, Stage } from "./stage";

type Rgb = [number, number, number]; // sRGB, 0 … 1

const readColour = (text: string) => [1, 3, 5].map((at) => parseInt(text.slice(at, at + 2), 16) / 255) as Rgb;

/** Returns the largest size below the top 3 %, so that outliers do not grey the others. */
function typicalLargest(read: (k: number) => number, count: number): number {
  const sizes: number[] = [], stride = Math.max(1, Math.floor(count / 20000));
  for (let k = 0; k < count; k += stride) if (Number.isFinite(read(k))) sizes.push(Math.abs(read(k)));
  sizes.sort((x, y) => x - y);
  return sizes.length ? sizes[Math.floor(0.97 * (sizes.length - 1))] : 0;
}

/** Returns the box around places, which Box3.setFromArray takes three times as long to find. */
function boxOf(places: Float32Array): Box3 {
  const least = [Infinity, Infinity, Infinity], most = [-Infinity, -Infinity, -Infinity];
  for (let axis = 0; axis < 3; ++axis) {
    let low = Infinity, high = -Infinity;
    for (let k = axis; k < places.length; k += 3) { const x = places[k]; if (x < low) low = x; if (x > high) high = x; }
    [least[axis], most[axis]] = [low, high];
  }
  return new Box3(new Vector3(...least), new Vector3(...most));
}

/** Releases the graphics memory of everything drawn in an object. */
function release(drawn: Object3D): void {
  drawn.traverse((child) => {
    if (!(child instanceof Mesh || child instanceof Line || child instanceof Points)) return;
    child.geometry.dispose();
    for (const material of [child.material].flat()) material.dispose();
  });
}

const rounding = 1e-6; // of forces, relative to the tensions

const most_shades = 256; // from no tension to the end of the scale

/** What a click chooses. */
export interface Chosen { kind: "rod" | "point" | "tie"; number: number }
/** What a reader switches on. */
export const parts = ["points", "rods", "guides", "normal", "tangent", "cell", "wrapped"] as const;

/** The motion in 3-D. */
export class View {
  readonly scale: number; // N, the end of the colours
  readonly newtonsPerSize: number; // N, force of an arrow as long as a sixth of the picture
  readonly tensions: Float32Array; // now
  readonly scene = new Scene(); // tests find its parts by their names
  hasUnknown = false; // a rod that is there now
  tensionStep = 0; // N, resolution of the packed tensions
  chosen: Chosen = { kind: "rod", number: 0 };
  shows = Object.fromEntries(parts.map((part) => [part, true])) as Record<(typeof parts)[number], boolean>;
  size = 1; // m, size of all that is shown
  private shades: Float32Array; // of tensions from -scale to scale
  private now: Record<"places" | "shown" | "normal" | "tangent", Float32Array>; // positions as they are, and as they are drawn
  private unknown: number[]; // tint of rods whose tension is not known, which are dashed
  private haze: Haze;
  private beads: Beads;
  private beadRadius: number; // m
  private rods: Ribbons;
  private ropes: Ropes;
  private marks: { rod: Ribbons; point: Beads }; // around what is chosen, which keeps its colour
  private arrows: { normal: Ribbons; tangent: Ribbons };
  private fixed = { guides: new Group(), supports: new Group(), cell: new Group() };
  private arms: Ribbons; // of cranks
  private until: Record<keyof Motion["gone"], number[]>; // time at which each is taken out
  private holding = -1; // number of supports that hold
  private paths = new Box3(); // of supports, with the pivots of cranks
  private time = NaN;
  private up = new Vector3();
  private guideFrame = -1;
  private middle = new Vector3();
  private frame = 0;

  constructor(private stage: Stage, private motion: Motion, private arrays: Arrays, private colours: Colours) {
    const room = (rows: Frames) => new Float32Array(rows.columns);
    this.now = { places: room(arrays.positions), shown: room(arrays.positions), normal: room(arrays.normal), tangent: room(arrays.tangent) };
    this.tensions = room(arrays.tensions);
    const over = (rows: Frames) => typicalLargest((k) => rows.get(Math.floor(k / rows.columns), k % rows.columns), motion.times.length * rows.columns);
    this.scale = Math.max(colours.tensions[1], -colours.tensions[0]);
    this.shades = this.mixShades();
    this.unknown = readColour(colours.unknown).map((part) => -part);
    const since = (count: number, gone: [number, number][]) => { const list = new Array<number>(count).fill(Infinity); for (const [k, time] of gone) list[k] = time; return list; };
    this.until = { rods: since(motion.rods, motion.gone.rods), ties: since(motion.ties.length, motion.gone.ties), supports: since(motion.points, motion.gone.supports), guides: since(motion.guides.length, motion.gone.guides) };
    this.up = this.measure();
    const held = arrays.held.length, many = motion.points > 3000, rod = this.typicalRod();
    // The size of points in pictures (choose_scale), but for many of them.
    const bead = many ? 0.0017 * this.size : Math.min(0.015 * this.size, rod > 0 ? 0.3 * rod : (0.12 * this.size) / Math.sqrt(motion.points));
    this.haze = makeHaze(readColour(colours.ground), many ? 0.85 : 0.35);
    this.beadRadius = bead * (many ? 1.3 : 1);
    this.beads = new Beads(motion.points, this.beadRadius, many ? 1.5 : 4, this.haze);
    this.rods = new Ribbons(motion.rods, bead * (many ? 1.0 : 0.9), many ? 1 : 2, this.haze);
    this.ropes = new Ropes(motion.ties, bead, this.haze, readColour(colours.support));
    this.marks = { rod: new Ribbons(1, bead * (many ? 2.5 : 1.6), many ? 5 : 7, this.haze, { isBehind: true }), point: new Beads(1, 1.7 * this.beadRadius, 12, this.haze, { isBehind: true }) };
    this.arrows = { normal: new Ribbons(held, 0, 3, this.haze, { hasHeads: true }), tangent: new Ribbons(held, 0, 3, this.haze, { hasHeads: true }) };
    this.newtonsPerSize = Math.max(over(arrays.normal), arrays.tangent.columns ? over(arrays.tangent) : 0);
    if (!(this.newtonsPerSize > rounding * this.scale)) this.newtonsPerSize = 0;
    this.arms = new Ribbons(motion.pivots.length, bead, 2, this.haze);
    motion.pivots.forEach((_, k) => this.arms.tint.set(readColour(colours.support), 3 * k));
    if (motion.cell) this.fixed.cell.add(drawCell(motion.cell.edges, this.middleOfCell));
    this.scene.add(...Object.values(this.fixed), this.ropes.ribbons.mesh, this.ropes.slack.mesh, this.rods.mesh, this.arms.mesh, this.marks.rod.mesh, this.marks.point.mesh, this.beads.mesh, this.arrows.normal.mesh, this.arrows.tangent.mesh);
    Object.entries({ rods: this.rods.mesh, ropes: this.ropes.ribbons.mesh, slack: this.ropes.slack.mesh, arms: this.arms.mesh, points: this.beads.mesh, normal: this.arrows.normal.mesh, tangent: this.arrows.tangent.mesh, ...this.fixed }).forEach(([name, drawn]) => (drawn.name = name));
    this.paint();
    stage.setUp(this.up);
    stage.camera.near = 0.002 * this.size;
    stage.camera.far = 40 * this.size;
    stage.resized = (width, height) => {
      for (const each of [this.rods, this.ropes.ribbons, this.ropes.slack, this.arms, this.marks.rod, this.arrows.normal, this.arrows.tangent]) each.resize(width, height);
      for (const each of [this.beads, this.marks.point]) each.resize(height);
    };
    stage.resize();
  }

  dispose(): void { release(this.scene); }

  /** Returns the rod that pulls or pushes most at a time. */
  findStrongest(time: number): number {
    this.stand(time);
    return this.tensions.reduce((best, tension, rod) => (Math.abs(tension) > (Math.abs(this.tensions[best]) || 0) ? rod : best), 0);
  }

  /** Adds round guides that are not much larger than a box around points. */
  private takeGuides(box: Box3): void {
    const size = box.getSize(new Vector3()).length();
    for (const { kind, rows: [row] } of this.motion.guides) {
      const radius = kind === "sphere" ? row[3] : kind === "circle" ? row[6] : kind === "ellipsoid" ? Math.max(row[3], row[4], row[5]) : 0;
      if (radius > 0 && radius <= 2 * size) box.union(new Box3().setFromCenterAndSize(new Vector3(...row), new Vector3(2, 2, 2).multiplyScalar(radius)));
    }
    for (const { sheaves } of this.motion.ties) for (const [x, y, z] of sheaves) box.expandByPoint(new Vector3(x, y, z));
    for (const [, x, y, z] of this.motion.pivots) box.expandByPoint(new Vector3(x, y, z));
    box.union(this.paths);
  }

  /** Returns the median length of rods at the start, or 0. */
  private typicalRod(): number {
    this.arrays.positions.read(0, [0, 1, 0, 0], this.now.places);
    const span = new Float32Array(3), lengths = new Float32Array(this.motion.rods).map((_, rod) => { this.spanOf(rod, span, 0); return Math.hypot(...span); });
    return lengths.sort()[lengths.length >> 1] ?? 0;
  }

  /** Writes the vector along a rod. */
  private spanOf(rod: number, into: Float32Array, at: number): void {
    const { now: { places }, arrays: { rods }, motion: { points, images } } = this, i = 3 * rods[2 * rod], j = rods[2 * rod + 1];
    const image = j >= points ? images[j - points] : null, far = 3 * (image ? image[0] : j);
    for (let axis = 0; axis < 3; ++axis) into[at + axis] = places[far + axis] - places[i + axis] + (image ? image[1 + axis] : 0);
  }

  /** Measures all that is shown over the whole motion, and returns the direction up. */
  private measure(): Vector3 {
    const { motion: { times, points, up }, arrays: { positions } } = this, box = new Box3(), p = new Vector3();
    for (let f = 0; f < times.length; f += Math.max(1, Math.floor(times.length / 12)))
      for (let k = 0; k < points; ++k) box.expandByPoint(p.set(positions.get(f, 3 * k), positions.get(f, 3 * k + 1), positions.get(f, 3 * k + 2)));
    this.takeGuides(box);
    box.getCenter(this.middle);
    const extent = box.getSize(new Vector3());
    this.size = extent.length() || 1;
    this.flat = [0, 1, 2].find((axis) => extent.getComponent(axis) < 0.02 * this.size);
    // Without gravity up is z, or y of a motion in the plane of x and y.
    return p.set(up[0], up[1], up[2]).lengthSq() > 0 ? p.normalize() : p.set(0, this.flat === 2 ? 1 : 0, this.flat === 2 ? 0 : 1);
  }
  private flat: number | undefined; // the axis along which nothing moves

  /** Returns the box around all that is shown now. */
  private measureNow(): Box3 {
    const box = boxOf(this.now.shown);
    this.takeGuides(box);
    for (const part of ["normal", "tangent"] as const) if (this.shows[part] && this.newtonsPerSize > 0) box.union(boxOf(this.arrows[part].b));
    if (this.motion.cell && this.shows.cell) box.expandByObject(this.fixed.cell);
    return box;
  }

  /** Fits the picture to what is there now, seen from a side; "best": from a corner, or straight at a motion in a plane. */
  look(from?: Look | "best"): void {
    const { up } = this.stage.camera, flat = this.flat;
    const isPlane = flat !== undefined && Math.abs(up.getComponent(flat)) <= 0.7, right = Math.abs(up.x) < 0.7 ? 0 : 1;
    this.stage.fit(this.measureNow(), from !== "best" ? from : !isPlane ? "corner" : flat === right ? "side" : "front");
  }

  /** Shows a slab across an axis alone: its middle and thickness as parts of all that there is. */
  slice(axis: number | null, middle = 0.5, thickness = 1): void {
    const { slab, halfSlab } = this.haze, box = this.measureNow(), normal = new Vector3();
    if (axis !== null) normal.setComponent(axis, 1);
    const low = box.min.dot(normal), high = box.max.dot(normal);
    slab.value.set(normal.x, normal.y, normal.z, low + middle * (high - low));
    halfSlab.value = axis === null ? 1 : Math.max(0.5 * thickness * (high - low), 1e-3 * this.size); // all of what is flat
  }

  private paint(): void {
    const count = this.motion.points, tint = this.beads.tint;
    const [bead, support, normal, tangent, ink] = [this.colours.bead, this.colours.support, this.colours.normal, this.colours.tangent, this.colours.ink].map(readColour);
    for (let k = 0; k < count; ++k) tint.set(bead, 3 * k);
    this.marks.rod.tint.set(ink);
    this.marks.point.tint.set(readColour("#2a7fc9"));
    for (const k of this.motion.supports) if (!(this.time >= this.until.supports[k])) tint.set(support, 3 * k);
    for (let k = 0; k < this.arrays.held.length; ++k) {
      this.arrows.normal.tint.set(normal, 3 * k);
      this.arrows.tangent.tint.set(tangent, 3 * k);
    }
  }

  /** Shows a time between the frames: positions follow curves, forces straight lines. */
  stand(time: number): void {
    const times = this.motion.times;
    this.time = time;
    let low = 0, high = times.length - 1;
    while (high - low > 1) { const half = (low + high) >> 1; if (times[half] <= time) low = half; else high = half; }
    const span = high > low ? times[high] - times[low] : 0;
    const part = span > 0 ? Math.min(1, Math.max(0, (time - times[low]) / span)) : 0;
    this.frame = part < 0.5 ? low : high;
    const straight = [0, 1 - part, part, 0];
    this.arrays.positions.read(low, weighRows(times, low, part), this.now.places);
    this.arrays.tensions.read(low, straight, this.tensions);
    this.arrays.normal.read(low, straight, this.now.normal);
    this.arrays.tangent.read(low, straight, this.now.tangent);
    this.tensionStep = this.tensions.length ? Math.max(this.arrays.tensions.step(low), this.arrays.tensions.step(high)) : 0;
    for (const [rod, since] of this.motion.gone.rods) if (time >= since) this.tensions[rod] = NaN;
    this.wrap();
    this.placeSupports();
    this.beads.positions.set(this.now.shown);
    this.beads.update();
    this.placeRods();
    const lengthOf = ({ lengths }: Tie) => (lengths!.length === 1 ? lengths![0] : (1 - part) * lengths![low] + part * lengths![high]);
    this.ropes.stand(this.place, (tie) => this.holds("ties", tie), lengthOf, this.up.clone().negate());
    this.placeArrows(this.arrows.normal, this.now.normal);
    this.placeArrows(this.arrows.tangent, this.now.tangent);
    this.placeGuides();
    this.mark();
    this.stage.follow(this.measureNow());
  }

  /** Returns the force on what is chosen now, in words. */
  tellForce({ kind, number }: Chosen): string {
    const tell = (force: number, rows: Frames) => words(Math.abs(force) < rows.step(this.frame) ? 0 : force, units.force);
    const since = this.until[kind === "rod" ? "rods" : kind === "tie" ? "ties" : "supports"][number];
    if (this.time >= since) return `gone since t = ${words(since, units.time)}`;
    if (kind === "rod") return tell(this.tensions[number], this.arrays.tensions);
    if (kind === "tie") return words(this.arrays.ties.get(this.frame, number), this.motion.ties[number].kind === "formula" ? "" : units.force);
    const row = 3 * this.arrays.held.indexOf(number), { normal, tangent } = this.now;
    return tell(Math.hypot(...[0, 1, 2].map((axis) => normal[row + axis] + (tangent[row + axis] ?? 0))), this.arrays.normal);
  }

  /** Returns where a point is drawn: the image of it that stands beside another one. */
  private place = (k: number, beside = k) => new Vector3().fromArray(this.now.places, 3 * k).sub(new Vector3().fromArray(this.now.places, 3 * beside)).add(new Vector3().fromArray(this.now.shown, 3 * beside));

  private get middleOfCell(): Vector3 {
    const { edges, origin } = this.motion.cell!;
    return origin ? edges.reduce((sum, [x, y, z]) => sum.add(new Vector3(x, y, z).multiplyScalar(0.5)), new Vector3(...origin)) : this.middle;
  }

  /** Moves the points by whole edges into the cell, if that is wanted. */
  private wrap(): void {
    const { places, shown } = this.now, { cell } = this.motion;
    shown.set(places);
    if (!cell || !this.shows.wrapped) return;
    const edges = cell.edges.map(([x, y, z]) => new Vector3(x, y, z)), p = new Vector3();
    const inverse = new Matrix3().set(...(([a, b, c]) => [a.x, b.x, c.x, a.y, b.y, c.y, a.z, b.z, c.z] as const)(edges)).invert();
    for (let k = 0; k < shown.length; k += 3) {
      const turns = p.fromArray(places, k).sub(this.middleOfCell).applyMatrix3(inverse).addScalar(0.5).floor().toArray();
      p.fromArray(places, k);
      edges.forEach((edge, axis) => p.addScaledVector(edge, -turns[axis]));
      p.toArray(shown, k);
    }
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

  private holds = (part: keyof Motion["gone"], number: number) => this.time < this.until[part][number];

  /** Draws the supports that hold now, and the arms of cranks among them. */
  private placeSupports(): void {
    const { supports, pivots } = this.motion, holding = supports.filter((k) => this.holds("supports", k)).length, { a, b } = this.arms;
    if (holding !== this.holding) {
      this.holding = holding;
      release(this.fixed.supports);
      this.fixed.supports.clear();
      this.fixed.supports.add(drawSupports(this.motion, this.arrays, this.up, this.beadRadius, this.size, this.colours, this.until.supports, this.time));
      this.fixed.supports.children[0].children.filter((each) => each instanceof Line).forEach((path) => this.paths.expandByObject(path));
      this.paint();
    }
    for (const [k, [point, x, y, z]] of pivots.entries()) {
      this.place(point).toArray(b, 3 * k);
      (this.holds("supports", point) ? new Vector3(x, y, z) : this.place(point)).toArray(a, 3 * k);
    }
    this.arms.update();
  }

  private placeRods(): void {
    this.hasUnknown = false;
    const { rods: ends } = this.arrays, { a, b, tint } = this.rods, { shown } = this.now;
    for (let k = 0; k < this.motion.rods; ++k) {
      const i = 3 * ends[2 * k], isThere = this.time < this.until.rods[k];
      this.spanOf(k, b, 3 * k);
      for (let axis = 0; axis < 3; ++axis) b[3 * k + axis] = (a[3 * k + axis] = shown[i + axis]) + (isThere ? b[3 * k + axis] : 0);
      if (!Number.isFinite(this.tensions[k])) { this.hasUnknown ||= isThere; tint.set(this.unknown, 3 * k); continue; }
      const part = this.scale > 0 ? Math.max(-1, Math.min(1, this.tensions[k] / this.scale)) : 0;
      const shade = 3 * (most_shades + Math.round(most_shades * part));
      tint[3 * k] = this.shades[shade];
      tint[3 * k + 1] = this.shades[shade + 1];
      tint[3 * k + 2] = this.shades[shade + 2];
    }
    this.rods.update();
  }

  /** Puts the mark around what is chosen. */
  private mark(): void {
    const { chosen: { kind, number }, marks: { rod, point } } = this;
    rod.mesh.visible = kind === "rod" && this.shows.rods && this.motion.rods > 1;
    point.mesh.visible = kind === "point" && this.shows.points && this.arrays.held.includes(number);
    for (const end of ["a", "b"] as const) if (rod.mesh.visible) rod[end].set(this.rods[end].subarray(3 * number, 3 * number + 3));
    if (point.mesh.visible) point.positions.set(this.now.shown.subarray(3 * number, 3 * number + 3));
    rod.update();
    point.update();
  }

  private placeArrows(arrows: Ribbons, forces: Float32Array): void {
    const held = this.arrays.held, length = this.newtonsPerSize > 0 ? (0.16 * this.size) / this.newtonsPerSize : 0;
    for (let k = 0; k < held.length; ++k) {
      // The arrows begin at the surface of the point's ball.
      const size = length * Math.hypot(forces[3 * k] ?? 0, forces[3 * k + 1] ?? 0, forces[3 * k + 2] ?? 0);
      const shift = size > 0.1 * this.beadRadius ? this.beadRadius / size : 0;
      for (let axis = 0; axis < 3; ++axis) {
        const arrow = forces.length && Number.isFinite(size) ? length * forces[3 * k + axis] : 0;
        arrows.a[3 * k + axis] = this.now.shown[3 * held[k] + axis] + shift * arrow;
        arrows.b[3 * k + axis] = arrows.a[3 * k + axis] + arrow;
      }
    }
    arrows.update();
  }

  private placeGuides(): void {
    const { guides } = this.motion, moves = guides.some((guide) => guide.rows.length > 1), holding = guides.filter((_, k) => this.holds("guides", k));
    if (this.guideFrame >= 0 && holding.length === this.fixed.guides.children.length && (!moves || this.guideFrame === this.frame)) return;
    this.guideFrame = this.frame;
    release(this.fixed.guides);
    this.fixed.guides.clear();
    for (const guide of holding) {
      const row = guide.rows[Math.min(this.frame, guide.rows.length - 1)];
      const drawn = drawGuide(guide, row, this.middle, this.size, this.colours.guide);
      drawn.name = guide.name;
      this.fixed.guides.add(drawn);
    }
  }

  render(): void {
    this.mark();
    this.beads.mesh.visible = this.fixed.supports.visible = this.arms.mesh.visible = this.shows.points;
    this.rods.mesh.visible = this.shows.rods;
    this.fixed.guides.visible = this.ropes.ribbons.mesh.visible = this.ropes.slack.mesh.visible = this.shows.guides;
    this.fixed.cell.visible = this.shows.cell;
    for (const part of ["normal", "tangent"] as const) this.arrows[part].mesh.visible = this.shows[part];
    const { camera, controls: { target } } = this.stage, away = camera.position.distanceTo(target);
    this.haze.haze.value.set(Math.max(0, away - 0.3 * this.size), away + 0.5 * this.size, this.haze.haze.value.z);
    this.stage.renderer.render(this.scene, camera);
  }

  /** Returns the rod, held point or rope nearest to a position in the picture, at most 12 pixels away. */
  pick(x: number, y: number): Chosen | null {
    const width = this.stage.host.clientWidth, height = this.stage.host.clientHeight, p = new Vector3();
    const onScreen = ([px, py, pz]: ArrayLike<number> & Iterable<number>) => {
      p.set(px, py, pz).project(this.stage.camera);
      return [((p.x + 1) / 2) * width, ((1 - p.y) / 2) * height, p.z];
    };
    let best = 12, depth = Infinity, found: Chosen | null = null;
    const tryOne = (kind: Chosen["kind"], number: number, a: ArrayLike<number> & Iterable<number>, b = a) => {
      const [ax, ay, az] = onScreen(a), [bx, by] = onScreen(b), square = (bx - ax) ** 2 + (by - ay) ** 2;
      const part = square > 0 ? Math.min(1, Math.max(0, ((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / square)) : 0;
      const away = Math.hypot(ax + part * (bx - ax) - x, ay + part * (by - ay) - y);
      if (away < best - 2 || (away < best + 2 && az < depth)) { best = Math.min(best, away); depth = az; found = { kind, number }; }
    };
    for (const k of this.arrays.held) tryOne("point", k, this.now.shown.subarray(3 * k, 3 * k + 3));
    if (found && best < 8) return found; // which rods end at
    for (let k = 0; k < this.motion.rods; ++k) if (this.holds("rods", k)) tryOne("rod", k, this.rods.a.subarray(3 * k, 3 * k + 3), this.rods.b.subarray(3 * k, 3 * k + 3));
    this.motion.ties.slice(0, countRopes(this.motion)).forEach((tie, k) => this.holds("ties", k) && courseOf(tie, this.place).forEach((to, part, course) => { if (part) tryOne("tie", k, course[part - 1].toArray(), to.toArray()); }));
    return found;
  }
}
