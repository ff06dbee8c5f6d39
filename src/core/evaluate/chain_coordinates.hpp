#pragma once

#include "evaluate/charts.hpp"
#include "evaluate/coordinate_family.hpp"
#include "kinds/tables.hpp"

namespace tanor::detail {

/// Coordinates of chains on a support, r_k = r_{k-1} + l_k u_k, where r_0 is the support. A link has two coordinates (a
/// chart of its direction) or one (its angle in a plane). Each has one block, l du/dq, which is the same for all points
/// after the link.
class ChainCoordinates final : public CoordinateFamily {
 public:
  using Group = ChainAngles;

  struct Chain {
    Index anchor;  // inner
    Index first_link, end_link;
    bool is_planar;
    Vec3 e1, e2;             // unit vectors of the plane
    Index first_coordinate;  // counted from the family's first
    Index links() const { return end_link - first_link; }
    Index per_link() const { return is_planar ? 1 : 2; }
  };
  std::vector<Chain> chains;
  std::vector<Index> points;          ///< [link] its outer end, inner
  std::vector<DirectionChart> chart;  ///< [link]; unused if planar
  ScalarTable length;                 ///< [link] m

  static bool takes(const ChainAngles&) { return true; }
  void add(const ChainAngles& group, const CoordinateStart& start) {
    if (group.points.empty()) return;
    const Vec3 normal = make_vec3(group.normal);
    const auto first_link = static_cast<Index>(points.size());
    Chain chain{start.inner(group.anchor), first_link, first_link + static_cast<Index>(group.points.size()),
                dot(normal, normal) > 0.0, {},         {},
                num_coordinates()};
    if (chain.is_planar) {
      const Vec3 n = (1.0 / norm(normal)) * normal;
      chain.e1 = any_orthogonal(n);
      chain.e2 = cross(n, chain.e1);
    }
    Vec3 before = start.place(group.anchor);
    for (std::size_t k = 0; k < group.points.size(); ++k) {
      const Vec3 place = start.place(group.points[k]);
      points.push_back(start.inner(group.points[k]));
      chart.emplace_back();
      length.append_member(length.add(number_of(group.length, k, norm(place - before))));
      before = place;
    }
    chains.push_back(chain);
  }

  std::size_t size() const override { return chains.size(); }
  Index num_coordinates() const override {
    return chains.empty() ? 0 : chains.back().first_coordinate + chains.back().links() * chains.back().per_link();
  }
  Index num_blocks() const override { return num_coordinates(); }
  Index first_coordinate_of(std::size_t k) const override { return first_coordinate + chains[k].first_coordinate; }
  bool depends_on_time() const override { return !length.is_constant(); }
  void set_time(double t) override { length.set_time(t); }

  void evaluate(const Parallel& parallel, const double* q, const double* q_dot, double* r, double* v, double* psi,
                double* blocks) const override {
    for_chains(parallel, [&](const Chain& chain) {
      Vec3 place = load(r, chain.anchor), rate{}, second{};
      if (v != nullptr) rate = load(v, chain.anchor);
      if (psi != nullptr) second = load(psi, chain.anchor);
      for (Index link = chain.first_link; link < chain.end_link; ++link) {
        const MovingScalar& l = length[static_cast<std::size_t>(link)];
        const Index own = coordinate(chain, link);
        const DirectionChart::Value u = direction(chain, link, q + own, q_dot + own);
        place = place + l.value * u.u;
        rate = rate + l.first * u.u + l.value * u.first;
        second = second + l.second * u.u + 2.0 * l.first * u.first + l.value * u.second;
        store(r, points[link], place);
        if (v != nullptr) store(v, points[link], rate);
        if (psi != nullptr) store(psi, points[link], second);
        if (blocks == nullptr) continue;
        for (Index j = 0; j < chain.per_link(); ++j) store(blocks, block(own) + j, l.value * u.tangent[j]);
      }
    });
  }

