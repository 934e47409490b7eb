#pragma once

/// \file
/// The numbers in the rules of mesh expanding, for all backends. Lengths are in edge lengths asked
/// for, unless a line says otherwise; angles in radians.

#include "types/angles.h"

namespace vasamesh::expand_rules {

// Triangles (stages/expand_checks.h).
inline constexpr float kLongestEdge = 1.75f;  // of a new edge
inline constexpr float kSameSheet = 0.2f;     // least cosine between normals of one sheet
inline constexpr float kFacing = 0.35f;       // least cosine of a triangle's normal and a corner's
inline constexpr float kSheetOffset = 0.6f;   // of the longest edge: farther off is another sheet
inline constexpr float kShrink = 0.06f;       // of the longest edge, off each side
inline constexpr float kAlongGradient = 0.45f;  // most cosine of an edge and the gradient

// Places (stages/expand_place.h).
inline constexpr int kPlaceSteps = 5;  // of Newton's
inline constexpr float kPlaceReach = 0.6f;

// Proposals (stages/expand_propose.h).
inline constexpr float kPart = kPi / 3;    // the angle that a corner is divided into
inline constexpr float kEarAngle = 1.75f;  // up to here a corner's edges are joined
inline constexpr float kNarrow =
    1 / 3.0f;                             // of the longest edge: nearer to the boundary is too near
inline constexpr float kCovered = 0.55f;  // from an inner vertex
inline constexpr float kSearch = 2.6f;    // in which boundary edges matter
inline constexpr float kFanTau = 0.6f;    // least of a fan's triangles
inline constexpr float kSmaller = 0.9f, kLarger = 1.12f;  // a new edge over its neighbours, at most
inline constexpr float kSpareAngle = 0.05f;  // that triangles may take beyond what is open
inline constexpr float kGapTau = 0.6f;       // of the least tau: of a triangle in a loop of three
inline constexpr float kWiderJoin = 1.6f;    // of the join's reach: where a fan finds no room

// Claims (stages/expand_steps.h).
inline constexpr float kClaim = 1.25f;  // that a corner claims round itself
inline constexpr float kWideClaim = 2.9f;

}  // namespace vasamesh::expand_rules
