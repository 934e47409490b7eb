/// \file
/// Places round points, and parts of meshes that are cut out round them.

#include "stages/places.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "stages/mesh_parts.h"
#include "support/host_backend.h"
#include "support/shapes.h"
#include "types/mesh_vertex.h"

namespace vasamesh::test {
namespace {

std::vector<Vec3> random_points(std::size_t count, float side) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> along(-0.3f * side, side);
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < count; ++i)
    points.push_back({along(random), along(random), along(random)});
  return points;
}

TEST(Places, EachPointThatNoPlaceBeforeCoversToHalfGetsOne) {
  constexpr float kRadius = 2.5f;
  std::vector<CarefulPlace> places = {{{3, 3, 3}, 1, 0.5f}}, plain = places;
  for (const std::size_t count : {0, 1, 37, 900}) {
    const std::vector<Vec3> points = random_points(count, 20);
    add_places(points, kRadius, 0.7f, places);
    for (const Vec3& p : points)
      if (std::none_of(plain.begin(), plain.end(), [&](const CarefulPlace& place) {
            return squared_norm(p - place.centre) < 0.25f * (kRadius * kRadius);
          }))
        plain.push_back({p, kRadius, 0.7f});
    ASSERT_EQ(places.size(), plain.size());
    for (std::size_t i = 0; i < plain.size(); ++i) {
      EXPECT_EQ(places[i].centre, plain[i].centre);
      EXPECT_EQ(places[i].radius, plain[i].radius);
      EXPECT_EQ(places[i].factor, plain[i].factor);
    }
  }
}

TEST(Parts, SeveralAtOnceAreThoseOneByOne) {
  const TriangleMesh mesh = torus(9, 2, 31, 9);
  std::vector<std::uint8_t> part(mesh.triangle_count());
  for (std::size_t t = 0; t < part.size(); ++t) {
    const float x = vertex_at(mesh, mesh.triangles[3 * t]).x;
    part[t] = x > 5 ? 1 : x < -5 ? 3 : 0;
  }
  const std::vector<TriangleMesh> parts = parts_of(mesh, part, 3);
  ASSERT_EQ(parts.size(), 3u);
  for (std::uint8_t p = 1; p <= 3; ++p) {
    std::vector<std::uint8_t> chosen(part.size());
    for (std::size_t t = 0; t < part.size(); ++t) chosen[t] = part[t] == p;
    const TriangleMesh one = part_of(host(), mesh, chosen);
    EXPECT_EQ(parts[p - 1].vertices, one.vertices);
    EXPECT_EQ(parts[p - 1].triangles, one.triangles);
    EXPECT_EQ(one.triangles.empty(), p == 2);
  }
}

}  // namespace
}  // namespace vasamesh::test
