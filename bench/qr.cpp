// Measures QR of C = M^-1/2 K, whose rows of R say which constraints depend on others, by our own fronts beside
// SuiteSparseQR:
//   qr [ROUNDS]
// The scenes are nets and lattices of rods, a net in a plane, and proteins with dependent rows; columns within 1e-11 of
// those before are left out. The program prints medians of runs taken in turn, processor time of one thread, ms, the
// rank
// that both find, and the size of R.

#include <omp.h>

#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "factor/patterns.hpp"
#include "factor/sparse_qr.hpp"
#include "timing.hpp"

namespace {

using namespace tanor;
using namespace tanor::detail;
using namespace tanor::patterns;

void measure(const std::string& name, const SparseColumns& C, int rounds) {
  constexpr double tolerance = 1e-11;
  struct Side {
    QrFunction* factorize;
    std::vector<double> times;
    TriangularFactor R;
  };
  Side sides[]{{factorize_by_fronts, {}, {}}, {factorize_with_suitesparse, {}, {}}};
  for (int round = 0; round <= rounds; ++round) {
    for (Side& side : sides) {
      const double before = processor_seconds();
      side.R = side.factorize(C, tolerance);
      if (round > 0) side.times.push_back(processor_seconds() - before);  // the first one wakes memory
    }
  }
  const auto& [ours, theirs] = sides;
  std::printf("| %s | %zu | %zu, %zu | %.1f | %.1f | %.2f | %.2f |\n", name.c_str(), C.num_columns(), ours.R.rank(),
              theirs.R.rank(), 1e3 * median(ours.times), 1e3 * median(theirs.times),
              median(theirs.times) / median(ours.times),
              static_cast<double>(theirs.R.values.size()) / static_cast<double>(ours.R.values.size()));
}

}  // namespace

int main(int argc, char** argv) {
  const int rounds = argc > 1 ? std::atoi(argv[1]) : 7;
  omp_set_num_threads(1);
  std::printf(
      "| | columns | rank, ours and SuiteSparseQR's | ours, ms | SuiteSparseQR, ms | SuiteSparseQR/ours | entries of "
      "R, likewise |\n"
      "|---|--:|--:|--:|--:|--:|--:|\n");
  for (const int side : {30, 100, 300})
    measure("net " + std::to_string(side), gradients_of(make_net(side, side), 1), rounds);
  measure("plane net 100", gradients_of(make_net(100, 100), 1, true), rounds);
  for (const int side : {10, 20})
    measure("lattice " + std::to_string(side), gradients_of(make_lattice(side), 1), rounds);
  for (const int residues : {57, 500})
    measure("protein of " + std::to_string(residues), gradients_of(make_protein(residues, 3), 1), rounds);
}