  void apply(const Parallel& parallel, const double* blocks, const double* x, double* y) const override {
    for_chains(parallel, [&](const Chain& chain) {
      Vec3 sum{};
      for (Index link = chain.first_link; link < chain.end_link; ++link) {
        const Index own = coordinate(chain, link);
        for (Index j = 0; j < chain.per_link(); ++j) sum = sum + x[own + j] * load(blocks, block(own) + j);
        store(y, points[link], sum);
      }
    });
  }

  void apply_transposed(const Parallel& parallel, const double* blocks, const double* y, double* x) const override {
    for_chains(parallel, [&](const Chain& chain) {
      Vec3 sum{};  // over all points from this link on
      for (Index link = chain.end_link; link-- > chain.first_link;) {
        const Index own = coordinate(chain, link);
        sum = sum + load(y, points[link]);
        for (Index j = 0; j < chain.per_link(); ++j) x[own + j] = dot(load(blocks, block(own) + j), sum);
      }
    });
  }

  void add_support_reactions(double* eta) const override {
    for (const Chain& chain : chains) {
      Vec3 sum{};
      for (Index link = chain.first_link; link < chain.end_link; ++link) sum = sum + load(eta, points[link]);
      add_to(eta, chain.anchor, -sum);
    }
  }

  /// Links i >= j share the points from i on, so weight(i, j) is the sum of the weights of these points.
  void append_products(const std::vector<double>& weights, std::vector<Product>* products) const override {
    std::vector<double> tail(points.size());
    for (const Chain& chain : chains) {
      double sum = 0.0;
      for (Index link = chain.end_link; link-- > chain.first_link;) {
        sum += weights[static_cast<std::size_t>(points[link])];
        tail[link] = sum;
      }
      const Index first = first_coordinate + chain.first_coordinate;
      for (Index i = first; i < first + chain.links() * chain.per_link(); ++i) {
        const double weight = tail[chain.first_link + (i - first) / chain.per_link()];
        for (Index j = first; j <= i; ++j) products->push_back({i, j, block(i), block(j), weight});
      }
    }
  }

  void locate(const double* r, double* q) override {
    for (const Chain& chain : chains) {
      Vec3 before = load(r, chain.anchor);
      for (Index link = chain.first_link; link < chain.end_link; ++link) {
        const Vec3 a = load(r, points[link]) - before;
        double* const own = q + coordinate(chain, link);
        if (chain.is_planar) {
          *own = std::atan2(dot(chain.e2, a), dot(chain.e1, a));
        } else {
          chart[link] = DirectionChart((1.0 / norm(a)) * a);
          own[0] = own[1] = 0.0;
        }
        before = load(r, points[link]);
      }
    }
  }

  bool has_charts() const override {
    return std::ranges::any_of(chains, [](const Chain& chain) { return !chain.is_planar; });
  }
  void exchange_memory(Memory& memory) override {
    for (auto& each : chart) each.exchange_memory(memory);
  }
  void recentre(double, double* q, double* q_dot, double* q_ddot) override {
    for (const Chain& chain : chains) {
      if (chain.is_planar) continue;
      for (Index link = chain.first_link; link < chain.end_link; ++link) {
        const Index own = coordinate(chain, link);
        chart[link].recentre(q + own, q_dot + own, q_ddot + own);
      }
    }
  }

 private:
  Index coordinate(const Chain& chain, Index link) const {
    return first_coordinate + chain.first_coordinate + (link - chain.first_link) * chain.per_link();
  }
  Index block(Index coordinate) const { return first_block + coordinate - first_coordinate; }

  DirectionChart::Value direction(const Chain& chain, Index link, const double* q, const double* q_dot) const {
    if (!chain.is_planar) return chart[link](q, q_dot);
    const double c = std::cos(*q), s = std::sin(*q);
    const Vec3 u = c * chain.e1 + s * chain.e2, t = c * chain.e2 - s * chain.e1;
    return {u, *q_dot * t, -(*q_dot * *q_dot) * u, {t, {}}};
  }

  template <class Body>
  void for_chains(const Parallel& parallel, const Body& body) const {
    for_members(parallel, points.size(), [&](std::size_t k) { body(chains[k]); });
  }
};

}  // namespace tanor::detail
