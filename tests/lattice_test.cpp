/// \file
/// The cell lattice against plain loops, and what the relabelling must leave alone: whatever the
/// field, the labelled nodes have the solid's topology.

#include "stages/lattice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "reference/lattice_reference.h"
#include "reference/octree_reference.h"
#include "reference/topology.h"
#include "stages/bricks.h"
#include "stages/link.h"
#include "stages/octree.h"
#include "stages/points.h"
#include "stages/relabel.h"
#include "stages/topology_count.h"
#include "support/backend_test.h"
#include "support/brick_sets.h"
#include "support/dense_volume.h"

namespace vasamesh {

/// Tells the numbers in a failure.
void PrintTo(const Topology& t, std::ostream* out) {
  *out << t.pieces << " pieces, " << t.handles << " handles, " << t.cavities << " cavities";
}

namespace {

using test::DenseVolume;

TEST(SimplePoints, AsFloodedAndCounted) {
  const auto table = make_simple_table();
  int simple = 0;
  for (std::uint32_t labels = 0; labels < kLinkCount; ++labels) {
    ASSERT_EQ(table[labels] != 0, reference::is_simple(labels)) << labels;
    EXPECT_EQ(table[labels], table[~labels & (kLinkCount - 1)]) << labels;
    simple += table[labels];
  }
  EXPECT_GT(simple, 1000);
  EXPECT_LT(simple, kLinkCount - 1000);
}

/// The volume as the lattice sees it: padded by kPad before it and at least as much behind.
DenseVolume padded(const DenseVolume& volume) {
  DenseVolume whole({(volume.size[0] + 2 * kPad + 7) / 8 * 8,
                     (volume.size[1] + 2 * kPad + 7) / 8 * 8,
                     (volume.size[2] + 2 * kPad + 7) / 8 * 8});
  for (int z = 0; z < volume.size[2]; ++z)
    for (int y = 0; y < volume.size[1]; ++y)
      for (int x = 0; x < volume.size[0]; ++x)
        whole.at(x + kPad, y + kPad, z + kPad) = volume.object(x, y, z);
  return whole;
}

/// The nodes of two voxels round the caller's volume; all others are outside whatever is done.
DenseVolume cropped(const DenseVolume& nodes, const DenseVolume& volume) {
  const int first = 2 * (kPad - 2);
  DenseVolume part({2 * volume.size[0] + 9, 2 * volume.size[1] + 9, 2 * volume.size[2] + 9});
  for (int z = 0; z < part.size[2]; ++z)
    for (int y = 0; y < part.size[1]; ++y)
      for (int x = 0; x < part.size[0]; ++x)
        part.at(x, y, z) = nodes.object(x + first, y + first, z + first);
  return part;
}

template <class Visit>
void visit_nodes(const BrickView& bricks, const Visit& visit) {
  for (std::size_t b = 0; b < bricks.count; ++b)
    for (int c = 0; c < kBrickCells; ++c)
      visit(kBrickCells * b + static_cast<std::size_t>(c), 8 * bricks.coords[b].x + c % 8,
            8 * bricks.coords[b].y + c / 8 % 8, 8 * bricks.coords[b].z + c / 64);
}

class CellLattice : public BackendTest {
 protected:
  /// All bricks of nodes of a packed volume.
  Bricks all_bricks(const BitVolume& bits) {
    std::vector<BrickCoord> coords;
    for (int z = 0; z < bits.size[2] / 4; ++z)
      for (int y = 0; y < bits.size[1] / 4; ++y)
        for (int x = 0; x < bits.size[0] / 4; ++x) coords.push_back({x, y, z});
    return make_bricks(backend(), coords);
  }
};

TEST_P(CellLattice, LabelsAsByTheVoxelsTouched) {
  unsigned seed = 0;
  for (const double density : {0.05, 0.4, 0.9})
    for (const int connectivity : {26, 18, 6}) {
      const DenseVolume volume = test::random_volume({37, 6, 5}, density, ++seed);
      const DenseVolume whole = padded(volume);
      const DenseVolume solid = test::solid_labels(whole, connectivity);
      const BitVolume bits = test::pack_plainly(backend(), volume);
      const Bricks bricks = all_bricks(bits);
      Buffer<std::uint8_t> state(backend(), bricks.count * kBrickCells);
      const std::array<int, 3> radius = {1 + static_cast<int>(seed % 3), 2,
                                         3 - static_cast<int>(seed % 3)};
      backend().lattice_label(bits.view(), connectivity, bricks.view(), radius, state.view());
      backend().settle();
      visit_nodes(bricks.view(), [&](std::size_t node, int x, int y, int z) {
        if (HasFatalFailure()) return;
        const int want = (solid.object(x, y, z) ? kLabel | kSolid : 0) |
                         (reference::near_face_centre(whole, radius, x, y, z) ? kFree : 0) |
                         (reference::is_face_centre(whole, x, y, z) ? kFaceCentre : 0);
        ASSERT_EQ(int{state.view()[node]}, want)
            << x << " " << y << " " << z << ", density " << density << ", " << connectivity;
      });
    }
}

TEST_P(CellLattice, BricksThatHoldFreeNodesOrNeighboursOfThem) {
  const DenseVolume volume = test::random_volume({41, 17, 9}, 0.004, 8);
  const DenseVolume whole = padded(volume);
  const BitVolume bits = test::pack_plainly(backend(), volume);
  const Bricks bricks = all_bricks(bits);
  for (const std::array<int, 3>& radius : {std::array{1, 2, 3}, {3, 1, 1}}) {
    Buffer<std::uint8_t> used(backend(), bricks.count);
    backend().lattice_mark(bits.view(), bricks.view(), radius, used.view());
    backend().settle();
    std::vector<std::uint8_t> want(bricks.count, 0);
    const std::array<int, 3> reach = {radius[0] + 1, radius[1] + 1, radius[2] + 1};
    visit_nodes(bricks.view(), [&](std::size_t node, int x, int y, int z) {
      std::uint8_t& found = want[node / kBrickCells];
      found = found || reference::near_face_centre(whole, reach, x, y, z);
    });
    EXPECT_EQ(to_host(backend(), used.view()), want);
    EXPECT_GT(std::count(want.begin(), want.end(), 0), 5);
  }
}

/// A volume's octree with a field of random coefficients on it.
struct RandomField {
  RandomField(Backend& backend, const DenseVolume& volume, const Scale& volume_scale,
              std::uint32_t seed, float bias)
      : scale(volume_scale),
        object(test::pack_plainly(backend, volume)),
        points(extract_points(backend, object, scale)),
        octree(build_octree(backend, points, scale, {})) {
    for (OctreeLevel& level : octree.levels) {
      std::vector<float> values = random_floats(level.solution.size(), seed++);
      for (float& value : values) value += bias;
      backend.upload<float>(level.solution.view(), values);
    }
  }
  Scale scale;
  BitVolume object;
  PointCloud points;
  Octree octree;
};

TEST_P(CellLattice, ValuesAreTheSplines) {
  const DenseVolume volume = test::random_volume({23, 9, 12}, 0.01, 3).box({2, 2, 2}, {8, 7, 9});
  const RandomField field(backend(), volume, {1, 1, 1}, 5, 0);
  ASSERT_TRUE(field.octree.has_refined());
  const Lattice lattice =
      build_lattice(backend(), field.object, field.points, field.scale, field.octree, {});
  backend().settle();
  const auto spline = [&](int exponent) {
    const OctreeLevel& level = field.octree.at_exponent(exponent);
    return reference::SplineField(exponent, level.coords,
                                  to_host<const float>(backend(), level.solution.view()));
  };
  const reference::SplineField regular = spline(0), refined = spline(-1);
  const std::vector<BrickCoord>& refined_bricks = field.octree.at_exponent(-1).coords;
  const auto has_refined = [&](int x, int y, int z) {
    return std::count(refined_bricks.begin(), refined_bricks.end(), BrickCoord{x, y, z}) > 0;
  };
  std::size_t from_regular = 0, from_refined = 0;
  const BrickView bricks = lattice.bricks.view();
  for (std::size_t b = 0; b < bricks.count; ++b) {
    bool is_refined = true;  // by the brick and the seven below it
    for (int n = 0; n < 8; ++n)
      is_refined =
          is_refined && has_refined(bricks.coords[b].x - (n & 1), bricks.coords[b].y - (n >> 1 & 1),
                                    bricks.coords[b].z - (n >> 2));
    (is_refined ? from_refined : from_regular) += 1;
    for (int c = 0; c < kBrickCells; ++c) {
      const reference::Position at = {0.5 * (8 * bricks.coords[b].x + c % 8),
                                      0.5 * (8 * bricks.coords[b].y + c / 8 % 8),
                                      0.5 * (8 * bricks.coords[b].z + c / 64)};
      ASSERT_NEAR(lattice.values.view().data()[kBrickCells * b + static_cast<std::size_t>(c)],
                  (is_refined ? refined : regular).at(at), 1e-5);
    }
  }
  EXPECT_GT(from_regular, 5u);
  EXPECT_GT(from_refined, 5u);
}

/// Random solids of all densities and connectivities, relabelled towards fields that have nothing
/// to do with them.
class Relabelling : public CellLattice {
 protected:
  void check(const DenseVolume& volume, const Scale& scale, std::uint32_t seed, float bias) {
    for (const Connectivity connectivity :
         {Connectivity::vertex, Connectivity::edge, Connectivity::face}) {
      SCOPED_TRACE(static_cast<int>(connectivity));
      check(volume, scale, seed, bias, connectivity);
    }
  }

