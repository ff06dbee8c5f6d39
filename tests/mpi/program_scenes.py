"""Scenes of the test of tanor-mpi. Each has parts enough for four ranks."""

import math


def net(side=8):
    """A net that hangs from two corners."""
    points = [[0.1 * i, 0.1 * j, 0.0] for i in range(side) for j in range(side)]
    pairs = [[i * side + j, (i + 1) * side + j] for i in range(side - 1) for j in range(side)]
    pairs += [[i * side + j, i * side + j + 1] for i in range(side) for j in range(side - 1)]
    return {"name": "net", "units": "si", "points": {"positions": points, "masses": 0.1},
            "supports": [{"points": [0, side * side - 1]}],
            "constraints": [{"kind": "rod", "pairs": pairs}],
            "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]}],
            "motion": {"method": "rattle", "step": 1e-3, "t_end": 0.04, "output_every": 0.02}}


def clusters(count=30, start=0):
    """Chains of 4 rods that fall beside each other, with a spring in each."""
    points, pairs, springs = [], [], []
    for k in range(start, start + count):
        first = len(points)
        points += [[1.0 * k + 0.1 * i, 0.03 * (i % 2), 0.0] for i in range(5)]
        pairs += [[first + i, first + i + 1] for i in range(4)]
        springs.append([first, first + 4])
    return {"name": "clusters", "units": "real", "points": {"positions": points, "masses": 0.1},
            "constraints": [{"kind": "rod", "pairs": pairs}],
            "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]},
                       {"kind": "spring", "pairs": springs, "stiffness": 5.0, "rest_length": 0.3}],
            "motion": {"t_end": 0.2, "rtol": 1e-9}}


def polymer(method, count=60):
    """A stiff chain that hangs, with a net of springs: constraints and forces reach from rank to rank."""
    points = [[0.1 * i, 0.02 * (i % 3), 0.0] for i in range(count)]
    return {"name": "polymer", "points": {"positions": points, "masses": 0.1}, "supports": [{"points": [0]}],
            "constraints": [{"kind": "rod", "pairs": [[i, i + 1] for i in range(count - 1)]}],
            "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]},
                       {"kind": "bending", "law": "cosine", "stiffness": 0.1,
                        "triples": [[i, i + 1, i + 2] for i in range(count - 2)]},
                       {"kind": "spring", "pairs": [[i, i + 3] for i in range(count - 3)], "stiffness": 5.0,
                        "rest_length": 0.25, "damping": 0.02}],
            "motion": {"method": method, "t_end": 0.05, "rtol": 1e-9}}


def melt(side=6):
    """Pairs of beads in a periodic box that repel each other: pair forces reach from rank to rank."""
    points = [[0.1 * i, 0.1 * j, 0.1 * k] for i in range(side) for j in range(side) for k in range(side)]
    velocities = [[0.3 * math.sin(3 * k + c) for c in range(3)] for k in range(len(points))]
    pairs = [[k, k + 1] for k in range(0, len(points), 2)]
    return {"name": "melt", "points": {"positions": points, "velocities": velocities, "masses": 0.1},
            "constraints": [{"kind": "rod", "pairs": pairs}],
            "forces": [{"kind": "pair", "law": "wca", "epsilon": 0.1, "sigma": 0.095, "exclude": "rods",
                        "box": [0.1 * side] * 3}],
            "motion": {"method": "rattle", "step": 2e-4, "start": "project", "t_end": 0.02}}


def beam(cubes=5):
    """Cubes in a row that all diagonals brace: many rods depend on others, on both sides of a cut."""
    points = [[0.1 * i, 0.1 * j, 0.1 * k] for i in range(cubes + 1) for j in range(2) for k in range(2)]
    pairs = [[a, b] for b in range(len(points)) for a in range(b) if math.dist(points[a], points[b]) < 0.18]
    return {"name": "beam", "points": {"positions": points, "masses": 0.1}, "supports": [{"points": [0]}],
            "constraints": [{"kind": "rod", "pairs": pairs}],
            "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]}],
            "motion": {"method": "rattle", "step": 1e-3, "t_end": 0.05}}


def beads(count=12, start=0):
    """Beads on rough inclines that stick and begin to slide under a growing pull: events."""
    points = [[0.5 * k, 0.0, 0.0] for k in range(start, start + count)]
    forces = [{"kind": "gravity", "acceleration": [0, 0, -9.81]},
              {"kind": "constant", "points": list(range(count)), "force": {"formula": ["0.5*t", "0", "0"]}}]
    return {"name": "beads", "points": {"positions": points, "masses": 0.1},
            "constraints": [{"kind": "plane", "name": "floor", "points": list(range(count)), "normal": [0, 0, 1],
                             "offset": 0.0}],
            "forces": forces, "friction": [{"kind": "coulomb", "at": "floor", "coefficient": 0.2}],
            "motion": {"method": "dop853", "t_end": 0.6, "rtol": 1e-9}}


