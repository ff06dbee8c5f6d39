#!/usr/bin/env bash
# Before sharing: format, scripts, rooms, reference, warnings as errors, tests (with package and exports), sanitizers, release tests.
#
#   scripts/check.sh            all of it
#   scripts/check.sh --format   rewrites the sources in the house's format, nothing else
#   scripts/check.sh --quick    without sanitizers and release
set -euo pipefail
cd "$(dirname "$0")/.."

headline() { printf '\n== %s\n' "$*"; }

build_and_test() {  # preset
  cmake --preset "$1"
  cmake --build --preset "$1" --parallel "$(nproc)"
  ctest --preset "$1" --parallel "$(nproc)"
}

mapfile -t sources < <(git ls-files --cached --others --exclude-standard -- '*.hpp' '*.cpp' '*.h')

scripts/install_packages library program test check

if [[ ${1:-} == --format ]]; then
  exec clang-format -i "${sources[@]}"
fi

headline "format (scripts/check.sh --format mends it)"
clang-format --dry-run -Werror "${sources[@]}"

headline "scripts"
shellcheck scripts/run scripts/test scripts/install_packages scripts/fetch_examples scripts/main_job scripts/extreme scripts/check.sh scripts/docs .ci/run

headline "rooms"
scripts/check_rooms.py

headline "reference of the public headers, without warnings"
scripts/docs

headline "develop: warnings are errors, checked containers, every public header alone"
build_and_test develop

if [[ ${1:-} != --quick ]]; then
  headline "sanitizers: address, undefined behaviour"
  build_and_test sanitize

  headline "release"
  build_and_test release
fi

headline "all good"
