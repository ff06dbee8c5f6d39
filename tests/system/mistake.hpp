#pragma once

/// \file The message of `validate` about a system with one mistake.

#include <ostream>
#include <string>

#include <gtest/gtest.h>
#include <tanor/system.hpp>

namespace tanor {

struct Mistake {
  const char* name;
  void (*make)(System&);
  const char* message;  ///< with its place

  friend std::ostream& operator<<(std::ostream& out, const Mistake& mistake) { return out << mistake.name; }
};

/// Expects the mistake to be named with its place in an otherwise valid system.
inline void expect_named_with_its_place(const Mistake& mistake, System system) {
  mistake.make(system);
  try {
    validate(system);
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_EQ(error.where() + ": " + error.what(), mistake.message);
  }
}

inline std::string name_of(const testing::TestParamInfo<Mistake>& instance) {
  return instance.param.name;
}

}  // namespace tanor
