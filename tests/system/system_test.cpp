#include <tanor/system.hpp>

#include <gtest/gtest.h>

namespace tanor {
namespace {

/// Makes two rods, three beads on a line (two rows each), and one angle.
System make_system() {
  System system;
  system.constraints = {Rods{.name = "", .pairs = {{0, 1}, {1, 2}}, .length = {}, .offsets = {}},
                        Lines{.name = "wire", .points = {0, 1, 2}, .origin = {}, .direction = {}},
                        Planes{.name = "empty", .points = {}, .normal = {}},
                        Angles{.name = "bend", .triples = {{0, 1, 2}}, .cosine = {}}};
  system.forces = {Gravity{}, Drag{.name = "air", .points = {}}, Springs{}};
  return system;
}

TEST(System, CountsTheRowsOfAllMembers) {
  EXPECT_EQ(num_equations(System()), 0u);
  EXPECT_EQ(num_equations(make_system()), 2u + 3 * 2 + 0 + 1);
}

TEST(System, NamesItsRowsMemberByMember) {
  const System system = make_system();

  EXPECT_EQ(equation_name(system, 0), "rod0[0]");
  EXPECT_EQ(equation_name(system, 1), "rod0[1]");
  EXPECT_EQ(equation_name(system, 2), "wire[0].0");
  EXPECT_EQ(equation_name(system, 3), "wire[0].1");
  EXPECT_EQ(equation_name(system, 7), "wire[2].1");
  EXPECT_EQ(equation_name(system, 8), "bend[0]");
}

TEST(System, RowsBeyondTheLastOneAreAnError) {
  try {
    equation_name(make_system(), 9);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "row 9 is out of range: the system has 9 equations");
  }
}

TEST(System, EntriesWithoutNameAreCalledByKindAndIndex) {
  const System system = make_system();

  EXPECT_EQ(constraint_name(system, 0), "rod0");
  EXPECT_EQ(constraint_name(system, 1), "wire");
  EXPECT_EQ(force_name(system, 0), "gravity0");
  EXPECT_EQ(force_name(system, 1), "air");
  EXPECT_EQ(force_name(system, 2), "spring2");
}

TEST(System, SpellsKindsAsTheSceneFileDoes) {
  EXPECT_EQ(kind_name(Constraint(Rods())), "rod");
  EXPECT_EQ(kind_name(Constraint(Planes())), "plane");
  EXPECT_EQ(kind_name(Constraint(Spheres())), "sphere");
  EXPECT_EQ(kind_name(Constraint(Lines())), "line");
  EXPECT_EQ(kind_name(Constraint(Circles())), "circle");
  EXPECT_EQ(kind_name(Constraint(Angles())), "angle");
  EXPECT_EQ(kind_name(Constraint(Pulleys())), "pulley");
  EXPECT_EQ(kind_name(Constraint(Linears())), "linear");
  EXPECT_EQ(kind_name(Force(Gravity())), "gravity");
  EXPECT_EQ(kind_name(Force(ConstantForce())), "constant");
  EXPECT_EQ(kind_name(Force(Springs())), "spring");
  EXPECT_EQ(kind_name(Force(Drag())), "drag");
}

}  // namespace
}  // namespace tanor
