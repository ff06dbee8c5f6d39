#include "evaluate/parametrisation.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/text.hpp"
#include "evaluate/body_coordinates.hpp"
#include "evaluate/chain_coordinates.hpp"
#include "evaluate/coordinate_kernels.hpp"
#include "evaluate/user_coordinates.hpp"

namespace tanor {

/// Fills the families, entry by entry of the user's list.
class Parametrisation::Builder {
 public:
  Builder(const System& system, const Numbering& numbering, double t) : system_(system), numbering_(numbering), t_(t) {
    for (std::size_t i = 0; i < system.coordinates.size(); ++i) {
      std::visit([&](const auto& entry) { add_entry(entry); }, system.coordinates[i]);
    }
  }

  std::vector<std::unique_ptr<CoordinateFamily>> take() {
    std::vector<std::unique_ptr<CoordinateFamily>> result;
    const auto keep = [&](auto&& family) {
      if (family && family->size() > 0) result.push_back(std::move(family));
    };
    keep(std::move(free_));
    keep(std::move(lines_));
    keep(std::move(planes_));
    keep(std::move(circles_));
    keep(std::move(fixed_circles_));
    keep(std::move(spheres_));
    keep(std::move(chains_));
    keep(std::move(bodies_));
    for (auto& family : users_) keep(std::move(family));
    return result;
  }
  const std::vector<Entry>& entries() const { return entries_; }

 private:
  const CoordinateFamily& family_of(const FreeCoordinates&) const { return *free_; }
  const CoordinateFamily& family_of(const LineCoordinates&) const { return *lines_; }
  const CoordinateFamily& family_of(const PlaneCoordinates&) const { return *planes_; }
  const CoordinateFamily& family_of(const CircleCoordinates& group) const {
    if (stays(group)) return *fixed_circles_;
    return *circles_;
  }
  const CoordinateFamily& family_of(const SphereCoordinates&) const { return *spheres_; }
  const CoordinateFamily& family_of(const ChainAngles&) const { return *chains_; }
  const CoordinateFamily& family_of(const RigidBody&) const { return *bodies_; }

  template <class Group>
  void add_entry(const Group& group) {
    const CoordinateFamily& family = family_of(group);
    const Index before = family.num_coordinates();
    add(group);
    entries_.push_back({&family, before, family.num_coordinates() - before});
  }
  void add_entry(const UserCoordinates& group) {
    add(group);
    entries_.push_back({users_.back().get(), 0, users_.back()->num_coordinates()});
  }

  Index inner(Index user) const { return numbering_.inner_point[static_cast<std::size_t>(user)]; }
  Vec3 initial(Index user) const { return load(system_.positions.data(), user); }

  static ScalarFunction value(const Parameter& parameter, std::size_t k, double initial) {
    if (parameter.is_initial()) return initial;
    if (parameter.functions.empty()) return parameter.constants[parameter.constants.size() == 1 ? 0 : k];
    return parameter.functions[parameter.functions.size() == 1 ? 0 : k];
  }
  static void append(ScalarTable* table, const ScalarFunction& function) { table->append_member(table->add(function)); }

  /// `make_entry()` once, then each point with its parameter (where the kind has one).
  template <class Family, class Group, class MakeEntry, class Append>
  void add_points(Family& family, const Group& group, const MakeEntry& make_entry, const Append& append_parameter) {
    const Index entry = make_entry();
    for (std::size_t k = 0; k < group.points.size(); ++k) {
      family.points.push_back(inner(group.points[k]));
      family.kernel.entry.push_back(entry);
      append_parameter(k);
    }
  }

