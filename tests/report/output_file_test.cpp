#include "report/output_file.hpp"

#include <sys/resource.h>

#include <csignal>

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

// The device /dev/full takes nothing: small texts fail when they are flushed or closed, large ones at once.
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

TEST(GrowingFileTest, HasTheTailBehindEveryPart) {
  const Folder folder;
  GrowingFile file(folder / "x", "<list>\n", "</list>\n");
  EXPECT_EQ(read_text(folder / "x"), "<list>\n</list>\n");

  file.append("one\n");
  file.append("two\n");
  EXPECT_EQ(read_text(folder / "x"), "<list>\none\ntwo\n</list>\n");
  EXPECT_EQ(file.body_size(), 15u);

  file.cut(11);
  EXPECT_EQ(read_text(folder / "x"), "<list>\none\n</list>\n");
  GrowingFile(folder / "x", 7, "</list>\n").append("three\n");
  EXPECT_EQ(read_text(folder / "x"), "<list>\nthree\n</list>\n");
}

/// No file of this process may grow beyond some bytes while the object lives.
class FileLimit {
 public:
  explicit FileLimit(std::size_t bytes) {
    getrlimit(RLIMIT_FSIZE, &before_);
    handler_ = std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileLimit() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  FileLimit(const FileLimit&) = delete;
  FileLimit& operator=(const FileLimit&) = delete;

 private:
  rlimit before_{};
  void (*handler_)(int) = SIG_DFL;
};

// A disk is full in the middle of a part, or of the tail behind it, and has room again later.
TEST(GrowingFileTest, APartThatDoesNotFitIsNotInTheFile) {
  for (std::size_t limit = 20; limit < 30; ++limit) {
    const Folder folder;
    GrowingFile file(folder / "x", "begin\n", "the end\n");
    file.append("kept\n");
    const std::string before = read_text(folder / "x");
    {
      const FileLimit full(limit);
      EXPECT_EQ(error_of([&] { file.append("it is too long\n"); }),
                "cannot write " + (folder / "x").string() + ": File too large");
    }
    EXPECT_EQ(read_text(folder / "x"), before) << limit;
    EXPECT_EQ(file.body_size(), 11u);

    file.append("it is too long\n");
    EXPECT_EQ(read_text(folder / "x"), "begin\nkept\nit is too long\nthe end\n");
  }
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
