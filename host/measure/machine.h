#pragma once

/// \file
/// What this machine's processor can do at best: the measure of each stage's floor. Seconds are
/// processor time.

namespace vasamesh {

/// Bytes a second that `threads` threads move in a = b + 3 c over arrays that no cache holds
/// (McCalpin's triad, 1995): 12 bytes an element, a write counted once.
double measure_bandwidth(int threads);

/// float32 additions and multiplications a second of `threads` threads, without fma.
double measure_arithmetic(int threads);

}  // namespace vasamesh
