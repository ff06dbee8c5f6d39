#pragma once

/// \file All thresholds that decide how a motion meets singular configurations. "Singular configurations" in
/// docs/methods.md tells how they work together. sigma is the smallest singular value of K; the reciprocal condition of
/// S is its square.
namespace tanor::detail::singular {

// Reciprocal conditions of S, over the largest one that was met during the motion or that masses alone may cause.

/// A zero of sigma is foreseen below this. sigma is then a tenth of a regular one, and nearly linear in time.
constexpr double near = 1e-2;
/// A configuration counts as singular below this. Nothing is evaluated nearer to one on purpose, since rows may count
/// as dependent below 1e-11.
constexpr double reached = 1e-9;

/// A step met the configuration unforeseen if it left less than this part of the reciprocal condition.
constexpr double surprise = 1e-3;

/// Pieces in which a step is looked through for a sign that has changed. One piece is enough if the step is near all
/// the way.
constexpr int pieces_of_long_step = 8;

// Lengths, in steps.

/// K is unreliable for stages and ends of a step that come nearer than this.
constexpr double margin = 0.25;
/// After a rejected step a zero ahead matters up to this distance. Otherwise steps that shrink would never reach it.
constexpr double reach = 4.0;
/// Passages that are nearer to each other than this are the same.
constexpr double same = 0.1;

// Extrapolations past a singular configuration.

/// The error may be so many tolerances, since it is of a lower order than its estimate.
constexpr double allowed_error = 10.0;
/// If coming nearer lowers the error no further, the states determine no more than this: so many tolerances, or this
/// part of the velocity.
constexpr double most_missed = 100.0, most_missed_of_velocity = 1e-6;
/// The constraints may turn the velocity by at most this part of it. Beyond lies another branch.
constexpr double turn = 0.1;
/// Number of approaches, each to half the distance, which come down to the distance over 4096.
constexpr int most_approaches = 12;

}  // namespace tanor::detail::singular
