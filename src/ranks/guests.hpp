#pragma once

#include <span>
#include <vector>

#include <tanor/ranks.hpp>

#include "system/numbering.hpp"

namespace tanor {

/// Points of other ranks that equations join to this one's: their numbers come from the ranks that own them.
class Guests {
 public:
  Guests(const Part& part, const Numbering& numbering);

  /// Of an array [3n] in the inner order, the numbers of guests. Collective.
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

}  // namespace tanor
