#include "opencl/constants.h"

#include <array>
#include <cstdio>

#include "stages/candidate_pairs.h"
#include "stages/expand_rules.h"
#include "stages/fan_moves.h"
#include "stages/far_offsets.h"
#include "stages/gradient_table.h"
#include "stages/jacobi.h"
#include "stages/normals.h"
#include "stages/patch_rules.h"
#include "stages/places.h"
#include "stages/sizing.h"
#include "types/front.h"
#include "types/lattice.h"
#include "types/volume.h"

namespace vasamesh {

namespace {

std::string define(const char* name, int value) {
  return std::string(" -D") + name + "=" + std::to_string(value);
}

/// To the last bit, in hexadecimal.
std::string define(const char* name, float value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%af", static_cast<double>(value));
  return std::string(" -D") + name + "=" + text.data();
}

std::string expand_constants() {
  using namespace expand_rules;
  return define("EXPAND_PI", kPi) + define("EXPAND_BLOCK", kCornerBlock) +
         define("EXPAND_MOST_VERTICES", kMostNewVertices) +
         define("EXPAND_LONGEST_EDGE", kLongestEdge) +
         define("EXPAND_SAME_SHEET", expand_rules::kSameSheet) + define("EXPAND_FACING", kFacing) +
         define("EXPAND_SHEET_OFFSET", kSheetOffset) + define("EXPAND_SHRINK", kShrink) +
         define("EXPAND_ALONG_GRADIENT", kAlongGradient) +
         define("EXPAND_PLACE_STEPS", kPlaceSteps) + define("EXPAND_PLACE_REACH", kPlaceReach) +
         define("EXPAND_PART", kPart) + define("EXPAND_EAR_ANGLE", kEarAngle) +
         define("EXPAND_NARROW", kNarrow) + define("EXPAND_COVERED", kCovered) +
         define("EXPAND_SEARCH", kSearch) + define("EXPAND_FAN_TAU", kFanTau) +
         define("EXPAND_SMALLER", kSmaller) + define("EXPAND_LARGER", kLarger) +
         define("EXPAND_SPARE_ANGLE", kSpareAngle) + define("EXPAND_GAP_TAU", kGapTau) +
         define("EXPAND_WIDER_JOIN", kWiderJoin) + define("EXPAND_CLAIM", kClaim) +
         define("EXPAND_WIDE_CLAIM", kWideClaim);
}

}  // namespace

std::string kernel_constants() {
  return define("THIN_PAD", kPad) + define("LATTICE_LABEL", kLabel) +
         define("LATTICE_SOLID", kSolid) + define("LATTICE_FREE", kFree) +
         define("LATTICE_FACE_CENTRE", kFaceCentre) + define("LATTICE_FAR_MARK", kFarMark) +
         define("LATTICE_STUCK_MARK", kStuckMark) + define("RELABEL_BLOCK", kNodeBlock) +
         define("RELABEL_LEAST_OCCUPANCY", kLeastOccupancy) + define("FAR_ENOUGH", kFarEnough) +
         define("NORMALS_REACH", kNeighbourReach) + define("NORMALS_SAME_SHEET", kSameSheet) +
         define("NORMALS_TANGENT_WEIGHT", kTangentWeight) +
         define("NORMALS_NO_GRADIENT", kNoGradient) +
         define("NORMALS_AGAINST_FACES", kAgainstFaces) + define("NORMALS_SPAN", kMaxGradientSpan) +
         define("NORMALS_FRACTIONS", kFractions) + define("NORMALS_SWEEPS", kJacobiSweeps) +
         define("SIZING_REACH", kSampleReach) + define("SIZING_STEPS", kSampleSteps) +
         define("SIZING_LARGEST_RADIUS", kLargestRadius) + define("RELAX_SINE25", kSine25) +
         define("RELAX_SINE40", kSine40) + define("RELAX_LEAST_FACING", kLeastFacing) +
         define("RELAX_LENGTH_FACTOR", RemeshGoal::kLengthFactor) +
         define("RELAX_LEAST_SLOPE", kLeastSlope) +
         define("RELAX_LEAST_AGREEMENT", kLeastAgreement) +
         define("RELAX_STEPS", kProjectionSteps) +
         define("RELAX_SMOOTHING_REACH", kSmoothingReach) +
         define("RELAX_EQUALISING_REACH", kEqualisingReach) + define("RELAX_GAP_REACH", kGapReach) +
         define("RELAX_GAP_STEPS", kGapSteps) + define("RELAX_LARGEST_STEP", kLargestStep) +
         define("RELAX_ENOUGH_EQUALITY", kEnoughEquality) +
         define("RELAX_PLACE_INVERSE_SIDE", Places::kInverseSide) +
         define("VERIFY_DOT_ERROR", kDotError) +
         define("VERIFY_DETERMINANT_ERROR", kDeterminantError) +
         define("VERIFY_CROSS_DOT_ERROR", kCrossDotError) +
         define("VERIFY_LEAST_EXTENT", kLeastExtent) + define("VERIFY_MOST_EXTENT", kMostExtent) +
         expand_constants();
}

}  // namespace vasamesh
