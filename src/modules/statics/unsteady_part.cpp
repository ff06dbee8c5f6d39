#include "statics/unsteady_part.hpp"

#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "statics/carried_parts.hpp"

namespace tanor::detail {

namespace {

/// Functions of time at all times since t.
struct WholeClock {
  using Number = ExponentialPolynomial;
  double t;

  Number time() const { return Number::time() + t; }
  Number operator()(const ScalarFunction& function) const {
    if (function.is_constant()) return function(t).value();
    const std::shared_ptr<const Expression> expression = function.expression();
    return expression ? evaluate(*expression, std::vector{time()})[0] : Number::unknown();
  }
  TripleOf<Number> operator()(const VectorFunction& function) const {
    return {(*this)(function.components[0]), (*this)(function.components[1]), (*this)(function.components[2])};
  }
};

/// A system at all times since t, as a frame carries it along.
struct CarriedView : WholeClock {
  const SteadyFrame& frame;
  std::array<std::vector<Vec3>, 2> starts;

  TripleOf<Number> carry(Index point, std::size_t start) const {
    return frame.carry(starts[start][static_cast<std::size_t>(point)]);
  }
  TripleOf<Number> turn_back(const TripleOf<Number>& a) const { return frame.turn_back(a); }
};

bool is_known(const ScalarFunction& function) {
  return WholeClock{0.0}(function).is_known();
}

/// The test of one system in one frame.
class SteadinessTest {
 public:
  SteadinessTest(const System& system, const SteadyFrame& frame, double t, double scene_size)
      : frame_(frame), view_{{t}, frame_, {}}, parts_(system, view_) {
    constexpr double part = 0.1;
    for (const std::size_t k : {0, 1}) {
      view_.starts[k] = disturb(system, k, part * scene_size);
      put_supports(system, t, &view_.starts[k]);
    }
  }

  /// Returns what is wrong with a part, or nothing.
  template <class Part>
  std::string complain(const std::string& name, const Part& part) const {
    if (const std::string what = refuse(part); !what.empty()) return name + what;
    if (is_steady(part)) return {};
    if constexpr (std::is_constructible_v<Force, Part>)
      return name + " changes with time" + (frame_.moves() ? " in the frame " + frame_.describe() : "") +
             ", so that nothing rests";
    else
      return "nothing rests: no frame that turns with a constant spin or accelerates evenly carries along all that "
             "supports, constraints and forces prescribe; " +
             name + " leaves " + (frame_.moves() ? "the frame " + frame_.describe() : "the frame at rest");
  }

 private:
  template <class Part>
  bool may_change(const Part& part) const {
    return frame_.moves() || !name_moving_fields(part).empty();
  }
  template <class Part>
  bool is_steady(const Part& part) const {
    if (!may_change(part)) return true;
    if constexpr (requires { part.kernel.expression; }) {
      if (!part.kernel.expression) return false;
    }
    bool is_steady = true;
    parts_.list(part, [&](std::span<const ExponentialPolynomial> numbers) {
      is_steady = is_steady && std::ranges::all_of(numbers, &ExponentialPolynomial::is_constant);
    });
    return is_steady;
  }

  // ---- forces that no frame makes steady ----

  std::string moved() const { return " acts on what moves, as all does that rests in the frame " + frame_.describe(); }
  static std::string opaque() {
    return " is not known to stand still at all times: its formula is not known, only numbers of it";
  }
  template <class Part>
  std::string refuse(const Part&) const {
    return {};
  }
  std::string refuse(const Drag&) const { return frame_.moves() ? moved() : ""; }
  std::string refuse(const PairForces& pairs) const {
    if (!frame_.turns() || pairs.box == Vector3{}) return {};
    return " is periodic and does not turn with the frame " + frame_.describe();
  }
  std::string refuse(const FormulaForce& formula) const {
    if (!may_change(formula)) return {};
    if (frame_.moves() && formula.kernel.depends_on_velocity) return moved();
    return formula.kernel.expression ? "" : opaque();
  }
  std::string refuse(const Potential& potential) const {
    return may_change(potential) && !potential.kernel.expression ? opaque() : "";
  }

  SteadyFrame frame_;
  CarriedView view_;
  CarriedParts<CarriedView> parts_;
};

}  // namespace

std::optional<UnsteadyPart> find_unknown_function(const System& system) {
  std::optional<UnsteadyPart> result;
  for_each_part(system, [&](const std::string& where, const std::string& name, const auto& part) {
    const std::vector<std::string> unknown = list_failing_fields(part, is_known);
    if (result || unknown.empty()) return;
    result = UnsteadyPart{where, name + " (" + unknown[0] +
                                     ") is not known to move steadily: neither a polynomial of t nor sines and "
                                     "cosines of constant frequency, as all motions of steady frames are"};
  });
  return result;
}

std::optional<UnsteadyPart> find_unsteady_part(const System& system, const SteadyFrame& frame, double t,
                                               double scene_size) {
  const SteadinessTest test(system, frame, t, scene_size);
  std::optional<UnsteadyPart> result;
  for_each_part(system, [&](const std::string& where, const std::string& name, const auto& part) {
    const std::string what = result ? "" : test.complain(name, part);
    if (!what.empty()) result = UnsteadyPart{where, what};
  });
  return result;
}

}  // namespace tanor::detail
