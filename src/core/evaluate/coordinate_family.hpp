#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "base/memory.hpp"
#include "base/parallel.hpp"
#include "evaluate/place.hpp"
#include "evaluate/product.hpp"
#include "kinds/tables.hpp"
#include "system/members.hpp"
#include "system/numbering.hpp"

namespace tanor::detail {

/// The input of coordinates: a system, and the instant of "initial" numbers and of the first charts.
struct CoordinateStart {
  const System& system;
  const Numbering& numbering;
  double t;

  Index inner(Index user) const { return numbering.inner_point[static_cast<std::size_t>(user)]; }
  Vec3 place(Index user) const { return load(system.positions.data(), user); }
};

/// Coordinates q of members of one kind and the positions of their points, in the inner order. A member's coordinates
/// move its own points alone. Arrays over points are 3n; A is stored as blocks dr_p/dq_j, 3 numbers each.
class CoordinateFamily {
 public:
  Index first_coordinate = 0, first_block = 0;

  virtual ~CoordinateFamily() = default;

  virtual std::size_t size() const = 0;  ///< number of members
  virtual Index num_coordinates() const = 0;
  virtual Index num_blocks() const = 0;
  virtual Index first_coordinate_of(std::size_t member) const = 0;
  virtual bool depends_on_time() const = 0;
  virtual void set_time(double t) = 0;

  /// Evaluates r, v = A q_dot + r_t, psi = d2r/de2 along (q + e q_dot, t + e), and the blocks of A; each but r may be
  /// null. What stands at supports is input.
  virtual void evaluate(const Parallel& parallel, const double* q, const double* q_dot, double* r, double* v,
                        double* psi, double* blocks) const = 0;
  /// Computes y = A x at the family's points.
  virtual void apply(const Parallel& parallel, const double* blocks, const double* x, double* y) const = 0;
  /// Computes x = A'y.
  virtual void apply_transposed(const Parallel& parallel, const double* blocks, const double* y, double* x) const = 0;
  /// Adds the reactions of members to the rows of the supports that hold them; eta at the points is given [3n].
  virtual void add_support_reactions(double*) const {}
  /// Appends the products of A'WA, member by member; `weights` [point].
  virtual void append_products(const std::vector<double>& weights, std::vector<Product>* products) const = 0;

  /// Finds q of the positions r, in charts centred there. If several q give the same r, finds one near the given q.
  virtual void locate(const double* r, double* q) = 0;

  /// Returns true if charts are centred anew during the motion.
  virtual bool has_charts() const = 0;
  /// Centres charts at q, at the time of `set_time`, and converts the motion (q, q_dot, q_ddot) to them.
  virtual void recentre(double t, double* q, double* q_dot, double* q_ddot) = 0;
  /// Saves or restores where charts are centred. Restoring leaves the family at the time of the last `set_time`.
  virtual void exchange_memory(Memory& memory) = 0;

 protected:
  /// Calls body(k) for all members, which have so many points together.
  template <class Body>
  void for_members(const Parallel& parallel, std::size_t num_points, const Body& body) const {
    const std::size_t mean = num_points / (size() + 1) + 1;
    const auto run = [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) body(k);
    };
    parallel.for_ranges(size(), run, 1024 / mean + 1);
  }
};

/// A family whose members move one point each, so that accelerations have a closed form.
class PointFamily : public CoordinateFamily {
 public:
  /// Computes q_ddot and w = A q_ddot + psi with A'M (w - w0) = 0, member by member. If `uniform` is not null, it is
  /// the w0 of every point instead of `w0` [3n]. Returns the largest condition of A'A, which is NaN if some number is
  /// not finite and infinite if A'A of a member is singular.
  virtual double accelerate(const Parallel& parallel, const double* q, const double* q_dot, const double* w0,
                            const Vec3* uniform, double* q_ddot, double* w) const = 0;
};

/// Members of P points and S coordinates that lie side by side. A has a block for each coordinate and point of a
/// member, [member][coordinate][point]. `Own` tells P and S by points_per_member() and coordinates_per_member().
template <class Own, class Base>
class CoordinatesOfMembers : public Base {
 public:
  std::vector<Index> points;  ///< [member][p] inner

  std::size_t size() const override { return points.size() / P(); }
  Index num_coordinates() const override { return static_cast<Index>(size() * S()); }
  Index num_blocks() const override { return static_cast<Index>(points.size() * S()); }
  Index first_coordinate_of(std::size_t k) const override { return static_cast<Index>(coordinate(k)); }

