/// Packing, top-hat, brick marks and samples of every backend, against loops over voxels.

#include "stages/points.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>

#include "reference/points_reference.h"
#include "support/backend_test.h"
#include "support/dense_volume.h"
#include "tbb/backend.h"
#include "vasamesh/errors.h"

namespace vasamesh {
namespace {

using test::DenseVolume;

constexpr Scale kCubes{1, 1, 1};

/// Volumes that touch all borders, of sizes that fill words and bricks badly.
std::vector<DenseVolume> awkward_volumes() {
  std::vector<DenseVolume> volumes;
  volumes.push_back(test::random_volume({1, 1, 1}, 1.0, 1));
  volumes.push_back(test::random_volume({7, 1, 5}, 0.5, 2));
  volumes.push_back(test::random_volume({48, 9, 3}, 0.9, 3));     // a row of exactly one word
  volumes.push_back(test::random_volume({121, 6, 10}, 0.97, 4));  // three words
  volumes.push_back(test::random_volume({33, 29, 1}, 0.8, 5));    // one slice
  volumes.push_back(test::random_volume({17, 18, 19}, 0.05, 6));
  volumes.push_back(test::random_volume({20, 13, 24}, 0.99, 7));
  volumes.push_back(test::random_volume({60, 8, 8}, 1.0, 8));  // full
  volumes.push_back(test::random_volume({9, 9, 9}, 0.0, 9));   // empty
  DenseVolume shapes({70, 20, 22});
  shapes.box({2, 2, 2}, {21, 17, 19}).box({22, 8, 8}, {66, 8, 8}).box({40, 3, 4}, {60, 5, 6});
  shapes.box({30, 12, 12}, {50, 13, 19});
  volumes.push_back(shapes);
  return volumes;
}

std::vector<Scale> scales() { return {kCubes, {0.8606f, 0.8606f, 1.3501f}, {1.9f, 0.7f, 0.752f}}; }

TEST(Scales, AreSpacingsOverTheirGeometricMean) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> exponent(-6, 4);
  Geometry geometry;
  for (int i = 0; i < 200; ++i) {
    for (double& spacing : geometry.spacing) spacing = std::pow(10.0, exponent(random));
    const auto& [x, y, z] = geometry.spacing;
    const double mean = std::cbrt(x * y * z);
    const Scale scale = make_scale(geometry);
    for (std::size_t axis = 0; axis < 3; ++axis)
      EXPECT_FLOAT_EQ(scale[axis], static_cast<float>(geometry.spacing[axis] / mean));
    geometry.spacing.fill(x);
    EXPECT_EQ(make_scale(geometry), kCubes) << x;
  }
}

/// The bits of a padded volume, a byte each.
DenseVolume unpack(Backend& backend, const std::array<int, 3>& size, int words_per_row,
                   View<const std::uint64_t> view) {
  std::vector<std::uint64_t> words(view.size);
  backend.download<std::uint64_t>(view, words);
  DenseVolume volume(size);
  std::size_t set = 0;
  for (int z = 0; z < size[2]; ++z)
    for (int y = 0; y < size[1]; ++y)
      for (int x = 0; x < size[0]; ++x) {
        const std::size_t row = (static_cast<std::size_t>(z) * size[1] + y) * words_per_row;
        volume.at(x, y, z) = words[row + x / 64] >> (x % 64) & 1;
        set += volume.at(x, y, z);
      }
  for (const std::uint64_t word : words) set -= __builtin_popcountll(word);
  EXPECT_EQ(set, 0u) << "bits past the rows' ends";
  return volume;
}

class Points : public BackendTest {
 protected:
  BitVolume pack(const DenseVolume& volume) { return pack_volume(backend(), volume.view()); }
  DenseVolume unpack(const BitVolume& bits) {
    return vasamesh::unpack(backend(), bits.size, bits.words_per_row, bits.words.view());
  }
};

TEST_P(Points, PackBytes) {
  for (DenseVolume& volume : awkward_volumes()) {
    for (std::size_t i = 0; i < volume.voxels.size(); ++i)
      if (volume.voxels[i]) volume.voxels[i] = static_cast<std::uint8_t>(1 + i % 255);
    const BitVolume bits = pack(volume);
    const DenseVolume expected = reference::padded(volume);
    EXPECT_EQ(bits.size, expected.size);
    EXPECT_EQ(bits.words_per_row, (expected.size[0] + 63) / 64);
    EXPECT_EQ(unpack(bits).voxels, expected.voxels);
  }
}

TEST_P(Points, PackBits) {
  for (const DenseVolume& volume : awkward_volumes()) {
    const int row_bytes = (volume.size[0] + 7) / 8;
    std::vector<std::uint8_t> packed(
        static_cast<std::size_t>(row_bytes) * volume.size[1] * volume.size[2], 0);
    for (int z = 0; z < volume.size[2]; ++z)
      for (int y = 0; y < volume.size[1]; ++y)
        for (int x = 0; x < 8 * row_bytes; ++x)  // the rows' rest holds ones
          if (x >= volume.size[0] || volume.object(x, y, z))
            packed[(static_cast<std::size_t>(z) * volume.size[1] + y) * row_bytes + x / 8] |=
                static_cast<std::uint8_t>(1u << (x % 8));
    VolumeView view = volume.view();
    view.data = packed.data();
    view.format = VoxelFormat::bits;
    EXPECT_EQ(unpack(pack_volume(backend(), view)).voxels, reference::padded(volume).voxels);
  }
}

TEST_P(Points, PackRefusesAbsurdSizes) {
  for (const std::int64_t size : {std::int64_t{0}, std::int64_t{-3}, std::int64_t{1} << 40}) {
    VolumeView view;
    view.geometry.size = {4, size, 4};
    try {
      pack_volume(backend(), view);
      ADD_FAILURE() << size;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::bad_input);
    }
  }
}

