#pragma once

#include <unistd.h>
#include <algorithm>

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <tanor/error.hpp>

/// Each target is one file with this function, which libFuzzer or `driver.cpp` calls with one input after another.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace tanor::fuzz {

inline std::string_view text_of(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

/// Does the work on an input. The input may be taken, or refused by an InputError of one line or by a length_error
/// where
/// it asks for more than this machine has. Any other exception ends the program.
template <class Work>
bool takes(const Work& work) {
  try {
    work();
    return true;
  } catch (const InputError& error) {
    const std::string_view what = error.what();
    if (what.empty() || what.find('\n') != std::string_view::npos) {
      std::fprintf(stderr, "the refusal is not one line: %s\n", error.what());
      std::abort();
    }
    return false;
  } catch (const std::length_error&) {
    return false;
  }
}

/// A good file has an input laid over it by exclusive or; bytes beyond its end are appended.
///
///     byte 0: which file; bit 7: its checksum stays wrong      bytes 1, 2: bytes cut off at the end
template <class Good>
struct Overlaid {
  Overlaid(const std::vector<Good>& files, const std::uint8_t* data, std::size_t size)
      : good(files[(data[0] & 0x7F) % files.size()]), mends_checksum(data[0] < 0x80), bytes(good.file) {
    const std::string_view input = text_of(data + head, size - head);
    const std::size_t common = std::min(bytes.size(), input.size());
    for (std::size_t k = 0; k < common; ++k) bytes[k] = static_cast<char>(bytes[k] ^ input[k]);
    bytes.append(input.substr(common));
    bytes.resize(bytes.size() - std::min<std::size_t>(bytes.size(), data[1] + 256u * data[2]));
  }

  static constexpr std::size_t head = 3;  ///< an input has so many bytes at least
  const Good& good;
  bool mends_checksum;
  std::string bytes;
};

/// A file for readers that open one; it is removed with the process.
class InputFile {
 public:
  explicit InputFile(const std::string& extension)
      : folder_(std::filesystem::temp_directory_path() / ("tanor-fuzz-" + std::to_string(getpid()))),
        path_(folder_ / ("input" + extension)) {
    std::filesystem::create_directories(folder_);
  }
  ~InputFile() { std::filesystem::remove_all(folder_); }
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path folder() const { return folder_; }
  void write(std::string_view bytes) const {
    std::ofstream(path_, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  }

 private:
  std::filesystem::path folder_, path_;
};

}  // namespace tanor::fuzz
