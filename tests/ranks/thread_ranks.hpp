#pragma once

#include <barrier>
#include <exception>
#include <functional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include <tanor/ranks.hpp>

namespace tanor {

/// Ranks that are threads of one process and exchange numbers through memory.
class ThreadWorld {
 public:
  explicit ThreadWorld(int size)
      : size_(size), barrier_(size), numbers_(slots()), texts_(slots()), messages_(slots()) {}

  class Rank final : public Ranks {
   public:
    Rank(ThreadWorld& world, int rank) : world_(world), rank_(rank) {}

    int rank() const override { return rank_; }
    int size() const override { return world_.size_; }
    void sum(std::span<double> numbers) override {
      world_.combine(rank_, numbers, [](double a, double b) { return a + b; });
    }
    void find_largest(std::span<double> numbers) override {
      world_.combine(rank_, numbers, [](double a, double b) { return std::max(a, b); });
    }
    void share(int from, std::string* text) override {
      world_.texts_[static_cast<std::size_t>(rank_)] = text;
      world_.barrier_.arrive_and_wait();
      const std::string shared = *world_.texts_[static_cast<std::size_t>(from)];
      world_.barrier_.arrive_and_wait();
      *text = shared;
    }
    void exchange(std::span<const Message> messages) override {
      world_.messages_[static_cast<std::size_t>(rank_)] = messages;
      world_.barrier_.arrive_and_wait();
      for (const Message& own : messages) {
        for (const Message& other : world_.messages_[static_cast<std::size_t>(own.rank)])
          if (other.rank == rank_) std::ranges::copy(other.sent, own.received.begin());
      }
      world_.barrier_.arrive_and_wait();
    }

   private:
    ThreadWorld& world_;
    int rank_;
  };

  /// Runs body(rank) on each rank and rethrows the exception of the lowest rank that failed.
  void run(const std::function<void(Ranks&)>& body) {
    std::vector<std::exception_ptr> failures(slots());
    std::vector<std::thread> threads;
    for (int rank = 0; rank < size_; ++rank) {
      threads.emplace_back([&, rank] {
        Rank own(*this, rank);
        try {
          body(own);
        } catch (...) {
          failures[static_cast<std::size_t>(rank)] = std::current_exception();
          barrier_.arrive_and_drop();
        }
      });
    }
    for (std::thread& thread : threads) thread.join();
    for (const std::exception_ptr& failure : failures)
      if (failure) std::rethrow_exception(failure);
  }

 private:
  std::size_t slots() const { return static_cast<std::size_t>(size_); }

  template <class Combine>
  void combine(int rank, std::span<double> numbers, const Combine& combine) {
    numbers_[static_cast<std::size_t>(rank)] = numbers;
    barrier_.arrive_and_wait();
    std::vector<double> result(numbers_[0].begin(), numbers_[0].end());
    for (std::size_t other = 1; other < slots(); ++other)
      for (std::size_t k = 0; k < result.size(); ++k) result[k] = combine(result[k], numbers_[other][k]);
    barrier_.arrive_and_wait();
    std::ranges::copy(result, numbers.begin());
  }

  int size_;
  std::barrier<> barrier_;
  std::vector<std::span<double>> numbers_;
  std::vector<std::string*> texts_;
  std::vector<std::span<const Ranks::Message>> messages_;
};

}  // namespace tanor
