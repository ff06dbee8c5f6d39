import {
  BufferAttribute, BufferGeometry, DoubleSide, DynamicDrawUsage, GLSL3, Group, InstancedBufferAttribute,
  InstancedBufferGeometry, LineBasicMaterial, LineSegments, Line, Matrix4, Mesh, MeshBasicMaterial, NormalBlending,
  PlaneGeometry, Points, ShaderMaterial, SphereGeometry, Vector2, Vector3, Vector4,
} from "three";
import type { Guide } from "./data";
import { polygonise, readFormula } from "./implicit";

/**
 * Makes the haze, which gives distant parts the colour of the ground to show depth, and the slab outside of which nothing
 * is drawn. All materials of a view share them.
 */
export const makeHaze = (ground: number[], most: number) => ({
  ground: { value: new Vector3(...ground) },
  haze: { value: new Vector3(0, 1, most) }, // distances at which it begins and is full, and its largest strength
  slab: { value: new Vector4(0, 0, 0, 0) }, // normal, middle along it
  halfSlab: { value: 1 }, // thickness
});
export type Haze = ReturnType<typeof makeHaze>;
const hazeVertex = `
uniform vec3 haze; uniform vec4 slab; out float far; out float aside;
void veil(float distance, vec3 place) {
  far = haze.z * clamp((distance - haze.x) / (haze.y - haze.x), 0.0, 1.0);
  aside = dot(place, slab.xyz) - slab.w;
}`;
const hazeFragment = `
precision highp float;
uniform vec3 ground; uniform float halfSlab; in float far; in float aside; out vec4 colour;
void paint(vec3 lit) {
  if (abs(aside) > halfSlab) discard;
  colour = vec4(mix(lit, ground, far), 1.0);
}`;

const ribbonVertex = `${hazeVertex}
in vec3 corner;  // part of the way from a to b, side, pixels back from b for heads
in vec3 a; in vec3 b; in vec3 tint;
uniform vec2 screen; uniform float width; uniform float least; uniform float head;
out vec3 shade; out float across; out float dash;
void main() {
  vec4 ca = projectionMatrix * viewMatrix * vec4(a, 1.0), cb = projectionMatrix * viewMatrix * vec4(b, 1.0);
  vec2 sa = ca.xy / ca.w * screen, sb = cb.xy / cb.w * screen, d = sb - sa;
  float size = length(d);
  vec2 along = size > 1e-6 ? d / size : vec2(0.0), side = vec2(-along.y, along.x);
  vec4 c = mix(ca, cb, corner.x);
  float pixels = max(least, width * projectionMatrix[1][1] * screen.y / c.w);
  vec2 shift = side * corner.y * pixels * (corner.z > 0.0 ? 2.6 : 1.0) - along * min(head * max(corner.z, -corner.z), size);
  c.xy += shift / screen * c.w;
  veil(c.w, mix(a, b, corner.x));
  gl_Position = c; shade = abs(tint); across = corner.z > 0.0 ? 0.0 : corner.y * 2.0;
  dash = tint.x < 0.0 ? corner.x * (max(1.0, floor(size / 14.0)) + 0.5) : 0.0;
}`;
const ribbonFragment = `${hazeFragment}
in vec3 shade; in float across; in float dash;
void main() { if (fract(dash) > 0.5) discard; paint(shade * (0.72 + 0.28 * sqrt(max(0.0, 1.0 - across * across)))); }`;

/**
 * Draws bands from a to b that face the eye, some pixels or some metres wide: rods, arrows if `hasHeads`, or the rim of a
 * rod if `isBehind`. One whose tint is negative is dashed.
 */
export class Ribbons {
  readonly mesh: Mesh;
  readonly a: Float32Array;
  readonly b: Float32Array;
  readonly tint: Float32Array;
  private geometry = new InstancedBufferGeometry();
  private material: ShaderMaterial;

