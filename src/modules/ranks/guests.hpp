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
  /// Adds x to y at guests.
  void add(const double* x, double* y) const;
  void clear(double* points) const;

 private:
  struct Link {
    int rank;
    std::vector<Index> sent_points, received_points;  // inner
    std::vector<double> sent, received;
  };
  template <class Visit>
  void for_each(const Visit& visit) const {
    for (const Link& link : links_)
      for (const Index point : link.received_points) visit(static_cast<std::size_t>(point));
  }

  Ranks& ranks_;
  std::vector<Link> links_;
  std::vector<Ranks::Message> messages_;
};

}  // namespace tanor::detail
