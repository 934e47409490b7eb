/// Every stage up to the base surface leaves the same bytes on an OpenCL device as on oneTBB,
/// whatever the shape of the kernels and wherever the device's memory lies.

#include <gtest/gtest.h>

#include <cstring>
#include <span>

#include "phantom/phantom.h"
#include "stages/lattice.h"
#include "stages/normals.h"
#include "stages/octree.h"
#include "stages/points.h"
#include "stages/poisson.h"
#include "stages/relabel.h"
#include "stages/surface.h"
#include "support/backend_test.h"
#include "support/dense_volume.h"

namespace vasamesh {
namespace {

/// What the stages have left, in their order.
class Trace {
 public:
  explicit Trace(Backend& backend) : backend_(backend) {}

  template <class T>
  void add(const std::string& name, View<T> view) {
    add(name, std::span<const std::remove_const_t<T>>(to_host(backend_, view)));
  }
  template <class T>
  void add(const std::string& name, std::span<const T> values) {
    const auto bytes = std::as_bytes(values);
    entries_.push_back({name, {bytes.begin(), bytes.end()}});
  }

  void expect_same_as(const Trace& other) const {
    ASSERT_EQ(entries_.size(), other.entries_.size());
    for (std::size_t i = 0; i < entries_.size(); ++i) {
      ASSERT_EQ(entries_[i].name, other.entries_[i].name);
      ASSERT_GT(entries_[i].bytes.size(), 0u) << entries_[i].name;
      ASSERT_EQ(entries_[i].bytes.size(), other.entries_[i].bytes.size()) << entries_[i].name;
      const auto differ = std::mismatch(entries_[i].bytes.begin(), entries_[i].bytes.end(),
                                        other.entries_[i].bytes.begin());
      ASSERT_EQ(differ.first - entries_[i].bytes.begin(),
                static_cast<std::ptrdiff_t>(entries_[i].bytes.size()))
          << "the first byte that differs, of " << entries_[i].name;
    }
  }

 private:
  struct Entry {
    std::string name;
    std::vector<std::byte> bytes;
  };
  Backend& backend_;
  std::vector<Entry> entries_;
};

void add_points(Trace& trace, const PointCloud& points) {
  const PointView view = points.view();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    trace.add("position", view.position[axis]);
    trace.add("area", view.area[axis]);
    trace.add("normal", view.normal[axis]);
  }
  trace.add("thickness", view.thickness);
  trace.add("voxel_start", points.voxel_start.view());
  trace.add("octants", points.octants.view());
}

void add_equation(Trace& trace, const Octree& octree) {
  for (const OctreeLevel& level : octree.levels) {
    const std::string at = " of level " + std::to_string(level.exponent);
    trace.add("unknown" + at, level.unknown.view());
    trace.add("right-hand side" + at, level.right_hand_side.view());
  }
}

void add_solution(Trace& trace, const Octree& octree) {
  for (const OctreeLevel& level : octree.levels)
    trace.add("solution of level " + std::to_string(level.exponent), level.solution.view());
}

/// The stages one after the other.
Trace run_stages(std::shared_ptr<Backend> on, const VolumeView& volume,
                 const Parameters& parameters) {
  Backend& backend = *on;
  Context context;
  context.backends = {on};
  Scheduler scheduler(context);
  Trace trace(backend);
  const Scale scale = make_scale(volume.geometry);
  const BitVolume object = pack_volume(backend, volume);
  trace.add("bits", object.words.view());
  PointCloud points = extract_points(backend, object, scale);
  estimate_normals(backend, object, scale, parameters, points);
  add_points(trace, points);
  Octree octree = build_octree(backend, points, scale, parameters);
  assemble_poisson(backend, points, scale, parameters, octree);
  add_equation(trace, octree);
  std::vector<LevelReport> levels;
  solve_poisson(scheduler, parameters, octree, levels);
  subtract_isovalue(backend, points, scale, octree);
  add_solution(trace, octree);
  Lattice lattice = build_lattice(backend, object, points, scale, octree, parameters);
  trace.add("solid labels", lattice.state.view());
  trace.add("sampled values", lattice.values.view());
  std::vector<Closing> closings;
  relabel(scheduler, scale, lattice, parameters.close_handles ? &closings : nullptr);
  trace.add("labels", lattice.state.view());
  trace.add("values", lattice.values.view());
  const TriangleMesh mesh = extract_base_surface(backend, lattice);
  trace.add("vertices", std::span(mesh.vertices));
  trace.add("triangles", std::span(mesh.triangles));
  return trace;
}

class StagesAgree : public BackendTest {
 protected:
  void check(const VolumeView& volume, const Parameters& parameters) {
    run_stages(shared_backend(), volume, parameters)
        .expect_same_as(run_stages(open_backend("tbb"), volume, parameters));
  }
};

TEST_P(StagesAgree, OnPhantoms) {
  for (const char* name : {"y_branch", "two_tubes", "torus"}) {
    SCOPED_TRACE(name);
    const Phantom phantom = make_phantom(name);
    check(phantom.view(), {});
  }
}

/// Noise has every constellation of voxels, thin parts everywhere, and much to repair.
TEST_P(StagesAgree, OnNoiseOfEverySpacingAndConnectivity) {
  const std::array<std::array<double, 3>, 3> spacings = {{{1, 1, 1}, {0.5, 0.5, 1.2}, {2, 0.7, 1}}};
  const std::array<Connectivity, 3> connectivities = {Connectivity::vertex, Connectivity::edge,
                                                      Connectivity::face};
  for (unsigned i = 0; i < 3; ++i) {
    SCOPED_TRACE(i);
    const test::DenseVolume volume = test::random_volume({37, 7, 9}, 0.1 + 0.25 * i, 40 + i);
    VolumeView view = volume.view();
    view.geometry.spacing = spacings[i];
    Parameters parameters;
    parameters.connectivity = connectivities[i];
    parameters.close_handles = i == 0;
    parameters.normals = i == 1 ? NormalMode::gradient : NormalMode::covariance;
    parameters.neighbours = i == 2 ? 64 : 10;
    check(view, parameters);
  }
}

INSTANTIATE_TEST_SUITE_P(Backends, StagesAgree,
                         ::testing::Values("opencl_one_item", "opencl_small_group",
                                           "opencl_work_group"),
                         test_name);

}  // namespace
}  // namespace vasamesh