  void apply(const Parallel& parallel, const double* blocks, const double* x, double* y) const override {
    parallel.for_ranges(size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) {
        for (std::size_t p = 0; p < P(); ++p) {
          Vec3 sum{};
          for (std::size_t j = 0; j < S(); ++j) sum = sum + x[coordinate(k) + j] * load(blocks, block(k, j, p));
          store(y, points[k * P() + p], sum);
        }
      }
    });
  }

  void apply_transposed(const Parallel& parallel, const double* blocks, const double* y, double* x) const override {
    parallel.for_ranges(size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) {
        for (std::size_t j = 0; j < S(); ++j) {
          double sum = 0.0;
          for (std::size_t p = 0; p < P(); ++p) sum += dot(load(blocks, block(k, j, p)), load(y, points[k * P() + p]));
          x[coordinate(k) + j] = sum;
        }
      }
    });
  }

  void append_products(const std::vector<double>& weights, std::vector<Product>* products) const override {
    const auto index = [](std::size_t number) { return static_cast<Index>(number); };
    for (std::size_t k = 0; k < size(); ++k) {
      for (std::size_t i = 0; i < S(); ++i) {
        for (std::size_t j = 0; j <= i; ++j) {
          for (std::size_t p = 0; p < P(); ++p)
            products->push_back({index(coordinate(k) + i), index(coordinate(k) + j), index(block(k, i, p)),
                                 index(block(k, j, p)), weights[static_cast<std::size_t>(points[k * P() + p])]});
        }
      }
    }
  }

 protected:
  std::size_t coordinate(std::size_t k) const { return static_cast<std::size_t>(this->first_coordinate) + k * S(); }
  std::size_t block(std::size_t k, std::size_t j = 0, std::size_t p = 0) const {
    return static_cast<std::size_t>(this->first_block) + (k * S() + j) * P() + p;
  }

 private:
  std::size_t P() const { return static_cast<const Own*>(this)->points_per_member(); }
  std::size_t S() const { return static_cast<const Own*>(this)->coordinates_per_member(); }
};

/// Solves A'A x = A'b of one point in closed form. Returns a bound of the condition of A'A scaled to a unit diagonal,
/// (1 + sqrt(1 - D))^2/D with its determinant D, which is exact for two tangents (Merikoski et al., Linear Algebra
/// Appl. 254, 1997). It is infinite if A'A is singular.
template <int S>
double solve_normal_equations(const Vec3 (&A)[S], Vec3 b, double* x) {
  double determinant = 0.0;
  if constexpr (S == 1) {
    const double square = dot(A[0], A[0]);
    x[0] = dot(A[0], b) / square;
    determinant = square > 0.0 ? 1.0 : 0.0;
  } else if constexpr (S == 2) {
    const double aa = dot(A[0], A[0]), ab = dot(A[0], A[1]), bb = dot(A[1], A[1]), det = aa * bb - ab * ab;
    const double first = dot(A[0], b), second = dot(A[1], b);
    x[0] = (bb * first - ab * second) / det;
    x[1] = (aa * second - ab * first) / det;
    determinant = det / (aa * bb);
  } else {
    static_assert(S == 3, "a point has at most three coordinates");
    // A x = b is solved by cross products.
    const Vec3 across[] = {cross(A[1], A[2]), cross(A[2], A[0]), cross(A[0], A[1])};
    const double det = dot(A[0], across[0]), volume = det / (norm(A[0]) * norm(A[1]) * norm(A[2]));
    for (int j = 0; j < S; ++j) x[j] = dot(across[j], b) / det;
    determinant = volume * volume;
  }
  if (!(determinant > 0.0)) return std::numeric_limits<double>::infinity();
  const double root = 1.0 + std::sqrt(std::max(0.0, 1.0 - determinant));
  return root * root / determinant;
}

/// Coordinates of members of one point each. Kernel has add(group, t), which keeps what the members of a group share
/// and returns its slot; add_member(group, slot, k, place, t); place(k, q, q_dot) and locate(k, r, q); and the
/// functions of charts. A member has S coordinates and S blocks. A kernel that has place_run(begin, count, q, q_dot,
/// places) places many members at once.
template <class Kernel>
class PointCoordinates final : public CoordinatesOfMembers<PointCoordinates<Kernel>, PointFamily> {
  using Members = CoordinatesOfMembers<PointCoordinates<Kernel>, PointFamily>;

 public:
  using Group = typename Kernel::Group;
  using Members::points, Members::size, Members::first_coordinate_of;
  static constexpr int S = Kernel::num_coordinates;
  static constexpr std::size_t points_per_member() { return 1; }
  static constexpr std::size_t coordinates_per_member() { return S; }

  Kernel kernel;

