#include "evaluate/parametrisation.hpp"

#include <algorithm>
#include <cmath>

#include "base/text.hpp"
#include "evaluate/coordinate_families.hpp"

namespace tanor::detail {

namespace {

/// Lists of families, in the order of the list of kinds. A list has one family, but one for each group of a user's own
/// coordinates.
template <class Kinds>
struct ListsOf;
template <class... Groups>
struct ListsOf<std::variant<Groups...>> {
  template <class... Families>
  static std::tuple<std::vector<std::unique_ptr<Families>>...> lists_of(const std::tuple<Families...>*);
  template <class Group>
  using Own = decltype(lists_of(static_cast<const FamiliesOfCoordinates<Group>*>(nullptr)));
  using Tuple = decltype(std::tuple_cat(std::declval<Own<Groups>>()...));
};

}  // namespace

/// Fills the families, entry by entry of the user's list.
class Parametrisation::Builder {
 public:
  Builder(const System& system, const Numbering& numbering, double t) : start_{system, numbering, t} {
    for (const Coordinates& entry : system.coordinates) std::visit([&](const auto& group) { add_entry(group); }, entry);
  }

  void move_to(Parametrisation* to) {
    const auto keep = [to]<class Family>(std::vector<std::unique_ptr<Family>>& families) {
      for (auto& family : families) {
        if (family->size() == 0) continue;
        if constexpr (std::is_base_of_v<PointFamily, Family>) to->points_.push_back(family.get());
        if constexpr (std::is_same_v<UserCoordinateFamily, Family>) to->users_.push_back(family.get());
        to->families_.push_back(std::move(family));
      }
    };
    std::apply([&](auto&... families) { (keep(families), ...); }, lists_);
    to->entries_ = std::move(entries_);
  }

 private:
  template <class Group>
  void add_entry(const Group& group) {
    const auto add_to = [&]<class Family>(std::vector<std::unique_ptr<Family>>& families) {
      if constexpr (std::is_same_v<typename Family::Group, Group>) {
        if (!Family::takes(group)) return;
        if (families.empty() || requires { Family::is_of_one_group; }) families.push_back(std::make_unique<Family>());
        Family& family = *families.back();
        // A family without members does not know yet how many coordinates each has.
        const Index before = family.points.empty() ? 0 : family.num_coordinates();
        family.add(group, start_);
        const Index after = family.points.empty() ? 0 : family.num_coordinates();
        entries_.push_back({&family, before, after - before});
      }
    };
    std::apply([&](auto&... families) { (add_to(families), ...); }, lists_);
  }

  const CoordinateStart start_;
  std::vector<Entry> entries_;
  ListsOf<Coordinates>::Tuple lists_;
};

Parametrisation::Parametrisation(const System& system, const Numbering& numbering, double t) {
  if (system.coordinates.empty()) return;
  island_start_.clear();
  Builder builder(system, numbering, t);
  builder.move_to(this);
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

std::vector<std::unique_ptr<FormulaFeatures>> Parametrisation::list_features() const {
  std::vector<std::unique_ptr<FormulaFeatures>> result;
  for (const UserCoordinateFamily* const users : users_) {
    auto features = make_coordinate_features(users->kernel, users->points, users->first_coordinate);
    if (features == nullptr) continue;
    features->name = "coordinates given by formulas";
    result.push_back(std::move(features));
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
  return points_.size() == families_.size();
}

double Parametrisation::accelerate(const Parallel& parallel, const double* q, const double* q_dot, const double* w0,
                                   const Vec3* uniform, double* q_ddot, double* w) const {
  double worst = 0.0;
  for (const PointFamily* const family : points_) {
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

void Parametrisation::gather(const double* users, double* inner) const {
  for (const auto& [family, first, count] : entries_) {
    if (count > 0) std::copy_n(users, count, inner + family->first_coordinate + first);
    users += count;
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
  for (const UserCoordinateFamily* const users : users_) users->write_start(q, q_dot);
}

void Parametrisation::copy_where_given(const double* from, double* to) const {
  for (const UserCoordinateFamily* const users : users_) users->copy_where_given(from, to);
}

void Parametrisation::recentre(double t, double* q, double* q_dot, double* q_ddot) {
  for (const auto& family : families_) {
    if (family->has_charts()) family->recentre(t, q, q_dot, q_ddot);
  }
}

}  // namespace tanor::detail
