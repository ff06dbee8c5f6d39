import { BufferAttribute, BufferGeometry, ConeGeometry, Group, InstancedMesh, Line, LineBasicMaterial, LineSegments, Matrix4, MeshBasicMaterial, Quaternion, Vector3 } from "three";
import type { Arrays, Colours, Motion, Tie } from "./data";
import { Ribbons, type Haze } from "./shapes";

const arcs = 32; // of a sheave, and of a rope that sags
const coils = 16;
const most_supports = 500; // with a path or on the ground

const lines = (places: number[], colour: string, opacity: number) =>
  new LineSegments(new BufferGeometry().setAttribute("position", new BufferAttribute(new Float32Array(places), 3)),
    new LineBasicMaterial({ color: colour, transparent: true, opacity }));

/** The edges of the cell of a periodic sample around a middle. */
export function drawCell(edges: number[][], middle: Vector3): LineSegments {
  const [a, b, c] = edges.map(([x, y, z]) => new Vector3(x, y, z)), places: number[] = [];
  const corner = (bits: number) => middle.clone().addScaledVector(a, (bits & 1) - 0.5).addScaledVector(b, ((bits >> 1) & 1) - 0.5).addScaledVector(c, (bits >> 2) - 0.5);
  for (let bits = 0; bits < 8; ++bits)
    for (const bit of [1, 2, 4]) if (!(bits & bit)) places.push(...corner(bits).toArray(), ...corner(bits | bit).toArray());
  return lines(places, "#3d4752", 0.7);
}

/** The paths of supports that move, and the ground beneath those that stand, of those that hold at a time; their `until`: when each is let go. */
export function drawSupports({ supports, times }: Motion, { positions }: Arrays, up: Vector3, bead: number, size: number, { guide, earth }: Colours, until: number[], time: number): Group {
  const place = (k: number, frame: number) => new Vector3(positions.get(frame, 3 * k), positions.get(frame, 3 * k + 1), positions.get(frame, 3 * k + 2));
  const group = new Group(), shown = supports.slice(0, most_supports).filter((k) => time < until[k]), every = Math.max(1, Math.floor((times.length * shown.length) / 100_000));
  const paths = shown.map((k) => times.map((_, frame) => frame).filter((frame) => frame % every === 0 && times[frame] < until[k]).map((frame) => place(k, frame)));
  const moves = (path: Vector3[]) => path.some((each) => each.distanceTo(path[0]) > 1e-4 * size);
  for (const path of paths.filter(moves))
    group.add(new Line(new BufferGeometry().setFromPoints(path), new LineBasicMaterial({ color: guide, transparent: true, opacity: 0.7 })));
  const standing = paths.filter((path) => !moves(path)), height = 2.8 * bead;
  const feet = new InstancedMesh(new ConeGeometry(0.75 * height, height, 4), new MeshBasicMaterial({ color: earth }), standing.length);
  const turn = new Quaternion().setFromUnitVectors(new Vector3(0, 1, 0), up), one = new Vector3(1, 1, 1);
  standing.forEach(([foot], k) => feet.setMatrixAt(k, new Matrix4().compose(foot.addScaledVector(up, -0.5 * height), turn, one)));
  feet.frustumCulled = false;
  group.add(feet);
  return group;
}

/** Ropes over their sheaves, thin lines between the points of formulas and bonds, and springs as coils. Slack ropes are thin and sag. */
export class Ropes {
  readonly ribbons: Ribbons;
  readonly slack: Ribbons;
  private sheave: number; // m, radius

  constructor(private ties: Tie[], bead: number, haze: Haze, rgb: number[]) {
    const count = ties.reduce((sum, tie) => sum + tie.points.length - 1 + (tie.kind === "spring" ? coils - 1 : (arcs + 1) * tie.sheaves.length), 0);
    const countOfSlack = ties.reduce((sum, tie) => sum + (tie.lengths ? tie.points.length - 2 + arcs : 0), 0);
    this.sheave = 2 * bead;
    this.ribbons = new Ribbons(count, 0.28 * bead, 1.5, haze);
    this.slack = new Ribbons(countOfSlack, 0.12 * bead, 1, haze);
    for (const { tint, count } of [this.ribbons, this.slack]) for (let k = 0; k < count; ++k) tint.set(rgb, 3 * k);
  }

