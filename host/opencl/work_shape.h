#pragma once

/// \file
/// How kernels are cut into work-items.

namespace vasamesh {

/// Of one kind of device: macros of kernels/common.cl. The results are the same for all.
struct WorkShape {
  int brick_items, scan_items, scan_run, fold_items, reduce_items;

  int scan_block() const { return scan_items * scan_run; }
  bool operator==(const WorkShape&) const = default;
};
inline constexpr WorkShape kOneItemShape{1, 1, 16384, 64, 1};
inline constexpr WorkShape kWorkGroupShape{64, 128, 8, 64, 128};

}  // namespace vasamesh
