/// The tests validate users' constraints and forces that come from C++, where no scene file has checked anything.

#include <string>

#include <gtest/gtest.h>
#include <tanor/system.hpp>
#include <tanor/user_kernel.hpp>

namespace tanor {
namespace {

System make_gear_in_field() {
  System system;
  system.positions = {0, 0, 0, 1, 0, 0, 2, 1, 0};
  system.velocities = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  system.masses = {1, 1, 1};
  system.constraints = {
      UserConstraints{"gear", {{0, 1}, {1, 2}}, make_constraint_kernel<2>([](const auto& x, const auto& t) {
                        return x[0] - x[3] + 0.1 * t;
                      })}};
  system.forces = {FormulaForce{"field", {1, 2}, formula_force({"vx", "0", "0"})}};
  return system;
}

template <class Change>
std::string error_of(const Change& change) {
  System system = make_gear_in_field();
  change(std::get<UserConstraints>(system.constraints[0]), std::get<FormulaForce>(system.forces[0]));
  try {
    validate(system, 0.5);
  } catch (const InputError& error) {
    return error.where() + ": " + error.what();
  }
  return "no error";
}

TEST(UserConstraintsValidation, CorrectConstraintsPass) {
  EXPECT_EQ(error_of([](UserConstraints&, FormulaForce&) {}), "no error");
}

TEST(UserConstraintsValidation, EachFaultIsNamed) {
  const auto with_constraint = [](auto change) {
    return error_of([&](UserConstraints& user, FormulaForce&) { change(user); });
  };

  EXPECT_EQ(with_constraint([](auto& user) { user.kernel = {}; }),
            "/constraints/0/equation: is missing: there is no function to call");
  EXPECT_EQ(with_constraint([](auto& user) { user.kernel.num_points = 0; }),
            "/constraints/0/equation: a function of 0 points; 1 to 256 are right");
  EXPECT_EQ(with_constraint([](auto& user) { user.kernel.num_points = 257; }),
            "/constraints/0/equation: a function of 257 points; 1 to 256 are right");
  EXPECT_EQ(with_constraint([](auto& user) { user.tuples[1] = {1}; }),
            "/constraints/0/points/1: 1 point for a function of 2 points");
  EXPECT_EQ(with_constraint([](auto& user) {
              user.tuples[1] = {2, 2};
            }),
            "/constraints/0/points/1: [2, 2] names point 2 twice; the points of a tuple differ");
  EXPECT_EQ(with_constraint([](auto& user) {
              user.tuples[1] = {2, 3};
            }),
            "/constraints/0/points/1: point 3 is out of range: the scene has 3 points, 0 to 2");
  EXPECT_EQ(with_constraint([](auto& user) { user.kernel = formula_constraint("log(x1) + x2", 2); }),
            "/constraints/0/points/0: [0, 1]: the function is -inf at the start");
  EXPECT_EQ(with_constraint([](auto& user) { user.kernel = formula_constraint("log(t - 0.5) + x2", 2); }),
            "/constraints/0/points/0: [0, 1]: the function is -inf at the start");
  EXPECT_EQ(with_constraint([](auto& user) { user.kernel = formula_constraint("x2 + sqrt(t - 0.5)", 2); }),
            "/constraints/0/points/0: [0, 1]: its rate is inf at the start");
  EXPECT_EQ(with_constraint([](auto& user) { user.kernel = formula_constraint("z1 + x2^1.5*0 + (x2-1)^1.5", 2); }),
            "/constraints/0/points/0: [0, 1]: its curvature is nan at the start");
  EXPECT_EQ(with_constraint([](auto& user) { user.kernel = formula_constraint("z2^2 + x1^2", 2); }),
            "/constraints/0/points/0: [0, 1]: its gradient is zero at the start: it holds nothing there");
}

TEST(FormulaForceValidation, EachFaultIsNamed) {
  const auto with_force = [](auto change) {
    return error_of([&](UserConstraints&, FormulaForce& force) { change(force); });
  };

  EXPECT_EQ(with_force([](auto& force) { force.kernel = {}; }),
            "/forces/0/x: is missing: there is no function to call");
  EXPECT_EQ(with_force([](auto& force) {
              force.points = {1, 5};
            }),
            "/forces/0/points/1: point 5 is out of range: the scene has 3 points, 0 to 2");
  EXPECT_EQ(with_force([](auto& force) {
              force.kernel = formula_force({"1/vx", "0", "0"});
            }),
            "/forces/0/points/1: point 2: the force is [inf, 0, 0] at the start");
}

TEST(UserConstraintsNames, AreThoseOfTheFormulaKind) {
  System system = make_gear_in_field();
  std::get<UserConstraints>(system.constraints[0]).name.clear();
  std::get<FormulaForce>(system.forces[0]).name.clear();

  EXPECT_NO_THROW(validate(system)) << "a constraint and a force without names";
  EXPECT_EQ(equation_name(system, 1), "formula0[1]");
  EXPECT_EQ(num_equations(system), 2u);
  EXPECT_EQ(kind_name(system.constraints[0]), "formula");
  EXPECT_EQ(force_name(system, 0), "formula0");
}

}  // namespace
}  // namespace tanor
