/** The surface of a formula, xi(x, y, z) = 0 at one time; src/program/picture/implicit_surface.cpp does the same. */

type Place = [number, number, number];
type Formula = (place: Place) => number;

/** The order is that of Expression::Operation, include/tanor/expression.hpp, from the constant on. */
const operations: ((a: number, b: number, constant: number) => number)[] = [
  (_a, _b, c) => c, (a, _b, c) => a * c, (a, _b, c) => a + c,
  (a, b) => a + b, (a, b) => a - b, (a, b) => a * b, (a, b) => a / b,
  Math.sqrt, Math.exp, Math.log, Math.sin, Math.cos, Math.sinh, Math.cosh, Math.asin, Math.atan, Math.atan2,
  Math.abs, (a, b) => Math.min(a, b), (a, b) => Math.max(a, b),
];

/** Reads a formula from the numbers of a guide of kind "formula", as described in src/program/report/guides.hpp. */
export function readFormula(row: number[]): Formula {
  const [t, result] = row, count = (row.length - 2) / 4, values = new Float64Array(count);
  return ([x, y, z]) => {
    const variables = [x, y, z, t];
    for (let k = 0, at = 2; k < count; ++k, at += 4)
      values[k] = row[at] === 0 ? variables[row[at + 3]] : operations[row[at] - 1](values[row[at + 1]], values[row[at + 2]], row[at + 3]);
    return values[result];
  };
}

interface Node { at: Place; r: Place; xi: number }
interface Crossing { inside: Node; outside: Node; r: Place }

const parts = 24; // along a side of the cube
const partsOfALine = 2; // between lines of the net that is drawn on the surface
const tetrahedra = [[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]]; // bits: x, y, z

/** Returns true if two crossings span an edge along a line of the net: their corners lie in one of its planes. */
const isOnLine = (a: Crossing, b: Crossing) => [0, 1, 2].some((axis) => {
  const plane = a.inside.at[axis];
  return plane % partsOfALine === 0 && [a.outside, b.inside, b.outside].every((node) => node.at[axis] === plane);
});

/** Returns the zero of xi between two corners, found by bisection; null if xi does not become small, because it has a pole or jumps. */
function findZero(xi: Formula, inside: Node, outside: Node): Place | null {
  const between = (a: Place, b: Place, part: number) => a.map((x, axis) => x + part * (b[axis] - x)) as Place;
  let [a, b, xiA, xiB] = [inside.r, outside.r, inside.xi, outside.xi];
  for (let k = 0; k < 5; ++k) {
    const middle = between(a, b, 0.5), value = xi(middle);
    if (!Number.isFinite(value)) return null;
    if (value < 0) [a, xiA] = [middle, value]; else [b, xiB] = [middle, value];
  }
  return xiB - xiA < 0.5 * (outside.xi - inside.xi) ? between(a, b, xiA / (xiA - xiB)) : null;
}

/** Adds the surface in a tetrahedron: nothing, or one or two triangles. */
function cut(xi: Formula, corners: Node[], triangles: number[], lines: number[]): void {
  const crossings: Crossing[] = [];
  for (const inside of corners.filter((node) => node.xi < 0))
    for (const outside of corners.filter((node) => !(node.xi < 0))) {
      const r = findZero(xi, inside, outside);
      if (!r) return;
      crossings.push({ inside, outside, r });
    }
  const add = (...three: Crossing[]) => three.forEach((each, k) => {
    triangles.push(...each.r);
    if (isOnLine(each, three[(k + 1) % 3])) lines.push(...each.r, ...three[(k + 1) % 3].r);
  });
  const [a, b, c, d] = crossings;
  if (crossings.length === 3) add(a, b, c);
  if (crossings.length === 4) { add(a, b, d); add(a, d, c); }
}

/** Returns triangles, and the lines on them, in a cube by marching tetrahedra. */
export function polygonise(xi: Formula, middle: Place, halfSide: number): { triangles: number[]; lines: number[] } {
  const nodes: Node[] = [], count = parts + 1, triangles: number[] = [], lines: number[] = [];
  for (let i = 0; i < count; ++i) for (let j = 0; j < count; ++j) for (let k = 0; k < count; ++k) {
    const at: Place = [i, j, k], r = at.map((n, axis) => middle[axis] + halfSide * ((2 * n) / parts - 1)) as Place;
    nodes.push({ at, r, xi: xi(r) });
  }
  for (const { at: [i, j, k] } of nodes) {
    if (i === parts || j === parts || k === parts) continue;
    for (const tetrahedron of tetrahedra) {
      const corners = tetrahedron.map((bits) => nodes[((i + (bits & 1)) * count + j + ((bits >> 1) & 1)) * count + k + (bits >> 2)]);
      if (corners.every((node) => Number.isFinite(node.xi))) cut(xi, corners, triangles, lines);
    }
  }
  return { triangles, lines };
}
