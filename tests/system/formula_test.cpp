#include "system/formula.hpp"

#include <cmath>
#include <numbers>
#include <string>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <tanor/error.hpp>

namespace tanor {
using namespace detail;
namespace {

const std::vector<std::string> time = {"t"};

double evaluate(const std::string& text, double t = 0.0, const Constants& constants = {}) {
  return Formula(text, time, constants).evaluate(std::span<const double>(&t, 1));
}

Jet<3> evaluate_jet(const std::string& text, double t) {
  const auto variable = Jet<3>::variable(t);
  return Formula(text, time).evaluate(std::span<const Jet<3>>(&variable, 1));
}

/// Returns the parser's message about a wrong text.
std::string error_of_formula(const std::string& text, const Constants& constants = {}) {
  try {
    Formula(text, time, constants);
  } catch (const InputError& error) {
    EXPECT_EQ(error.where(), "");
    return error.what();
  }
  return "no error";
}

/// Expects an error whose `message` follows the quoted text.
void expect_error(const std::string& text, const std::string& message) {
  EXPECT_EQ(error_of_formula(text), "formula \"" + text + "\": " + message);
}

TEST(Formula, MultiplicationBindsTighterThanAddition) {
  EXPECT_EQ(evaluate("1 + 2*3"), 7.0);
  EXPECT_EQ(evaluate("(1 + 2)*3"), 9.0);
  EXPECT_EQ(evaluate("2*3 - 4/8"), 5.5);
}

TEST(Formula, SubtractionAndDivisionGoFromLeftToRight) {
  EXPECT_EQ(evaluate("10 - 4 - 3"), 3.0);
  EXPECT_EQ(evaluate("16/4/2"), 2.0);
  EXPECT_EQ(evaluate("8/4*2"), 4.0);
}

TEST(Formula, PowersGoFromRightToLeftAndBindTighterThanTheMinus) {
  EXPECT_EQ(evaluate("2^3^2"), 512.0);
  EXPECT_EQ(evaluate("-2^2"), -4.0);
  EXPECT_EQ(evaluate("-t^2", 3.0), -9.0);
  EXPECT_EQ(evaluate("(-t)^2", 3.0), 9.0);
  EXPECT_EQ(evaluate("2^-1"), 0.5);
  EXPECT_EQ(evaluate("2^-t^2", 2.0), 0.0625);
  EXPECT_EQ(evaluate("2*t^2", 3.0), 18.0);
}

TEST(Formula, SignsMayBeRepeated) {
  EXPECT_EQ(evaluate("--3"), 3.0);
  EXPECT_EQ(evaluate("2 - -3"), 5.0);
  EXPECT_EQ(evaluate("2*-3"), -6.0);
  EXPECT_EQ(evaluate("+t", 2.0), 2.0);
}

TEST(Formula, ReadsNumbersInAllTheirForms) {
  EXPECT_EQ(evaluate("1e-3"), 1e-3);
  EXPECT_EQ(evaluate("1E+3"), 1e3);
  EXPECT_EQ(evaluate(".5"), 0.5);
  EXPECT_EQ(evaluate("2."), 2.0);
  EXPECT_EQ(evaluate("2.e1"), 20.0);
  EXPECT_EQ(evaluate("0.1"), 0.1);
  EXPECT_EQ(evaluate(" 1.5\t*\n2 "), 3.0);
}

TEST(Formula, KnowsItsVariablesConstantsAndPi) {
  const std::vector<std::string> names = {"x1", "y1", "t"};
  const std::array<double, 3> values = {2.0, 3.0, 5.0};

  EXPECT_EQ(Formula("x1 + 10*y1 + 100*t", names).evaluate(std::span<const double>(values)), 532.0);
  EXPECT_EQ(evaluate("omega_2*t", 2.0, {{"omega_2", 3.0}}), 6.0);
  EXPECT_EQ(evaluate("pi"), std::numbers::pi);
}

TEST(Formula, HasEveryFunction) {
  const double t = 0.6;
  EXPECT_EQ(evaluate("sqrt(t)", t), std::sqrt(t));
  EXPECT_EQ(evaluate("exp(t)", t), std::exp(t));
  EXPECT_EQ(evaluate("log(t)", t), std::log(t));
  EXPECT_EQ(evaluate("sin(t)", t), std::sin(t));
  EXPECT_EQ(evaluate("cos(t)", t), std::cos(t));
  EXPECT_EQ(evaluate("tan(t)", t), std::tan(t));
  EXPECT_EQ(evaluate("asin(t)", t), std::asin(t));
  EXPECT_EQ(evaluate("acos(t)", t), std::acos(t));
  EXPECT_EQ(evaluate("atan(t)", t), std::atan(t));
  EXPECT_EQ(evaluate("atan2(t, -2)", t), std::atan2(t, -2.0));
  EXPECT_EQ(evaluate("sinh(t)", t), std::sinh(t));
  EXPECT_EQ(evaluate("cosh(t)", t), std::cosh(t));
  EXPECT_EQ(evaluate("tanh(t)", t), std::tanh(t));
  EXPECT_EQ(evaluate("abs(t - 1)", t), 1.0 - t);
  EXPECT_EQ(evaluate("min(t, 1)", t), t);
  EXPECT_EQ(evaluate("max(t, 1)", t), 1.0);
  EXPECT_EQ(evaluate("t^2.5", t), std::pow(t, 2.5));
  EXPECT_EQ(evaluate("t^t", t), std::pow(t, t));
}

TEST(Formula, SmallestAndLargestTakeAnyNumberOfArguments) {
  EXPECT_EQ(evaluate("min(3, t, 2, 5)", 1.0), 1.0);
  EXPECT_EQ(evaluate("max(3, t, 2, 5)", 1.0), 5.0);
}

TEST(Formula, GivesTheSameDerivativesAsTheSameFunctionOverJets) {
  const auto t = Jet<3>::variable(0.6);

  const Jet<3> expected = exp(-t * t) * sin(3.0 * t) / (1.0 + atan2(t, 2.0)) + pow(t, 2.5) - pow(t, 3.0) + pow(t, t) +
                          tan(t) * tanh(t) + log(t) * sqrt(t) + abs(t - 1.0) + min(t, t * t) + max(t, 0.1) +
                          asin(t) * acos(t) * atan(t) * sinh(t) * cosh(t) * cos(t);

  const Jet<3> jet = evaluate_jet(
      "exp(-t*t)*sin(3*t)/(1 + atan2(t, 2)) + t^2.5 - t^3 + t^t + tan(t)*tanh(t) + log(t)*sqrt(t) + abs(t - 1)"
      " + min(t, t^2) + max(t, 0.1) + asin(t)*acos(t)*atan(t)*sinh(t)*cosh(t)*cos(t)",
      0.6);
  for (int k = 0; k <= 3; ++k) EXPECT_NEAR(jet.c[k], expected.c[k], 1e-13 * (1.0 + std::abs(expected.c[k])));
}

TEST(Formula, IntegerPowersWorkAtZeroAndBelow) {
  EXPECT_EQ(evaluate_jet("t^2", 0.0).c, (std::array{0.0, 0.0, 1.0, 0.0}));
  EXPECT_EQ(evaluate_jet("t^3", -1.0).c, (std::array{-1.0, 3.0, -3.0, 1.0}));
  EXPECT_EQ(evaluate("t^-2", -2.0), 0.25);
}

RC_GTEST_PROP(Formula, ValueOnNumbersIsTheValueOnJets, ()) {
  const double t = *rc::gen::inRange(-2000, 2001) / 1000.0;
  const std::string text = "0.1*sin(3*t) - t^3/(2 + cos(t)) + 2^t - max(t, -t)*t^-2.0*t^2";
  RC_PRE(t != 0.0);

  RC_ASSERT(std::abs(evaluate_jet(text, t).value() - evaluate(text, t)) <= 1e-14 * (1.0 + std::abs(evaluate(text, t))));
}

TEST(Formula, IsConstantWhenNoVariableTakesPart) {
  EXPECT_TRUE(Formula("2*sin(pi/2)^3 - omega", time, {{"omega", 1.0}}).is_constant());
  EXPECT_FALSE(Formula("0*t", time).is_constant());
}

TEST(Formula, DeepFormulasAreEvaluatedOnTheLargerStack) {
  // In 1 + (1 + (… (1 + t))) `depth` operands wait.
  const auto nested = [](int depth) {
    std::string text = "t";
    for (int k = 1; k < depth; ++k) text = "t*1 + (" + text + ")";
    return text;
  };

  EXPECT_EQ(evaluate(nested(8), 2.0), 16.0);
  EXPECT_EQ(evaluate(nested(9), 2.0), 18.0);
  EXPECT_EQ(evaluate(nested(63), 2.0), 126.0);
}

TEST(Formula, LongSumsNeedNoDeepStack) {
  std::string text = "t^2";
  for (int k = 1; k < 1000; ++k) text += " + t^2";

  EXPECT_EQ(evaluate(text, 2.0), 4000.0);
}

TEST(Formula, UnknownNamesAreListedWithTheKnownOnes) {
  EXPECT_EQ(error_of_formula("0.1*sin(3*q)", {{"omega", 3.0}}),
            "formula \"0.1*sin(3*q)\": column 11: 'q' is not known; known names: t, pi, omega and the functions "
            "sqrt, exp, log, sin, cos, tan, asin, acos, atan, atan2, sinh, cosh, tanh, abs, min, max");
}

TEST(Formula, NamesAreReadWhole) {
  EXPECT_TRUE(error_of_formula("1 + time1").starts_with("formula \"1 + time1\": column 5: 'time1' is not known;"));
  EXPECT_TRUE(
      error_of_formula("Sin(t)").starts_with("formula \"Sin(t)\": column 1: 'Sin' is not known (did you mean sin?);"));
}

TEST(Formula, ErrorsNameTheColumnWhatIsThereAndWhatWasExpected) {
  expect_error("", "column 1: found the end, expected a number, a name or '('");
  expect_error("  ", "column 3: found the end, expected a number, a name or '('");
  expect_error("2*", "column 3: found the end, expected a number, a name or '('");
  expect_error("2*)", "column 3: found ')', expected a number, a name or '('");
  expect_error("2**3", "column 3: found '*', expected a number, a name or '('");
  expect_error("2 3", "column 3: found '3', expected an operator or the end");
  expect_error("2 t", "column 3: found 't', expected an operator or the end");
  expect_error("3*t)", "column 4: found ')', expected an operator or the end");
  expect_error("(1 + t", "column 7: found the end, expected an operator or ')'");
  expect_error("(1, t)", "column 3: found ',', expected an operator or ')'");
  expect_error("t(3)", "column 2: found '(', expected an operator or the end");
  expect_error("t = 3", "column 3: found '=', expected an operator or the end");
  expect_error(".", "column 1: found '.', expected a number");
  expect_error("1.2.3", "column 4: found '.', expected an operator or the end");
  expect_error("1e", "column 2: found 'e', expected an operator or the end");
  expect_error("0x10", "column 2: found 'x10', expected an operator or the end");
}

TEST(Formula, ErrorsInArgumentsNameTheFunction) {
  expect_error("sin", "column 4: found the end, expected '(': sin takes 1 argument");
  expect_error("sin t", "column 5: found 't', expected '(': sin takes 1 argument");
  expect_error("sin()", "column 5: found ')', expected a number, a name or '('");
  expect_error("sin(1, 2)", "column 6: found ',', expected an operator or ')': sin takes 1 argument");
  expect_error("sin(t", "column 6: found the end, expected an operator or ')': sin takes 1 argument");
  expect_error("atan2(1)", "column 8: found ')', expected an operator or ',': atan2 takes 2 arguments");
  expect_error("atan2(1, 2, 3)", "column 11: found ',', expected an operator or ')': atan2 takes 2 arguments");
  expect_error("max(1)", "column 6: found ')', expected an operator or ',': max takes 2 or more arguments");
  expect_error("max(1, 2", "column 9: found the end, expected an operator, ',' or ')'");
}

TEST(Formula, NumbersOutsideTheRangeOfDoubleAreErrors) {
  expect_error("2 + 1e999", "column 5: 1e999 is outside the range of numbers");
  expect_error("1e-999", "column 1: 1e-999 is outside the range of numbers");
}

TEST(Formula, ColumnsCountCharactersNotBytes) {
  expect_error("2*\u03c9", "column 3: found '\u03c9', expected a number, a name or '('");
  expect_error("\u03c9", "column 1: found '\u03c9', expected a number, a name or '('");
  expect_error("2\u00b7t", "column 2: found '\u00b7', expected an operator or the end");
}

TEST(Formula, MessagesStayOnOneLine) {
  EXPECT_EQ(error_of_formula("2\n*\n)"), "formula \"2 * )\": column 5: found ')', expected a number, a name or '('");
}

TEST(Formula, ConstantsMustNotHideOtherNames) {
  EXPECT_EQ(error_of_formula("1", {{"t", 1.0}}), "formula \"1\": the constant 't' has the name of a variable");
  EXPECT_EQ(error_of_formula("1", {{"sin", 1.0}}), "formula \"1\": the constant 'sin' has the name of a function");
  EXPECT_EQ(error_of_formula("1", {{"pi", 1.0}}), "formula \"1\": the constant 'pi' has the name of the number pi");
  EXPECT_EQ(error_of_formula("1", {{"a", NAN}}), "formula \"1\": the constant 'a' is not finite");
}

TEST(Formula, NestingHasALimitInsteadOfACrash) {
  const std::string open(100000, '('), minus(100000, '-');

  EXPECT_NE(error_of_formula(open).find("column 201: nested deeper than 200 levels"), std::string::npos);
  EXPECT_NE(error_of_formula(minus).find("nested deeper than 200 levels"), std::string::npos);
  EXPECT_EQ(evaluate(std::string(150, '(') + "t" + std::string(150, ')'), 3.0), 3.0);
}

TEST(Formula, WaitingOperandsHaveALimitThatIsCheckedBeforehand) {
  std::string text = "t";
  for (int k = 0; k < 64; ++k) text = "t + (" + text + ")";

  EXPECT_NE(error_of_formula(text).find("more than 64 operands wait for their operator here"), std::string::npos);
}

}  // namespace
}  // namespace tanor
