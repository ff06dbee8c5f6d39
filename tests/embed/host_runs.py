"""Runs a host with an input script, on one or several ranks, and reads what it wrote."""

import os
import pathlib
import re
import subprocess
import tempfile
import unittest


def environment():
    own = dict(os.environ, OMP_NUM_THREADS="1")
    # Ranks give way while they wait; containers run as root and have few cores.
    own.update(OMPI_MCA_mpi_yield_when_idle="1", OMPI_MCA_rmaps_base_oversubscribe="1", OMPI_ALLOW_RUN_AS_ROOT="1",
               OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1", OMPI_MCA_btl_vader_single_copy_mechanism="none")
    return own


def blocks_of_page(heading, language=""):
    """The blocks of code of docs/embedding.md behind a heading, up to the next one of its rank."""
    page = (pathlib.Path(__file__).resolve().parents[2] / "docs/embedding.md").read_text(encoding="utf-8")
    section = page.split(f"\n## {heading}\n")[1].split("\n## ")[0]
    return re.findall(rf"^```{language}\n(.*?)^```$", section, flags=re.M | re.S)


class HostTest(unittest.TestCase):
    """Every test has a folder of its own, `self.folder`."""

    program = None  # the host
    limit = 240  # s; who hangs fails

    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self.temporary.cleanup)
        self.folder = pathlib.Path(self.temporary.name)

    def write(self, name, text):
        (self.folder / name).write_text(text, encoding="utf-8")

    def call(self, script, ranks=1, program=None):
        """The exit code and what the host said."""
        self.write("script", script)
        command = [program or self.program, "-in", "script"]
        if ranks > 1:
            command = ["mpirun", "-np", str(ranks)] + command
        done = subprocess.run(command, cwd=self.folder, env=environment(), stdin=subprocess.DEVNULL,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=self.limit, check=False)
        return done.returncode, done.stdout.decode(errors="replace")

    def run_host(self, script, ranks=1, program=None):
        """The tables of thermo output, one a run: lists of rows {column: number}."""
        code, said = self.call(script, ranks, program)
        self.assertEqual(code, 0, said[-3000:])
        return tables(said)

    def atoms(self, name, step=None):
        """{tag: row} of a dump, of its last step or of a certain one."""
        return {int(row[0]): row[1:] for row in read_dump(self.folder / name, step)}

    def assert_same_atoms(self, one, other, tolerance):
        self.assertEqual(one.keys(), other.keys())
        worst = max(abs(a - b) for tag in one for a, b in zip(one[tag], other[tag]))
        self.assertLessEqual(worst, tolerance)
        return worst


# How hosts head their columns.
KEYWORDS = {"Step": "step", "Temp": "temp", "KinEng": "ke", "PotEng": "pe", "TotEng": "etotal", "Press": "press",
            "Volume": "vol", "Econserve": "econserve", "Fmax": "fmax", "Atoms": "atoms"}


def tables(said):
    found, rows, names = [], None, None
    for line in said.splitlines():
        words = line.split()
        if words[:1] == ["Step"]:
            rows, names = [], [KEYWORDS.get(word, word) for word in words]
            found.append(rows)
        elif line.startswith("Loop time"):
            names = None
        elif names and len(words) == len(names) and re.fullmatch(r"[-+0-9.enaif]+", "".join(words)):
            rows.append(dict(zip(names, map(float, words))))
    return found


def read_dump(path, step=None):
    """Rows of numbers of one step of a dump."""
    rows, now, wanted = [], None, False
    lines = iter(path.read_text(encoding="utf-8").splitlines())
    for line in lines:
        if line.startswith("ITEM: TIMESTEP"):
            now, wanted = int(next(lines)), False
        elif line.startswith(("ITEM: ATOMS", "ITEM: ENTRIES")):
            wanted = step is None or now == step
            if wanted:
                rows = []
        elif line.startswith("ITEM:"):
            wanted = False
        elif wanted:
            rows.append([float(word) for word in line.split()])
    return rows