  constructor(readonly count: number, width: number, least: number, haze: Haze, { hasHeads = false, isBehind = false } = {}) {
    // The shaft ends where a head begins (z < 0), and the head is a triangle (z > 0 at its foot).
    const end = hasHeads ? -1 : 0;
    const corners = [0, -0.5, 0, 0, 0.5, 0, 1, -0.5, end, 1, 0.5, end];
    const index = [0, 2, 1, 1, 2, 3];
    if (hasHeads) { corners.push(1, -0.9, 1, 1, 0.9, 1, 1, 0, 0); index.push(4, 6, 5); }
    this.geometry.setAttribute("corner", new BufferAttribute(new Float32Array(corners), 3));
    this.geometry.setIndex(index);
    const add = (name: string) => {
      const attribute = new InstancedBufferAttribute(new Float32Array(3 * count), 3);
      attribute.setUsage(DynamicDrawUsage);
      this.geometry.setAttribute(name, attribute);
      return attribute.array as Float32Array;
    };
    [this.a, this.b, this.tint] = [add("a"), add("b"), add("tint")];
    this.geometry.instanceCount = count;
    this.material = new ShaderMaterial({ glslVersion: GLSL3, vertexShader: ribbonVertex, fragmentShader: ribbonFragment,
      side: DoubleSide, polygonOffset: isBehind, polygonOffsetFactor: 1, polygonOffsetUnits: 8, uniforms: { screen: { value: new Vector2(1, 1) }, width: { value: width }, least: { value: least },
        head: { value: 11 }, ...haze } });
    this.mesh = new Mesh(this.geometry, this.material);
    this.mesh.frustumCulled = false;
  }
  resize(width: number, height: number): void { this.material.uniforms.screen.value.set(width / 2, height / 2); }
  update(): void { for (const name of ["a", "b", "tint"]) this.geometry.getAttribute(name).needsUpdate = true; }
}

const beadVertex = `${hazeVertex}
in vec3 tint; uniform float height; uniform float radius; uniform float least; out vec3 shade;
void main() {
  vec4 p = viewMatrix * vec4(position, 1.0);
  gl_Position = projectionMatrix * p;
  gl_PointSize = max(least, radius * projectionMatrix[1][1] * height / gl_Position.w);
  shade = tint;
  veil(gl_Position.w, position);
}`;
const beadFragment = `${hazeFragment}
in vec3 shade;
void main() {
  vec2 q = 2.0 * gl_PointCoord - 1.0; float s = dot(q, q);
  if (s > 1.0) discard;
  float light = 0.55 + 0.45 * max(0.0, dot(vec3(q.x, -q.y, sqrt(1.0 - s)), vec3(-0.35, 0.6, 0.72)));
  paint(shade * light);
}`;

/** Draws points as small lit balls, or as discs behind other balls if `isBehind`. */
export class Beads {
  readonly mesh: Points;
  readonly positions: Float32Array;
  readonly tint: Float32Array;
  private geometry = new BufferGeometry();
  private material: ShaderMaterial;

  constructor(count: number, radius: number, least: number, haze: Haze, { isBehind = false } = {}) {
    const add = (name: string) => {
      const attribute = new BufferAttribute(new Float32Array(3 * count), 3);
      attribute.setUsage(DynamicDrawUsage);
      this.geometry.setAttribute(name, attribute);
      return attribute.array as Float32Array;
    };
    [this.positions, this.tint] = [add("position"), add("tint")];
    this.material = new ShaderMaterial({ glslVersion: GLSL3, vertexShader: beadVertex, fragmentShader: beadFragment,
      uniforms: { height: { value: 1 }, radius: { value: radius }, least: { value: least }, ...haze } });
    this.mesh = new Points(this.geometry, this.material);
    this.mesh.renderOrder = isBehind ? -1 : 0;
    this.material.depthWrite = !isBehind;
    this.mesh.frustumCulled = false;
  }
  resize(height: number): void { this.material.uniforms.height.value = height; }
  update(): void { for (const name of ["position", "tint"]) this.geometry.getAttribute(name).needsUpdate = true; }
}

const vector = (row: number[], k: number) => new Vector3(row[k], row[k + 1], row[k + 2]);

/** Returns the axes of a guide: x, y, z of a unit shape become u, v, w. */
function frameAround(w: Vector3): [Vector3, Vector3, Vector3] {
  const axis = w.clone().normalize();
  const other = Math.abs(axis.x) < 0.8 ? new Vector3(1, 0, 0) : new Vector3(0, 1, 0);
  const u = other.cross(axis).normalize();
  return [u, axis.clone().cross(u), axis];
}

const curve = (points: Vector3[], colour: string) =>
  new Line(new BufferGeometry().setFromPoints(points), new LineBasicMaterial({ color: colour, transparent: true, opacity: 0.75 }));

const veil = (colour: string) =>
  new MeshBasicMaterial({ color: colour, transparent: true, opacity: 0.1, side: DoubleSide, depthWrite: false, blending: NormalBlending });

function net(u: number, v: number, place: (s: number, t: number) => Vector3, colour: string): LineSegments {
  const points: Vector3[] = [], fine = 48;
  for (let i = 0; i <= u; ++i) for (let k = 0; k < fine; ++k) points.push(place(i / u, k / fine), place(i / u, (k + 1) / fine));
  for (let i = 0; i <= v; ++i) for (let k = 0; k < fine; ++k) points.push(place(k / fine, i / v), place((k + 1) / fine, i / v));
  return new LineSegments(new BufferGeometry().setFromPoints(points),
    new LineBasicMaterial({ color: colour, transparent: true, opacity: 0.22, depthWrite: false }));
}

