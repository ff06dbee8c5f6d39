#!/usr/bin/python3
"""fix tanor/rods inside Debian's LIGGGHTS: check_liggghts.py DRIVER EXAMPLES [unittest arguments]"""

import pathlib
import re
import subprocess
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
import host_runs  # noqa: E402

DRIVER = EXAMPLES = None
TIGHT = 1e-12  # of a bond, relative


class Liggghts(host_runs.HostTest):
    def setUp(self):
        super().setUp()
        self.program = DRIVER
        self.write("chains.data", subprocess.run([EXAMPLES / "make_chains.py", "36", "20"], check=True,
                                                 capture_output=True, text=True).stdout)
        self.script = (EXAMPLES / "pour.in").read_text(encoding="utf-8")

    def free_chains(self, every, steps):
        """Without the bed, whose grains are put where a random number says, which depends on the ranks."""
        lines = [line for line in self.script.splitlines() if "insert/pack" not in line]
        return "\n".join(lines).replace("${every}", str(every)).replace("${n}", str(steps))

    def test_chains_are_poured_on_a_bed(self):
        # From rest the first chain is at the bed after 0.05 s.
        script = self.script.replace("${every}", "500").replace("${n}", "20000")
        (rows,) = self.run_host(script)
        self.assertEqual(rows[-1]["rods[4]"], 36 * 19)
        self.assertGreater(rows[-1]["atoms"], 36 * 20 + 300)
        self.assertTrue(all(row["rods"] <= TIGHT for row in rows))
        self.assertLess(rows[-1]["ke"], 0.2 * max(row["ke"] for row in rows))
        tensions = [row[2] for row in host_runs.read_dump(self.folder / "tension.dump")]
        self.assertEqual(len(tensions), 36 * 19)
        self.assertGreater(max(map(abs, tensions)), 0.0)

    def test_ranks_agree(self):
        dump = "\ndump d all custom 12000 {} id x y z\ndump_modify d sort id format \"%d %.17g %.17g %.17g\"\n"
        for name, ranks in (("one", 1), ("two", 2)):
            script = self.free_chains(1000, 12000).replace("\nrun ", dump.format(name) + "run ")
            (rows,) = self.run_host(script, ranks)
            self.assertTrue(all(row["rods"] <= TIGHT for row in rows))
        self.assert_same_atoms(self.atoms("one", 12000), self.atoms("two", 12000), 1e-9)

    def test_stress_of_swinging_chains(self):
        # In the air: what moves gives sum of m v^2, each rod its tension times its length.
        compute = ("velocity all ramp vy -0.3 0.3 z 0.12 0.35 units box\ncompute stress all stress/atom\n"
                   "compute sum all reduce sum c_stress[1] c_stress[2] c_stress[3]\n")
        script = self.free_chains(100, 300).replace("thermo_style custom step", compute + "thermo_style custom step "
                                                    "c_sum[1] c_sum[2] c_sum[3]")
        for ranks in (1, 2):
            with self.subTest(ranks=ranks):
                (rows,) = self.run_host(script, ranks)
                for row in rows[1:]:
                    pull = [0.01 * line[2] for line in host_runs.read_dump(self.folder / "tension.dump", row["step"])]
                    self.assertGreater(abs(sum(pull)), 0.1 * row["ke"])
                    trace = row["sum[1]"] + row["sum[2]"] + row["sum[3]"]
                    self.assertAlmostEqual(trace, sum(pull) - 2.0 * row["ke"], delta=1e-6 * row["ke"])

    def test_a_minimisation_is_refused(self):
        lines = [line for line in self.free_chains(10, 10).splitlines() if not line.startswith("run")]
        said = self.call("\n".join(lines + ["compute thermo_pe all pe", "minimize 0 1e-8 10 100"]))[1]
        self.assertIn("minimize is not supported", said)
        self.assertIn("tanor/rods", said)

    def test_the_lines_of_the_manual_are_those_of_the_example(self):
        commands, fix = host_runs.blocks_of_page("Inside LIGGGHTS")
        script = (EXAMPLES / "pour.in").read_text(encoding="utf-8")
        words = [line.split() for line in script.splitlines()]
        self.assertIn(fix.split(), words)
        make, run = (line.split() for line in commands.splitlines())
        self.assertEqual(make[0], f"examples/liggghts/{EXAMPLES.joinpath('make_chains.py').resolve(strict=True).name}")
        self.assertEqual(run[-1], f"examples/liggghts/{EXAMPLES.joinpath('pour.in').resolve(strict=True).name}")
        for variable in re.findall(r"-var (\w+) ", commands):
            self.assertRegex(script, rf"\bv_{variable}\b|\$\{{{variable}\}}")

    def assert_refused(self, script, message):
        """One line, in the host's style and the same on every rank, and no step is taken."""
        for ranks in (1, 2):
            with self.subTest(message=message, ranks=ranks):
                code, said = self.call(script, ranks)
                lines = [line for line in said.splitlines() if line.startswith("ERROR")]
                self.assertEqual(len(lines), 1, said[-2000:])
                self.assertIn("tanor/rods", lines[0])
                self.assertIn(message, lines[0])
                self.assertNotIn("Loop time", said)
                del code  # with some MPI it is 0 after an error of LIGGGHTS

    def test_wrong_words(self):
        for was, now, message in (
                ("bond 1 store yes", "bond 3", "there is no bond type 3; there are 1"),
                ("bond 1 store yes", "bond 1 colour red", "unknown word colour"),
                ("fix rods all", "group few id 1 3\nfix rods few", "no bond of type 1 joins two atoms of the group")):
            self.assert_refused(self.free_chains(10, 10).replace(was, now), message)

    def test_it_stands_after_what_integrates(self):
        script = self.free_chains(10, 10).replace("fix move all nve/sphere\n", "")
        self.assert_refused(script.replace("store yes\n", "store yes\nfix move all nve/sphere\n"),
                            "it must be defined after fix move (nve/sphere), which integrates")

    def test_a_bond_of_zero_length(self):
        lines = (self.folder / "chains.data").read_text(encoding="utf-8").splitlines()
        first = lines.index("Atoms") + 2
        second, third = (lines[first + k].split() for k in (1, 2))
        lines[first + 2] = " ".join(third[:2] + second[2:5] + third[5:])
        self.write("chains.data", "\n".join(lines) + "\n")
        self.assert_refused(self.free_chains(10, 10),
                            "the bond of type 1 between atoms 2 and 3 has length 0: they are at one place")

    def test_an_atom_that_is_lost(self):
        before = {"that flies out": "velocity all set 4000 0 0 units box",
                  "that is deleted": "group gone id 3\ndelete_atoms group gone compress no"}
        messages = {"that flies out": ", which a bond holds, was lost",
                    "that is deleted": "atom 3 was lost: the bond of type 1 between atoms 2 and 3 holds it"}
        for what, command in before.items():
            script = self.free_chains(10, 200).replace("lost error", "lost ignore")
            self.assert_refused(script.replace("fix rods", command + "\nfix rods"), messages[what])

    def test_numbers_that_are_none(self):
        push = "fix push all addforce 1e308 0 0\nfix again all addforce 1e308 0 0\nfix rods"
        self.assert_refused(self.free_chains(10, 10).replace("fix rods", push), "not finite")


if __name__ == "__main__":
    DRIVER, EXAMPLES = (pathlib.Path(word).resolve() for word in sys.argv[1:3])
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