def pendulums(count=6, start=0):
    """Double pendulums of a rod and a stiff spring: implicit steps of whole islands."""
    points, rods, springs = [], [], []
    for k in range(count):
        turn = 0.5 * (start + k)
        along = [math.cos(turn), math.sin(turn)]
        points += [[4.0 * turn + 0.1 * i * along[0], 0.1 * i * along[1], 0.0] for i in range(3)]
        rods.append([3 * k, 3 * k + 1])
        springs.append([3 * k + 1, 3 * k + 2])
    return {"name": "pendulums", "points": {"positions": points, "masses": 0.1},
            "supports": [{"points": [3 * k for k in range(count)]}], "constraints": [{"kind": "rod", "pairs": rods}],
            "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]},
                       {"kind": "spring", "pairs": springs, "stiffness": 1e6, "damping": 1e3, "rest_length": 0.1}],
            "motion": {"method": "radau5", "t_end": 0.2, "rtol": 1e-7}}


def stiff_chains(method, lengths=(30, 8, 7, 6)):
    """Chains that hang, with a stiff spring at the end of each. One would be cut, since it costs more than its share."""
    points, anchors, rods, springs = [], [], [], []
    for k, length in enumerate(lengths):
        first = len(points)
        points += [[0.1 * i, 1.0 * k, 0.02 * (i % 2)] for i in range(length)] + [[0.1 * length, 1.0 * k, 0.0]]
        anchors.append(first)
        rods += [[i, i + 1] for i in range(first, first + length - 1)]
        springs.append([first + length - 1, first + length])
    return {"name": "stiff chains", "points": {"positions": points, "masses": 0.1}, "supports": [{"points": anchors}],
            "constraints": [{"kind": "rod", "pairs": rods}],
            "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]},
                       {"kind": "spring", "pairs": springs, "stiffness": 1e6, "damping": 1e3, "rest_length": 0.1}],
            "motion": {"method": method, "t_end": 0.05, "rtol": 1e-7}}


def rough_beads(groups=4):
    """Beads that slide on a rough floor and repel each other: those of a group are whole on one rank."""
    points, velocities, pairs = [], [], []
    for k in range(groups):
        first = len(points)
        points += [[5.0 * k + 0.1 * i, 0.1 * j, 0.0] for i in range(2) for j in range(2)]
        velocities += [[0.1 * i + 0.02 * k, 0.3 - 0.1 * i, 0.0] for i in range(4)]
        pairs.append({"kind": "pair", "law": "wca", "epsilon": 1e-3, "sigma": 0.095,
                      "points": list(range(first, first + 4))})
    return {"name": "rough beads", "points": {"positions": points, "velocities": velocities, "masses": 0.1},
            "constraints": [{"kind": "plane", "name": "floor", "points": list(range(len(points))), "normal": [0, 0, 1],
                             "offset": 0.0}],
            "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]}, *pairs],
            "friction": [{"kind": "coulomb", "at": "floor", "coefficient": 0.1}],
            "motion": {"method": "dop853", "t_end": 0.05, "rtol": 1e-9}}


def mechanisms(count=4, start=0, has_constraints=False):
    """Bodies that tumble, chains and beads on rings; in coordinates alone, or as bodies and chains of rods as well."""
    points, velocities, anchors, coordinates, rods = [], [], [], [], []
    for k in range(start, start + count):
        first = len(points)
        points += [[0.1 * i, 0.4 * k, 0.0] for i in range(3)]
        velocities += [[0, 0, 0]] * 3
        anchors.append(first)
        coordinates.append({"kind": "chain_angles", "points": [first + 1, first + 2], "anchor": first})
        rods += [[first, first + 1], [first + 1, first + 2]]
        corners = [[0, 0, 0], [0.1, 0, 0], [0, 0.2, 0], [0, 0, 0.3]]
        points += [[0.4 + x, 0.4 * k + y, z] for x, y, z in corners]
        velocities += [[-y * (2 + k), x * (2 + k), 0.0] for x, y, z in corners]
        coordinates.append({"kind": "rigid_body", "points": list(range(first + 3, first + 7))})
        rods += [[first + 3 + i, first + 3 + j] for i in range(4) for j in range(i)]
        if has_constraints:
            continue
        points.append([0.7, 0.4 * k + 0.1, 0.0])
        velocities.append([0, 0, 0])
        coordinates.append({"kind": "circle", "points": [first + 7], "center": [0.7, 0.4 * k, 0],
                            "normal": [1, 0, 0]})
    return {"name": "mechanisms", "points": {"positions": points, "velocities": velocities, "masses": 0.1},
            "supports": [{"points": anchors}], "coordinates": coordinates,
            "constraints": [{"kind": "rod", "pairs": rods}] if has_constraints else [],
            "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]}],
            "motion": {"method": "auto", "t_end": 0.2, "rtol": 1e-9}}


def charges(count=12):
    """Charged pendulum bobs without supports: pair forces at any distance reach from rank to rank."""
    points = [[0.3 * i, 0.1 * (i % 3), 0.05 * (i % 2)] for i in range(count)]
    return {"name": "charges", "points": {"positions": points, "masses": 0.1},
            "constraints": [{"kind": "rod", "pairs": [[i, i + 1] for i in range(0, count, 2)]}],
            "forces": [{"kind": "pair", "law": "coulomb", "strength": 1e-3, "exclude": "rods",
                        "charges": [1.0 + 0.1 * i if i % 2 else -1.0 for i in range(count)]}],
            "motion": {"method": "auto", "t_end": 0.2, "rtol": 1e-9}}
