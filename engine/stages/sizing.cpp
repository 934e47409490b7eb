#include "stages/sizing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "backend/in_steps.h"
#include "backend/ranges.h"
#include "stages/adjacency.h"
#include "stages/compass.h"
#include "stages/lower_to.h"
#include "types/box.h"
#include "types/mesh_vertex.h"

namespace vasamesh {

namespace {

constexpr std::size_t kCells = 64;  // size cells a brick
constexpr std::size_t kTriangleGrain = 8192, kVertexGrain = 8192, kBrickGrain = 32;
constexpr float kSmallShell = 1;  // voxel lengths: half the longest side of the box round a shell
constexpr float kMostOfRadius = 1.25f;    // of an edge
constexpr float kRings[] = {1, 1, 2, 3};  // steps to the distances at which normals are compared
constexpr std::uint32_t kNoVertex = 0xffffffffu;

/// The first base vertex of each cell, not yet on the zero set.
SurfaceSamples first_vertices(Backend& backend, const FieldView& field,
                              const TriangleMesh& surface) {
  const std::size_t cells = field.coefficients.size / kBrickCells * kCells;
  auto first = filled_in_steps(backend, cells + 1, kNoVertex);
  for_each_index(backend, surface.vertex_count(), kVertexGrain, [&](std::size_t v) {
    lower_to(first[size_cell(field, vertex_at(surface, v))], static_cast<std::uint32_t>(v));
  });
  SurfaceSamples samples;
  in_steps(backend, cells, [&](std::size_t cell) {
    if (first[cell] == kNoVertex) return;
    samples.cell.push_back(static_cast<std::uint32_t>(cell));
    samples.position.push_back(vertex_at(surface, first[cell]));
  });
  samples.normal.resize(samples.count());
  samples.radius.resize(samples.count());
  return samples;
}

/// Puts the samples on the zero set and takes normals and radii there.
void measure(Backend& backend, const FieldView& field, float ample, SurfaceSamples& samples) {
  Buffer<Vec3> positions(backend, samples.count()), normals(backend, samples.count());
  Buffer<float> radii(backend, samples.count());
  backend.upload<Vec3>(positions.view(), samples.position);
  backend.sizing_measure(field, ample, positions.view(), normals.view(), radii.view());
  backend.download<Vec3>(positions.view(), samples.position);
  backend.download<Vec3>(normals.view(), samples.normal);
  backend.download<float>(radii.view(), samples.radius);
}

float size_for(const SizeRule& rule, float radius) {
  if (!(radius > 0)) return rule.edge_min;
  const float curved =
      rule.chord_error > 0 ? std::sqrt(8 * rule.chord_error * radius) : rule.rho * radius;
  const float wanted = std::clamp(curved, rule.edge_min, rule.edge_max);
  return std::min(wanted, kMostOfRadius * radius);
}

/// The values of a brick and of the cells round it.
struct SizeHalo {
  /// \param near  the brick's entries of the neighbour table.
  SizeHalo(const std::int32_t* near, const float* values, float outside) {
    const float* brick[27];
    for (int n = 0; n < 27; ++n)
      brick[n] =
          near[n] == kNoBrick ? nullptr : values + kCells * static_cast<std::size_t>(near[n]);
    for (int z = 0; z < 6; ++z)
      for (int y = 0; y < 6; ++y) {
        const float* const* row = brick + 3 * ((y + 3) >> 2) + 9 * ((z + 3) >> 2);
        const int first = 4 * (((y + 3) & 3) + 4 * ((z + 3) & 3));
        float* to = value[z][y];
        to[0] = row[0] ? row[0][first + 3] : outside;
        for (int x = 0; x < 4; ++x) to[x + 1] = row[1] ? row[1][first + x] : outside;
        to[5] = row[2] ? row[2][first] : outside;
      }
  }

  void copy_own(float* out) const {
    for (int row = 0; row < 16; ++row)
      std::copy_n(&value[row / 4 + 1][row % 4 + 1][1], 4, out + 4 * row);
  }

