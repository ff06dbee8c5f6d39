#include "ranks/guests.hpp"

#include "base/vec3.hpp"

namespace tanor::detail {

Guests::Guests(const Part& part, const Numbering& numbering) : ranks_(*part.ranks) {
  for (const Part::Link& given : part.links) {
    Link& link = links_.emplace_back(Link{given.rank, {}, {}, {}, {}});
    const auto number = [&](std::span<const Index> points, std::vector<Index>* inner, std::vector<double>* numbers) {
      for (const Index point : points) inner->push_back(numbering.inner_point[static_cast<std::size_t>(point)]);
      numbers->resize(3 * points.size());
    };
    number(given.sent, &link.sent_points, &link.sent);
    number(given.received, &link.received_points, &link.received);
  }
  for (Link& link : links_) messages_.push_back({link.rank, link.sent, link.received});
}

void Guests::fetch(double* points) {
  for (Link& link : links_) {
    for (std::size_t k = 0; k < link.sent_points.size(); ++k)
      store(link.sent.data(), k, load(points, link.sent_points[k]));
  }
  ranks_.exchange(messages_);
  for (const Link& link : links_) {
    for (std::size_t k = 0; k < link.received_points.size(); ++k)
      store(points, static_cast<std::size_t>(link.received_points[k]), load(link.received.data(), k));
  }
}

void Guests::add(const double* x, double* y) const {
  for_each([&](std::size_t guest) { store(y, guest, load(y, guest) + load(x, guest)); });
}

void Guests::clear(double* points) const {
  for_each([&](std::size_t guest) { store(points, guest, Vec3{}); });
}

}  // namespace tanor::detail
