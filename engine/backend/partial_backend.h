#pragma once

/// \file
/// A base for backends that offer some stages alone: every pass that such a backend leaves out
/// throws. The scheduler asks offers() first, so that a throw is our own fault.

#include "backend/backend.h"
#include "vasamesh/errors.h"

namespace vasamesh {

class PartialBackend : public Backend {
 public:
  /// In order, on the calling thread.
  void run(std::size_t tasks, const std::function<void(std::size_t)>& task) override {
    for (std::size_t i = 0; i < tasks; ++i) task(i);
  }

  void volume_pack(const VolumeView&, const std::array<int, 3>&, int,
                   View<std::uint64_t>) override {
    missing("volume_pack");
  }
  void points_thin_mask(const BitView&, View<std::uint64_t>, View<std::uint64_t>) override {
    missing("points_thin_mask");
  }
  void points_mark_bricks(const BitView&, View<std::uint8_t>) override {
    missing("points_mark_bricks");
  }
  void points_count(const BitView&, const BitView&, const BrickView&, View<std::uint32_t>,
                    View<std::uint32_t>) override {
    missing("points_count");
  }
  void points_emit(const BitView&, const BitView&, const BitView&, const BrickView&,
                   View<const std::uint32_t>, const Scale&, const PointOutput&) override {
    missing("points_emit");
  }

  void normals_gradient(const BitView&, const PointView&, const Scale&, float,
                        std::array<View<float>, 3>) override {
    missing("normals_gradient");
  }
  void normals_covariance(const PointView&, const BrickView&, View<const std::uint32_t>,
                          const Scale&, int, std::array<View<const float>, 3>,
                          std::array<View<float>, 3>) override {
    missing("normals_covariance");
  }

  void poisson_apply(const LevelView&, View<const std::uint8_t>, View<const float>, View<float>,
                     View<float>) override {
    missing("poisson_apply");
  }
  void poisson_residual(const LevelView&, View<const std::uint8_t>, View<const float>,
                        View<const float>, View<float>, View<float>) override {
    missing("poisson_residual");
  }
  void poisson_update_solution(const LevelView&, float, View<const float>, View<const float>,
                               View<float>, View<float>, View<float>) override {
    missing("poisson_update_solution");
  }
  void poisson_update_direction(const LevelView&, float, View<const float>, View<float>) override {
    missing("poisson_update_direction");
  }

  void octree_mark_unknown(const LevelView&, bool, View<std::uint8_t>) override {
    missing("octree_mark_unknown");
  }
  void poisson_splat(const LevelView&, const PointIndex&, const PointView&, const Scale&,
                     const Kernel&, View<float>) override {
    missing("poisson_splat");
  }
  void poisson_restrict(const LevelView&, View<const std::int32_t>, View<const float>,
                        View<float>) override {
    missing("poisson_restrict");
  }
  void poisson_prolong(const LevelView&, View<const std::int32_t>, View<const float>,
                       View<float>) override {
    missing("poisson_prolong");
  }
  void poisson_sample_points(const LevelView&, const PointIndex&, const PointView&,
                             View<const float>, View<float>) override {
    missing("poisson_sample_points");
  }
  void isovalue_splat(const LevelView&, const PointIndex&, const PointView&, View<const float>,
                      View<float>, View<float>) override {
    missing("isovalue_splat");
  }
  void isovalue_smooth(const LevelView&, int, float, View<const float>, View<float>) override {
    missing("isovalue_smooth");
  }
  void isovalue_divide(float, View<const float>, View<float>) override {
    missing("isovalue_divide");
  }
  void field_subtract(View<float>, View<const float>) override { missing("field_subtract"); }
  void lattice_mark(const BitView&, const BrickView&, const std::array<int, 3>&,
                    View<std::uint8_t>) override {
    missing("lattice_mark");
  }
  void lattice_label(const BitView&, int, const BrickView&, const std::array<int, 3>&,
                     View<std::uint8_t>) override {
    missing("lattice_label");
  }
  void lattice_sample(const BrickView&, View<const std::int32_t>, View<const float>,
                      View<const std::int32_t>, View<const float>, View<float>) override {
    missing("lattice_sample");
  }
  void relabel_count(const BrickView&, View<const std::uint8_t>, View<const std::uint8_t>,
                     View<const float>, View<std::uint32_t>) override {
    missing("relabel_count");
  }
  void relabel_collect(const BrickView&, View<const std::uint8_t>, View<const std::uint8_t>,
                       View<const float>, View<const std::uint32_t>, View<std::uint32_t>) override {
    missing("relabel_collect");
  }
  std::uint32_t relabel_sweep(const BrickView&, View<const std::uint8_t>, View<const float>, float,
                              View<const std::uint32_t>, View<std::uint8_t>,
                              View<std::uint32_t>) override {
    missing("relabel_sweep");
  }
  void relabel_mark(View<const std::uint32_t>, std::uint8_t, View<std::uint8_t>) override {
    missing("relabel_mark");
  }
  void relabel_find_marked(const BrickView&, View<const std::uint8_t>,
                           View<std::uint8_t>) override {
    missing("relabel_find_marked");
  }
  std::uint32_t lattice_mark_far(const BrickView&, View<const std::uint8_t>, const Scale&, float,
                                 View<const std::uint8_t>, View<const float>,
                                 View<std::uint8_t>) override {
    missing("lattice_mark_far");
  }
  void lattice_blend(const BrickView&, View<const std::uint8_t>, float, float, bool,
                     View<const std::uint8_t>, View<float>) override {
    missing("lattice_blend");
  }
  std::uint32_t lattice_clamp(const BrickView&, float, View<const std::uint8_t>,
                              View<float>) override {
    missing("lattice_clamp");
  }
  void surface_count(const BrickView&, View<const std::uint8_t>, View<std::uint8_t>,
                     View<std::uint16_t>, View<std::uint32_t>, View<std::uint32_t>) override {
    missing("surface_count");
  }
  void surface_emit(const BrickView&, View<const std::uint8_t>, View<const float>, float,
                    View<const std::uint8_t>, View<const std::uint16_t>, View<const std::uint32_t>,
                    View<const std::uint32_t>, View<float>, View<std::uint32_t>) override {
    missing("surface_emit");
  }

 private:
  [[noreturn]] void missing(const char* pass) const {
    throw Error(ErrorCode::internal, std::string("the ") + name() + " backend has no " + pass +
                                         ": ask offers() before a pass is called");
  }
};

}  // namespace vasamesh
