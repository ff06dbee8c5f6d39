#pragma once

#include <string>

#include "motion/scheme.hpp"

namespace tanor {

/// Keeps steps from passing over what functions of time do inside them, and tells what fixed steps passed over.
///
/// Functions are looked at with a spacing of 1/4096 of the advance, or of the time since the motion began where that is
/// longer: many short advances cost little more than a long one. A stretch of time in which they go as one polynomial
/// of degree 20 hides nothing from steps of order p that are shorter than p/20 of it: one look serves many steps.
class DriveControl {
 public:
  DriveControl(const IntegrationOptions& options, const Scheme& scheme, Mechanics& mechanics);

  /// Steps are made by another scheme from now on.
  void follow(const Scheme& scheme);
  /// A motion begins at t.
  void begin(double t);
  /// What the next step depends on beside the state.
  void exchange_memory(Memory& memory) {
    memory.exchange(begin_, seen_until_, longest_seen_, length_, next_length_, pieces_, spacing_, end_);
  }
  /// An advance begins at t.
  void advance(double t, double t_end);

  /// The longest step from this state, at most h, whose scheme sees all that functions of time do, within its
  /// tolerance. One that is shorter than `shortest` is not asked for.
  double shorten(const State& from, double h, double shortest);
  /// Looks at a fixed step, which is as long as it was told to be.
  void watch(const State& from, double h);
  /// Number of pieces, of the step that was asked for last, in each of which forces go nearly straight.
  int pieces() const { return step_pieces_; }

  /// A fixed step of length h from there was accepted.
  void note(const State& from, double h);
  /// What fixed steps passed over so far, m/s, and in words where most of it was.
  double missed() const { return missed_; }
  std::string describe() const;

 private:
  void look(const State& from, double h, int degree);
  bool has_seen(const State& from, double h);
  template <class Sees>
  bool look_ahead(const State& from, double h, const Sees& sees);
  void remember(const State& from, double length, double longest_step);
  void set_pieces(double h);

  IntegrationOptions options_;
  DriveMonitor* const monitor_;  // null: no function of time acts
  int degree_ = 2;
  double begin_ = 0.0, end_ = 0.0, spacing_ = 0.0;
  // Of the last look: where it ends, the longest step that it serves, how long it was, the next one shall be; its
  // pieces.
  double seen_until_ = 0.0, longest_seen_ = 0.0, length_ = 0.0, next_length_ = 0.0, pieces_ = 1.0;
  int step_pieces_ = 1;
  DriveReport report_;  // of the last look
  double missed_ = 0.0, most_ = 0.0, worst_begin_ = 0.0, worst_length_ = 0.0;
  std::size_t worst_drive_ = 0;
};

}  // namespace tanor