TEST_P(Points, ThinMask) {
  for (const DenseVolume& volume : awkward_volumes()) {
    const BitVolume bits = pack(volume);
    const std::vector<std::uint64_t> rubbish(bits.view().word_count(), 0x5a5a5a5a5a5a5a5au);
    Buffer<std::uint64_t> thin = to_backend(backend(), rubbish);
    Buffer<std::uint64_t> refine = to_backend(backend(), rubbish);
    backend().points_thin_mask(bits.view(), thin.view(), refine.view());
    const DenseVolume expected = reference::top_hat(reference::padded(volume));
    const auto plain = [&](Buffer<std::uint64_t>& mask) {
      return vasamesh::unpack(backend(), bits.size, bits.words_per_row, mask.view());
    };
    EXPECT_EQ(plain(thin).voxels, expected.voxels);
    EXPECT_EQ(plain(refine).voxels, reference::dilated(expected).voxels);
  }
}

TEST_P(Points, MarkBricks) {
  for (const DenseVolume& volume : awkward_volumes()) {
    const DenseVolume object = reference::padded(volume);
    const std::array<int, 3> bricks{object.size[0] / 8, object.size[1] / 8, object.size[2] / 8};
    std::vector<std::uint8_t> expected(static_cast<std::size_t>(bricks[0]) * bricks[1] * bricks[2],
                                       0);
    for (int z = 0; z < object.size[2]; ++z)
      for (int y = 0; y < object.size[1]; ++y)
        for (int x = 0; x < object.size[0]; ++x)
          if (reference::is_outer_boundary(object, {x, y, z}))
            expected[x / 8 + bricks[0] * (y / 8 + bricks[1] * (z / 8))] |=
                1u << (x / 4 % 2 + 2 * (y / 4 % 2) + 4 * (z / 4 % 2));
    const BitVolume bits = pack(volume);
    Buffer<std::uint8_t> octants =
        to_backend(backend(), std::vector<std::uint8_t>(expected.size(), 0xee));
    backend().points_mark_bricks(bits.view(), octants.view());
    EXPECT_EQ(to_host(backend(), octants.view()), expected);
  }
}

