#!/usr/bin/env bash
# Before sharing: format, scripts, rooms, reference, warnings as errors, tests (with package and exports), clang-tidy,
# sanitizers, release tests.
#
#   scripts/check.sh               all of it
#   scripts/check.sh --format      rewrites the sources in the house's format, nothing else
#   scripts/check.sh --quick       without clang-tidy, sanitizers and release
#   scripts/check.sh --sanitizers  those alone: address and undefined behaviour, then threads, then the fuzz targets
set -euo pipefail
cd "$(dirname "$0")/.."

headline() { printf '\n== %s\n' "$*"; }

# As scripts/test: threads that wait soon give way, and random systems are the same in every run.
export GOMP_SPINCOUNT=${GOMP_SPINCOUNT:-2000} RC_PARAMS=${RC_PARAMS:-seed=1}

build_and_test() {  # preset [command that runs programs …]
  cmake --preset "$1"
  "${@:2}" cmake --build --preset "$1" --parallel "$(nproc)"  # it asks the tests for their names
  "${@:2}" ctest --preset "$1" --parallel "$(nproc)"
}

sanitize() {
  headline "sanitizers: address, undefined behaviour"
  build_and_test sanitize

  headline "sanitizers: threads"
  build_and_test threads setarch "$(uname -m)" -R  # it knows no random places of memory

  headline "fuzz targets, a short look (scripts/fuzz takes a long one)"
  scripts/fuzz 20000
}

mapfile -t sources < <(git ls-files --cached --others --exclude-standard -- '*.hpp' '*.cpp' '*.h')

scripts/install_packages library program test python check

if [[ ${1:-} == --format ]]; then
  exec clang-format -i "${sources[@]}"
fi

if [[ ${1:-} == --sanitizers ]]; then
  sanitize
  exit
fi

headline "format (scripts/check.sh --format mends it)"
clang-format --dry-run -Werror "${sources[@]}"

headline "scripts"
shellcheck scripts/{abi,bench,check.sh,coverage,docs,error-time,extreme,fetch_examples,install_packages,main_job,package,run,test,test-hosts,test_aarch64} \
  .ci/run

headline "rooms"
scripts/check_rooms.py

headline "reference of the public headers, without warnings"
scripts/docs

headline "develop: warnings are errors, checked containers, every public header alone"
build_and_test develop

if [[ ${1:-} != --quick ]]; then
  headline "clang-tidy (.clang-tidy says which checks)"
  # GCC's commands name warnings that clang does not know, and clang 14 does not take OpenMM's headers for C++20.
  git ls-files 'src/*.cpp' ':!src/embed/openmm' |
    xargs -P "$(nproc)" -n 2 clang-tidy -p build-develop --quiet --extra-arg=-Wno-unknown-warning-option

  sanitize

  headline "release"
  build_and_test release

  headline "flat nets of more sizes (TANOR_LARGEST_NET=30 takes hours)"
  TANOR_LARGEST_NET=12 ctest --preset release --tests-regex 'FlatNet\.ArrivesByEveryMethod' --parallel "$(nproc)"

  headline "valgrind: memory and leaks of the self-test"
  valgrind --quiet --error-exitcode=1 --leak-check=full --errors-for-leak-kinds=definite --child-silent-after-fork=yes \
    --suppressions=scripts/valgrind.supp build/src/cli/tanor selftest

  headline "binary interface"
  scripts/abi

  headline "a project that contains tanor"
  cmake --build build/tests/package-FetchContent --parallel "$(nproc)"
  build/tests/package-FetchContent/chain_host

  headline "Debian packages"
  scripts/package --check
fi

headline "all good"
