#pragma once

#include <span>
#include <utility>
#include <vector>

#include <tanor/ranks.hpp>

#include "base/vec3.hpp"

namespace tanor::detail {

/// Vectors of points that ranks send each other.
class PointExchange {
 public:
  /// The list of points of the other rank of a link has the same order.
  PointExchange(Ranks& ranks, std::vector<Part::Link> links) : ranks_(ranks), links_(std::move(links)) {
    for (const Part::Link& link : links_) {
      Buffers& here = buffers_.emplace_back(
          Buffers{std::vector<double>(3 * link.sent.size()), std::vector<double>(3 * link.received.size())});
      messages_.push_back({link.rank, here.sent, here.received});
    }
  }

  PointExchange(const PointExchange&) = delete;
  PointExchange& operator=(const PointExchange&) = delete;

  /// Sends get(point) of the points sent, and calls put(point, vector) for those received. Collective.
  template <class Get, class Put>
  void fetch(const Get& get, const Put& put) {
    for (std::size_t l = 0; l < links_.size(); ++l)
      for (std::size_t k = 0; k < links_[l].sent.size(); ++k) store(buffers_[l].sent.data(), k, get(links_[l].sent[k]));
    ranks_.exchange(messages_);
    for (std::size_t l = 0; l < links_.size(); ++l)
      for (std::size_t k = 0; k < links_[l].received.size(); ++k)
        put(links_[l].received[k], load(buffers_[l].received.data(), k));
  }

 private:
  struct Buffers {
    std::vector<double> sent, received;
  };

  Ranks& ranks_;
  std::vector<Part::Link> links_;
  std::vector<Buffers> buffers_;
  std::vector<Ranks::Message> messages_;
};

}  // namespace tanor::detail