  void add(const FreeCoordinates& group) {
    for (const Index point : group.points) free_->points.push_back(inner(point));
  }
  void add(const LineCoordinates& group) {
    auto& kernel = lines_->kernel;
    add_points(
        *lines_, group,
        [&] {
          kernel.origin.add(group.origin);
          return static_cast<Index>(kernel.direction.add(group.direction));
        },
        [](std::size_t) {});
  }
  void add(const PlaneCoordinates& group) {
    auto& kernel = planes_->kernel;
    const auto initial_offset = [&](std::size_t k) {
      const MovingVec3 n = make_moving(group.normal(t_));
      return dot(n.value, initial(group.points[k]));
    };
    add_points(
        *planes_, group,
        [&] {
          kernel.axes.emplace_back(group.normal, t_);
          kernel.turn.emplace_back();
          return static_cast<Index>(kernel.normal.add(group.normal));
        },
        [&](std::size_t k) { append(&kernel.offset, value(group.offset, k, initial_offset(k))); });
  }
  static bool stays(const CircleCoordinates& group) {
    return group.center.is_constant() && group.normal.is_constant() &&
           std::ranges::all_of(group.radius.functions,
                               [](const ScalarFunction& radius) { return radius.is_constant(); });
  }
  void add(const CircleCoordinates& group) {
    auto& kernel = circles_->kernel;
    const auto initial_radius = [&](std::size_t k) {
      const Vec3 a = initial(group.points[k]) - make_moving(group.center(t_)).value;
      const Vec3 n = ToUnit{}(group.normal(t_)).value;
      return norm(a - dot(n, a) * n);
    };
    if (stays(group)) {
      const TurningPair axes(group.normal, t_);
      const Vec3 center = make_moving(group.center(t_)).value;
      for (std::size_t k = 0; k < group.points.size(); ++k) {
        const double radius = value(group.radius, k, initial_radius(k))(t_).value();
        fixed_circles_->points.push_back(inner(group.points[k]));
        fixed_circles_->kernel.add(center, radius * axes.first.value, radius * axes.second.value);
      }
      return;
    }
    add_points(
        *circles_, group,
        [&] {
          kernel.axes.emplace_back(group.normal, t_);
          kernel.turn.emplace_back();
          return static_cast<Index>(kernel.center.add(group.center));
        },
        [&](std::size_t k) { append(&kernel.radius, value(group.radius, k, initial_radius(k))); });
  }
  void add(const SphereCoordinates& group) {
    auto& kernel = spheres_->kernel;
    const auto initial_radius = [&](std::size_t k) {
      return norm(initial(group.points[k]) - make_moving(group.center(t_)).value);
    };
    add_points(
        *spheres_, group, [&] { return static_cast<Index>(kernel.center.add(group.center)); },
        [&](std::size_t k) {
          append(&kernel.radius, value(group.radius, k, initial_radius(k)));
          kernel.chart.emplace_back();
        });
  }
  void add(const ChainAngles& group) {
    if (group.points.empty()) return;
    const Vec3 normal = make_vec3(group.normal);
    const bool is_planar = dot(normal, normal) > 0.0;
    const auto first_link = static_cast<Index>(chains_->points.size());
    Vec3 before = initial(group.anchor), e1{}, e2{};
    if (is_planar) {
      const Vec3 n = (1.0 / norm(normal)) * normal;
      e1 = any_orthogonal(n);
      e2 = cross(n, e1);
    }
    const Index first_coordinate = chains_->num_coordinates();
    for (std::size_t k = 0; k < group.points.size(); ++k) {
      chains_->points.push_back(inner(group.points[k]));
      chains_->chart.emplace_back();
      append(&chains_->length, value(group.length, k, norm(initial(group.points[k]) - before)));
      before = initial(group.points[k]);
    }
    chains_->chains.push_back({inner(group.anchor), first_link, static_cast<Index>(chains_->points.size()), is_planar,
                               e1, e2, first_coordinate});
  }
  void add(const RigidBody& group) {
    std::vector<Index> points;
    std::vector<Vec3> places;
    std::vector<double> masses;
    for (const Index point : group.points) {
      points.push_back(inner(point));
      places.push_back(initial(point));
      masses.push_back(system_.masses[static_cast<std::size_t>(point)]);
    }
    bodies_->add(points, places, masses);
  }
  void add(const UserCoordinates& group) {
    auto family = std::make_unique<UserCoordinateFamily>();
    family->kernel = group.kernel;
    for (const auto& tuple : group.tuples) {
      for (const Index point : tuple) family->points.push_back(inner(point));
    }
    family->q_start = group.q;
    family->q_dot_start = group.q_dot;
    family->q_dot_start.resize(group.q.size(), 0.0);
    users_.push_back(std::move(family));
  }

