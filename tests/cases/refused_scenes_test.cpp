/// The scenes of reference/E_errors.json and E_errors_onesided.json must be refused, with the exit code, the place and a word of the message.

#ifdef TANOR_PROGRAM

#include <gtest/gtest.h>

#include <sys/wait.h>

#include <ostream>
#include <sstream>

#include "cases/interfaces.hpp"
#include "cases/reference_case.hpp"

namespace tanor::cases {
namespace {

std::vector<nlohmann::json> refused_scenes() {
  std::vector<nlohmann::json> all = read_case("E_errors").at("cases");
  for (const nlohmann::json& each : read_case("E_errors_onesided").at("cases")) all.push_back(each);
  return all;
}

class RefusedScene : public testing::TestWithParam<nlohmann::json> {};

TEST_P(RefusedScene, IsRefusedWithItsCodePlaceAndWord) {
  const nlohmann::json& refused = GetParam();
  const Folder folder;
  std::ofstream(folder / "scene.json") << refused.at("scene");
  const std::string command = "cd " + (folder / "").string() + " && " TANOR_PROGRAM " " +
                              refused.at("command").get<std::string>() + " scene.json > out 2> err";

  const int status = std::system(command.c_str());

  std::ostringstream said;
  said << std::ifstream(folder / "err").rdbuf();
  const std::string line = said.str();
  EXPECT_EQ(WEXITSTATUS(status), refused.at("exit").get<int>()) << line;
  EXPECT_EQ(std::count(line.begin(), line.end(), '\n'), 1) << line;
  EXPECT_NE(line.find(refused.at("must_say").get<std::string>()), std::string::npos) << line;
  if (refused.at("pointer").is_string()) {
    EXPECT_NE(line.find("scene.json: " + refused.at("pointer").get<std::string>() + ": "), std::string::npos) << line;
  }
  EXPECT_EQ(std::filesystem::file_size(folder / "out"), 0U);
}

INSTANTIATE_TEST_SUITE_P(Reference, RefusedScene, testing::ValuesIn(refused_scenes()), [](const auto& instance) {
  std::string name = instance.param.at("name").template get<std::string>();
  for (char& letter : name)
    if (std::isalnum(static_cast<unsigned char>(letter)) == 0) letter = '_';
  return name;
});

}  // namespace
}  // namespace tanor::cases

#endif