  /// Returns true if this one of several families of a kind serves the group.
  static bool takes([[maybe_unused]] const Group& group) {
    if constexpr (requires { Kernel::takes(group); }) return Kernel::takes(group);
    return true;
  }
  void add(const Group& group, const CoordinateStart& start) {
    const Index slot = kernel.add(group, start.t);
    for (std::size_t k = 0; k < group.points.size(); ++k) {
      points.push_back(start.inner(group.points[k]));
      kernel.add_member(group, slot, k, start.place(group.points[k]), start.t);
    }
  }

  bool depends_on_time() const override { return kernel.depends_on_time(); }
  void set_time(double t) override { kernel.set_time(t); }

  void evaluate(const Parallel& parallel, const double* q, const double* q_dot, double* r, double* v, double* psi,
                double* blocks) const override {
    parallel.for_ranges(size(), [&](std::size_t begin, std::size_t end) {
      for_each_place(begin, end, q, q_dot, [&](std::size_t k, const Place<S>& place) {
        store(r, points[k], place.r);
        if (v != nullptr) store(v, points[k], place.v);
        if (psi != nullptr) store(psi, points[k], place.psi);
        if (blocks == nullptr) return;
        for (std::size_t j = 0; j < S; ++j) store(blocks, this->block(k, j), place.tangent[j]);
      });
    });
  }

  /// Solves A'A q_ddot = A'(w0 - psi), in which a point's mass drops out.
  double accelerate(const Parallel& parallel, const double* q, const double* q_dot, const double* w0,
                    const Vec3* uniform, double* q_ddot, double* w) const override {
    return parallel.max_over_ranges(size(), [&](std::size_t begin, std::size_t end) {
      if constexpr (requires { &Kernel::accelerate_run; }) {
        if (uniform != nullptr) return accelerate_runs(begin, end, q, q_dot, *uniform, q_ddot, w);
      }
      double worst = 0.0, lost = 0.0;
      for_each_place(begin, end, q, q_dot, [&](std::size_t k, const Place<S>& place) {
        double* const x = q_ddot + first_coordinate_of(k);
        const Vec3 missing = (uniform != nullptr ? *uniform : load(w0, points[k])) - place.psi;
        worst = std::max(worst, solve_normal_equations(place.tangent, missing, x));
        Vec3 sum = place.psi;
        for (int j = 0; j < S; ++j) sum = sum + x[j] * place.tangent[j];
        store(w, points[k], sum);
        lost += 0.0 * (sum.x + sum.y + sum.z);
      });
      return worst + lost;
    });
  }

  void locate(const double* r, double* q) override {
    for (std::size_t k = 0; k < size(); ++k) kernel.locate(k, load(r, points[k]), q + first_coordinate_of(k));
  }
  bool has_charts() const override { return kernel.has_charts(); }
  void exchange_memory(Memory& memory) override { kernel.exchange_memory(memory); }
  void recentre(double t, double* q, double* q_dot, double* q_ddot) override {
    if (!has_charts()) return;
    kernel.begin_recentre(t);
    for (std::size_t k = 0; k < size(); ++k) {
      const Index first = first_coordinate_of(k);
      kernel.recentre(k, q + first, q_dot + first, q_ddot + first);
    }
  }

 private:
  double accelerate_runs(std::size_t begin, std::size_t end, const double* q, const double* q_dot, Vec3 w0,
                         double* q_ddot, double* w) const {
    std::array<Vec3, Kernel::run_size> run;
    double lost = 0.0;
    for (std::size_t first = begin; first < end; first += run.size()) {
      const std::size_t count = std::min(run.size(), end - first);
      const Index at = first_coordinate_of(first);
      lost += kernel.accelerate_run(first, count, q + at, q_dot + at, w0, q_ddot + at, run.data());
      for (std::size_t k = 0; k < count; ++k) store(w, points[first + k], run[k]);
    }
    return 1.0 + lost;
  }

  /// Calls use(k, place) for the members [begin, end).
  template <class Use>
  void for_each_place(std::size_t begin, std::size_t end, const double* q, const double* q_dot, const Use& use) const {
    if constexpr (requires(Place<S> * places) { kernel.place_run(begin, end, q, q_dot, places); }) {
      std::array<Place<S>, Kernel::run_size> places;  // NOLINT: filled before use
      for (std::size_t first = begin; first < end; first += places.size()) {
        const std::size_t count = std::min(places.size(), end - first);
        kernel.place_run(first, count, q + first_coordinate_of(first), q_dot + first_coordinate_of(first),
                         places.data());
        for (std::size_t k = 0; k < count; ++k) use(first + k, places[k]);
      }
    } else {
      for (std::size_t k = begin; k < end; ++k)
        use(k, kernel.place(k, q + first_coordinate_of(k), q_dot + first_coordinate_of(k)));
    }
  }
};

}  // namespace tanor::detail