/// The arrays of a point cloud, on the host.
struct HostPoints {
  std::array<std::vector<float>, 3> position, area;
  std::vector<float> thickness;
  std::vector<BrickCoord> coords;
  std::vector<std::uint32_t> voxel_start;
  std::vector<std::uint8_t> octants;
  std::size_t count, thin_count;

  HostPoints(Backend& backend, const PointCloud& points)
      : thickness(to_host(backend, points.thickness.view())),
        coords(to_host(backend, points.bricks.coords.view())),
        voxel_start(to_host(backend, points.voxel_start.view())),
        octants(to_host(backend, points.octants.view())),
        count(points.count),
        thin_count(points.thin_count) {
    for (int axis = 0; axis < 3; ++axis) {
      position[axis] = to_host(backend, points.position[axis].view());
      area[axis] = to_host(backend, points.area[axis].view());
    }
  }
  bool operator==(const HostPoints&) const = default;
};

HostPoints extract(Backend& backend, const DenseVolume& volume, const Scale& scale) {
  const BitVolume bits = pack_volume(backend, volume.view());
  return HostPoints(backend, extract_points(backend, bits, scale));
}

void expect_same_points(const HostPoints& points, const std::vector<reference::Point>& expected) {
  ASSERT_EQ(points.count, expected.size());
  std::size_t refined = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      ASSERT_NEAR(points.position[axis][i], expected[i].position[axis], 1e-5) << i;
      ASSERT_NEAR(points.area[axis][i], expected[i].area[axis], 1e-6) << i;
    }
    ASSERT_NEAR(points.thickness[i], expected[i].thickness, 1e-6) << i;
    refined += expected[i].refined;
  }
  EXPECT_EQ(points.thin_count, refined);
}

/// Every point lies where voxel_start says, and bricks and octants hold points all of them.
void expect_table(const HostPoints& points, const std::vector<reference::Point>& expected) {
  ASSERT_EQ(points.voxel_start.size(), 512 * points.coords.size() + 1);
  ASSERT_EQ(points.octants.size(), points.coords.size());
  std::size_t next = 0;
  for (std::size_t brick = 0; brick < points.coords.size(); ++brick) {
    unsigned octants = 0;
    for (int cell = 0; cell < 512; ++cell) {
      ASSERT_EQ(points.voxel_start[512 * brick + cell], next);
      const std::array<int, 3> voxel{8 * points.coords[brick].x + cell % 8,
                                     8 * points.coords[brick].y + cell / 8 % 8,
                                     8 * points.coords[brick].z + cell / 64};
      const std::size_t first = next;
      while (next < expected.size() && expected[next].voxel == voxel) ++next;
      if (next > first) octants |= 1u << (cell / 4 % 2 + 2 * (cell / 32 % 2) + 4 * (cell / 256));
    }
    EXPECT_EQ(points.octants[brick], octants);
    EXPECT_NE(octants, 0u);
  }
  EXPECT_EQ(next, expected.size());
  EXPECT_EQ(points.voxel_start.back(), expected.size());
}

TEST_P(Points, ExtractAsTheOracle) {
  for (const Scale& scale : scales())
    for (const DenseVolume& volume : awkward_volumes()) {
      const HostPoints points = extract(backend(), volume, scale);
      const auto expected = reference::extract_points(reference::padded(volume), scale);
      expect_same_points(points, expected);
      expect_table(points, expected);
    }
}

