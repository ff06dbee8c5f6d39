#!/usr/bin/python3
"""Does the shared library call code under the GPL? SuiteSparseQR where it was built with TANOR_GPL, nothing else ever.

    check_licence.py LIBTANOR_SO ON|OFF [NM]      ON, OFF: what TANOR_GPL was
    check_licence.py --self-test
"""

import re
import subprocess
import sys

SUITESPARSE_QR = re.compile(r"SuiteSparseQR|spqr_")
# CHOLMOD's modules Supernodal, MatrixOps and Modify.
CHOLMOD_GPL = re.compile(r"cholmod_(l_)?(super|drop|horzcat|norm|scale|sdmult|ssmult|submatrix|vertcat|symmetry|"
                         r"updown|rowadd|rowdel)")


def complaints(symbols: list[str], with_gpl: bool) -> list[str]:
    found = [f"{symbol}: under the GPL" for symbol in symbols
             if CHOLMOD_GPL.match(symbol) or (not with_gpl and SUITESPARSE_QR.search(symbol))]
    if with_gpl and not any(SUITESPARSE_QR.search(symbol) for symbol in symbols):
        found.append("SuiteSparseQR is not called, though TANOR_GPL is ON")
    if "cholmod_analyze" not in symbols:
        found.append("cholmod_analyze is not called: are these the symbols of libtanor?")
    return found


def self_test() -> int:
    free = ["cholmod_analyze", "cholmod_factorize", "cholmod_colamd", "klu_factor"]
    qr = "_Z13SuiteSparseQRIdEliT_lP21cholmod_sparse_structPS2_PPlP21cholmod_common_struct"
    wrong = [what for what, passes in {
        "free": not complaints(free, False), "with QR": not complaints([*free, qr], True),
        "QR in the free one": len(complaints([*free, qr], False)) == 1,
        "no QR in the other": len(complaints(free, True)) == 1,
        "supernodal": len(complaints([*free, "cholmod_super_symbolic"], False)) == 1,
        "sdmult": len(complaints([*free, qr, "cholmod_l_sdmult"], True)) == 1,
        "nothing": len(complaints([], False)) == 1}.items() if not passes]
    print("check_licence self-test:", "wrong: " + ", ".join(wrong) if wrong else "good")
    return 1 if wrong else 0


def main(arguments: list[str]) -> int:
    if arguments == ["--self-test"]:
        return self_test()
    library, gpl, *nm = arguments
    lines = subprocess.run([*(nm or ["nm"]), "-D", "--undefined-only", library],
                           check=True, capture_output=True, text=True).stdout.splitlines()
    symbols = [re.sub(r"^ *\w ", "", line).split("@")[0] for line in lines]
    found = complaints(symbols, gpl == "ON")
    print("\n".join(found))
    print(f"{library}: {len(symbols)} names called, {len(found)} wrong")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