  const System& system_;
  const Numbering& numbering_;
  const double t_;
  std::vector<Entry> entries_;
  std::unique_ptr<PointCoordinates<FreeKernel>> free_ = std::make_unique<PointCoordinates<FreeKernel>>();
  std::unique_ptr<PointCoordinates<LineChartKernel>> lines_ = std::make_unique<PointCoordinates<LineChartKernel>>();
  std::unique_ptr<PointCoordinates<PlaneChartKernel>> planes_ = std::make_unique<PointCoordinates<PlaneChartKernel>>();
  std::unique_ptr<PointCoordinates<CircleChartKernel>> circles_ =
      std::make_unique<PointCoordinates<CircleChartKernel>>();
  std::unique_ptr<PointCoordinates<FixedCircleKernel>> fixed_circles_ =
      std::make_unique<PointCoordinates<FixedCircleKernel>>();
  std::unique_ptr<PointCoordinates<SphereChartKernel>> spheres_ =
      std::make_unique<PointCoordinates<SphereChartKernel>>();
  std::unique_ptr<ChainCoordinates> chains_ = std::make_unique<ChainCoordinates>();
  std::unique_ptr<BodyCoordinates> bodies_ = std::make_unique<BodyCoordinates>();
  std::vector<std::unique_ptr<UserCoordinateFamily>> users_;
};

Parametrisation::Parametrisation(const System& system, const Numbering& numbering, double t) {
  if (system.coordinates.empty()) return;
  island_start_.clear();
  Builder builder(system, numbering, t);
  entries_ = builder.entries();
  families_ = builder.take();
  for (const auto& family : families_) {
    family->first_coordinate = static_cast<Index>(num_coordinates_);
    family->first_block = static_cast<Index>(num_blocks_);
    num_coordinates_ += static_cast<std::size_t>(family->num_coordinates());
    num_blocks_ += static_cast<std::size_t>(family->num_blocks());
    for (std::size_t k = 0; k < family->size(); ++k) island_start_.push_back(family->first_coordinate_of(k));
  }
  island_start_.push_back(static_cast<Index>(num_coordinates_));
  set_time(t);
}

bool Parametrisation::depends_on_time() const {
  return std::ranges::any_of(families_, [](const auto& family) { return family->depends_on_time(); });
}

bool Parametrisation::has_charts() const {
  return std::ranges::any_of(families_, [](const auto& family) { return family->has_charts(); });
}

std::vector<std::unique_ptr<FormulaPassages>> Parametrisation::list_passages() const {
  std::vector<std::unique_ptr<FormulaPassages>> result;
  for (const auto& family : families_) {
    const auto* const users = dynamic_cast<const UserCoordinateFamily*>(family.get());
    if (users == nullptr) continue;
    auto passages = make_coordinate_passages(users->kernel, users->points, users->first_coordinate);
    if (passages != nullptr) result.push_back(std::move(passages));
  }
  return result;
}

void Parametrisation::set_time(double t) {
  for (const auto& family : families_) family->set_time(t);
}

void Parametrisation::evaluate(const Parallel& parallel, const double* q, const double* q_dot, double* r, double* v,
                               double* psi, double* blocks) const {
  for (const auto& family : families_) family->evaluate(parallel, q, q_dot, r, v, psi, blocks);
}

bool Parametrisation::has_closed_form() const {
  return std::ranges::all_of(families_, [](const auto& family) { return family->has_closed_form(); });
}

double Parametrisation::accelerate(const Parallel& parallel, const double* q, const double* q_dot, const double* w0,
                                   const Vec3* uniform, double* q_ddot, double* w) const {
  double worst = 0.0;
  for (const auto& family : families_) {
    worst = larger(worst, family->accelerate(parallel, q, q_dot, w0, uniform, q_ddot, w));
    if (!std::isfinite(worst)) break;
  }
  return worst;
}

void Parametrisation::apply(const Parallel& parallel, const double* blocks, const double* x, double* y) const {
  for (const auto& family : families_) family->apply(parallel, blocks, x, y);
}

void Parametrisation::apply_transposed(const Parallel& parallel, const double* blocks, const double* y,
                                       double* x) const {
  for (const auto& family : families_) family->apply_transposed(parallel, blocks, y, x);
}

void Parametrisation::add_support_reactions(double* eta) const {
  for (const auto& family : families_) family->add_support_reactions(eta);
}

void Parametrisation::scatter(const double* inner, double* users) const {
  for (const auto& [family, first, count] : entries_) {
    if (count > 0) users = std::copy_n(inner + family->first_coordinate + first, count, users);
  }
}

std::string Parametrisation::name_coordinate(const System& system, std::size_t inner) const {
  const auto j = static_cast<Index>(inner);
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    const auto& [family, first, count] = entries_[i];
    const Index own = count > 0 ? j - family->first_coordinate - first : -1;
    if (own >= 0 && own < count) return coordinates_name(system, i) + "[" + text(own) + "]";
  }
  return text(inner);
}

std::vector<Product> Parametrisation::list_products(const std::vector<double>& weights) const {
  std::vector<Product> result;
  for (const auto& family : families_) family->append_products(weights, &result);
  return result;
}

void Parametrisation::locate(const double* r, double* q) {
  for (const auto& family : families_) family->locate(r, q);
}

void Parametrisation::write_start(double* q, double* q_dot) const {
  for (const auto& family : families_) family->write_start(q, q_dot);
}

void Parametrisation::copy_where_given(const double* from, double* to) const {
  for (const auto& family : families_) family->copy_where_given(from, to);
}

void Parametrisation::recentre(double t, double* q, double* q_dot, double* q_ddot) {
  for (const auto& family : families_) {
    if (family->has_charts()) family->recentre(t, q, q_dot, q_ddot);
  }
}

}  // namespace tanor
