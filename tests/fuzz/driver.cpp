/// driver CORPUS MUTANTS SECONDS does in short what libFuzzer does, for builds without it.
///
/// Takes every file of the corpus as an input, then mutants of them: bits turned, numbers replaced, pieces removed,
/// moved, doubled, joined with those of another file, or repeated until they make a megabyte. The first ones, MUTANTS,
/// are the same in every run; it goes on with further ones until the SECONDS are over. An input that crashes, takes
/// more than ten seconds of the processor or more than a gigabyte ends the program and is left in `crash-<pid>`.

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include "target.hpp"

namespace {

namespace fs = std::filesystem;

constexpr unsigned most_seconds = 10;
constexpr std::size_t most_bytes = std::size_t{1} << 30, largest_input = 1 << 20;

std::string input;  // a handler of signals must find it

extern "C" void keep_input(int signal) {
  std::array<char, 32> name{};
  std::snprintf(name.data(), name.size(), "crash-%d", static_cast<int>(getpid()));
  const int file = open(name.data(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  if (file >= 0 && write(file, input.data(), input.size()) >= 0)
    std::fprintf(stderr, "the input is in %s\n", name.data());
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

/// Limits the processor time of the process, not wall-clock time, since others may keep the processor busy.
void limit_seconds(unsigned seconds) {
  itimerval limit{};
  limit.it_value.tv_sec = seconds;
  setitimer(ITIMER_PROF, &limit, nullptr);
}

/// Limits the memory beyond what the process has now. Sanitizers map all addresses, so that their builds have no limit.
void limit_memory() {
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  std::size_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  const rlim_t most = pages * static_cast<std::size_t>(sysconf(_SC_PAGESIZE)) + most_bytes;
  const rlimit limit{most, most};
  setrlimit(RLIMIT_AS, &limit);
#endif
}

std::vector<std::string> read_corpus(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::vector<std::string> corpus;
  for (const fs::path& file : files) {
    std::ifstream stream(file, std::ios::binary);
    corpus.emplace_back(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
  }
  return corpus;
}

/// Changes inputs at random.
class Mutator {
 public:
  explicit Mutator(const std::vector<std::string>& corpus) : corpus_(corpus) {}

  std::string next() {
    std::string mutant = corpus_[below(corpus_.size())];
    for (std::size_t count = 1 + below(4); count > 0; --count) change(&mutant);
    if (mutant.size() > largest_input) mutant.resize(largest_input);
    return mutant;
  }

 private:
  std::size_t below(std::size_t bound) { return bound == 0 ? 0 : random_() % bound; }

  void change(std::string* text) {
    const std::size_t begin = below(text->size() + 1),
                      length = below(std::min<std::size_t>(text->size() - begin, 32) + 1);
    switch (below(200) == 0 ? 7 : below(7)) {
      case 0:
        if (begin < text->size()) (*text)[begin] = static_cast<char>((*text)[begin] ^ (1 << below(8)));
        break;
      case 1:
        text->insert(begin, 1, static_cast<char>(below(256)));
        break;
      case 2:
        text->erase(begin, length);
        break;
      case 3:
        text->insert(below(text->size() + 1), std::string(*text, begin, length));
        break;
      case 4:
        text->replace(begin, length, odd_[below(odd_.size())]);
        break;
      case 5:
        replace_number(text, begin);
        break;
      case 6: {
        const std::string& other = corpus_[below(corpus_.size())];
        text->replace(begin, std::string::npos, other, below(other.size() + 1));
        break;
      }
      default:
        repeat(text, begin, length);
    }
  }
  /// Replaces the first number of a text from a position on.
  void replace_number(std::string* text, std::size_t from) {
    constexpr std::string_view digits = "0123456789.eE+-";
    const std::size_t begin = text->find_first_of("0123456789", from);
    if (begin == std::string::npos) return;
    text->replace(begin, std::min(text->find_first_not_of(digits, begin), text->size()) - begin,
                  odd_[below(odd_.size())]);
  }
  void repeat(std::string* text, std::size_t begin, std::size_t length) {
    const std::string piece(*text, begin, std::max<std::size_t>(length, 1));
    if (piece.empty()) return;
    std::string pieces;
    while (pieces.size() + piece.size() + text->size() < largest_input) pieces += piece;
    text->insert(begin, pieces);
  }

  const std::vector<std::string>& corpus_;
  std::minstd_rand random_{1};
  const std::vector<std::string> odd_{"0",          "-1",
                                      "1e308",      "-1e308",
                                      "1e-320",     "2147483647",
                                      "4294967296", "1e999",
                                      "nan",        "inf",
                                      "[",          "]",
                                      "{",          "}",
                                      "(",          "\"",
                                      ",",          "null",
                                      "\n",         "\xff",
                                      "all",        "0.5",
                                      "^",          "\"all\"",
                                      "\\u0000",    "9223372036854775807",
                                      "initial"};
};

void execute(const std::string& next) {
  input = next;
  limit_seconds(most_seconds);
  // The bytes are on the heap in their exact length, so that a sanitizer finds a read beyond them.
  const std::vector<std::uint8_t> bytes(input.begin(), input.end());
  LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
  limit_seconds(0);
}

}  // namespace

int main(int argc, char** argv) {
  using Clock = std::chrono::steady_clock;
  if (argc != 4) return 2;
  const std::vector<std::string> corpus = read_corpus(argv[1]);
  const int least = std::atoi(argv[2]);
  const auto end = Clock::now() + std::chrono::duration<double>(std::atof(argv[3]));
  if (corpus.empty() || least < 1) return 2;
  for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGPROF}) std::signal(signal, keep_input);
  limit_memory();
  for (const std::string& file : corpus) execute(file);
  Mutator mutator(corpus);
  int executions = 0;
  for (; executions < least || Clock::now() < end; ++executions) execute(mutator.next());
  std::printf("%zu files and %d mutants of them\n", corpus.size(), executions);
  return 0;
}