/// The surface is closed: the areas sum to nothing, and their sizes to the faces.
TEST_P(Points, AreasAreThoseOfTheFaces) {
  const Scale scale{1.9f, 0.7f, 0.752f};
  for (const DenseVolume& volume : awkward_volumes()) {
    const DenseVolume object = reference::padded(volume);
    const HostPoints points = extract(backend(), volume, scale);
    for (int axis = 0; axis < 3; ++axis) {
      std::size_t faces = 0;
      for (int z = 1; z < object.size[2]; ++z)
        for (int y = 1; y < object.size[1]; ++y)
          for (int x = 1; x < object.size[0]; ++x)
            faces += object.object(x, y, z) !=
                     object.object(x - (axis == 0), y - (axis == 1), z - (axis == 2));
      double sum = 0, size = 0;
      for (const float a : points.area[axis]) {
        sum += a;
        size += std::fabs(a);
      }
      const double face = scale[(axis + 1) % 3] * scale[(axis + 2) % 3];
      EXPECT_NEAR(sum, 0, 1e-3);
      EXPECT_NEAR(size, static_cast<double>(faces) * face, 1e-6 * size);
    }
  }
}

TEST_P(Points, OneVoxelHasFourPointsAFace) {
  DenseVolume voxel({1, 1, 1});
  voxel.box({0, 0, 0}, {0, 0, 0});
  const HostPoints points = extract(backend(), voxel, kCubes);
  EXPECT_EQ(points.count, 24u);
  EXPECT_EQ(points.thin_count, 24u);
  for (const float thickness : points.thickness) EXPECT_EQ(thickness, 0);
}

TEST_P(Points, AThickBoxIsNotRefined) {
  DenseVolume box({12, 11, 10});
  box.box({0, 0, 0}, {11, 10, 9});
  const HostPoints points = extract(backend(), box, kCubes);
  EXPECT_EQ(points.count, 2u * (12 * 11 + 12 * 10 + 11 * 10));
  EXPECT_EQ(points.thin_count, 0u);
  for (const float thickness : points.thickness) EXPECT_EQ(thickness, 1);
}

/// A gap of one voxel between two blocks: two points a voxel, with opposite areas.
TEST_P(Points, TwoSheetsGiveOnePointAFace) {
  DenseVolume blocks({3, 3, 7});
  blocks.box({0, 0, 0}, {2, 2, 2}).box({0, 0, 4}, {2, 2, 6});
  const HostPoints points = extract(backend(), blocks, kCubes);
  std::size_t up = 0, down = 0;
  for (std::size_t i = 0; i < points.count; ++i) {
    const float z = points.position[2][i] - kPad;
    if (z < 3 || z > 4 || points.area[2][i] == 0) continue;
    EXPECT_EQ(z, points.area[2][i] > 0 ? 3 : 4);
    ++(points.area[2][i] > 0 ? up : down);
  }
  EXPECT_EQ(up, 9u);
  EXPECT_EQ(down, 9u);
}

TEST_P(Points, NoForegroundNoPoints) {
  const HostPoints points = extract(backend(), DenseVolume({5, 6, 7}), kCubes);
  EXPECT_EQ(points.count, 0u);
  EXPECT_TRUE(points.coords.empty());
  EXPECT_EQ(points.voxel_start, std::vector<std::uint32_t>{0});
}

// The backends that offer the stage.
INSTANTIATE_TEST_SUITE_P(Backends, Points, ::testing::ValuesIn(backend_names()), test_name);

TEST(PointThreads, SameBytesWithAnyNumberOfThreads) {
  const DenseVolume volume = test::random_volume({90, 61, 77}, 0.6, 11);
  const Scale scale{0.8606f, 0.8606f, 1.3501f};
  const HostPoints one = extract(*make_tbb_backend(1, nullptr), volume, scale);
  EXPECT_GT(one.count, 100000u);
  for (const int threads : {2, 4})
    EXPECT_EQ(extract(*make_tbb_backend(threads, nullptr), volume, scale), one);
}

}  // namespace
}  // namespace vasamesh
