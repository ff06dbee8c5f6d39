#pragma once

#include <span>
#include <vector>

#include <tanor/ranks.hpp>

#include "system/numbering.hpp"

namespace tanor::detail {

/// Points of other ranks that equations join to this rank's. The ranks that own them send their numbers.
class Guests {
 public:
  Guests(const Part& part, const Numbering& numbering);

  /// Fetches the numbers of guests in an array [3n] in the inner order. Collective.
  void fetch(double* points);
  bool empty() const { return links_.empty(); }

 private:
  struct Link {
    int rank;
    std::vector<Index> sent_points, received_points;  // inner
    std::vector<double> sent, received;
  };
  Ranks& ranks_;
  std::vector<Link> links_;
  std::vector<Ranks::Message> messages_;
};

}  // namespace tanor::detail
