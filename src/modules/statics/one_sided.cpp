#include "statics/one_sided.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <set>
#include <string>
#include <utility>

#include "base/check_size.hpp"
#include "base/text.hpp"
#include "system/chosen_members.hpp"
#include "system/enum_check.hpp"
#include "system/members.hpp"

namespace tanor {
using namespace detail;

namespace {

/// Returns the side of each one-sided equation [row].
std::vector<int> find_sides(const System& system, const std::vector<OneSided>& given) {
  std::vector<int> result(num_equations(system), 0);
  for (const OneSided& each : given) {
    const std::string where = "/equilibrium/one_sided/" + each.constraint;
    check_enum(each.side, OneSide::AtMost, where.c_str());
    bool is_found = false;
    std::size_t row = 0;
    for (std::size_t g = 0; g < system.constraints.size(); ++g) {
      const auto [members, rows] = shape_of(system.constraints[g]);
      if (constraint_name(system, g) == each.constraint) {
        if (rows != 1)
          throw InputError(where, "constraints of kind " + std::string(kind_name(system.constraints[g])) + " have " +
                                      std::to_string(rows) + " equations a member; one-sided ones have one");
        is_found = true;
        std::fill_n(result.begin() + static_cast<std::ptrdiff_t>(row), members, each.side == OneSide::AtLeast ? 1 : -1);
      }
      row += members * rows;
    }
    if (!is_found) throw InputError(where, "no constraint has the name \"" + each.constraint + "\"");
  }
  return result;
}

}  // namespace

System without_open_constraints(const System& system, const std::vector<bool>& open) {
  if (open.empty()) return system;
  if (open.size() != num_equations(system))
    throw InputError("open", "found " + text(open.size()) + " flags, wanted one for each of the " +
                                 text_of_count(num_equations(system), "equation"));
  return without_open_rows(system, open);
}

std::vector<double> detail::keep_rows(const std::vector<double>& all, const std::vector<bool>& open,
                                      std::size_t first) {
  std::vector<double> result;
  for (std::size_t k = 0; k < all.size(); ++k)
    if (!open[first + k]) result.push_back(all[k]);
  return result;
}

std::vector<double> detail::spread_rows(const std::vector<double>& kept, const std::vector<bool>& open) {
  std::vector<double> result(open.size(), 0.0);
  for (std::size_t row = 0, k = 0; row < result.size(); ++row)
    if (!open[row]) result[row] = kept[k++];
  return result;
}

void detail::rename_members(const System& system, const std::vector<bool>& open, std::string* text) {
  std::size_t row = 0;
  for (std::size_t g = 0; g < system.constraints.size(); ++g) {
    const auto [members, rows] = shape_of(system.constraints[g]);
    std::vector<std::size_t> kept;
    for (std::size_t k = 0; k < members; ++k) {
      if (!open[row + k * rows]) kept.push_back(k);
    }
    row += members * rows;
    if (kept.size() == members) continue;
    const std::string before = constraint_name(system, g) + "[";
    for (std::size_t at = text->find(before); at != std::string::npos; at = text->find(before, at)) {
      const bool is_whole_name = at == 0 || (*text)[at - 1] == ' ' || (*text)[at - 1] == '(';
      at += before.size();
      if (!is_whole_name) continue;
      const std::size_t end = text->find(']', at), k = std::stoul(text->substr(at, end - at));
      text->replace(at, end - at, std::to_string(kept[k]));
    }
  }
}

namespace {

/// One-sided constraints, s = 1 or -1, and which of them are closed:
///
///   s xi >= 0,   s lambda >= 0,   xi lambda = 0
class OneSidedRows {
 public:
  /// Closes the constraints that touch or are broken at the start. Throws InputError.
  OneSidedRows(const StaticsInput& input, const EquilibriumOptions& options, std::span<const double> positions)
      : system_(input.system),
        work_(input.system, options.solver, 0.0),
        equations_(work_, options.at),
        tolerance_(options.force_tolerance),
        side_(find_sides(input.system, options.one_sided)),
        open_(side_.size(), false) {
    stand_at(positions, {});
    const double touches = 1e-6 * work_.model().smallest_length;
    for (std::size_t row = 0; row < side_.size(); ++row) open_[row] = side_[row] * xi_[row] > touches * norm_[row];
  }

