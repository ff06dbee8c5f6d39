#!/usr/bin/python3
"""fix tanor/rods inside Debian's LAMMPS: check_lammps.py TANOR.LMP DRIVER [unittest arguments]"""

import math
import pathlib
import random
import re
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
import host_runs  # noqa: E402

REGISTER = DRIVER = None
TIGHT = 1e-12  # of a bond, relative


def data(atoms, bonds, box, masses=(1.0,), image_flags=None, tilt=None):
    """A data file of atom_style bond; atoms: positions, bonds: (type, i, j) from 1; box: (low, high) each."""
    lines = ["test", "", f"{len(atoms)} atoms", f"{len(bonds)} bonds", f"{len(masses)} atom types",
             f"{max([kind for kind, _, _ in bonds], default=1)} bond types", "10 extra bond per atom", "40 extra special per atom", ""]
    lines += [f"{low!r} {high!r} {axis}lo {axis}hi" for (low, high), axis in zip(box, "xyz")]
    lines += [f"{tilt[0]} {tilt[1]} {tilt[2]} xy xz yz"] if tilt else []
    lines += ["", "Masses", ""] + [f"{k + 1} {mass}" for k, mass in enumerate(masses)]
    lines += ["", "Atoms", ""]
    for k, place in enumerate(atoms):
        flags = " ".join(map(str, image_flags[k])) if image_flags else ""
        lines.append(f"{k + 1} 1 {k % len(masses) + 1} " + " ".join(f"{x!r}" for x in place) + " " + flags)
    lines += ["", "Bonds", ""] + [f"{k + 1} {kind} {i} {j}" for k, (kind, i, j) in enumerate(bonds)]
    return "\n".join(lines) + "\n"


def melt(side=8, spacing=1.05, length=32, shift=0.0, tilt=None):
    """Chains along one line that winds through all places of a cubic lattice; `shift` of it goes over the faces."""
    places = []
    for z in range(side):
        for y in range(side)[:: 1 if z % 2 == 0 else -1]:
            for x in range(side)[:: 1 if (y + z) % 2 == 0 else -1]:
                places.append([(x + 0.5 + shift) * spacing, (y + 0.5 + shift) * spacing, (z + 0.5 + shift) * spacing])
    edge = side * spacing
    bonds = [(1, k, k + 1) for k in range(1, len(places)) if k % length != 0]
    wrapped = [[x % edge for x in place] for place in places]
    return data(wrapped, bonds, [(0.0, edge)] * 3, tilt=tilt), len(bonds)


MELT = """
units lj
atom_style bond
{before}
read_data melt.data
special_bonds lj 0 1 1
neighbor 0.4 bin
neigh_modify every 1 delay 0
bond_style zero nocoeff
bond_coeff *
pair_style lj/cut 1.122462
pair_modify shift yes
pair_coeff * * 1.0 1.0
timestep 0.004
{start}
"""

RODS = """
include {register}
fix move all {move}
fix rods all tanor/rods bond 1 {options}
compute length all bond/local dist
compute shortest all reduce min c_length
compute longest all reduce max c_length
{columns}"""


def columns(names):
    return f"thermo_style custom step {names}\nthermo_modify norm no format float %.16g\n"


def lj(before="", start="velocity all create 1.0 4928459"):
    return MELT.format(before=before, start=start)


def rods(move="nve", options="length 0.97"):
    shown = "temp ke pe etotal press vol econserve fmax c_shortest c_longest f_rods f_rods[1] f_rods[4]"
    return RODS.format(register=REGISTER, move=move, options=options, columns=columns(shown))


def dump(name, every, columns="xu yu zu"):
    return f"dump d all custom {every} {name} id {columns}\ndump_modify d sort id format float %.17g\n"


