/// The tests ask for tensions, some of which the rods cannot have.

#include <algorithm>

#include <gtest/gtest.h>
#include <tanor/equilibrium.hpp>
#include <tanor/modes.hpp>

namespace tanor {
namespace {

/// Makes a wire of ten rods between two supports, without weight.
System make_wire() {
  System system;
  Rods rods{.name = "r"};
  for (int i = 0; i <= 10; ++i) {
    system.positions.insert(system.positions.end(), {0.1 * i, 0.0, 0.0});
    if (i > 0) rods.pairs.push_back({i - 1, i});
  }
  system.masses.assign(11, 1.0);
  system.supports.push_back({"", {0, 10}, {}});
  system.constraints = {rods};
  return system;
}

template <class Result>
std::string prestress_note(const Result& found) {
  const auto note =
      std::ranges::find_if(found.left_out, [](const std::string& what) { return what.starts_with("prestress: "); });
  return note == found.left_out.end() ? "" : *note;
}

TEST(Prestress, UnbalancedTensionsAreToldWithThoseThatTakeTheirPlace) {
  const System wire = make_wire();
  std::vector<double> tensions(10, 100.0);
  std::fill(tensions.begin() + 5, tensions.end(), 50.0);

  const std::string note = prestress_note(modes(wire, wire.positions, {.prestress = {{"r", tensions}}}));

  EXPECT_NE(note.find("is 75"), std::string::npos) << note;
  EXPECT_NE(note.find("where 100 is asked for"), std::string::npos) << note;
}

/// The message blames no rod of which no tension was asked.
TEST(Prestress, UnbalancedTensionsNameARodThatTheyWereAskedOf) {
  const System wire = make_wire();
  std::vector<double> tensions(10, 0.0);
  std::fill(tensions.begin() + 5, tensions.end(), 100.0);
  const std::vector<Prestress> prestress{{"r", tensions}};

  const EquilibriumResult found = find_equilibrium(wire, {.prestress = prestress});

  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  for (const std::string& note :
       {prestress_note(found), prestress_note(modes(wire, wire.positions, {.prestress = prestress}))}) {
    EXPECT_NE(note.find("is 50"), std::string::npos) << note;
    EXPECT_NE(note.find("where 100 is asked for"), std::string::npos) << note;
  }
}

TEST(Prestress, StateOfSelfStressIsTakenWithoutANote) {
  const System wire = make_wire();

  EXPECT_EQ(prestress_note(modes(wire, wire.positions, {.prestress = {{"r", {100.0}}}})), "");
}

/// Forces act along the wire, and the tensions balance them.
TEST(Prestress, TensionsThatBalanceTheForcesAreTakenWithoutANote) {
  System wire = make_wire();
  wire.forces.push_back(ConstantForce{.name = "pull", .points = {5}, .force = Vector3{50.0, 0.0, 0.0}});
  std::vector<double> tensions(10, 100.0);
  std::fill(tensions.begin() + 5, tensions.end(), 50.0);

  EXPECT_EQ(prestress_note(modes(wire, wire.positions, {.prestress = {{"r", tensions}}})), "");
}

}  // namespace
}  // namespace tanor