  void check(const DenseVolume& volume, const Scale& scale, std::uint32_t seed, float bias,
             Connectivity connectivity) {
    Parameters parameters;
    parameters.connectivity = connectivity;
    RandomField field(backend(), volume, scale, seed, bias);
    backend().settle();
    const Solid solid =
        examine_solid(backend(), field.object.view(), volume.size64(), connectivity);
    Lattice lattice =
        build_lattice(backend(), field.object, field.points, scale, field.octree, parameters);
    const auto before = to_host<const std::uint8_t>(backend(), lattice.state.view());
    Context context;
    context.backends = {shared_backend()};
    Scheduler scheduler(context);
    const RelabelReport report = relabel(scheduler, scale, lattice, nullptr);
    backend().settle();
    flips_ += report.flips;
    expect_consistent(lattice, before);
    const DenseVolume nodes = reference::relabelled(
        test::solid_labels(padded(volume), static_cast<int>(connectivity)), lattice);
    const DenseVolume part = cropped(nodes, volume);
    EXPECT_EQ(std::count(part.voxels.begin(), part.voxels.end(), 0),
              std::count(nodes.voxels.begin(), nodes.voxels.end(), 0) -
                  static_cast<std::ptrdiff_t>(nodes.voxels.size() - part.voxels.size()))
        << "labels far from the volume";
    EXPECT_EQ(test::count_nodes(part), solid.topology);
  }

