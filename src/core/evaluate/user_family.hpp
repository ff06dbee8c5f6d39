#pragma once

#include <cmath>
#include <limits>

#include "evaluate/family.hpp"
#include "kinds/user_kernels.hpp"
#include "system/tuples.hpp"

namespace tanor::detail {

/// User constraints, with one loop for each group, where a kernel is called once for some dozens of members. Members
/// are numbered group by group.
class UserFamily : public RowLoops<UserFamily> {
 public:
  UserKernels kernel;
  Index first_block = 0;

  std::size_t size() const {
    std::size_t result = 0;
    for (const UserGroup& group : kernel.groups) result += group.size();
    return result;
  }

  template <class Take>
  double visit(const Parallel& parallel, const IndexRanges& members, const double* r, const double* v,
               const Take& take) const {
    const Parallel serial(1);
    return max_over_groups(members, [&](const UserGroup& group, const auto& max_over_members) {
      return max_over_members(group.kernel.thread_safe ? parallel : serial, [&](std::size_t begin, std::size_t end) {
        double part = 0.0;
        for_each_chunk(group.kernel, group.points, begin, end, kernel.t, r, v, [&](const TupleValues& values) {
          for (std::size_t k = 0; k < values.count; ++k)
            part = larger(part,
                          take(Member(*this, group, values.first + k, values.gradient + k * values.size, &values), 0));
        });
        return part;
      });
    });
  }
  template <class Take>
  double visit_stored(const Parallel& parallel, const IndexRanges& members, const double* blocks,
                      const Take& take) const {
    return max_over_groups(members, [&](const UserGroup& group, const auto& max_over_members) {
      return max_over_members(parallel, [&](std::size_t begin, std::size_t end) {
        double part = 0.0;
        for (std::size_t k = begin; k < end; ++k)
          part = larger(part, take(Member(*this, group, k, blocks + 3 * block(group, k)), 0));
        return part;
      });
    });
  }

  void write_lengths(double* lengths) const {
    for (const UserGroup& group : kernel.groups) {
      for (std::size_t k = 0; k < group.size(); ++k) lengths[group.rows[k]] = group.lengths[k];
    }
  }

  template <class Append>
  void list_incidences(const Append& append) const {
    for (const UserGroup& group : kernel.groups) {
      const std::size_t p = group.points_per_member();
      for (std::size_t i = 0; i < group.points.size(); ++i) {
        append(Incidence{group.points[i], group.rows[i / p], static_cast<Index>(block(group, 0) + i), 1.0});
      }
    }
  }

 private:
  /// Member k of a group, with its gradient [3p], and its place in the values of a kernel if these are known.
  struct Member {
    const UserFamily& family;
    const UserGroup& group;
    std::size_t k;
    const double* gradient;
    const TupleValues* values;
    Index row;

    Member(const UserFamily& of, const UserGroup& in, std::size_t number, const double* slope,
           const TupleValues* found = nullptr)
        : family(of), group(in), k(number), gradient(slope), values(found), row(in.rows[number]) {}

    double xi(int) const { return values->xi[k - values->first]; }
    double rate(int) const { return values->rate[k - values->first]; }
    double phi(int) const { return values->phi[k - values->first]; }
    // Ratios stay finite where xi has no gradient, so that a violation of 0 counts as none.
    double norm(int) const {
      return std::max(largest_block(gradient, 3 * group.points_per_member()), std::numeric_limits<double>::min());
    }
    double scale() const { return group.lengths[k]; }
    double transposed(int, const double* x) const {
      const std::size_t p = group.points_per_member();
      double sum = 0.0;
      for (std::size_t i = 0; i < p; ++i) sum += dot(load(gradient, i), load(x, group.points[k * p + i]));
      return sum;
    }
    void store(int, double* blocks) const {
      std::copy_n(gradient, 3 * group.points_per_member(), blocks + 3 * family.block(group, k));
    }
  };

  /// Returns the first block of member k.
  std::size_t block(const UserGroup& group, std::size_t k) const {
    return static_cast<std::size_t>(first_block + group.first_block) + k * group.points_per_member();
  }

  /// Calls of_group(group, max_over_members), which returns a number, for each group; returns the largest one.
  template <class OfGroup>
  double max_over_groups(const IndexRanges& members, const OfGroup& of_group) const {
    double worst = 0.0;
    std::size_t first = 0;  // number of the group's first member in the family
    for (const UserGroup& group : kernel.groups) {
      worst = larger(worst, of_group(group, [&](const Parallel& parallel, const auto& body) {
                       const auto in_group = [&](std::size_t begin, std::size_t end) {
                         return body(begin - first, end - first);
                       };
                       return members.max_over_ranges(parallel, first, first + group.size(), in_group);
                     }));
      first += group.size();
    }
    return worst;
  }
};

}  // namespace tanor::detail