  float value[6][6][8];  ///< z, y, x, each from one cell before the brick's first
};

/// What a step to a neighbour costs: along the axes of the bits (x, y, z) of the entry's number.
struct StepCosts {
  StepCosts(const Scale& voxel, float growth) {
    for (int n = 0; n < 8; ++n) {
      const float x = voxel[0] * static_cast<float>(n & 1);
      const float y = voxel[1] * static_cast<float>(n >> 1 & 1);
      const float z = voxel[2] * static_cast<float>(n >> 2);
      cost[n] = growth * norm({x, y, z});
    }
    least = std::min({cost[1], cost[2], cost[4]});
  }
  float cost[8];
  float least;
};

using SizeRow = std::array<float, 4>;

SizeRow lesser(const SizeRow& a, const SizeRow& b) {
  SizeRow row;
  for (std::size_t x = 0; x < 4; ++x) row[x] = a[x] < b[x] ? a[x] : b[x];
  return row;
}

SizeRow row_from(const float* values) { return {values[0], values[1], values[2], values[3]}; }

/// Each of the brick's own values as its neighbours allow it: the least of those at both ends of an
/// axis goes on with one cost.
void lower(const SizeHalo& halo, const StepCosts& steps, SizeRow (&least)[4][4]) {
  SizeRow along_x[2][6][6], along_y[4][6][4];  // z, y; bits as those of the costs
  for (int z = 0; z < 6; ++z)
    for (int y = 0; y < 6; ++y) {
      const float* row = halo.value[z][y];
      along_x[0][z][y] = row_from(row + 1);
      along_x[1][z][y] = lesser(row_from(row), row_from(row + 2));
    }
  for (int n = 0; n < 2; ++n)
    for (int z = 0; z < 6; ++z)
      for (int y = 0; y < 4; ++y) {
        along_y[n][z][y] = along_x[n][z][y + 1];
        along_y[n + 2][z][y] = lesser(along_x[n][z][y], along_x[n][z][y + 2]);
      }
  for (int z = 0; z < 4; ++z)
    for (int y = 0; y < 4; ++y) {
      SizeRow row = along_y[0][z + 1][y];
      for (int n = 1; n < 8; ++n) {
        const auto& plane = along_y[n & 3];
        SizeRow there = n < 4 ? plane[z + 1][y] : lesser(plane[z][y], plane[z + 2][y]);
        for (float& value : there) value += steps.cost[n];
        row = lesser(there, row);
      }
      least[z][y] = row;
    }
}

/// Whether no value of the halo is low enough to lower one of the brick's own.
bool obeys(const SizeHalo& halo, const StepCosts& steps) {
  SizeRow least = row_from(halo.value[0][0]), most = row_from(&halo.value[1][1][1]);
  for (int z = 0; z < 6; ++z)
    for (int y = 0; y < 6; ++y) {
      const float* row = halo.value[z][y];
      least = lesser(least, lesser(row_from(row), row_from(row + 2)));
      if (y == 0 || y == 5 || z == 0 || z == 5) continue;
      for (std::size_t x = 0; x < 4; ++x) most[x] = std::max(most[x], row[x + 1]);
    }
  return *std::min_element(least.begin(), least.end()) + steps.least >=
         *std::max_element(most.begin(), most.end());
}

/// Lowers the brick's own values until each obeys those round it; those of other bricks stay.
void relax(const StepCosts& steps, SizeHalo& halo) {
  for (bool changed = !obeys(halo, steps); changed;) {
    SizeRow least[4][4];
    lower(halo, steps, least);
    changed = false;
    for (std::size_t z = 0; z < 4; ++z)
      for (std::size_t y = 0; y < 4; ++y) {
        float* own = &halo.value[z + 1][y + 1][1];
        changed = changed || !std::equal(own, own + 4, least[z][y].begin());
        std::copy_n(least[z][y].begin(), 4, own);
      }
  }
}

/// Whether a brick or one round it is flagged.
bool any_of(const std::int32_t* near, const std::vector<std::uint8_t>& flags) {
  for (int n = 0; n < 27; ++n)
    if (near[n] != kNoBrick && flags[static_cast<std::size_t>(near[n])]) return true;
  return false;
}

/// The mean curvature over a cell and those round it that the surface passes; `none` elsewhere.
void average(const SizeHalo& halo, float none, float* out) {
  for (int z = 0; z < 4; ++z)
    for (int y = 0; y < 4; ++y)
      for (int x = 0; x < 4; ++x, ++out) {
        if (*out == none) continue;
        float sum = 0, count = 0;
        for (int n = 0; n < 27; ++n) {
          const float value = halo.value[z + n / 9][y + n / 3 % 3][x + n % 3];
          if (value == none) continue;
          sum += value;
          count += 1;
        }
        *out = sum / count;
      }
}

/// Each radius of curvature becomes that of the mean curvature round it.
void smooth_radii(Backend& backend, const IndicatorField& field, SurfaceSamples& samples) {
  constexpr float kNoValue = -1;
  const std::int32_t* near = field.neighbours.view().data();
  const std::size_t bricks = field.brick_count();
  auto curvature = filled_in_steps(backend, bricks * kCells, kNoValue);
  in_steps(backend, samples.count(), [&](std::size_t i) {
    if (samples.radius[i] > 0) curvature[samples.cell[i]] = 1 / samples.radius[i];
  });
  std::vector<float> smooth;
  append_in_steps<float>(backend, curvature, smooth);
  for_each_index(backend, bricks, kBrickGrain, [&](std::size_t b) {
    average(SizeHalo(near + 27 * b, curvature.data(), kNoValue), kNoValue, &smooth[kCells * b]);
  });
  in_steps(backend, samples.count(), [&](std::size_t i) {
    if (samples.radius[i] > 0) samples.radius[i] = 1 / smooth[samples.cell[i]];
  });
}

/// Vertices of a shell that follow one another, and the box round them.
struct ShellRun {
  std::uint32_t shell;
  Box box;

