#include <bit>
#include <ostream>

#include <gtest/gtest.h>

#include "motion/scenes.hpp"

namespace tanor {
namespace {

/// FNV-1a over the bytes of numbers.
class Hash {
 public:
  void add(double x) {
    auto bits = std::bit_cast<std::uint64_t>(x);
    for (int byte = 0; byte < 8; ++byte, bits >>= 8) state_ = (state_ ^ (bits & 0xff)) * 0x100000001b3;
  }
  void add(std::span<const double> array) {
    for (const double x : array) add(x);
  }
  std::uint64_t value() const { return state_; }

 private:
  std::uint64_t state_ = 0xcbf29ce484222325;
};

struct BigScene {
  std::string name;
  System (*build)();
  const char* factorization;

  friend std::ostream& operator<<(std::ostream& out, const BigScene& scene) { return out << scene.name; }
};

// Big enough for loops in two ranges.
const BigScene big_scenes[]{
    {"chain_of_20000", [] { return scenes::make_chain(20'000); }, "paths"},
    {"net_60x60", [] { return scenes::make_net(60, 60); }, "simplicial"},
    {"clusters_of_200", [] { return scenes::make_clusters(200); }, "bundles"},
    {"lattice_11x11x11", [] { return scenes::make_lattice(11); }, "multifrontal"},
    {"melt_of_8000", [] { return scenes::make_melt(20); }, "bundles"},
    {"beads_of_6000", [] { return scenes::make_beads(1'500); }, "closed form"},
};

class ThreadsTest : public testing::TestWithParam<std::tuple<BigScene, Method>> {
 protected:
  /// Of all that 20 steps leave behind.
  static std::uint64_t hash_steps(int threads) {
    const auto& [scene, method] = GetParam();
    MotionOptions options{.method = method, .rtol = 1e-6, .atol = 1e-8, .start = StartMode::Project};
    if (method != Method::Dopri5) options.step = 1e-3;
    Simulation simulation(scene.build(), options, {.threads = threads});
    EXPECT_EQ(simulation.plan().factorization, scene.factorization);

    const Outcome outcome = simulation.advance(1.0, scenes::stop_after(20));

    EXPECT_TRUE(outcome.ok()) << outcome.what;
    EXPECT_EQ(simulation.report().steps, 20u);
    Hash hash;
    hash.add(simulation.time());
    hash.add(simulation.positions());
    hash.add(simulation.velocities());
    hash.add(simulation.accelerations());
    hash.add(simulation.multipliers());
    hash.add(simulation.reactions());
    hash.add(simulation.report().energy.now);
    hash.add(simulation.report().energy.work_of_forces);
    return hash.value();
  }
};

TEST_P(ThreadsTest, OneAndTwoThreadsGiveTheSameBits) {
  const std::uint64_t one = hash_steps(1);
  const std::uint64_t two = hash_steps(2);

  EXPECT_EQ(one, two);
}

INSTANTIATE_TEST_SUITE_P(BigScenes, ThreadsTest,
                         testing::Combine(testing::ValuesIn(big_scenes),
                                          testing::Values(Method::Rk4, Method::Dopri5, Method::Rattle)),
                         [](const auto& instance) {
                           return std::get<0>(instance.param).name + "_" +
                                  std::string(method_name(std::get<1>(instance.param)));
                         });

}  // namespace
}  // namespace tanor