class Lammps(host_runs.HostTest):
    program = "lmp"

    def write_melt(self, **options):
        text, self.num_bonds = melt(**options)
        self.write("melt.data", text)

    def assert_lengths(self, rows, length, tolerance=TIGHT):
        """By the host's own measure and by ours, in every row."""
        self.assertGreater(len(rows), 1)
        for row in rows:
            self.assertLessEqual(row["f_rods"], tolerance, row)
            for name in ("c_shortest", "c_longest"):
                self.assertLessEqual(abs(row[name] / length - 1.0), tolerance, row)

    # ---- dynamics ----

    def test_bonds_keep_their_length_in_every_step(self):
        self.write_melt()
        (rows,) = self.run_host(lj() + rods() + "thermo 1\nrun 300\n")
        self.assertEqual(len(rows), 301)
        self.assertEqual(rows[0]["f_rods[4]"], self.num_bonds)
        self.assert_lengths(rows, 0.97)

    def test_a_tolerance_saves_iterations(self):
        self.write_melt()
        script = lj() + rods().replace("length 0.97", "length 0.97 {}") + "thermo 1\nrun 50\n"
        (exact,) = self.run_host(script.format(""))
        (rough,) = self.run_host(script.format("tolerance 1e-7"))
        self.assert_lengths(rough[1:], 0.97, 1e-7)
        self.assertGreater(max(row["f_rods"] for row in rough), TIGHT)
        self.assertLess(rough[-1]["f_rods[1]"], 0.6 * exact[-1]["f_rods[1]"])

    def test_the_driver_needs_no_python(self):
        self.write_melt()
        script = lj() + rods().replace(f"include {REGISTER}", "") + "thermo 10\nrun 20\n"
        (rows,) = self.run_host(script, program=DRIVER)
        self.assert_lengths(rows, 0.97)

    def test_the_script_of_the_manual(self):
        (script,) = host_runs.blocks_of_page("Inside LAMMPS")
        (melt,) = re.findall(r"^read_data +(\S+)", script, flags=re.M)
        if not pathlib.Path(melt).exists():  # Debian's lammps-examples has it; any bonded melt serves
            self.write_melt()
            script = script.replace(melt, "melt.data")
        for was, now in (("/usr/share/tanor/tanor.lmp", str(REGISTER)), ("run             1000", "run 20"),
                         ("dump            tensions all local 100", "dump tensions all local 20"), ("thermo          100", "thermo 20"), ("store 100", "store 20")):
            self.assertIn(was, script)
            script = script.replace(was, now)
        (rows,) = self.run_host(script)
        self.assertEqual([row["step"] for row in rows], [0, 20])
        for row in rows:
            self.assertLessEqual(row["f_rods"], TIGHT)
        tensions = host_runs.read_dump(self.folder / "tensions.txt", 20)
        self.assertGreater(len(tensions), 400)
        for rod in tensions:
            self.assertEqual(len(rod), 4)
            self.assertNotEqual(rod[0], rod[1])

    def test_energy_has_no_trend(self):
        self.write_melt()
        script = lj() + rods() + "thermo 5000\nrun 2000\nthermo 1\nrun 10000\n"
        rows = self.run_host(script)[1]
        self.assertEqual(len(rows), 10001)
        self.assert_lengths(rows, 0.97)
        energies = [row["etotal"] for row in rows]
        fifth = len(energies) // 5
        first, last = sum(energies[:fifth]) / fifth, sum(energies[-fifth:]) / fifth
        # The melt is chaotic, and its energy walks at random: by 2.8e-4, 1.3e-4, 0.0 and 0.1e-4 from four starts. Rods
        # that are not those of RATTLE lose a tenth and more.
        self.assertLess(abs(last - first) / max(row["ke"] for row in rows), 1e-3)

    def test_energy_is_that_after_the_start(self):
        # Forces of the first step belong to the positions that the start has found.
        self.write_melt()
        (rows,) = self.run_host(lj() + rods() + "thermo 1\nrun 20\n")
        self.assertLess(abs(rows[20]["etotal"] - rows[0]["etotal"]), 3e-3 * rows[0]["ke"])

    def test_lengths_are_the_initial_ones(self):
        self.write_melt()
        (rows,) = self.run_host(lj() + rods(options="") + "thermo 5\nrun 50\n")
        self.assert_lengths(rows, 1.05)

    def test_ranks_agree(self):
        self.write_melt()
        script = lj("processors * * *") + rods() + "thermo 100\n" + dump("{}", 100) + "run 100\n"
        one = self.run_host(script.format("one"))[0][-1]
        for ranks in (2, 4):
            with self.subTest(ranks=ranks):
                many = self.run_host(script.format("many"), ranks)[0][-1]
                self.assert_same_atoms(self.atoms("one", 100), self.atoms("many", 100), 1e-9)
                self.assertLessEqual(abs(one["f_rods[1]"] - many["f_rods[1]"]), 1.0)
                self.assertAlmostEqual(one["press"], many["press"], delta=1e-8)
                self.assertEqual(one["f_rods[4]"], many["f_rods[4]"])

    def test_bonds_stored_with_both_atoms_count_once(self):
        self.write_melt()
        (rows,) = self.run_host(lj("newton off") + rods() + "thermo 10\nrun 20\n", ranks=2)
        self.assertEqual(rows[-1]["f_rods[4]"], self.num_bonds)
        self.assert_lengths(rows, 0.97)

    def test_image_flags_may_be_wrong(self):
        # Half of the chains goes over the faces and all flags are 0: bonds join nearest images.
        for ranks in (1, 2):
            with self.subTest(ranks=ranks):
                self.write_melt(shift=3.7)
                (rows,) = self.run_host(lj() + rods() + "thermo 5\nrun 50\n", ranks)
                self.assert_lengths(rows, 0.97)

    def test_a_ring_may_close_round_the_box(self):
        n, edge = 20, 19.0
        places = [[edge * k / n, 3.0 + 0.3 * (-1) ** k, 3.0 + 0.2 * math.sin(k)] for k in range(n)]
        bonds = [(1, k + 1, (k + 1) % n + 1) for k in range(n)]
        self.write("melt.data", data(places, bonds, [(0.0, edge), (0.0, 6.0), (0.0, 6.0)]))
        (rows,) = self.run_host(lj() + rods(options="") + "thermo 5\nrun 200\n")
        self.assertTrue(all(row["f_rods"] <= TIGHT for row in rows))

    def test_a_box_that_changes(self):
        self.write_melt(tilt=(0.5, 0.0, 0.3))
        moves = "npt temp 1.0 1.0 0.5 tri 4.0 4.0 2.0"
        (rows,) = self.run_host(lj() + rods(moves) + "thermo 10\nrun 500\n", ranks=2)
        self.assertGreater(abs(rows[-1]["vol"] / rows[0]["vol"] - 1.0), 0.01)
        self.assert_lengths(rows, 0.97)

    def test_a_barostat_sees_the_virial_of_its_step(self):
        self.write_melt()
        script = lj() + rods("nph iso 5.0 5.0 2.0") + "thermo 1000\nrun 1000\nthermo 10\nrun 3000\n"
        rows = self.run_host(script)[1]
        conserved = [row["econserve"] for row in rows]
        # Atoms without rods spread as much: 0.007 of their kinetic energy.
        self.assertLess(max(conserved) - min(conserved), 3e-2 * rows[0]["ke"])
        self.assert_lengths(rows, 0.97)

    # ---- what the host's temperature and pressure see ----

    def test_pressure_of_dumbbells_is_molecular(self):
        # (sum m v^2 + virial of rods + sum (r - R) f) = sum M V^2 at every instant, f being a field.
        chance = random.Random(5)
        places, bonds = [], []
        for k in range(27):
            corner = [4.0 * (k // 9) + 1.0, 4.0 * (k // 3 % 3) + 1.0, 4.0 * (k % 3) + 1.0]
            turn = [chance.gauss(0, 1) for _ in range(3)]
            size = math.sqrt(sum(x * x for x in turn))
            places += [corner, [x + t / size for x, t in zip(corner, turn)]]
            bonds.append((1, 2 * k + 1, 2 * k + 2))
        self.write("melt.data", data(places, bonds, [(-20.0, 20.0)] * 3, masses=(1.0, 2.5)))
        script = lj().replace("lj/cut 1.122462", "zero 1.0 nocoeff").replace("pair_modify shift yes", "")
        script = script.replace("pair_coeff * * 1.0 1.0", "pair_coeff * *")
        field = "variable fx atom sin(x)+y\nvariable fy atom cos(z)\nvariable fz atom -0.3*x*y\n"
        (rows,) = self.run_host(script + field + rods("nve", "").replace(
            "fix rods", "fix field all addforce v_fx v_fy v_fz\nfix rods") +
            "thermo 10\n" + dump("d", 10, "mass xu yu zu vx vy vz fx fy fz") + "run 50\n")
        for row in rows[1:]:
            atoms = self.atoms("d", int(row["step"]))
            inner = molecular = 0.0
            for k in range(27):
                a, b = atoms[2 * k + 1], atoms[2 * k + 2]
                total = a[0] + b[0]
                for axis in range(3):
                    molecular += (a[0] * a[4 + axis] + b[0] * b[4 + axis]) ** 2 / total
                    center = (a[0] * a[1 + axis] + b[0] * b[1 + axis]) / total
                    inner += sum((p[1 + axis] - center) * p[7 + axis] for p in (a, b))
            atomic = 3.0 * row["vol"] * row["press"] + inner
            self.assertLess(abs(atomic - molecular) / molecular, 1e-12)

    def test_temperature_counts_the_rank(self):
        # Methane with all ten distances has rank nine.
        corners = [(0, 0, 0), (1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)]
        places = [[5.0 * (k // 9) + 0.6 * c[0] + 1, 5.0 * (k // 3 % 3) + 0.6 * c[1] + 1, 5.0 * (k % 3) + 0.6 * c[2] + 1]
                  for k in range(27) for c in corners]
        bonds = [(1, 5 * k + i + 1, 5 * k + j + 1) for k in range(27) for i in range(5) for j in range(i)]
        self.write("melt.data", data(places, bonds, [(0.0, 15.0)] * 3))
        for ranks in (1, 2):
            with self.subTest(ranks=ranks):
                (rows,) = self.run_host(lj().replace("lj 0 1 1", "lj 0 0 0") + rods(options="") +
                                        "thermo 10\nrun 100\n", ranks)
                degrees = 3 * 135 - 3 - 9 * 27
                self.assertEqual(rows[0]["f_rods[4]"], 270)
                for row in rows:
                    self.assertAlmostEqual(row["temp"] * degrees, 2.0 * row["ke"], delta=1e-9 * row["ke"])
                    self.assertLessEqual(row["f_rods"], TIGHT)

    def test_tension_of_a_spinning_dumbbell(self):
        # m v^2/(L/2) pulls at the rod.
        self.write("melt.data", data([[4.0, 4.0, 4.0], [5.5, 4.0, 4.0]], [(1, 1, 2)], [(0.0, 9.0)] * 3))
        start = "group one id 1\ngroup two id 2\nvelocity one set 0 1 0\nvelocity two set 0 -1 0"
        self.run_host(lj(start=start) + rods(options="store yes") +
                      "thermo 10\ndump t all local 10 tension f_rods[1] f_rods[2] f_rods[3] f_rods[4]\n"
                      "dump_modify t format float %.17g\nrun 100\n")
        for step in (0, 10, 100):
            ((a, b, kind, tension),) = host_runs.read_dump(self.folder / "tension", step)
            self.assertEqual((a, b, kind), (1, 2, 1))
            self.assertAlmostEqual(tension, 1.0 / 0.75, delta=1e-12)

    STRESS = """
compute stress all stress/atom thermo_temp
compute sum all reduce sum c_stress[1] c_stress[2] c_stress[3] c_stress[4] c_stress[5] c_stress[6]
""" + columns("press vol pxx pyy pzz pxy pxz pyz c_sum[1] c_sum[2] c_sum[3] c_sum[4] c_sum[5] c_sum[6]")

    def test_stresses_of_atoms_are_the_pressure(self):
        self.write_melt()
        parts = ("xx", "yy", "zz", "xy", "xz", "yz")
        for ranks in (1, 2):
            with self.subTest(ranks=ranks):
                script = lj() + rods() + self.STRESS + "thermo 10\nrun 50\nminimize 0 1e-8 20 200\n"
                tables = self.run_host(script, ranks)
                self.assertEqual(len(tables), 2)
                for rows in tables:
                    self.assertGreater(len(rows), 1)
                    for row in rows:
                        for k, part in enumerate(parts):
                            pressure = -row[f"c_sum[{k + 1}]"] / row["vol"]
                            self.assertAlmostEqual(pressure, row["P" + part], delta=1e-11 * abs(row["press"]))

    def test_stress_of_a_spinning_dumbbell(self):
        # Half of the rod's tension times its length at each atom.
        self.write("melt.data", data([[4.0, 4.0, 4.0], [5.5, 4.0, 4.0]], [(1, 1, 2)], [(0.0, 9.0)] * 3))
        start = "group one id 1\ngroup two id 2\nvelocity one set 0 1 0\nvelocity two set 0 -1 0"
        self.run_host(lj(start=start) + rods(options="") + "compute stress all stress/atom NULL fix\n" +
                      dump("d", 1, "c_stress[*]") + "run 0\n")
        for row in self.atoms("d").values():
            for number, wanted in zip(row, (1.0, 0.0, 0.0, 0.0, 0.0, 0.0)):
                self.assertAlmostEqual(number, wanted, delta=1e-12)

    # ---- bonds that come and go ----

    def test_bonds_that_break_in_a_run(self):
        self.write_melt()
        for ranks in (1, 2):
            with self.subTest(ranks=ranks):
                script = (lj() + rods() + "fix gone all bond/break 10 1 0.5 prob 0.02 4711\n"
                          "compute_modify thermo_temp dynamic/dof yes\n" +
                          columns("temp ke f_rods f_rods[4] f_gone[2]") + "thermo 1\nrun 100\n")
                (rows,) = self.run_host(script, ranks)
                self.assertGreater(rows[-1]["f_gone[2]"], 10)
                for row in rows:
                    self.assertEqual(row["f_rods[4]"], self.num_bonds - row["f_gone[2]"])
                    self.assertLessEqual(row["f_rods"], TIGHT)
                    self.assertAlmostEqual(row["temp"] * (3 * 512 - 3 - row["f_rods[4]"]), 2.0 * row["ke"],
                                           delta=1e-9 * row["ke"])

    def test_bonds_that_are_made_in_a_run(self):
        # From dumbbells; a bond to one more atom has its length at once.
        self.write_melt(length=2)
        for options, ranks in (("length 0.97", 1), ("length 0.97", 2), ("", 2)):
            with self.subTest(options=options, ranks=ranks):
                script = (lj("comm_modify cutoff 3.0") + rods(options=options) +
                          "fix new all bond/create 10 1 1 1.1 1 iparam 3 1 jparam 3 1\n" +
                          columns("ke f_rods f_rods[4] f_new[2]") + "thermo 1\nrun 100\n")
                (rows,) = self.run_host(script, ranks)
                self.assertGreater(rows[-1]["f_new[2]"], 20)
                for row in rows:
                    self.assertEqual(row["f_rods[4]"], self.num_bonds + row["f_new[2]"])
                    self.assertLessEqual(row["f_rods"], TIGHT)

    # ---- restart, minimisation, grains ----

    def test_a_restart_goes_on(self):
        self.write_melt()
        last = dump("{}", 100) + "run 100\n"
        self.run_host(lj() + rods(options="") + "thermo 100\nrun 100\nwrite_restart saved\n" + last.format("one"))
        read = lj(start="").replace("read_data melt.data", "read_restart saved").replace("atom_style bond", "")
        for ranks in (1, 2):
            with self.subTest(ranks=ranks):
                (rows,) = self.run_host(read + rods(options="") + "thermo 10\n" + last.format("two"), ranks)
                self.assert_lengths(rows, 1.05)
                self.assert_same_atoms(self.atoms("one", 200), self.atoms("two", 200), 1e-9)

    def test_a_restart_keeps_the_lengths(self):
        # Atoms that were displaced go back to the lengths of the file, not to those that they are found with.
        self.write_melt()
        self.run_host(lj() + rods(options="") + "thermo 100\nrun 100\nwrite_restart saved\n")
        read = lj(start="").replace("read_data melt.data", "read_restart saved").replace("atom_style bond", "")
        script = read + "displace_atoms all random 0.01 0.01 0.01 7\n" + rods(options="") + "thermo 5\nrun 20\n"
        self.assert_lengths(self.run_host(script, ranks=2)[0], 1.05)

    def test_two_runs_are_one(self):
        self.write_melt()
        start = lj() + rods() + "thermo 50\n" + dump("{}", 100)
        self.run_host(start.format("one") + "run 100\n")
        self.run_host(start.format("two") + "run 50\nrun 50\n")
        self.assert_same_atoms(self.atoms("one", 100), self.atoms("two", 100), 1e-9)

    def test_minimisers_move_along_the_constraints(self):
        self.write_melt()
        for style in ("cg", "sd", "fire", "quickmin"):
            for ranks in (1, 2):
                with self.subTest(style=style, ranks=ranks):
                    script = lj() + rods() + "thermo 20\nrun 200\n" + "thermo 100\nmin_style {}\n".format(style)
                    rows = self.run_host(script + "min_modify dmax 0.05\nminimize 0 1e-8 400 4000\n", ranks)[1]
                    self.assert_lengths(rows, 0.97, 1e-11)
                    self.assertLess(rows[-1]["pe"], 0.5 * rows[0]["pe"])
                    self.assertLess(rows[-1]["fmax"], 0.05 * rows[0]["fmax"])

    def test_a_bent_chain_finds_the_minimum(self):
        # Three atoms, two rods of length 1; the ends attract each other and meet where lj is lowest.
        self.write("melt.data", data([[3.0, 4.0, 4.0], [4.0, 4.2, 4.0], [5.0, 4.0, 4.0]], [(1, 1, 2), (1, 2, 3)],
                                     [(0.0, 9.0)] * 3))
        script = lj(start="").replace("lj/cut 1.122462", "lj/cut 3.0").replace("pair_modify shift yes", "")
        script += rods(options="length 1.0") + "thermo 100\nmin_style cg\nminimize 0 1e-10 1000 10000\n"
        rows = self.run_host(script + dump("d", 1) + "run 0\n")[0]
        self.assertAlmostEqual(rows[-1]["pe"], -1.0, delta=1e-10)
        self.assert_lengths(rows, 1.0, 1e-11)

    GRAINS = """
units si
atom_style hybrid sphere bond
comm_modify vel yes
newton off
boundary p p f
read_data grains.data
special_bonds lj 0 1 1
neighbor 0.002 bin
neigh_modify every 1 delay 0
bond_style zero nocoeff
bond_coeff *
pair_style gran/hertz/history 1e6 NULL 50.0 NULL 0.4 1
pair_coeff * *
timestep 1e-5
fix gravity all gravity 9.81 vector 0 0 -1
fix floor all wall/gran hertz/history 1e6 NULL 50.0 NULL 0.4 1 zplane 0.0 NULL
"""

    def test_chains_of_grains_fall_onto_a_floor(self):
        lines, bonds, d = [], [], 0.01
        for c in range(12):
            for k in range(8):
                tag = 8 * c + k + 1
                lines.append(f"{tag} 1 {0.02 + 0.015 * (c % 4) + 0.003 * (k % 2)} {0.02 + 0.015 * (c // 4)} "
                             f"{0.012 + 0.0096 * k} {d} 2500 {c + 1}")
                bonds += [f"{len(bonds) + 1} 1 {tag - 1} {tag}"] if k else []
        self.write("grains.data", f"grains\n\n{len(lines)} atoms\n{len(bonds)} bonds\n1 atom types\n1 bond types\n\n"
                   "0 0.1 xlo xhi\n0 0.1 ylo yhi\n-0.01 0.2 zlo zhi\n\nAtoms\n\n" + "\n".join(lines) +
                   "\n\nBonds\n\n" + "\n".join(bonds) + "\n")
        script = self.GRAINS + rods("nve/sphere", "") + "thermo 500\n" + dump("{}", 3000) + "run 3000\nthermo 2000\nrun 40000\n"
        first, second = self.run_host(script.format("one"))
        for rows in (first, second):
            self.assertTrue(all(row["f_rods"] <= TIGHT for row in rows))
        self.assertLess(second[-1]["ke"], 0.25 * max(row["ke"] for row in first + second))
        self.run_host(script.format("two").replace("thermo 2000\nrun 40000\n", ""), ranks=2)
        self.assert_same_atoms(self.atoms("one", 3000), self.atoms("two", 3000), 1e-9)

    # ---- errors ----

    def assert_refused(self, script, message, ranks=(1, 2)):
        for count in ranks:
            with self.subTest(ranks=count, message=message):
                code, said = self.call(script, count)
                self.assertNotEqual(code, 0, said[-2000:])
                lines = [line for line in said.splitlines() if line.startswith("ERROR")]
                self.assertEqual(len(lines), 1, said[-2000:])
                self.assertIn(message, lines[0])

    def test_wrong_words(self):
        self.write_melt()
        for options, message in (("bond 7", "there is no bond type 7; there are 1"),
                                 ("bond", "no bond types are given"),
                                 ("bond 1 length -2", "length -2 is no positive number"),
                                 ("bond 1 length", "length lacks its value"),
                                 ("bond 1 tolerance nan", "tolerance nan is no positive number"),
                                 ("bond 1 store maybe", "store maybe is no number of steps"),
                                 ("bond 1 colour red", "unknown word colour")):
            self.assert_refused(lj() + rods().replace("bond 1 length 0.97", options) + "run 1\n",
                                "fix tanor/rods: " + message, ranks=(1,))

    def test_a_group_without_bonds(self):
        self.write_melt()
        script = lj() + "group few id 1 3 5\n" + rods().replace("rods all", "rods few") + "run 1\n"
        self.assert_refused(script, "fix tanor/rods: no bond of type 1 joins two atoms of the group")

    def test_a_bond_of_zero_length(self):
        self.write("melt.data", data([[1.0, 1.0, 1.0], [3.0, 1.0, 1.0], [3.0, 1.0, 1.0]], [(1, 1, 2), (1, 2, 3)],
                                     [(0.0, 9.0)] * 3))
        self.assert_refused(lj() + rods() + "run 1\n", "the bond of type 1 between atoms 2 and 3 has length 0")

    def test_an_atom_that_is_lost(self):
        self.write("melt.data", data([[1.0, 1.0, 1.0], [2.0, 1.0, 1.0], [8.0, 8.0, 8.0]], [(1, 1, 2)], [(0.0, 9.0)] * 3))
        script = lj("boundary f f f", "velocity all set 40 0 0") + rods() + "thermo_modify lost ignore\nrun 2000\n"
        self.assert_refused(script, ", which a bond holds, was lost")
        self.write_melt()
        script = lj() + "group gone id 34\ndelete_atoms group gone compress no\n" + rods() + "run 1\n"
        self.assert_refused(script, "atom 34 was lost: the bond of type 1 between atoms 33 and 34 holds it")

    def test_numbers_that_are_none(self):
        self.write_melt()
        push = "fix push all addforce 1e308 0 0\nfix again all addforce 1e308 0 0\nfix rods"
        self.assert_refused(lj() + rods().replace("fix rods", push) + "run 10\n", "not finite")

    def test_a_step_that_is_too_long(self):
        self.write_melt()
        self.assert_refused(lj() + rods() + "timestep 5.0\nrun 10\n", "the bond of type 1 between atoms ")

    def test_what_the_host_must_not_ask(self):
        self.write_melt()
        script = lj() + rods().replace("fix move all nve", "") + "fix move all nve\nrun 1\n"
        self.assert_refused(script, "it must be defined after fix move (nve), which integrates", ranks=(1,))
        self.assert_refused(lj() + rods() + "run_style respa 2 2\nrun 1\n", "run_style respa is not supported", ranks=(1,))


if __name__ == "__main__":
    REGISTER, DRIVER = (pathlib.Path(word).resolve() for word in sys.argv[1:3])
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
