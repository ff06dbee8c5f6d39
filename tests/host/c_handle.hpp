#pragma once

#include <gtest/gtest.h>
#include <tanor.h>

#include <cstdint>
#include <memory>
#include <vector>

#include <tanor/constrainer.hpp>

/// \file A handle of <tanor.h> and the Constrainer that it stands for.
namespace tanor::host {

struct Destroy {
  void operator()(tn_system* system) const { tn_destroy(system); }
};
using Handle = std::unique_ptr<tn_system, Destroy>;

/// A triangle with a tail.
struct Tailed {
  std::vector<double> masses{1.0, 2.0, 0.5, 1.5};
  std::vector<double> r{0, 0, 0, 1, 0.2, 0.1, 0.4, 0.9, -0.2, 0.5, 1.8, 0.3};
  std::vector<double> v{0.1, 0.3, -0.2, 0.4, -0.1, 0.6, 0.2, 0.8, -0.5, 0.3, 0.1, 0.7};
  std::vector<std::int32_t> pairs{0, 1, 1, 2, 0, 2, 2, 3};

  Handle make_handle(const tn_options* options = nullptr) const {
    tn_system* system = nullptr;
    EXPECT_EQ(tn_create(&system, 4, masses.data(), {r.data(), 0, nullptr}, options), TN_OK) << tn_create_error();
    EXPECT_EQ(tn_add_rods(system, 4, pairs.data(), nullptr, nullptr, nullptr), TN_OK) << tn_last_error(system);
    return Handle(system);
  }
  Constrainer make_constrainer() const {
    Rods rods;
    for (std::size_t k = 0; k < 4; ++k) rods.pairs.push_back({pairs[2 * k], pairs[2 * k + 1]});
    return {masses, {rods}, r};
  }
};

}  // namespace tanor::host
