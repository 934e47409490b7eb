/// \file
/// Polygons of surface files: concave ones are cut without a triangle that turns round, in each
/// format, whichever corner is the first; convex ones are fans.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "io/surface_io.h"
#include "support/invariants.h"
#include "support/scratch.h"

namespace vasamesh {
namespace {

using Polygon = std::vector<std::array<int, 2>>;

std::string line_of(const std::vector<int>& numbers, int add = 0) {
  std::string text;
  for (const int number : numbers) text.append(" ").append(std::to_string(number + add));
  return text + "\n";
}

/// A polygon of the plane as bottom and top, and quads round it.
class Prism {
 public:
  explicit Prism(const Polygon& polygon) : faces_(2) {
    const int count = static_cast<int>(polygon.size());
    for (const int z : {0, 1})
      for (const auto& [x, y] : polygon) points_.push_back({x, y, z});
    for (int i = 0; i < count; ++i) {
      const int next = (i + 1) % count;
      faces_[0].push_back(count - 1 - i);
      faces_[1].push_back(count + i);
      faces_.push_back({i, next, count + next, count + i});
    }
  }

  std::string obj() const {
    std::string text;
    for (const auto& point : points_) text.append("v").append(line_of(point));
    for (const auto& face : faces_) text.append("f").append(line_of(face, 1));
    return text;
  }

  std::string ply() const {
    return "ply\nformat ascii 1.0\nelement vertex " + std::to_string(points_.size()) +
           "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
           std::to_string(faces_.size()) +
           "\nproperty list uchar int vertex_indices\nend_header\n" + point_lines() + face_lines();
  }

  std::string vtk() const {
    std::size_t numbers = 0;
    for (const auto& face : faces_) numbers += face.size() + 1;
    return "# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\nPOINTS " +
           std::to_string(points_.size()) + " float\n" + point_lines() + "POLYGONS " +
           std::to_string(faces_.size()) + " " + std::to_string(numbers) + "\n" + face_lines();
  }

 private:
  std::string point_lines() const {
    std::string text;
    for (const auto& point : points_) text += line_of(point);
    return text;
  }

  std::string face_lines() const {
    std::string text;
    for (const auto& face : faces_) text += std::to_string(face.size()) + line_of(face);
    return text;
  }

  std::vector<std::vector<int>> points_, faces_;
};

class Polygons : public testing::Test {
 protected:
  TriangleMesh read(const std::string& name, const std::string& bytes) {
    write_text(scratch_ / name, bytes);
    return read_surface(scratch_ / name);
  }

  Scratch scratch_;
};

TEST_F(Polygons, ConcaveOnes) {
  const std::vector<Polygon> polygons = {
      {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}},
      {{0, 0}, {3, 0}, {1, 1}, {0, 3}},
      {{0, 0}, {1, 0}, {2, 0}, {2, 2}, {0, 2}, {0, 1}},  // with corners on its edges
      {{0, 0},
       {7, 0},
       {7, 3},
       {6, 3},
       {6, 1},
       {4, 1},
       {4, 3},
       {3, 3},
       {3, 1},
       {1, 1},
       {1, 3},
       {0, 3}}};
  for (Polygon polygon : polygons)
    for (std::size_t first = 0; first < polygon.size(); ++first) {
      std::rotate(polygon.begin(), polygon.begin() + 1, polygon.end());
      const Prism prism(polygon);
      const TriangleMesh mesh = read("a.obj", prism.obj());
      EXPECT_EQ(mesh.triangle_count(), 4 * polygon.size() - 4);
      test::expect_good_surface(mesh, Topology{1, 0, 0});
      EXPECT_EQ(read("a.ply", prism.ply()).triangles, mesh.triangles);
      EXPECT_EQ(read("a.vtk", prism.vtk()).triangles, mesh.triangles);
    }
}

TEST_F(Polygons, ConvexOnesAreFans) {
  const TriangleMesh mesh = read("a.obj", Prism({{0, 0}, {5, 0}, {5, 4}, {4, 5}, {0, 5}}).obj());
  const std::vector<std::uint32_t> top(mesh.triangles.begin() + 9, mesh.triangles.begin() + 18);
  EXPECT_EQ(top, (std::vector<std::uint32_t>{5, 6, 7, 5, 7, 8, 5, 8, 9}));
}

TEST_F(Polygons, WhatCannotBeCutStaysAFan) {
  const std::vector<std::uint32_t> fan = {0, 1, 2, 0, 2, 3};
  for (const char* points : {"v 0 0 0\nv 2 2 0\nv 2 0 0\nv 0 2 0\n",  // crosses itself
                             "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 3 0 0\n",  // has no area
                             "v 0 0 0\nv 0 0 0\nv 0 0 0\nv 0 0 0\n"})
    EXPECT_EQ(read("a.obj", points + std::string("f 1 2 3 4\n")).triangles, fan);
}

}  // namespace
}  // namespace vasamesh
