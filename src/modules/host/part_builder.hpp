#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "host/host_part.hpp"

namespace tanor::detail {

/// Plans parts of a host: the System of a part, its images in a periodic cell, and what solves it.
class PartBuilder {
 public:
  /// Points, constraints and cell outlive it.
  PartBuilder(const HostPoints& points, const Inventory& inventory, const std::optional<PeriodicCell>& cell,
              const SolverOptions& options)
      : points_(points), inventory_(inventory), cell_(cell), options_(options) {}

  /// Plans the part, whose lists are filled. Throws InputError, with the host's names, if that is impossible.
  void build(HostPart* part);

 private:
  std::unique_ptr<ConstrainedHost> make_host(HostPart* part);
  System make_system(HostPart* part);

  const HostPoints& points_;
  const Inventory& inventory_;
  const std::optional<PeriodicCell>& cell_;
  const SolverOptions options_;
  std::vector<Index> local_;  // scratch [point]: its number in the part at hand
};

}  // namespace tanor::detail
