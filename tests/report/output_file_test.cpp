#include "report/output_file.hpp"

#include <gtest/gtest.h>

#include "report/reading.hpp"

namespace tanor::report {
namespace {

std::string error_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const WriteError& error) {
    return error.what();
  }
  return "no error";
}

TEST(OutputFileTest, FailuresNameTheFileAndTheReason) {
  EXPECT_EQ(error_of([] { OutputFile("/nowhere/x"); }), "cannot write /nowhere/x: No such file or directory");
  EXPECT_EQ(error_of([] { make_folder("/dev/null/x"); }), "cannot write /dev/null/x: Not a directory");
}

// /dev/full takes nothing: small texts fail when they are flushed or closed, large ones at once.
TEST(OutputFileTest, AFullDiskIsNoticed) {
  const std::string message = "cannot write /dev/full: No space left on device";
  EXPECT_EQ(error_of([] {
              OutputFile file("/dev/full");
              file.write("short");
              file.flush();
            }),
            message);
  EXPECT_EQ(error_of([] {
              OutputFile file("/dev/full");
              file.write("short");
              file.close();
            }),
            message);
  EXPECT_EQ(error_of([] { OutputFile("/dev/full").write(std::string(1 << 20, 'x')); }), message);
}

TEST(OutputFileTest, AReplacedFileIsTheOldOneUntilTheNewOneIsComplete) {
  const Folder folder;
  write_text(folder / "x", "old");

  EXPECT_THROW(replace_file(folder / "x",
                            [](OutputFile* file) {
                              file->write("half");
                              throw std::runtime_error("stopped here");
                            }),
               std::runtime_error);
  EXPECT_EQ(read_text(folder / "x"), "old");

  replace_file(folder / "x", [](OutputFile* file) { file->write("new"); });
  EXPECT_EQ(read_text(folder / "x"), "new");
  EXPECT_EQ(list_names(folder.path()), std::vector<std::string>{"x"});
}

}  // namespace
}  // namespace tanor::report
