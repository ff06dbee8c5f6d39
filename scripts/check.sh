#!/usr/bin/env bash
# Before sharing: format, scripts, types, rooms, warnings as errors, tests (with reference, package and exports), clang-tidy,
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

build_and_test() {  # preset
  cmake --preset "$1"
  cmake --build --preset "$1" --parallel "$(nproc)"
  ctest --preset "$1" --parallel "$(nproc)"
}

# The longest tests are left out: they run the same code with other numbers, for hours under sanitizers.
sanitize() (  # in a shell of its own: what it leaves out, later steps do not
  export TANOR_SKIP='*ExtremeScene*:*ReuseTest*:*DraggedChain*:*FlatNet*:*LongRun*:*TurningFourBar*' TANOR_DRAWS=100
  headline "sanitizers: address, undefined behaviour"
  cmake --preset sanitize
  cmake --build --preset sanitize --parallel "$(nproc)"
  TANOR_SKIP+=':*ThreadsTest*' scripts/test-rooms build-sanitize
  ctest --preset sanitize --parallel "$(nproc)"  # what is in no room

  headline "sanitizers: threads"
  cmake --preset threads
  setarch "$(uname -m)" -R cmake --build --preset threads --parallel "$(nproc)"  # tsan knows no random places of memory
  OMP_NUM_THREADS=3 OMP_TOOL_LIBRARIES=/usr/lib/llvm-14/lib/libarcher.so KMP_BLOCKTIME=0 OPENBLAS_NUM_THREADS=1 \
    TSAN_OPTIONS=ignore_noninstrumented_modules=1 setarch "$(uname -m)" -R scripts/test-rooms build-threads

  headline "fuzz targets, a short look (scripts/fuzz takes a long one)"
  scripts/fuzz 20000
)

# tsc looks for libraries beside the sources, and the source tree has none; esbuild, which bundles the page, drops types unread.
check_types() {
  local folder=build-page-types
  mkdir -p "$folder"
  rm -f "$folder"/*.ts
  cp src/program/report/page/{*.ts,tsconfig.json,package.json,package-lock.json} "$folder"
  (cd "$folder" && npm ci --ignore-scripts --no-audit --no-fund && npx tsc)
}

mapfile -t sources < <(git ls-files --cached --others --exclude-standard -- '*.hpp' '*.cpp' '*.h')

scripts/install_packages library program page test docs python check
scripts/report_page
if command -v ccache >/dev/null; then export CMAKE_CXX_COMPILER_LAUNCHER=${CMAKE_CXX_COMPILER_LAUNCHER-ccache}; fi

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
shellcheck scripts/{abi,bench,blas_kernels,check.sh,coverage,docs,error-time,extreme,fetch_examples,install_packages,main_job,package,report_page,run,test,test-formats,test-hosts,test-rooms,test_aarch64} \
  .ci/run

headline "types of the page of a run"
check_types

headline "rooms"
scripts/check_rooms.py

headline "develop: warnings are errors, checked containers, every public header alone"
build_and_test develop

if [[ ${1:-} != --quick ]]; then
  headline "clang-tidy (.clang-tidy says which checks)"
  # GCC's commands name warnings that clang does not know, and clang 14 does not take OpenMM's headers for C++20.
  git ls-files 'src/*.cpp' ':!src/bindings/embed/openmm' |
    xargs -P "$(nproc)" -n 2 clang-tidy -p build-develop --quiet --extra-arg=-Wno-unknown-warning-option

  headline "clang: everything compiles without a warning"
  scripts/clang_warnings

  sanitize

  headline "release, with the long tests"
  TANOR_LONG_TESTS=1 build_and_test release

  headline "a program without node says that it has no page"
  cmake --preset release -B build-without-page -D TANOR_REPORT_PAGE=OFF -D TANOR_UNITY=ON -D TANOR_BUILD_TESTS=OFF
  cmake --build build-without-page --target tanor_cli --parallel "$(nproc)"
  build-without-page/src/cli/tanor run examples/pendulum.json --report --out build-without-page/pendulum.out 2>&1 |
    grep "there is no report.html"
  [[ ! -e build-without-page/pendulum.out/report.html ]]

  headline "flat nets of more sizes (TANOR_LARGEST_NET=30 takes hours)"
  TANOR_LARGEST_NET=12 ctest --preset release --tests-regex 'FlatNet\.ArrivesByEveryMethod' --parallel "$(nproc)"

  headline "valgrind: memory and leaks of the self-test"
  valgrind --quiet --error-exitcode=1 --leak-check=full --errors-for-leak-kinds=definite --child-silent-after-fork=yes \
    --suppressions=scripts/valgrind.supp build/src/cli/tanor selftest

  headline "binary interface"
  scripts/abi

  headline "projects that contain tanor"
  for by in add_subdirectory FetchContent; do
    cmake --build build/tests/package-$by --parallel "$(nproc)"
    build/tests/package-$by/chain_host
  done

  headline "Debian packages"
  scripts/package --check
fi

headline "all good"
