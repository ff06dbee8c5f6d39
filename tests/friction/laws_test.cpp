/// The tests check what the laws of friction say in their files, and a law that has nothing but a magnitude.

#include <cmath>

#include <gtest/gtest.h>

#include "friction/laws.hpp"

namespace tanor {
using namespace detail;

/// A law mu (|N| + adhesion) with a limit, which the library does not know.
struct Sticky {
  double coefficient, adhesion;  ///< 1, N
};

template <>
struct KindOf<Sticky> {
  template <class T>
  static T magnitude(const Sticky& law, double speed, const T& normal) {
    using std::sqrt;
    return law.coefficient * std::tanh(speed) * sqrt(normal * normal + law.adhesion * law.adhesion);
  }
};

static_assert(HasMagnitude<Sticky> && !IsProportionalFriction<Sticky>);
static_assert(form_of<Sticky>() == LawForm::Magnitude && form_of<Coulomb>() == LawForm::Proportional);
static_assert(form_of<Viscous>() == LawForm::Given && form_of<UserFriction>() == LawForm::ThreeParts);

namespace {

constexpr double speed = 0.3, normal = 2.5;

TEST(FrictionLaw, DerivativeOfAnyMagnitudeFollowsFromItsDefinition) {
  const std::variant<Sticky, Coulomb> law = Sticky{0.4, 1.5};
  const double size = std::hypot(normal, 1.5);

  EXPECT_DOUBLE_EQ(magnitude(law, speed, normal), 0.4 * std::tanh(speed) * size);
  EXPECT_DOUBLE_EQ(slope_in_normal_force(law, speed, normal), 0.4 * std::tanh(speed) * normal / size);
}

TEST(FrictionLaw, CoulombsIsProportionalToTheNormalForce) {
  const Friction exact = Coulomb{.name = "", .at = {}, .coefficient = 0.4, .static_coefficient = 0.6};
  const Friction smooth = Coulomb{.name = "", .at = {}, .coefficient = 0.4, .regularisation = 0.4};

  EXPECT_DOUBLE_EQ(magnitude(exact, speed, normal), 0.4 * normal);
  EXPECT_DOUBLE_EQ(magnitude(smooth, speed, normal), 0.4 * normal * 0.6);  // 0.3/hypot(0.3, 0.4)
  for (const Friction& law : {exact, smooth}) {
    EXPECT_DOUBLE_EQ(magnitude(law, speed, 2.0 * normal), 2.0 * magnitude(law, speed, normal));
    EXPECT_DOUBLE_EQ(slope_in_normal_force(law, speed, normal), magnitude(law, speed, 1.0));
  }
}

TEST(FrictionLaw, ViscousReadsTheSpeedAlone) {
  const Friction law = Viscous{"", {}, 0.7};

  EXPECT_DOUBLE_EQ(magnitude(law, speed, normal), 0.7 * speed);
  EXPECT_EQ(slope_in_normal_force(law, speed, normal), 0.0);
}

}  // namespace
}  // namespace tanor