  float radius() const { return 0.5f * box.longest_side(); }
};

/// Of each shell (joined by vertices) the box, as one run.
std::vector<ShellRun> whole_shells(Backend& backend, const TriangleMesh& surface,
                                   const std::vector<std::uint32_t>& shell) {
  const auto find = [&](std::size_t begin, std::size_t end, std::vector<ShellRun>& runs) {
    for (std::size_t v = begin; v < end; ++v) {
      const Vec3 at = vertex_at(surface, v);
      if (runs.empty() || runs.back().shell != shell[v])
        runs.push_back({shell[v], {at, at}});
      else
        runs.back().box.take_in(at);
    }
  };
  const auto runs = collect<ShellRun>(backend, shell.size(), kVertexGrain, find);
  std::unordered_map<std::uint32_t, std::size_t> index;  // of a shell in:
  std::vector<ShellRun> shells;
  in_steps(backend, runs.size(), [&](std::size_t i) {
    const auto [found, fresh] = index.try_emplace(runs[i].shell, shells.size());
    if (fresh)
      shells.push_back(runs[i]);
    else
      shells[found->second].box.take_in(runs[i].box);
  });
  return shells;
}

/// Shells within a ball of kSmallShell have its radius of curvature at most: the function hardly
/// shows them, and at a voxel's distance other sheets.
void bound_by_shells(Backend& backend, const FieldView& field, const TriangleMesh& surface,
                     SurfaceSamples& samples) {
  const std::vector<std::uint32_t> shell = connect_vertices(backend, surface);
  std::vector<float> radius;  // of a shell, where some are small
  for (const ShellRun& whole : whole_shells(backend, surface, shell)) {
    if (whole.radius() >= kSmallShell) continue;
    radius.resize(shell.size(), kSmallShell);
    radius[whole.shell] = whole.radius();
  }
  if (radius.empty()) return;
  auto bound =
      filled_in_steps(backend, field.coefficients.size / kBrickCells * kCells, kSmallShell);
  in_steps(backend, shell.size(), [&](std::size_t v) {
    if (radius[shell[v]] >= kSmallShell) return;
    float& here = bound[size_cell(field, vertex_at(surface, v))];
    here = std::min(here, radius[shell[v]]);
  });
  in_steps(backend, samples.count(), [&](std::size_t i) {
    const float most = bound[samples.cell[i]];
    if (most < kSmallShell && !(samples.radius[i] > 0 && samples.radius[i] < most))
      samples.radius[i] = most;
  });
}

/// Sum over the triangles of their area over that of an equilateral one of the size there.
double predict_triangles(Backend& backend, const SizeView& sizes, const TriangleMesh& surface) {
  const auto predict = [&](std::size_t begin, std::size_t end) {
    double sum = 0;
    for (std::size_t t = begin; t < end; ++t) {
      const Vec3 a = vertex_at(surface, surface.triangles[3 * t]);
      const Vec3 b = vertex_at(surface, surface.triangles[3 * t + 1]);
      const Vec3 c = vertex_at(surface, surface.triangles[3 * t + 2]);
      const float h = size_at(sizes, a);
      sum += 0.5f * norm(cross(b - a, c - a)) / (0.4330127f * (h * h));
    }
    return sum;
  };
  return reduce_ranges(backend, surface.triangle_count(), kTriangleGrain, 0.0, predict);
}

/// A walk over the surface: where it has come to, and the tangent along which it goes on.
struct Walk {
  Vec3 at, direction;
};

/// Goes a step on. \return the square of d / (2 sin(theta / 2)) from p; 0 where no surface is
/// found, and the walk stays where it was.
float walk_on(const FieldView& field, const Vec3& p, const Vec3& normal, float step, Walk& walk) {
  Vec3 q = walk.at + step * walk.direction;
  const FieldSample found = project_to_surface(field, step, kSampleSteps, q);
  if (!found.known) return 0;
  const Vec3 there = -normalised(found.gradient);
  walk = {q, normalised(walk.direction - dot(walk.direction, there) * there)};
  const float squared = squared_norm(q - p) / std::max(squared_norm(normal - there), 1e-12f);
  return std::min(squared, kLargestRadius * kLargestRadius);
}

/// The least factor of the places that hold a point, at least 0.4; 1 in none.
float place_factor(std::span<const CarefulPlace> places, const Vec3& p) {
  constexpr float kLeast = 0.4f;
  float factor = 1;
  for (const CarefulPlace& place : places)
    if (place.holds(p)) factor = std::min(factor, std::max(place.factor, kLeast));
  return factor;
}

}  // namespace

float radius_of_curvature(const FieldView& field, const Vec3& p, const Vec3& normal, float ample) {
  const std::array<Vec3, 6> directions = hexagon_across(normal);
  std::array<Walk, 6> walks;
  for (std::size_t i = 0; i < walks.size(); ++i) walks[i] = {p, directions[i]};
  float least = 0, far = 0;
  for (const float step : kRings) {
    float here = kLargestRadius * kLargestRadius;
    for (Walk& walk : walks) {
      float squared = walk_on(field, p, normal, step, walk);
      if (!(squared > 0) && far == 0) squared = walk_on(field, p, normal, 0.5f * step, walk);
      here = std::min(here, squared);
    }
    if (!(here > 0) && far > 0) break;
    least = here;
    far += step;
    if (least < far * far || least >= ample * ample) break;
  }
  return std::sqrt(least);
}

float ample_radius(const SizeRule& rule) {
  constexpr float kMargin = 1.5f;
  const float longest = rule.edge_max;
  const float curved =
      rule.chord_error > 0 ? longest * longest / (8 * rule.chord_error) : longest / rule.rho;
  return std::min(kMargin * std::max(curved, longest / kMostOfRadius), kLargestRadius);
}

void grow_limited(Backend& backend, const IndicatorField& field, float growth,
                  Buffer<float>& values) {
  const Scale voxel = {2 * field.step[0], 2 * field.step[1], 2 * field.step[2]};
  const StepCosts steps(voxel, growth);
  const std::int32_t* near = field.neighbours.view().data();
  const std::size_t bricks = field.brick_count();
  Buffer<float> next(backend, values.size());
  std::vector<std::uint8_t> changed(bricks, 1), changes(bricks);
  while (std::find(changed.begin(), changed.end(), 1) != changed.end()) {
    const float* from = backend.on_host(std::as_const(values).view()).data();
    float* to = backend.on_host(next.view()).data();
    for_each_index(backend, bricks, kBrickGrain, [&](std::size_t b) {
      const float* own = from + kCells * b;
      std::copy_n(own, kCells, to + kCells * b);
      changes[b] = 0;
      if (!any_of(near + 27 * b, changed)) return;
      SizeHalo halo(near + 27 * b, from, kLargestRadius);
      relax(steps, halo);
      halo.copy_own(to + kCells * b);
      changes[b] = !std::equal(own, own + kCells, to + kCells * b);
    });
    std::swap(values, next);
    std::swap(changed, changes);
  }
}

SizeField make_sizes(Backend& backend, const IndicatorField& field, const TriangleMesh& surface,
                     const SizeRule& rule, float ample) {
  const FieldView view = field.view();
  SizeField result;
  result.samples = first_vertices(backend, view, surface);
  measure(backend, view, ample, result.samples);
  smooth_radii(backend, field, result.samples);
  bound_by_shells(backend, view, surface, result.samples);
  result.sizes = Buffer<float>(backend, view.coefficients.size / kBrickCells * kCells);
  apply_rule(backend, field, surface, rule, {}, result);
  return result;
}

void apply_rule(Backend& backend, const IndicatorField& field, const TriangleMesh& surface,
                const SizeRule& rule, std::span<const CarefulPlace> places, SizeField& sizes) {
  sizes.largest = rule.edge_max;
  const auto values = backend.on_host(sizes.sizes.view());
  std::fill(values.begin(), values.end(), rule.edge_max);
  in_steps(backend, sizes.samples.count(), [&](std::size_t i) {
    values[sizes.samples.cell[i]] =
        place_factor(places, sizes.samples.position[i]) * size_for(rule, sizes.samples.radius[i]);
  });
  grow_limited(backend, field, rule.gradation, sizes.sizes);
  sizes.predicted_triangles = predict_triangles(backend, sizes.view(field), surface);
}

}  // namespace vasamesh
