#include <cmath>

#include <tanor/motion.hpp>

#include "cli/program.hpp"
#include "report/digits.hpp"

namespace tanor::cli {
namespace {

TEST(SelftestTest, EveryProblemKeepsItsPromiseWithoutAnyFile) {
  const Folder folder;

  const Ended ended = run_program(folder, {"selftest"});

  EXPECT_EQ(ended.code, 0) << ended.out << ended.err;
  EXPECT_EQ(ended.err, "");
  EXPECT_TRUE(list_names(folder.path()).empty()) << "nothing is written";
  EXPECT_FALSE(contains(ended.out, "MISSED")) << ended.out;
  for (const std::string word : {"IFToMM A01", "IFToMM A02", "car axis", "Painleve", "Fekete"})
    EXPECT_TRUE(contains(ended.out, word)) << word << "\n" << ended.out;
  for (const MethodTraits& each : methods()) {
    if (each.method == Method::Auto) continue;  // auto stands for one of the others
    EXPECT_TRUE(contains(ended.out, std::string(each.name))) << each.name << "\n" << ended.out;
  }
  EXPECT_GE(std::count(ended.out.begin(), ended.out.end(), '\n'), 25) << "headline, problems, sum";
}

report::DigitsRow row(double promised, double error, Outcome outcome = {}) {
  return {.name = "spin", .known = "", .method = "rk4", .promised = promised, .error = error, .outcome = outcome};
}

TEST(DigitsTest, AreTheLogarithmOfTheRelativeError) {
  EXPECT_NEAR(row(3.0, 2e-5).won(), 4.69897, 1e-5);
  EXPECT_EQ(row(3.0, 0.0).won(), 16.0) << "no more than a double has";
  EXPECT_EQ(row(3.0, 7.0).won(), 0.0);
  EXPECT_EQ(row(3.0, NAN).won(), 0.0);
  EXPECT_EQ(row(3.0, 1e-9, {Status::NotFinite, "it flew away"}).won(), 0.0)
      << "what is found on the way counts nothing";
}

TEST(DigitsTest, APromiseThatIsMissedIsNamedWithItsReason) {
  EXPECT_TRUE(report::verify_digits({row(4.0, 1e-5), row(5.0, 0.99e-5)}).ok());

  const std::string few = report::verify_digits({row(4.0, 1e-5), row(6.0, 1e-5)}).what;
  EXPECT_EQ(few, "spin (rk4): 5.0 of 6.0 digits");
  const std::string none = report::verify_digits({row(0.0, 0.0, {Status::NotFinite, "it flew away"})}).what;
  EXPECT_EQ(none, "spin (rk4): it flew away");
  EXPECT_TRUE(contains(report::format_digits({row(6.0, 1e-5)}), "MISSED"));
  EXPECT_FALSE(contains(report::format_digits({row(4.0, 1e-5)}), "MISSED"));
}

}  // namespace
}  // namespace tanor::cli