const onSphere = (s: number, t: number) =>
  new Vector3(Math.sin(Math.PI * s) * Math.cos(2 * Math.PI * t), Math.sin(Math.PI * s) * Math.sin(2 * Math.PI * t), Math.cos(Math.PI * s));

function ball(u: Vector3, v: Vector3, w: Vector3, center: Vector3, colour: string): Group {
  const group = new Group();
  group.add(new Mesh(new SphereGeometry(1, 48, 32), veil(colour)), net(8, 12, onSphere, colour));
  group.matrixAutoUpdate = false;
  group.matrix = new Matrix4().makeBasis(u, v, w).setPosition(center);
  return group;
}

/** Returns the picture of a guide at one frame; `middle` and `size` bound unbounded guides. */
export function drawGuide(guide: Guide, row: number[], middle: Vector3, size: number, colour: string): Group {
  const group = new Group(), turn = 2 * Math.PI;
  if (guide.kind === "plane") {
    const normal = vector(row, 0), square = normal.lengthSq();
    const foot = middle.clone().addScaledVector(normal, (row[3] - normal.dot(middle)) / square);
    const [u, v, w] = frameAround(normal);
    const side = 1.3 * size;
    const sheet = new Group();
    sheet.add(new Mesh(new PlaneGeometry(side, side), veil(colour)),
      net(10, 10, (s, t) => new Vector3((s - 0.5) * side, (t - 0.5) * side, 0), colour));
    sheet.matrixAutoUpdate = false;
    sheet.matrix = new Matrix4().makeBasis(u, v, w).setPosition(foot);
    group.add(sheet);
  } else if (guide.kind === "sphere") {
    const r = row[3];
    group.add(ball(new Vector3(r, 0, 0), new Vector3(0, r, 0), new Vector3(0, 0, r), vector(row, 0), colour));
  } else if (guide.kind === "ellipsoid") {
    const e = vector(row, 6).normalize(), h = vector(row, 9);
    const f = h.addScaledVector(e, -e.dot(h)).normalize(), g = e.clone().cross(f);
    group.add(ball(e.multiplyScalar(row[3]), f.multiplyScalar(row[4]), g.multiplyScalar(row[5]), vector(row, 0), colour));
  } else if (guide.kind === "line") {
    const along = vector(row, 3).normalize(), origin = vector(row, 0);
    const near = origin.clone().addScaledVector(along, along.dot(middle.clone().sub(origin)));
    group.add(curve([near.clone().addScaledVector(along, -size), near.clone().addScaledVector(along, size)], colour));
  } else if (guide.kind === "circle") {
    const [u, v] = frameAround(vector(row, 3)), center = vector(row, 0), points: Vector3[] = [];
    for (let k = 0; k <= 128; ++k)
      points.push(center.clone().addScaledVector(u, row[6] * Math.cos((turn * k) / 128)).addScaledVector(v, row[6] * Math.sin((turn * k) / 128)));
    group.add(curve(points, colour));
  } else if (guide.kind === "helix") {
    // The vectors e1 and e2 are those of include/tanor/kinds/line_frame.hpp.
    const d = vector(row, 3).normalize(), x = [Math.abs(d.x), Math.abs(d.y), Math.abs(d.z)];
    const axis = x[0] <= x[1] + 1e-6 && x[0] <= x[2] + 1e-6 ? 0 : x[1] <= x[2] + 1e-6 ? 1 : 2;
    const h = new Vector3().setComponent(axis, 1), e1 = h.addScaledVector(d, -d.getComponent(axis)).normalize();
    const e2 = d.clone().cross(e1), origin = vector(row, 0), middleHeight = d.dot(middle.clone().sub(origin));
    const points: Vector3[] = [], [radius, pitch, phase] = [row[6], row[7], row[8]];
    const count = Math.min(6000, Math.ceil(64 * Math.max(1, (2 * size) / Math.abs(pitch))));
    for (let k = 0; k <= count; ++k) {
      const z = middleHeight + size * ((2 * k) / count - 1), angle = phase + (turn * z) / pitch;
      points.push(origin.clone().addScaledVector(d, z).addScaledVector(e1, radius * Math.cos(angle)).addScaledVector(e2, radius * Math.sin(angle)));
    }
    group.add(curve(points, colour));
  } else if (guide.kind === "formula") {
    const { triangles, lines } = polygonise(readFormula(row), middle.toArray(), 0.5 * size);
    const shape = (places: number[]) => new BufferGeometry().setAttribute("position", new BufferAttribute(new Float32Array(places), 3));
    group.add(new Mesh(shape(triangles), veil(colour)), new LineSegments(shape(lines),
      new LineBasicMaterial({ color: colour, transparent: true, opacity: 0.22, depthWrite: false })));
  }
  return group;
}
