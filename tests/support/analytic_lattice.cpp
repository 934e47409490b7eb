#include "support/analytic_lattice.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "stages/bricks.h"
#include "stages/surface.h"
#include "support/backends.h"

namespace vasamesh::test {

Lattice analytic_lattice(Backend& backend, const std::array<int, 3>& size, const Scale& scale,
                         const Solid3& solid, const std::function<bool(const BrickCoord&)>& keep) {
  std::vector<BrickCoord> coords;
  for (int z = 0; z < size[2] / 4; ++z)
    for (int y = 0; y < size[1] / 4; ++y)
      for (int x = 0; x < size[0] / 4; ++x)
        if (!keep || keep({x, y, z})) coords.push_back({x, y, z});
  std::vector<std::uint8_t> state;
  std::vector<float> values;
  for (const BrickCoord& b : coords)
    for (int c = 0; c < kBrickCells; ++c) {
      const float x = 0.5f * static_cast<float>(8 * b.x + c % 8);
      const float y = 0.5f * static_cast<float>(8 * b.y + c / 8 % 8);
      const float z = 0.5f * static_cast<float>(8 * b.z + c / 64);
      values.push_back(solid({scale[0] * x, scale[1] * y, scale[2] * z}));
      state.push_back(values.back() > 0 ? kLabel | kFree : kFree);
    }
  Lattice lattice;
  lattice.bricks = make_bricks(backend, coords);
  lattice.state = to_backend(backend, state);
  lattice.values = to_backend(backend, values);
  return lattice;
}

AnalyticScene::AnalyticScene(Backend& backend, const std::array<int, 3>& size, const Solid3& solid,
                             const Scale& scale) {
  const Lattice lattice = analytic_lattice(backend, size, scale, solid);
  field = make_field(backend, lattice, size, scale);
  surface = extract_base_surface(backend, lattice);
  for (std::size_t i = 0; i < surface.vertices.size(); ++i) surface.vertices[i] *= scale[i % 3];
}

Solid3 ball(const Vec3& centre, float radius) {
  return [=](const Vec3& p) { return radius - norm(p - centre); };
}

Solid3 ring(const Vec3& centre, float large, float small) {
  return [=](const Vec3& p) {
    const Vec3 d = p - centre;
    const float out = std::sqrt(d.x * d.x + d.y * d.y) - large;
    return small - std::sqrt(out * out + d.z * d.z);
  };
}

Solid3 capsule(const Vec3& a, const Vec3& b, float radius) {
  return [=](const Vec3& p) {
    const Vec3 along = b - a;
    const float at = std::clamp(dot(p - a, along) / squared_norm(along), 0.0f, 1.0f);
    return radius - norm(p - a - at * along);
  };
}

Solid3 joined(std::vector<Solid3> solids, float blend) {
  return [solids = std::move(solids), blend](const Vec3& p) {
    float most = solids[0](p);
    for (std::size_t i = 1; i < solids.size(); ++i) {
      const float other = solids[i](p);
      const float share = std::max(blend - std::fabs(most - other), 0.0f) / blend;
      most = std::max(most, other) + 0.25f * blend * share * share;
    }
    return most;
  };
}

Solid3 random_tree(unsigned seed, int branches, float side) {
  std::mt19937 random(seed);
  const auto between = [&](float low, float high) {
    return low + (high - low) * static_cast<float>(random() % 10001) / 10000.0f;
  };
  const auto place = [&] {
    return Vec3{between(6, side - 6), between(6, side - 6), between(6, side - 6)};
  };
  std::vector<Vec3> ends = {place()};
  std::vector<Solid3> tubes;
  while (static_cast<int>(tubes.size()) < branches) {
    const Vec3 from = ends[random() % ends.size()], to = place();
    if (norm(to - from) < 8) continue;
    tubes.push_back(capsule(from, to, between(1.5f, 3)));
    ends.push_back(to);
  }
  return joined(tubes, 1.5f);
}

}  // namespace vasamesh::test
