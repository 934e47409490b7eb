/// \file
/// vasamesh_normals_table: angles between estimated and exact normals on round tubes, by radius and
/// mode, as a Markdown table on stdout. Each row is six tubes of random directions and places.

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "stages/normals.h"
#include "stages/points.h"
#include "tbb/backend.h"

namespace vasamesh {
namespace {

using Vector = std::array<double, 3>;

constexpr int kTubes = 6;
constexpr double kHalfLength = 25;  // voxels
constexpr double kRadii[] = {0.7, 1, 2.5, 5};

double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// A straight tube with round ends. Lengths in voxels (geometric mean of the spacings), from the
/// volume's corner.
struct Tube {
  Vector centre, direction;
  double radius;

  /// From the nearest point of the axis to p.
  Vector from_axis(const Vector& p) const {
    Vector q{p[0] - centre[0], p[1] - centre[1], p[2] - centre[2]};
    const double t = std::clamp(dot(q, direction), -kHalfLength, kHalfLength);
    for (std::size_t a = 0; a < 3; ++a) q[a] -= t * direction[a];
    return q;
  }
};

struct Segmented {
  Tube tube;
  Geometry geometry;
  std::vector<std::uint8_t> voxels;
};

Segmented make_tube(double radius, const Vector& spacing, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> shift(-0.5, 0.5);
  Segmented made{{{}, {normal(random), normal(random), normal(random)}, radius}, {}, {}};
  const double length = std::sqrt(dot(made.tube.direction, made.tube.direction));
  made.geometry.spacing = spacing;
  const Scale scale = make_scale(made.geometry);
  auto& size = made.geometry.size;
  for (std::size_t a = 0; a < 3; ++a) {
    made.tube.direction[a] /= length;
    const double extent = 2 * (kHalfLength * std::fabs(made.tube.direction[a]) + radius + 1.5);
    made.tube.centre[a] = extent / 2 + shift(random);
    size[a] = static_cast<std::int64_t>(std::ceil(extent / scale[a]));
  }
  for (std::int64_t z = 0; z < size[2]; ++z)
    for (std::int64_t y = 0; y < size[1]; ++y)
      for (std::int64_t x = 0; x < size[0]; ++x) {
        const Vector away = made.tube.from_axis({(static_cast<double>(x) + 0.5) * scale[0],
                                                 (static_cast<double>(y) + 0.5) * scale[1],
                                                 (static_cast<double>(z) + 0.5) * scale[2]});
        made.voxels.push_back(dot(away, away) <= radius * radius);
      }
  return made;
}

/// Appends the angles of all points' normals, in degrees.
void append_angles(Backend& backend, const Segmented& made, NormalMode mode,
                   std::vector<double>& angles) {
  const Scale scale = make_scale(made.geometry);
  const BitVolume object =
      pack_volume(backend, {made.voxels.data(), VoxelFormat::bytes, made.geometry});
  PointCloud points = extract_points(backend, object, scale);
  Parameters parameters;
  parameters.normals = mode;
  estimate_normals(backend, object, scale, parameters, points);
  const PointView view = points.view();
  for (std::size_t i = 0; i < view.count; ++i) {
    Vector p, n;
    for (std::size_t a = 0; a < 3; ++a) {
      p[a] = (static_cast<double>(view.position[a][i]) - kPad) * scale[a];
      n[a] = view.normal[a][i];
    }
    const Vector exact = made.tube.from_axis(p);
    const double cosine = dot(n, exact) / std::sqrt(dot(n, n) * dot(exact, exact));
    angles.push_back(std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / std::acos(-1.0));
  }
}

void print_row(Backend& backend, double radius, const Vector& spacing, NormalMode mode) {
  std::vector<double> angles;
  for (unsigned seed = 1; seed <= kTubes; ++seed)
    append_angles(backend, make_tube(radius, spacing, seed), mode, angles);
  std::sort(angles.begin(), angles.end());
  double sum = 0;
  for (const double angle : angles) sum += angle;
  const auto flipped =
      std::count_if(angles.begin(), angles.end(), [](double a) { return a >= 90; });
  fmt::print("| {} | {} x {} x {} | {} | {} | {:.1f} | {:.1f} | {:.1f} | {} |\n",
             mode == NormalMode::covariance ? "covariance" : "gradient", spacing[0], spacing[1],
             spacing[2], radius, angles.size(), sum / static_cast<double>(angles.size()),
             angles[angles.size() * 95 / 100], angles.back(), flipped);
}

}  // namespace
}  // namespace vasamesh

int main() {
  using namespace vasamesh;
  const auto backend = make_tbb_backend(2, nullptr);
  fmt::print(
      "# Normals of tubes\n\n"
      "Angle between the estimated and the exact normal, degrees. Written by\n"
      "`vasamesh_normals_table`: six tubes of random directions a row, round ends included. A\n"
      "flipped normal is 90 degrees or more away. The limits, for radii of 2.5 voxels or more:\n"
      "mean 8 and 95th percentile 16 (covariance), 5 and 10 (gradient), none flipped.\n\n"
      "| mode | spacing | radius, voxels | points | mean | 95th percentile | largest | flipped |\n"
      "|---|---|---|---|---|---|---|---|\n");
  for (const NormalMode mode : {NormalMode::covariance, NormalMode::gradient})
    for (const Vector& spacing : {Vector{1, 1, 1}, Vector{0.51, 0.51, 0.8}})
      for (const double radius : kRadii) print_row(*backend, radius, spacing, mode);
}