  const std::vector<bool>& open() const { return open_; }
  void change(const UserRows& rows) {
    for (const std::size_t row : rows) open_[row] = !open_[row];
  }

  std::vector<double> spread(const std::vector<double>& kept) const { return spread_rows(kept, open_); }

  /// Returns the rows that contradict `found`, an equilibrium of the closed system: closed ones that pull, and of the
  /// open ones that are broken the worst one of each point.
  UserRows find_wrong(const EquilibriumResult& found) {
    const std::vector<double> lambda = spread(found.multipliers);
    stand_at(found.positions, lambda);
    const Model& model = work_.model();
    const double force = force_tolerance(found),
                 length = std::max(1e-9 * model.smallest_length,
                                   64.0 * std::numeric_limits<double>::epsilon() * model.scene_size);
    std::vector<std::pair<double, std::size_t>> broken;
    UserRows pulling, wrong;
    for (std::size_t row = 0; row < side_.size(); ++row) {
      if (side_[row] == 0) continue;
      if (open_[row] && side_[row] * xi_[row] < -length * norm_[row])
        broken.push_back({side_[row] * xi_[row] / norm_[row], row});
      if (!open_[row] && side_[row] * lambda[row] * norm_[row] < -force) pulling.push_back(row);
    }
    std::ranges::merge(pulling, find_first_of_points(broken), std::back_inserter(wrong));
    return wrong;
  }

  /// Returns the open rows towards which residual forces drive points: the one that each point meets first.
  UserRows find_pushed(const EquilibriumResult& found) {
    stand_at(found.positions, spread(found.multipliers));
    double largest = 0.0;
    for (const double rate : rate_) largest = std::max(largest, std::abs(rate));
    // A fall from rest through the gap takes the square root of twice this value.
    std::vector<std::pair<double, std::size_t>> pushed;
    for (std::size_t row = 0; row < side_.size(); ++row) {
      const double rate = side_[row] * rate_[row];
      if (open_[row] && rate < -1e-9 * largest) pushed.push_back({-side_[row] * xi_[row] / rate, row});
    }
    return find_first_of_points(pushed);
  }

  UserRows find_open() const {
    UserRows result;
    for (std::size_t row = 0; row < open_.size(); ++row) {
      if (open_[row]) result.push_back(row);
    }
    return result;
  }

  /// Returns the closed rows that carry no force.
  UserRows find_weak(const EquilibriumResult& found) {
    const std::vector<double> lambda = spread(found.multipliers);
    UserRows weak;
    for (std::size_t row = 0; row < side_.size(); ++row) {
      if (side_[row] != 0 && !open_[row] && std::abs(lambda[row]) * norm_[row] <= force_tolerance(found))
        weak.push_back(row);
    }
    return weak;
  }

  /// Returns "floor[3], floor[4], floor[5] and 7 more".
  std::string name(const UserRows& rows) const {
    std::vector<std::string> names;
    for (const std::size_t row : rows) names.push_back(equation_name(system_, row));
    return name_some(names);
  }

 private:
  /// Evaluates xi, |gradient| and xi'' = K'M^-1 g there; empty multipliers count as zero.
  void stand_at(std::span<const double> positions, const std::vector<double>& multipliers) {
    const Model& model = work_.model();
    const Numbering& numbering = model.numbering;
    const auto user_row = [&](std::size_t a) { return static_cast<std::size_t>(numbering.user_row[a]); };
    std::vector<double> r(positions.size()), v(positions.size()), lambda(model.num_rows(), 0.0), xi(model.num_rows()),
        g(equations_.size());
    numbering.gather_points(positions, r);
    work_.set_time(equations_.time());
    work_.prescribe_all(equations_.time(), r.data(), v.data());
    if (!multipliers.empty()) {
      for (std::size_t a = 0; a < lambda.size(); ++a) lambda[a] = multipliers[user_row(a)];
    }
    (void)equations_.evaluate(r.data(), lambda.data(), g.data(), xi.data());
    for (std::vector<double>* each : {&xi_, &norm_, &rate_}) each->assign(side_.size(), 0.0);
    for (std::size_t a = 0; a < xi.size(); ++a) xi_[user_row(a)] = xi[a];
    for (const Incidence& incidence : model.incidences) {
      const std::size_t row = user_row(static_cast<std::size_t>(incidence.row)),
                        i = static_cast<std::size_t>(incidence.point);
      const Vec3 gradient = incidence.sign * load(equations_.gradients().data(), incidence.block);
      norm_[row] = std::hypot(norm_[row], norm(gradient));
      if (i < model.num_moving()) rate_[row] += model.inverse_mass[i] * dot(gradient, load(g.data(), i));
    }
  }

