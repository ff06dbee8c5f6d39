#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace tanor::scene {

/// An array of doubles in NumPy's file format.
struct NpyArray {
  std::vector<std::size_t> shape;
  std::vector<double> numbers;  ///< C order: the last index runs fastest
};

/// Takes one array ('<f8', C order) from the front of `bytes`; other arrays may follow. Throws InputError with `name`
/// in its `where()`.
NpyArray read_npy(const std::string& name, std::string_view* bytes);

}  // namespace tanor::scene
