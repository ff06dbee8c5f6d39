#pragma once

#include <algorithm>
#include <vector>

#include <tanor/system.hpp>

#include "base/index_ranges.hpp"
#include "base/parallel.hpp"
#include "kinds/kernel.hpp"

namespace tanor::detail {

/// The position of a block of K: column `row` of K has `sign * blocks[block]` at `point`.
struct Incidence {
  Index point, row, block;
  double sign;
};

/// The loops over the rows of a family, which all families share. Each quantity is one loop over the members, without
/// virtual calls and allocations. The output index is the row, so members may run in any order and on any thread.
/// `members` are those that take part.
///
/// Own::visit(parallel, members, r, v, take) calls take(member, m), which returns a number, for each row m of the
/// members, and returns the largest of these numbers; without v, rate and phi are not wanted. Own::visit_stored does so
/// with the gradients that `blocks` hold. A member has its first `row`, xi(m), rate(m), phi(m), the length norm(m) of
/// its gradient, the length scale() that violations are measured by, transposed(m, x), which is row m of K'x, and
/// store(m, blocks), which writes its gradient.
template <class Own>
class RowLoops {
 public:
  /// Evaluates xi; returns the largest relative violation |xi|/|gradient|/length.
  double evaluate_values(const Parallel& parallel, const IndexRanges& members, const double* r, double* xi) const {
    return own().visit(parallel, members, r, nullptr, [=](const auto& member, int m) {
      xi[member.row + m] = member.xi(m);
      return violation(member, m);
    });
  }

  /// Evaluates rate = K'v + xi_t; returns the largest |rate|/|gradient|, m/s.
  double evaluate_rates(const Parallel& parallel, const IndexRanges& members, const double* r, const double* v,
                        double* rate) const {
    return own().visit(parallel, members, r, v, [=](const auto& member, int m) {
      rate[member.row + m] = member.rate(m);
      return std::abs(member.rate(m)) / member.norm(m);
    });
  }

  /// Writes the blocks of K.
  void evaluate_gradients(const Parallel& parallel, const IndexRanges& members, const double* r, double* blocks) const {
    (void)own().visit(parallel, members, r, nullptr, [=](const auto& member, int m) {
      member.store(m, blocks);
      return 0.0;
    });
  }

  /// Evaluates phi + K'w0, minus the right-hand side of S lambda, and writes the blocks of K if they are wanted.
  /// Returns the largest |.|/|gradient|, m/s^2.
  template <bool WithGradients>
  double evaluate_right_side(const Parallel& parallel, const IndexRanges& members, const double* r, const double* v,
                             const double* w0, double* phi, double* blocks) const {
    return own().visit(parallel, members, r, v, [=](const auto& member, int m) {
      const double value = member.phi(m) + member.transposed(m, w0);
      phi[member.row + m] = value;
      if constexpr (WithGradients) member.store(m, blocks);
      return std::abs(value) / member.norm(m);
    });
  }

  /// Computes y = K'x + shift from stored blocks; returns the largest |y|/|gradient|. A null `shift` is 0.
  double apply_transposed(const Parallel& parallel, const IndexRanges& members, const double* blocks, const double* x,
                          const double* shift, double* y) const {
    return own().visit_stored(parallel, members, blocks, [=](const auto& member, int m) {
      const double value = member.transposed(m, x) + (shift != nullptr ? shift[member.row + m] : 0.0);
      y[member.row + m] = value;
      return std::abs(value) / member.norm(m);
    });
  }

  /// Writes |xi|/|gradient|/length and |rate|/|gradient| of each row, to find the worst one.
  void measure(const IndexRanges& members, const double* r, const double* v, double* position, double* velocity) const {
    (void)own().visit(Parallel(1), members, r, v, [=](const auto& member, int m) {
      position[member.row + m] = violation(member, m);
      velocity[member.row + m] = std::abs(member.rate(m)) / member.norm(m);
      return 0.0;
    });
  }

 protected:
  /// Returns the largest number(k) of some members.
  template <class Number>
  static double find_largest(const Parallel& parallel, const IndexRanges& members, const Number& number) {
    return members.max_over_ranges(parallel, [&](std::size_t begin, std::size_t end) {
      double worst = 0.0;
      for (std::size_t k = begin; k < end; ++k) worst = larger(worst, number(k));
      return worst;
    });
  }