  /// Values have their labels' signs; only free nodes changed, and nothing of them but the label.
  void expect_consistent(const Lattice& lattice, const std::vector<std::uint8_t>& before) {
    const auto state = to_host<const std::uint8_t>(backend(), lattice.state.view());
    const auto values = to_host<const float>(backend(), lattice.values.view());
    for (std::size_t i = 0; i < state.size(); ++i) {
      const int changed = state[i] ^ before[i];
      ASSERT_TRUE(changed == 0 || (changed == kLabel && (before[i] & kFree))) << i;
      ASSERT_EQ(values[i] > 0, (state[i] & kLabel) != 0) << i;
      ASSERT_NE(values[i], 0.0f) << i;
    }
  }

  std::int64_t flips_ = 0;
};

TEST_P(Relabelling, KeepsTheSolidsTopology) {
  std::uint32_t seed = 100;
  // Other backends are compared with oneTBB byte by byte besides (opencl_stages_test).
  const std::vector<float> biases =
      backend().name() == "tbb" ? std::vector{0.0f, -2.0f, 2.0f} : std::vector{-2.0f};
  for (const double density : {0.02, 0.1, 0.25, 0.4, 0.6, 0.8, 0.97})
    for (const float bias : biases) {
      SCOPED_TRACE(::testing::Message() << "density " << density << ", bias " << bias);
      check(test::random_volume({11, 9, 10}, density, seed), {1, 1, 1}, seed, bias);
      ++seed;
    }
  EXPECT_GT(flips_, 3000);
}

TEST_P(Relabelling, KeepsTheSolidsTopologyWhereSpacingsDiffer) {
  std::uint32_t seed = 500;
  for (const Scale& scale : {Scale{0.7f, 0.7f, 2.04f}, {1.6f, 0.5f, 1.25f}})
    for (const float bias : {0.0f, -2.0f, 2.0f}) {
      SCOPED_TRACE(::testing::Message() << "scale " << scale[2] << ", bias " << bias);
      check(test::random_volume({13, 7, 6}, 0.35, seed), scale, seed, bias);
      ++seed;
    }
  EXPECT_GT(flips_, 1000);
}

INSTANTIATE_TEST_SUITE_P(Backends, Relabelling, ::testing::ValuesIn(backend_names()), test_name);

/// A lattice of random labels and values for single passes.
struct RandomLattice {
  RandomLattice(Backend& backend, std::uint32_t seed) {
    lattice.bricks = make_bricks(backend, random_bricks(30, seed));
    const std::size_t nodes = lattice.bricks.count * kBrickCells;
    lattice.values = to_backend(backend, random_floats(nodes, seed));
    std::mt19937 random(seed);
    std::vector<std::uint8_t> state(nodes);
    for (std::uint8_t& s : state) s = random() & (kLabel | kSolid | kFree);
    lattice.state = to_backend(backend, state);
  }
  bool wrong(std::size_t node) const {
    return (lattice.values.view().data()[node] > 0) !=
           ((lattice.state.view().data()[node] & kLabel) != 0);
  }
  Lattice lattice;
};

TEST_P(CellLattice, ClampGivesEachWrongValueItsLabelsSign) {
  RandomLattice random(backend(), 12);
  backend().settle();
  Lattice& lattice = random.lattice;
  const auto before = to_host(backend(), lattice.values.view());
  std::vector<bool> wrong;
  for (std::size_t i = 0; i < before.size(); ++i) wrong.push_back(random.wrong(i));
  backend().lattice_clamp(lattice.bricks.view(), 0.125f, lattice.state.view(),
                          lattice.values.view());
  backend().settle();
  for (std::size_t i = 0; i < before.size(); ++i) {
    const bool inside = lattice.state.view()[i] & kLabel;
    ASSERT_EQ(lattice.values.view()[i], wrong[i] ? (inside ? 0.125f : -0.125f) : before[i]) << i;
  }
}

/// On random labels, a third or a fifth of the nodes inside.
TEST_P(CellLattice, NarrowPlacesAreMarked) {
  constexpr LeastWidths kLeast = {0.8f, 0.7f};
  int inside_marks = 0, outside_marks = 0;
  for (std::uint32_t seed = 60; seed < 64; ++seed) {
    RandomLattice random(backend(), seed);
    Lattice& lattice = random.lattice;
    const BrickView bricks = lattice.bricks.view();
    std::mt19937 chance(seed);
    std::vector<std::uint8_t> state(lattice.values.size());
    for (std::uint8_t& s : state) s = chance() % (seed % 2 ? 5 : 3) ? 0 : (kLabel | kSolid);
    lattice.state = to_backend(backend(), state);
    std::vector<std::uint8_t> active(bricks.count), none(lattice.values.size(), 0);
    for (std::uint8_t& octants : active) octants = static_cast<std::uint8_t>(chance());
    const auto shown = to_backend(backend(), active);
    auto marks = to_backend(backend(), none);
    const auto table = make_simple_table();
    const auto simple =
        to_backend(backend(), std::vector<std::uint8_t>(table.begin(), table.end()));
    const std::uint32_t count =
        backend().lattice_mark_narrow(bricks, shown.view(), simple.view(), kLeast,
                                      lattice.state.view(), lattice.values.view(), marks.view());
    const auto marked = to_host<const std::uint8_t>(backend(), marks.view());
    const auto values = to_host<const float>(backend(), lattice.values.view());
    backend().settle();
    reference::NodePlaces nodes;
    visit_nodes(bricks, [&](std::size_t node, int x, int y, int z) { nodes[{x, y, z}] = node; });
    std::uint32_t wanted = 0;
    for (const auto& [at, node] : nodes) {
      const bool inside = (state[node] & kLabel) != 0;
      const int octant = (at[0] >> 2 & 1) + 2 * (at[1] >> 2 & 1) + 4 * (at[2] >> 2 & 1);
      const bool is_marked = (active[node / kBrickCells] >> octant & 1) &&
                             reference::is_narrow(nodes, state, values, kLeast, at);
      wanted += is_marked;
      (inside ? inside_marks : outside_marks) += is_marked;
      ASSERT_EQ(marked[node], is_marked ? kStuckMark : 0) << node;
    }
    EXPECT_EQ(count, wanted);
  }
  EXPECT_GT(inside_marks, 20);
  EXPECT_GT(outside_marks, 5);
}

TEST_P(CellLattice, BlendChangesNothingBeyondItsRadius) {
  for (const float radius : {3.0f, 5.0f, 8.0f}) {
    SCOPED_TRACE(radius);
    RandomLattice random(backend(), 20 + static_cast<std::uint32_t>(radius));
    backend().settle();
    Lattice& lattice = random.lattice;
    std::vector<std::uint8_t> marked(lattice.values.size(), 0);
    std::vector<std::array<int, 3>> places;
    visit_nodes(lattice.bricks.view(), [&](std::size_t node, int x, int y, int z) {
      if (node % 3001 != 5) return;
      marked[node] = kStuckMark;
      places.push_back({x, y, z});
    });
    ASSERT_GE(places.size(), 4u);
    const auto marks = to_backend(backend(), marked);
    const auto before = to_host(backend(), lattice.values.view());
    Buffer<std::uint8_t> changed(backend(), lattice.bricks.count);
    backend().lattice_blend(lattice.bricks.view(), marks.view(), radius, 1, true,
                            lattice.state.view(), lattice.values.view(), changed.view());
    backend().settle();
    std::vector<std::uint8_t> reached(lattice.bricks.count, 0);
    visit_nodes(lattice.bricks.view(), [&](std::size_t node, int x, int y, int z) {
      double nearest = 1e9;
      for (const auto& p : places)
        nearest = std::min(nearest, std::hypot(p[0] - x, p[1] - y, p[2] - z));
      const float value = lattice.values.view()[node];
      if (nearest >= radius) {
        ASSERT_EQ(value, before[node]) << node;
      } else {
        reached[node / kBrickCells] |=
            static_cast<std::uint8_t>(1u << ((x >> 2 & 1) + 2 * (y >> 2 & 1) + 4 * (z >> 2 & 1)));
        const double part = 1 - nearest * nearest / (radius * radius);
        // Beside the solid's own value, which is within 0.5 of zero.
        EXPECT_NEAR(value, (1 - part * part) * before[node], 0.5 * part * part + 1e-5) << node;
      }
      if (nearest == 0) {
        EXPECT_EQ(value > 0, (lattice.state.view()[node] & kSolid) != 0) << node;
      }
    });
    EXPECT_EQ(to_host<const std::uint8_t>(backend(), changed.view()), reached);
  }
}

TEST_P(CellLattice, FarMarksAreWhereLabelsHaveLeftTheSolid) {
  const std::array<int, 3> low = {3, 3, 3}, high = {13, 11, 9};  // the object's voxels
  DenseVolume volume({16, 14, 12});
  for (int z = low[2]; z < high[2]; ++z)
    for (int y = low[1]; y < high[1]; ++y)
      for (int x = low[0]; x < high[0]; ++x) volume.at(x, y, z) = 1;
  const BitVolume bits = test::pack_plainly(backend(), volume);
  const Bricks bricks = all_bricks(bits);
  const std::size_t nodes = bricks.count * kBrickCells;
  Buffer<std::uint8_t> labels(backend(), nodes);
  backend().lattice_label(bits.view(), 26, bricks.view(), {3, 3, 3}, labels.view());
  std::vector<std::uint8_t> state = to_host<const std::uint8_t>(backend(), labels.view());
  Buffer<std::uint8_t> marks(backend(), nodes);
  const auto far = [&](std::uint8_t octants) {
    std::vector<float> values;
    for (const std::uint8_t s : state) values.push_back(s & kLabel ? 0.5f : -0.5f);
    const auto active = to_backend(backend(), std::vector<std::uint8_t>(bricks.count, octants));
    backend().fill(marks.view(), kStuckMark);
    return backend().lattice_mark_far(bricks.view(), active.view(), {1, 1, 1}, 0.8f,
                                      to_backend(backend(), state).view(),
                                      to_backend(backend(), values).view(), marks.view());
  };
  EXPECT_EQ(far(0xff), 0u);

  const int end = 2 * (kPad + high[0]), retreat = 5;  // nodes along x
  visit_nodes(bricks.view(), [&](std::size_t node, int x, int, int) {
    if (x > end - retreat) state[node] = static_cast<std::uint8_t>(state[node] & ~kLabel);
  });
  const std::uint32_t count = far(0xff);
  const auto marked = to_host<const std::uint8_t>(backend(), marks.view());
  std::uint32_t centres = 0, seen = 0;
  visit_nodes(bricks.view(), [&](std::size_t node, int x, int y, int z) {
    ASSERT_TRUE(marked[node] == 0 || marked[node] == kFarMark);
    seen += marked[node] != 0;
    if (x < end - retreat - 1) {
      EXPECT_EQ(marked[node], 0) << x << " " << y << " " << z;
    }
    if (x != end || !(state[node] & kFaceCentre)) return;
    EXPECT_EQ(marked[node], kFarMark) << x << " " << y << " " << z;
    ++centres;
  });
  EXPECT_EQ(seen, count);
  EXPECT_EQ(centres, 8u * 6u);

  for (const std::uint8_t octants : {0x01, 0x90, 0x00}) {
    far(octants);
    const auto some = to_host<const std::uint8_t>(backend(), marks.view());
    visit_nodes(bricks.view(), [&](std::size_t node, int x, int y, int z) {
      const int octant = (x >> 2 & 1) + 2 * (y >> 2 & 1) + 4 * (z >> 2 & 1);
      ASSERT_EQ(some[node], octants >> octant & 1 ? marked[node] : 0) << x << " " << y << " " << z;
    });
  }
}

INSTANTIATE_TEST_SUITE_P(Backends, CellLattice, ::testing::ValuesIn(backend_names()), test_name);

}  // namespace
}  // namespace vasamesh
