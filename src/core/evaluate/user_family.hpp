#pragma once

#include <cmath>
#include <limits>

#include "evaluate/family.hpp"
#include "kinds/user_kernels.hpp"
#include "system/tuples.hpp"

namespace tanor::detail {

/// User constraints, with one loop for each group, where a kernel is called once for some dozens of members. The
/// interface is that of Family. Members are numbered group by group.
class UserFamily {
 public:
  UserKernels kernel;
  Index first_block = 0;

  std::size_t size() const {
    std::size_t result = 0;
    for (const UserGroup& group : kernel.groups) result += group.size();
    return result;
  }

  double evaluate_values(const Parallel& parallel, const IndexRanges& members, const double* r, double* xi) const {
    return evaluate(parallel, members, r, nullptr, [&](const UserGroup& group, std::size_t k, const Member& member) {
      xi[group.rows[k]] = member.xi;
      return std::abs(member.xi) / (member.norm() * group.lengths[k]);
    });
  }

  double evaluate_rates(const Parallel& parallel, const IndexRanges& members, const double* r, const double* v,
                        double* rate) const {
    return evaluate(parallel, members, r, v, [&](const UserGroup& group, std::size_t k, const Member& member) {
      rate[group.rows[k]] = member.rate;
      return std::abs(member.rate) / member.norm();
    });
  }

  void evaluate_gradients(const Parallel& parallel, const IndexRanges& members, const double* r, double* blocks) const {
    (void)evaluate(parallel, members, r, nullptr, [&](const UserGroup& group, std::size_t k, const Member& member) {
      store_gradient(group, k, member, blocks);
      return 0.0;
    });
  }

  /// Evaluates phi + K'w0, and the blocks of K if they are wanted.
  template <bool WithGradients>
  double evaluate_right_side(const Parallel& parallel, const IndexRanges& members, const double* r, const double* v,
                             const double* w0, double* phi, double* blocks) const {
    return evaluate(parallel, members, r, v, [&](const UserGroup& group, std::size_t k, const Member& member) {
      const double value = member.phi + transposed(group, k, member.gradient, w0);
      phi[group.rows[k]] = value;
      if constexpr (WithGradients) store_gradient(group, k, member, blocks);
      return std::abs(value) / member.norm();
    });
  }

  double apply_transposed(const Parallel& parallel, const IndexRanges& members, const double* blocks, const double* x,
                          const double* shift, double* y) const {
    return max_over_groups(members, [&](const UserGroup& group, const auto& max_over_members) {
      const std::size_t p = group.points_per_member();
      return max_over_members(parallel, [&](std::size_t begin, std::size_t end) {
        double part = 0.0;
        for (std::size_t k = begin; k < end; ++k) {
          const double* const gradient = blocks + 3 * block(group, k);
          const Index row = group.rows[k];
          y[row] = transposed(group, k, gradient, x) + (shift != nullptr ? shift[row] : 0.0);
          part = larger(part, std::abs(y[row]) / norm_of(gradient, 3 * p));
        }
        return part;
      });
    });
  }

  void measure(const double* r, const double* v, double* position, double* velocity) const {
    (void)evaluate(Parallel(1), IndexRanges(size()), r, v,
                   [&](const UserGroup& group, std::size_t k, const Member& member) {
                     position[group.rows[k]] = std::abs(member.xi) / (member.norm() * group.lengths[k]);
                     velocity[group.rows[k]] = std::abs(member.rate) / member.norm();
                     return 0.0;
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
  struct Member {
    double xi, rate, phi;
    const double* gradient;  // [3p]
    std::size_t size;        // 3p

    double norm() const { return norm_of(gradient, size); }
  };

  /// Returns the first block of member k.
  std::size_t block(const UserGroup& group, std::size_t k) const {
    return static_cast<std::size_t>(first_block + group.first_block) + k * group.points_per_member();
  }

  // Ratios stay finite where xi has no gradient, so that a violation of 0 counts as none.
  static double norm_of(const double* gradient, std::size_t size) {
    return std::max(largest_block(gradient, size), std::numeric_limits<double>::min());
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

  /// Calls take(group, member, its numbers), which returns a number, for all `members`; returns the largest one.
  template <class Take>
  double evaluate(const Parallel& parallel, const IndexRanges& members, const double* r, const double* v,
                  const Take& take) const {
    return max_over_groups(members, [&](const UserGroup& group, const auto& max_over_members) {
      return max_over_members(
          group.kernel.thread_safe ? parallel : Parallel(1), [&](std::size_t begin, std::size_t end) {
            double part = 0.0;
            for_each_chunk(group.kernel, group.points, begin, end, kernel.t, r, v, [&](const TupleValues& values) {
              for (std::size_t k = 0; k < values.count; ++k) {
                const Member member{values.xi[k], v != nullptr ? values.rate[k] : 0.0,
                                    v != nullptr ? values.phi[k] : 0.0, values.gradient + k * values.size, values.size};
                part = larger(part, take(group, values.first + k, member));
              }
            });
            return part;
          });
    });
  }

  static double transposed(const UserGroup& group, std::size_t k, const double* gradient, const double* x) {
    const std::size_t p = group.points_per_member();
    double sum = 0.0;
    for (std::size_t i = 0; i < p; ++i) sum += dot(load(gradient, i), load(x, group.points[k * p + i]));
    return sum;
  }

  void store_gradient(const UserGroup& group, std::size_t k, const Member& member, double* blocks) const {
    const std::size_t p = group.points_per_member();
    for (std::size_t i = 0; i < p; ++i) {
      store(blocks, block(group, k) + i, load(member.gradient, i));
    }
  }
};

}  // namespace tanor::detail