 private:
  const Own& own() const { return *static_cast<const Own*>(this); }
  template <class Member>
  static double violation(const Member& member, int m) {
    return std::abs(member.xi(m)) / (member.norm(m) * member.scale());
  }
};

/// All constraints of one kind as a structure of arrays.
template <class Kernel>
class Family : public RowLoops<Family<Kernel>> {
 public:
  static constexpr int P = Kernel::num_points, R = Kernel::num_rows, B = Kernel::num_blocks;

  Kernel kernel;
  std::vector<Index> rows;  ///< [member] first row
  Index first_block = 0;

  std::size_t size() const { return rows.size(); }

  template <class Take>
  double visit(const Parallel& parallel, const IndexRanges& members, const double* r, const double* v,
               const Take& take) const {
    return this->find_largest(parallel, members, [&](std::size_t k) {
      return take_rows(Member{*this, k, rows[k], kernel(k, r, v != nullptr ? v : r)}, take);
    });
  }
  template <class Take>
  double visit_stored(const Parallel& parallel, const IndexRanges& members, const double* blocks,
                      const Take& take) const {
    return this->find_largest(parallel, members, [&](std::size_t k) {
      Member member{*this, k, rows[k], {}};
      for (int b = 0; b < B; ++b) member.local.gradient[b] = load(blocks, block(k) + b);
      for (int m = 0; m < R && !Kernel::unit_gradient; ++m) {
        double norm2 = 0.0;
        for (int b = m * P; b < (m + 1) * P; ++b)
          norm2 = std::max(norm2, dot(member.local.gradient[b], member.local.gradient[b]));
        member.local.gradient_norm[m] = std::sqrt(norm2);
      }
      return take_rows(member, take);
    });
  }

  void write_lengths(double* lengths) const {
    for (std::size_t k = 0; k < size(); ++k) std::fill_n(lengths + rows[k], R, kernel.scale(k));
  }

  template <class Append>
  void list_incidences(const Append& append) const {
    for (std::size_t k = 0; k < size(); ++k) {
      for (int m = 0; m < R; ++m) {
        for (int p = 0; p < P; ++p) {
          append(Incidence{kernel.points[k][p], rows[k] + m, block(k) + local_block(m, p), sign(p)});
        }
      }
    }
  }

 private:
  // A rod has one block for both points, with opposite signs; all others have one for each row and point.
  static constexpr bool antisymmetric = B < R * P;
  static constexpr Index local_block(int m, int p) { return antisymmetric ? 0 : m * P + p; }
  static constexpr double sign(int p) { return antisymmetric && p == 0 ? -1.0 : 1.0; }

  Index block(std::size_t k) const { return first_block + static_cast<Index>(k) * B; }

  struct Member {
    const Family& family;
    std::size_t k;
    Index row;
    Local<R, B> local;

    double xi(int m) const { return local.xi[m]; }
    double rate(int m) const { return local.rate[m]; }
    double phi(int m) const { return local.phi[m]; }
    double norm(int m) const { return Kernel::unit_gradient ? 1.0 : local.gradient_norm[m]; }
    double scale() const { return family.kernel.scale(k); }
    void store(int m, double* blocks) const {
      for (int b = m * (B / R); b < (m + 1) * (B / R); ++b)
        detail::store(blocks, family.block(k) + b, local.gradient[b]);
    }
    double transposed(int m, const double* x) const {
      const auto& points = family.kernel.points[k];
      if constexpr (antisymmetric) {
        return dot(local.gradient[0], load(x, points[1]) - load(x, points[0]));
      } else {
        double sum = 0.0;
        for (int p = 0; p < P; ++p) sum += dot(local.gradient[m * P + p], load(x, points[p]));
        return sum;
      }
    }
  };
  template <class Take>
  [[gnu::always_inline]] static double take_rows(const Member& member, const Take& take) {
    double worst = 0.0;
    for (int m = 0; m < R; ++m) worst = larger(worst, take(member, m));
    return worst;
  }
};

}  // namespace tanor::detail
