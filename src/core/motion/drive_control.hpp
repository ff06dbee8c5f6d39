#pragma once

#include <string>

#include "motion/scheme.hpp"

namespace tanor::detail {

/// Keeps steps from passing over what functions of time do inside them, and tells what fixed steps passed over.
///
/// Functions are sampled with a spacing of 1/4096 of the advance, or of the time since the motion began if that is
/// longer, so that many short advances cost little more than a long one. An interval in which they follow one
/// polynomial of degree 20 hides nothing from steps of order p that are shorter than p/20 of it, so that one look
/// serves many steps.
class DriveControl {
 public:
  DriveControl(const IntegrationOptions& options, const Scheme& scheme, Mechanics& mechanics);

  /// Takes note that another scheme makes the steps from now on.
  void follow(const Scheme& scheme);
  /// Takes note that a motion begins at t.
  void begin(double t);
  /// Exchanges what the next step depends on besides the state.
  void exchange_memory(Memory& memory) {
    memory.exchange(begin_, seen_until_, longest_seen_, length_, next_length_, pieces_, spacing_, end_);
  }
  /// Takes note that an advance begins at t.
  void advance(double t, double t_end);

  /// Returns the longest step from this state, at most h, whose scheme sees all that functions of time do, within its
  /// tolerance. The search stops at steps shorter than `shortest`. A fixed step keeps its length.
  double shorten(const State& from, double h, double shortest);
  /// Returns the number of pieces of the step looked at last in each of which forces are nearly linear in time.
  int pieces() const { return step_pieces_; }

  /// Takes note that a fixed step of length h from there was accepted.
  void note(const State& from, double h);
  /// Returns what fixed steps passed over so far, m/s; `describe` says where most of it was, for all processes.
  double missed() const { return missed_; }
  std::string describe();

 private:
  void look(const State& from, double h, int degree);
  bool has_seen(const State& from, double h);
  /// Returns true if a step follows what the last look saw.
  bool sees() const { return is_fixed_ ? report_.velocity == 0.0 : report_.error <= 1.0; }
  bool look_ahead(const State& from, double h);
  void remember(const State& from, double length, double longest_step);
  void set_pieces(double h);

  IntegrationOptions options_;
  Mechanics& mechanics_;
  DriveMonitor* const monitor_;  // null if no function of time acts
  int degree_ = 2;
  bool is_fixed_ = false;
  double begin_ = 0.0, end_ = 0.0, spacing_ = 0.0;
  // The last look: where it ends, the longest step that it serves, its length, the length of the next look, its pieces.
  double seen_until_ = 0.0, longest_seen_ = 0.0, length_ = 0.0, next_length_ = 0.0, pieces_ = 1.0;
  int step_pieces_ = 1;
  DriveReport report_;   // result of the last look
  bool is_here_ = true;  // the function looked at last is of this process
  double missed_ = 0.0, most_ = 0.0;
  struct {
    double begin = 0.0, length = 0.0;  // s
    std::size_t drive = 0;
    bool is_here = true;
  } worst_;  // the fixed step that passed over most
};

}  // namespace tanor::detail
