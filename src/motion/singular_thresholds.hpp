#pragma once

/// \file All thresholds that decide how a motion meets singular configurations. "Singular configurations" in
/// docs/methods.md tells how they work together. sigma is the smallest singular value of K; the reciprocal condition of
/// S is its square.
namespace tanor::singular {

// Reciprocal conditions of S, over the largest one that was met on the way or that masses alone may bring about.

/// A zero of sigma is foreseen below this: sigma is then a tenth of a regular one, and goes like a straight line.
constexpr double near = 1e-2;
/// A configuration counts as singular below this. Nothing is evaluated nearer to one on purpose: from 1e-11 on rows may
/// count as dependent.
constexpr double reached = 1e-9;

/// A step came upon the configuration unforeseen if it left less than this part of the reciprocal condition.
constexpr double surprise = 1e-3;

// Lengths, in steps.

/// K says little to stages and ends of a step that come nearer than this.
constexpr double margin = 0.25;
/// After a rejected step a zero ahead matters from so far: steps that shrink on the way would never reach it.
constexpr double reach = 4.0;
/// Passages that are nearer to each other than this are one and the same.
constexpr double same = 0.1;

// Extrapolations past a singular configuration.

/// The error may be so many tolerances: it is of a lower order than its estimate.
constexpr double allowed_error = 10.0;
/// Where coming nearer lowers the error no further, the states determine no more than this: so many tolerances, or this
/// part of the velocity.
constexpr double most_missed = 100.0, most_missed_of_velocity = 1e-6;
/// The constraints may turn the velocity by this part of it, no more: beyond lies another branch.
constexpr double turn = 0.1;
/// So many approaches, each to half the distance, come down to the distance over 4096.
constexpr int most_approaches = 12;

}  // namespace tanor::singular