  /// Returns the tolerance of multipliers, which are about as accurate as forces balance.
  double force_tolerance(const EquilibriumResult& found) const {
    return 10.0 * std::max(tolerance_, 1e-12) * found.largest_force;
  }

  /// Returns in order, of the rows with a rank, those with the least rank at one of their points.
  UserRows find_first_of_points(const std::vector<std::pair<double, std::size_t>>& rows) const {
    const Model& model = work_.model();
    std::vector<double> rank(side_.size(), std::numeric_limits<double>::infinity());
    for (const auto& [own, row] : rows) rank[row] = own;
    using Best = std::pair<double, std::size_t>;
    std::vector<Best> best(model.num_moving(), {std::numeric_limits<double>::infinity(), side_.size()});
    for (const Incidence& incidence : model.incidences) {
      const auto i = static_cast<std::size_t>(incidence.point);
      const auto row = static_cast<std::size_t>(model.numbering.user_row[static_cast<std::size_t>(incidence.row)]);
      if (i < best.size() && std::isfinite(rank[row])) best[i] = std::min(best[i], Best{rank[row], row});
    }
    std::set<std::size_t> first;
    for (const auto& [own, row] : best) {
      if (row < side_.size()) first.insert(row);
    }
    return {first.begin(), first.end()};
  }

  const System& system_;
  Workspace work_;
  EquilibriumEquations equations_;
  const double tolerance_;
  std::vector<int> side_;  // [row] 1 or -1; 0 if it acts both ways
  std::vector<bool> open_;
  std::vector<double> xi_, norm_;  // [row] values there, and |gradient|
  std::vector<double> rate_;       // [row] second derivative of xi by residual forces
};

/// Returns true if the constraints cannot hold together, at least not from that start.
bool contradicts(const EquilibriumResult& found) {
  constexpr double broken = 1e-6;
  return !found.outcome.ok() && found.violation > broken;
}

class OneSidedSearch {
 public:
  OneSidedSearch(const StaticsInput& input, const EquilibriumOptions& options)
      : input_(input),
        options_(options),
        rows_(input, options, input.system.positions),
        positions_(input.system.positions) {}

  EquilibriumResult run() {
    bool assesses_stability = false;
    for (int round = 0;; ++round) {
      EquilibriumResult found = rest(assesses_stability);
      const bool rests = found.outcome.ok() || found.stability.status != Stability::None;
      const bool is_final = assesses_stability && !rests;
      if (rests) {
        changed_ = wanted_ = exchange_.choose(rows_.find_wrong(found), rows_.open());
        positions_ = found.positions;
        has_rested_ = true;
      } else if (!is_final) {
        changed_ = change_after(found);
      }
      if (is_final || (changed_.empty() && (assesses_stability || !rests))) return write(std::move(found));
      if (exchange_.is_stuck() || round == options_.max_iterations) {
        found.stability.status = Stability::None;
        found.outcome = {Status::NotConverged, "one-sided constraints do not settle after " +
                                                   text_of_count(static_cast<std::size_t>(round + 1), "round") + ": " +
                                                   rows_.name(changed_) + " would close and open in turn"};
        return write(std::move(found));
      }
      assesses_stability = changed_.empty();
      rows_.change(changed_);
    }
  }

 private:
  /// Searches from the last equilibrium. If that fails, as for a chain that hung through the floor, it searches from
  /// the start.
  EquilibriumResult rest(bool assesses_stability) {
    EquilibriumOptions options = options_;
    if (has_rested_) options.load_steps = 1;
    const System closed = without_open_constraints(input_.system, rows_.open());
    const std::vector<double> prestress = keep_rows(input_.prestress, rows_.open());
    const auto rest_at = [&](const std::vector<double>& start) {
      EquilibriumResult found = rest_from(closed, input_.frame, options, prestress, start, assesses_stability);
      for (std::vector<std::string>* const texts : {&found.dependences, &found.left_out})
        for (std::string& each : *texts) rename_members(input_.system, rows_.open(), &each);
      rename_members(input_.system, rows_.open(), &found.outcome.what);
      search_.iterations += found.search.iterations;
      search_.factorizations += found.search.factorizations;
      search_.residuals.insert(search_.residuals.end(), found.search.residuals.begin(), found.search.residuals.end());
      return found;
    };
    EquilibriumResult found = rest_at(positions_);
    return contradicts(found) && has_rested_ ? rest_at(input_.system.positions) : found;
  }

