#include "stages/points.h"

#include <cmath>
#include <numeric>
#include <string>
#include <vector>

#include "stages/bricks.h"
#include "stages/volume_check.h"

namespace vasamesh {

namespace {

/// Bricks of the whole volume that hold outer boundary voxels, in raster order, and their octants.
struct Marked {
  std::vector<BrickCoord> coords;
  std::vector<std::uint8_t> octants;
};

Marked mark_bricks(Backend& backend, const BitView& object) {
  const int nx = object.size[0] / kBrickSide, ny = object.size[1] / kBrickSide,
            nz = object.size[2] / kBrickSide;
  std::vector<std::uint8_t> all(static_cast<std::size_t>(nx) * ny * nz);
  Buffer<std::uint8_t> octants(backend, all.size());
  backend.points_mark_bricks(object, octants.view());
  backend.download<std::uint8_t>(octants.view(), all);
  Marked marked;
  std::size_t i = 0;
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x, ++i) {
        if (all[i] == 0) continue;
        marked.coords.push_back({x, y, z});
        marked.octants.push_back(all[i]);
      }
  return marked;
}

/// Counts the points and allots their places: voxel_start, count, thin_count.
void allot_points(Backend& backend, const BitView& object, const BitView& refine,
                  PointCloud& points) {
  const std::size_t voxels = points.bricks.count * kBrickCells;
  points.voxel_start = Buffer<std::uint32_t>(backend, voxels + 1);
  const View<std::uint32_t> counts = points.voxel_start.view().subview(0, voxels);
  Buffer<std::uint32_t> refined(backend, points.bricks.count);
  backend.points_count(object, refine, points.bricks.view(), counts, refined.view());
  points.count = backend.exclusive_scan(counts, points.voxel_start.view());
  std::vector<std::uint32_t> refined_counts(points.bricks.count);
  backend.download<std::uint32_t>(refined.view(), refined_counts);
  points.thin_count = std::accumulate(refined_counts.begin(), refined_counts.end(), std::size_t{0});
  for (int axis = 0; axis < 3; ++axis) {
    points.position[axis] = Buffer<float>(backend, points.count);
    points.area[axis] = Buffer<float>(backend, points.count);
  }
  points.thickness = Buffer<float>(backend, points.count);
}

/// Newton's method from a power of two above: the library's last bit is its own. \pre x > 0.
double cube_root(double x) {
  int exponent = 0;
  std::frexp(x, &exponent);
  double root = std::ldexp(1.0, (exponent + 2) / 3);
  for (int step = 0; step < 10; ++step) root = (2 * root + x / (root * root)) / 3;
  return root;
}

}  // namespace

double voxel_length(const Geometry& geometry) {
  return cube_root(geometry.spacing[0] * geometry.spacing[1] * geometry.spacing[2]);
}

Scale make_scale(const Geometry& geometry) {
  const auto& s = geometry.spacing;
  const double voxel = voxel_length(geometry);
  return {static_cast<float>(s[0] / voxel), static_cast<float>(s[1] / voxel),
          static_cast<float>(s[2] / voxel)};
}

BitVolume pack_volume(Backend& backend, const VolumeView& volume) {
  check_size(volume.geometry);
  BitVolume bits;
  for (int axis = 0; axis < 3; ++axis) {
    bits.size[axis] = static_cast<int>((volume.geometry.size[axis] + 2 * kPad + 7) / 8 * 8);
  }
  bits.words_per_row = (bits.size[0] + 63) / 64;
  bits.words = Buffer<std::uint64_t>(backend, bits.view().word_count());
  backend.volume_pack(volume, bits.size, bits.words_per_row, bits.words.view());
  return bits;
}

PointCloud extract_points(Backend& backend, const BitVolume& volume, const Scale& scale) {
  const BitView object = volume.view();
  Buffer<std::uint64_t> thin_words(backend, object.word_count());
  Buffer<std::uint64_t> refine_words(backend, object.word_count());
  // thin = O \ (O opened by the 3 x 3 x 3 cube), the top-hat
  backend.points_thin_mask(object, thin_words.view(), refine_words.view());
  const BitView thin{object.size, object.words_per_row, thin_words.view()};
  const BitView refine{object.size, object.words_per_row, refine_words.view()};

  PointCloud points;
  const Marked marked = mark_bricks(backend, object);
  points.bricks = make_bricks(backend, marked.coords);
  points.octants = Buffer<std::uint8_t>(backend, marked.octants.size());
  backend.upload<std::uint8_t>(points.octants.view(), marked.octants);
  allot_points(backend, object, refine, points);
  backend.points_emit(object, thin, refine, points.bricks.view(), points.voxel_start.view(), scale,
                      points.output());
  return points;
}

}  // namespace vasamesh
