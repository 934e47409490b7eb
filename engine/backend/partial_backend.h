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
  void points_count(const BitView&, const BitView&, const BrickView&,
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
  void poisson_update_direction(const LevelView&, float, View<const float>,
                                View<float>) override {
    missing("poisson_update_direction");
  }

 private:
  [[noreturn]] void missing(const char* pass) const {
    throw Error(ErrorCode::internal, std::string("the ") + name() + " backend has no " + pass +
                                         ": ask offers() before a pass is called");
  }
};

}  // namespace vasamesh