  /// Returns the next change after a failed search. If the closed constraints contradict each other, part of the last
  /// change is undone. If they do not hold the system, the open rows are closed that its points run into next; without
  /// such rows the wrong rows change, and without those all open rows close. Returns nothing if this set was tried
  /// before.
  UserRows change_after(const EquilibriumResult& failed) {
    if (contradicts(failed) && !changed_.empty()) return take_part_of_change();
    if (!failed_.insert(rows_.open()).second) return {};
    wanted_ = rows_.find_pushed(failed);
    if (wanted_.empty()) wanted_ = rows_.find_wrong(failed);
    if (wanted_.empty()) wanted_ = rows_.find_open();
    return wanted_;
  }

  /// Halves the change that was tried; if it was a single row, returns the other rows that were wanted.
  UserRows take_part_of_change() {
    if (changed_.size() == 1) std::erase(wanted_, changed_.front());
    if (wanted_.empty()) return {};
    rows_.change(changed_);
    if (changed_.size() == 1) return wanted_;
    changed_.resize(changed_.size() / 2);
    return changed_;
  }

  /// Writes the results for the rows of all constraints, in the user's order.
  EquilibriumResult write(EquilibriumResult found) {
    const UserRows weak = rows_.find_weak(found);
    if (found.outcome.ok() && !weak.empty())
      found.left_out.push_back("one-sided constraints that touch and carry nothing (" + rows_.name(weak) +
                               "): stability takes them as held both ways");
    found.multipliers = rows_.spread(found.multipliers);
    if (!found.self_stress.empty()) found.self_stress = rows_.spread(found.self_stress);
    std::vector<bool> unique(rows_.open().size(), true);
    for (std::size_t row = 0, k = 0; row < unique.size(); ++row) {
      if (!rows_.open()[row] && k < found.multipliers_unique.size()) unique[row] = found.multipliers_unique[k++];
    }
    found.multipliers_unique = std::move(unique);
    found.open = rows_.open();
    search_.method_used = found.search.method_used;
    found.search = std::move(search_);
    return found;
  }

  const StaticsInput& input_;
  const EquilibriumOptions& options_;
  OneSidedRows rows_;
  Exchange exchange_;
  UserRows wanted_, changed_;           // what should change before this round, and what did
  std::vector<double> positions_;       // last equilibrium
  std::set<std::vector<bool>> failed_;  // sets that have no equilibrium
  bool has_rested_ = false;
  EquilibriumSearch search_;  // over all rounds
};

}  // namespace

EquilibriumOptions detail::take_sides(System* system, const EquilibriumOptions& given) {
  EquilibriumOptions options = given;
  for (std::size_t g = 0; g < system->constraints.size(); ++g) {
    std::visit(
        [&](auto& group) {
          if constexpr (requires { group.side; }) {
            if (!group.side) return;
            const std::string name = constraint_name(*system, g);
            if (std::ranges::find(given.one_sided, name, &OneSided::constraint) != given.one_sided.end())
              throw InputError("/equilibrium/one_sided/" + name, "the constraint has a side of its own already");
            options.one_sided.push_back({name, *group.side});
            group.side.reset();
          }
        },
        system->constraints[g]);
  }
  return options;
}

std::vector<bool> detail::find_open_rows(const System& system, std::span<const double> positions,
                                         const EquilibriumOptions& given) {
  System held = system;
  const EquilibriumOptions options = take_sides(&held, given);
  if (options.one_sided.empty()) return {};
  check_size(positions.size(), 3 * system.num_points(), "positions");
  std::vector<bool> open = OneSidedRows(StaticsInput(held, options), options, positions).open();
  return std::ranges::count(open, true) > 0 ? open : std::vector<bool>();
}

EquilibriumResult detail::rest_with_one_sided(const StaticsInput& input, const EquilibriumOptions& options) {
  return OneSidedSearch(input, options).run();
}

}  // namespace tanor
