#pragma once

/// \file
/// The lesser and the greater of two values. By value, not by reference as in the standard library:
/// loops of these become vectors.

namespace vasamesh {

inline float least(float a, float b) { return a < b ? a : b; }
inline float most(float a, float b) { return a > b ? a : b; }

}  // namespace vasamesh
