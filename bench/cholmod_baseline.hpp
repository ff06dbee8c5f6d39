#pragma once

#include <cholmod.h>

#include <span>
#include <vector>

#include "assembly/gather_plan.hpp"

/// The baseline of a program that factorizes anew at every evaluation: S = K'M^-1K by tanor's assembly, and L L' = S by
/// CHOLMOD with its own choices (the best of AMD and METIS, supernodal from 40 flops a nonzero of L on).
class CholmodBaseline {
 public:
  /// Takes `weights` [point], the inverse masses, and the number of rows that take part.
  CholmodBaseline(std::span<const tanor::Incidence> incidences, const std::vector<double>& weights,
                  std::size_t num_rows);
  ~CholmodBaseline();
  CholmodBaseline(const CholmodBaseline&) = delete;
  CholmodBaseline& operator=(const CholmodBaseline&) = delete;

  /// Assembles and factorizes. Throws std::runtime_error where S is not positive definite.
  void factorize(const double* blocks);

 private:
  cholmod_common common_;
  tanor::GatherPlan plan_;
  std::vector<double> values_;
  cholmod_sparse S_{};
  cholmod_factor* L_ = nullptr;
};
