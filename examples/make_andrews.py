#!/usr/bin/python3
"""Writes andrews.json: Andrews' squeezing mechanism as 14 points (docs/modelling.md, "Bodies as points").

    make_andrews.py > andrews.json
"""

import cmath
import json

BETA, THETA, GAMMA, PHI, DELTA, OMEGA, EPSILON = (
    -0.0617138900142764496, 0.0, 0.455279819163070380, 0.222668390165885885, 0.487364979543842550,
    -0.222668390165885885, 1.23054744454982119)
A, B, C = complex(-0.06934, -0.00227), complex(-0.03635, 0.03273), complex(0.014, 0.072)


def along(angle: float) -> complex:
    return cmath.exp(1j * angle)


CRANK = 0.007 * along(BETA)
F = CRANK - 0.028 * along(BETA + THETA)
G = A + 0.04 * along(DELTA)
H = A - 0.04j * along(EPSILON)
SPRING = B + (0.02 - 0.018j) * along(GAMMA)

# mass, moment of inertia, joint, centre of mass; the bodies K1 to K7 of the test set
BODIES = [(0.04325, 2.194e-6, CRANK, 0.00092 * along(BETA)),
          (0.00365, 4.410e-7, F, CRANK - 0.0115 * along(BETA + THETA)),
          (0.02373, 5.255e-6, F, B + (0.01043 - 0.01874j) * along(GAMMA)),
          (0.00706, 5.667e-7, G, G - 0.00579j * along(PHI + DELTA)),
          (0.07050, 1.169e-5, G, A + (0.02308 + 0.00916j) * along(DELTA)),
          (0.00706, 5.667e-7, H, H + 0.00579 * along(OMEGA + EPSILON)),
          (0.05498, 1.912e-5, H, A + (-0.00449 - 0.01228j) * along(EPSILON))]


def opposite(body) -> complex:
    """The second point lies behind the centre, so that both have the body's centre and moment of inertia."""
    mass, inertia, joint, centre = body
    return centre + inertia / (mass * abs(centre - joint) ** 2) * (centre - joint)


def combination(body: int, place: complex) -> complex:
    """alpha + i beta with place = a + (alpha + i beta)(c - a), a and c being the body's points."""
    a, c = BODIES[body][2], opposite(BODIES[body])
    return (place - a) / (c - a)


def joint(name: str, bodies: list, place: complex, value: complex = 0.0) -> list:
    """The place of the first body is that of the second one, or stands at `value`: an equation for x, one for y."""
    points, by_x, by_y, sign = [], [], [], 1.0
    for body in bodies:
        s = combination(body, place)
        for point, part in ((2 * body, sign * (1 - s)), (2 * body + 1, sign * s)):
            if part == 0:  # the place is the body's other point
                continue
            points.append(point)
            by_x.append([part.real, -part.imag, 0])
            by_y.append([part.imag, part.real, 0])
        sign = -1.0
    return [{"kind": "linear", "name": f"{name}.{axis}", "tuples": [points], "coefficients": rows, "value": end}
            for axis, rows, end in (("x", by_x, complex(value).real), ("y", by_y, complex(value).imag))]


def make_scene() -> dict:
    positions, masses = [], []
    for body in BODIES:
        mass, inertia, a, centre = body
        at_joint = mass * inertia / (mass * abs(centre - a) ** 2 + inertia)
        for place in (a, opposite(body)):
            positions.append([place.real, place.imag, 0])
        masses += [at_joint, mass - at_joint]
    s = combination(2, SPRING)
    couple = "moment/((x2 - x1)^2 + (y2 - y1)^2)"
    return {
        "tanor_scene": 1,
        "name": "Andrews' squeezing mechanism",
        "parameters": {"moment": 0.033, "k": 4530, "rest": 0.07785, "a": s.real, "b": s.imag, "cx": C.real, "cy": C.imag},
        "points": {"positions": positions, "masses": masses},
        "constraints": [
            {"kind": "plane", "name": "plane", "points": "all", "normal": [0, 0, 1], "offset": 0},
            {"kind": "rod", "name": "bodies", "pairs": [[2 * k, 2 * k + 1] for k in range(7)]},
            *joint("pin 1", [0], 0.0, 0.0), *joint("crank", [0, 1], CRANK), *joint("f2-3", [1, 2], F),
            *joint("f2-4", [1, 3], F), *joint("f2-6", [1, 5], F), *joint("pin 3", [2], B, B),
            *joint("g", [3, 4], G), *joint("pin 5", [4], A, A), *joint("h", [5, 6], H), *joint("pin 7", [6], A, A)],
        "forces": [
            {"kind": "potential", "name": "spring", "points": [[4, 5]],
             "energy": "k/2*(sqrt((x1 + a*(x2 - x1) - b*(y2 - y1) - cx)^2 + (y1 + a*(y2 - y1) + b*(x2 - x1) - cy)^2)"
                       " - rest)^2"},
            {"kind": "formula", "name": "drive", "tuples": [[0, 1]],
             "x1": f"(y2 - y1)*{couple}", "y1": f"(x1 - x2)*{couple}",
             "x2": f"(y1 - y2)*{couple}", "y2": f"(x2 - x1)*{couple}"}],
        "motion": {"method": "taylor", "rtol": 1e-12, "atol": 1e-14, "t_end": 0.03, "output_every": 0.0001}}


if __name__ == "__main__":
    print(json.dumps(make_scene(), indent=1))
