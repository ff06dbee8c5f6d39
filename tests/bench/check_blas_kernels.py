#!/usr/bin/python3
"""Fails where rivals would run with slow kernels of OpenBLAS: scripts/blas_kernels chooses, bench/rivals/compare.py obeys.

A small program stands for dense_product and for a driver: its "speed" depends on OPENBLAS_CORETYPE.
"""

import importlib.util
import os
import pathlib
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]


def load_compare():
    spec = importlib.util.spec_from_file_location("compare", ROOT / "bench/rivals/compare.py")
    compare = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(compare)
    return compare


class Kernels(unittest.TestCase):
    def setUp(self):
        room = tempfile.TemporaryDirectory()
        self.addCleanup(room.cleanup)
        self.folder = pathlib.Path(room.name)
        self.environment = {name: value for name, value in os.environ.items() if name != "OPENBLAS_CORETYPE"}

    def speeds(self, chosen: float, wide: float, flags: str = "sse2 avx2 avx512f avx512dq") -> pathlib.Path:
        program = self.folder / "dense_product"
        program.write_text(f'#!/bin/sh\n[ "$OPENBLAS_CORETYPE" = SKYLAKEX ] && echo {wide} || echo {chosen}\n')
        program.chmod(0o755)
        (self.folder / "cpuinfo").write_text(f"model name\t: some\nflags\t\t: {flags}\n")
        self.environment["BLAS_PROCESSOR"] = str(self.folder / "cpuinfo")
        return program

    def choice(self, program: pathlib.Path) -> str:
        asked = [ROOT / "scripts/blas_kernels", program]
        return subprocess.run(asked, check=True, stdout=subprocess.PIPE, text=True, env=self.environment).stdout

    def test_they_are_named_where_they_are_a_tenth_faster(self):
        self.assertEqual(self.choice(self.speeds(3.1e10, 6.2e10)), "SKYLAKEX\n")
        self.assertEqual(self.choice(self.speeds(6.0e10, 6.2e10)), "")
        self.assertEqual(self.choice(self.speeds(6.0e10, 1e9)), "")

    def test_they_are_not_tried_where_the_processor_has_no_avx512(self):
        self.assertEqual(self.choice(self.speeds(3.1e10, 6.2e10, "sse2 avx2")), "")

    def test_a_program_that_prints_no_speed_is_an_error(self):
        with self.assertRaises(subprocess.CalledProcessError):
            self.choice(self.speeds("none", 6.2e10))

    def test_a_program_that_is_not_there_is_an_error(self):
        program = self.speeds(1, 2)
        program.unlink()
        with self.assertRaises(subprocess.CalledProcessError):
            self.choice(program)

    def test_rivals_run_with_them(self):
        self.speeds(3.1e10, 6.2e10)
        compare = load_compare()
        drivers = self.folder / "rivals"
        drivers.mkdir()
        compare.ENVIRONMENT = {**self.environment}
        compare.ENVIRONMENT.update(compare.choose_kernels(drivers))
        driver = drivers / "rival_tanor"
        driver.write_text('#!/bin/sh\necho "1 0 0" >"$5"\n[ "$OPENBLAS_CORETYPE" = SKYLAKEX ] && echo 0.5 7 8\n')
        driver.chmod(0o755)
        run = compare.Run("tanor", "taylor", 1e-6)
        found = compare.make_run(drivers, compare.PROBLEMS["P3"], run, [(1.0, 0.0, 0.0)])
        self.assertEqual(found, {"seconds": 0.5, "steps": 7, "factorizations": 8, "error": 0.0})
        self.assertIn("OpenBLAS as SKYLAKEX", compare.describe_now())


if __name__ == "__main__":
    unittest.main()
