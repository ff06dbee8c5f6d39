#include <algorithm>
#include <array>
#include <memory>

#include "base/parallel.hpp"
#include "evaluate/definitions.hpp"
#include "evaluate/forces.hpp"
#include "observe/quantity.hpp"

namespace tanor::detail {

namespace {

/// Symmetric tensors as LAMMPS orders them.
constexpr std::array<std::array<std::size_t, 2>, 6> axes{{{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}}};

/// Degrees of freedom that share the kinetic energy, less the three of a sample that nothing holds in its periodic cell,
/// since it moves as a whole.
double count_sharing(const Things& things, const ObservedInstant& at) {
  const System& system = things.system();
  bool is_held = false;
  for (std::size_t s = 0; s < system.supports.size(); ++s) {
    const std::vector<bool> gone = things.find_absent({Thing::List::Supports, s});
    is_held |= gone.empty() ? !system.supports[s].points.empty() : std::ranges::count(gone, false) > 0;
  }
  return static_cast<double>(at.degrees_of_freedom) - (system.cell && !is_held ? 3.0 : 0.0);
}

/// The virial of the forces between points and of the constraints that join points: the sum of r (x) F over what acts,
/// with images of points where it reaches through the faces of the cell. Forces from outside have none.
class Virial {
 public:
  explicit Virial(const Things& things)
      : system_(inner_system(things.what_is_left())),
        numbering_(number(system_)),
        forces_(system_, numbering_),
        definitions_(system_, 0.0) {
    const std::vector<Constraint>& constraints = things.system().constraints;
    for (std::size_t g = 0, row = 0; g < constraints.size(); ++g) {
      const GroupShape shape = shape_of(constraints[g]);
      const std::vector<bool> gone = things.find_absent({Thing::List::Constraints, g});
      for (std::size_t k = 0; k < shape.members; ++k) {
        const bool takes_part = joins_points(constraints[g]) && (gone.empty() || !gone[k]);
        for (std::size_t end = row + shape.rows_per_member; row < end; ++row)
          if (takes_part) rows_.push_back(row);
      }
    }
    lambda_.resize(definitions_.num_rows());
    for (std::vector<double>* array : {&r_, &v_, &f_, &eta_}) array->resize(system_.positions.size());
  }

  std::array<double, 6> evaluate(const ObservedInstant& at) const {
    std::array<double, 6> sum{};
    const auto add = [&](Vec3 r, Vec3 f) {
      const std::array<double, 3> a{r.x, r.y, r.z}, b{f.x, f.y, f.z};
      for (std::size_t k = 0; k < 6; ++k)
        sum[k] += 0.5 * (a[axes[k][0]] * b[axes[k][1]] + a[axes[k][1]] * b[axes[k][0]]);
    };
    for (std::size_t a = 0; a < rows_.size(); ++a) lambda_[a] = at.multipliers[rows_[a]];
    definitions_.reactions(at.time, at.positions, lambda_, eta_);
    for (std::size_t i = 0; i < system_.num_points(); ++i) add(load(at.positions.data(), i), load(eta_.data(), i));
    add_images_of_rods(at, add);

    numbering_.gather_points(at.positions, r_);
    numbering_.gather_points(at.velocities, v_);
    forces_.set_time(at.time);
    const Parallel serial(1);
    forces_.evaluate(serial, at.time, r_.data(), v_.data(), f_.data());
    for (std::size_t i = 0; i < system_.num_points(); ++i) add(load(r_.data(), i), load(f_.data(), i));
    forces_.for_each_image(serial, r_.data(), [&](Vec3 shift, Vec3 force) { add(shift, force); });
    return sum;
  }

 private:
  /// Returns true for constraints of several points; those that refer to fixed places act from outside.
  static bool joins_points(const Constraint& constraint) {
    if (const auto* own = std::get_if<UserConstraints>(&constraint)) return own->kernel.num_points > 1;
    return std::holds_alternative<Rods>(constraint) || std::holds_alternative<Angles>(constraint) ||
           std::holds_alternative<Ropes>(constraint);
  }
  static bool acts_between_points(const Force& force) {
    if (const auto* energy = std::get_if<Potential>(&force)) return energy->kernel.num_points > 1;
    if (const auto* formula = std::get_if<FormulaForce>(&force)) return formula->kernel.num_points > 1;
    return std::holds_alternative<Springs>(force) || std::holds_alternative<PairForces>(force) ||
           std::holds_alternative<Bonds>(force) || std::holds_alternative<Bendings>(force) ||
           std::holds_alternative<Torsions>(force);
  }
  static System inner_system(System system) {
    std::erase_if(system.constraints, [](const Constraint& each) { return !joins_points(each); });
    std::erase_if(system.forces, [](const Force& each) { return !acts_between_points(each); });
    return system;
  }

  /// A rod with an offset pulls at the image of its second point.
  template <class Add>
  void add_images_of_rods(const ObservedInstant& at, const Add& add) const {
    std::size_t row = 0;
    for (const Constraint& constraint : system_.constraints) {
      const GroupShape shape = shape_of(constraint);
      if (const auto* rods = std::get_if<Rods>(&constraint); rods && !rods->offsets.empty()) {
        for (std::size_t k = 0; k < shape.members; ++k) {
          const auto [i, j] = rods->pairs[k];
          const Vec3 shift = make_vec3(rods->offsets[k]);
          const Vec3 d = load(at.positions.data(), j) - load(at.positions.data(), i) + shift;
          add(shift, (lambda_[row + k] / norm(d)) * d);
        }
      }
      row += shape.members * shape.rows_per_member;
    }
  }

  System system_;
  Numbering numbering_;
  mutable Forces forces_;
  Definitions definitions_;
  std::vector<std::size_t> rows_;  // [inner row] its row in multipliers
  mutable std::vector<double> lambda_, r_, v_, f_, eta_;
};

void require_cell(const Things& things, const Arguments& arguments) {
  arguments.require(0, 0, "");
  things.require_forces(arguments);
  if (!things.system().cell || !(things.system().cell->volume() > 0.0))
    throw TextFault{arguments.place,
                    std::string(arguments.quantity) + " needs a periodic cell, and the system has none"};
}

}  // namespace

Quantity make_temperature(const Things& things, const Arguments& arguments) {
  arguments.require(0, 0, "");
  return one_number(Dimension::Temperature, {.energy = true, .freedoms = true}, [things](const ObservedInstant& at) {
    const double degrees = count_sharing(things, at);
    return degrees > 0.0 ? 2.0 * at.kinetic / (degrees * things.system().units.boltzmann) : 0.0;
  });
}

/// The pressure is (m v^2 + virial)/(3 V).
Quantity make_pressure(const Things& things, const Arguments& arguments) {
  require_cell(things, arguments);
  const auto find = [&system = things.system(), all = std::make_shared<Virial>(things)](const auto& at) {
    const std::array<double, 6> virial = all->evaluate(at);
    return (2.0 * at.kinetic + virial[0] + virial[1] + virial[2]) / (3.0 * system.cell->volume());
  };
  return one_number(Dimension::Pressure, {.forces = true, .energy = true}, find);
}

Quantity make_virial(const Things& things, const Arguments& arguments) {
  require_cell(things, arguments);
  const auto evaluate = [all = std::make_shared<Virial>(things)](const ObservedInstant& at, double* values) {
    std::ranges::copy(all->evaluate(at), values);
  };
  return {Dimension::Energy, {.forces = true, .energy = true}, evaluate, {"xx", "yy", "zz", "xy", "xz", "yz"}};
}

}  // namespace tanor::detail