  /**
   * Places all ropes; `place` returns where a point is now beside another one, `isThere` whether a tie holds, `lengthOf` the
   * length of a rope now. Slack ropes sag along `down`.
   */
  stand(place: (point: number, beside: number) => Vector3, isThere: (tie: number) => boolean, lengthOf: (tie: Tie) => number, down: Vector3): void {
    let k = 0, thin = 0;
    this.slack.a.fill(0);
    this.slack.b.fill(0);
    for (const [number, tie] of this.ties.entries()) {
      const add = (from: Vector3, to: Vector3) => { from.toArray(this.ribbons.a, 3 * k); (isThere(number) ? to : from).toArray(this.ribbons.b, 3 * k); ++k; };
      const course = courseOf(tie, place), arc = tie.lengths && sag(course, tie.coefficients!, lengthOf(tie), down);
      if (arc && isThere(number)) arc.slice(1).forEach((to, part) => { arc[part].toArray(this.slack.a, 3 * thin); to.toArray(this.slack.b, 3 * thin); ++thin; });
      course.slice(1).forEach((to, part) => add(course[part], arc ? course[part] : to));
      tie.sheaves.forEach((_, sheave) => {
        // A wheel in the plane of the rope there.
        const middle = course[sheave + 1], along = course[sheave].clone().sub(middle), other = course.at(sheave ? -1 : -2)!.clone().sub(middle);
        const u = along.normalize(), v = other.addScaledVector(u, -u.dot(other));
        if (v.length() < 1e-9) v.set(u.y, u.z, u.x).addScaledVector(u, -u.dot(v));
        v.normalize();
        const rim = (arc: number) => middle.clone().addScaledVector(u, this.sheave * Math.cos((2 * Math.PI * arc) / arcs)).addScaledVector(v, this.sheave * Math.sin((2 * Math.PI * arc) / arcs));
        for (let arc = 0; arc < arcs; ++arc) add(rim(arc), rim(arc + 1));
      });
    }
    this.ribbons.update();
    this.slack.update();
  }
}

/** Returns the course of a rope whose longest segment sags along `down`, as pictures draw it, or nothing if the rope is taut. */
function sag(course: Vector3[], coefficients: number[], length: number, down: Vector3): Vector3[] | null {
  const chords = coefficients.map((_, k) => course[k].distanceTo(course[k + 1]));
  const slack = chords.reduce((left, chord, k) => left - coefficients[k] * chord, length), chord = Math.max(...chords), longest = chords.indexOf(chord);
  if (!(slack > 1e-4 * length)) return null; // places are packed
  const whole = chord + slack / coefficients[longest], low = Math.sqrt(((whole * whole - chord * chord) * (4 - chord / whole)) / 16);
  const [a, b] = [course[longest], course[longest + 1]];
  const arc = Array.from({ length: arcs - 1 }, (_, k) => { const s = (k + 1) / arcs; return a.clone().lerp(b, s).addScaledVector(down, 4 * s * (1 - s) * low); });
  return [...course.slice(0, longest + 1), ...arc, ...course.slice(longest + 1)];
}

/** A coil of square turns along the way from a place to another one, as springs are drawn. */
function makeCoil(a: Vector3, b: Vector3): Vector3[] {
  const parts = coils, width = 0.05, along = b.clone().sub(a), sizes = along.toArray().map(Math.abs);
  const across = along.clone().cross(new Vector3().setComponent(sizes.indexOf(Math.min(...sizes)), 1)), over = along.clone().normalize().cross(across);
  return Array.from({ length: parts + 1 }, (_, k) =>
    a.clone().addScaledVector(along, k / parts).addScaledVector(k % 2 ? over : across, k % parts === 0 ? 0 : k % 4 < 2 ? width : -width));
}

/** Returns the places that a rope passes, its first point, its sheaves, its other points, or those of a spring. */
export function courseOf({ kind, points, sheaves }: Tie, place: (point: number, beside: number) => Vector3): Vector3[] {
  const [first, ...rest] = points.map((point) => place(point, points[0]));
  return kind === "spring" ? makeCoil(first, rest[0]) : [first, ...sheaves.map(([x, y, z]) => new Vector3(x, y, z)), ...rest];
}
