#pragma once

#include <functional>
#include <string>
#include <vector>

#include <tanor/system.hpp>

struct BenchScene {
  std::string name;
  std::function<tanor::System()> make;
  double bar;     ///< wanted ratio baseline/ours on one thread; 0: none
  double listed;  ///< ns a rod or bead that the baseline may need (measured once, the upper end); 0: none
};

/// Returns chains, clusters, trees, small cycles and bodies, beads, nets and lattices, clusters beside a net, of 1e3 to
/// 1e6 rods.
const std::vector<BenchScene>& bench_scenes();

/// Makes the system of a generator of scene files. Points that it leaves at rest get waves across their flat
/// directions.
tanor::System make_generated(const std::string& generate);

/// Makes a chain of `count` beads as a random walk.
tanor::System make_random_walk(int count);
