#pragma once

/// \file
/// Surface files of a test's own.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <random>
#include <string>

#include "io/surface_io.h"
#include "support/scratch.h"
#include "vasamesh/errors.h"

namespace vasamesh {

inline constexpr const char* kFormats[] = {"a.vtp", "a.stl", "a.ply", "a.obj"};

/// A strip of triangles over random vertices of awkward magnitudes, each vertex used.
inline TriangleMesh random_mesh(std::size_t vertices) {
  std::mt19937 random(17);
  std::uniform_real_distribution<float> coordinate(-300, 300);
  TriangleMesh mesh;
  for (std::size_t i = 0; i < 3 * vertices; ++i) {
    mesh.vertices.push_back(coordinate(random) * (i % 7 == 0 ? 1e-6f : 1.0f));
  }
  mesh.vertices[4] = std::numeric_limits<float>::denorm_min();
  mesh.vertices[5] = -0.0f;
  for (std::uint32_t i = 0; i + 2 < vertices; ++i) {
    mesh.triangles.insert(mesh.triangles.end(), {i, i + 1 + i % 2, i + 2 - i % 2});
  }
  return mesh;
}

inline TriangleMesh tetrahedron() {
  return {{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2}};
}

class Surfaces : public ::testing::Test {
 protected:
  std::string write(const std::string& name, const std::string& bytes) {
    write_text(scratch_ / name, bytes);
    return scratch_ / name;
  }

  void expect_bad(const std::string& path, const std::string& reason) {
    ::testing::internal::CaptureStderr();
    ::testing::internal::CaptureStdout();
    try {
      read_surface(path);
      ADD_FAILURE() << path << " was read";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::bad_input) << error.what();
      EXPECT_THAT(error.what(), ::testing::HasSubstr(reason));
      EXPECT_THAT(error.what(), ::testing::HasSubstr(path));
      EXPECT_THAT(error.what(), ::testing::Not(::testing::HasSubstr("\n")));
    }
    EXPECT_EQ(::testing::internal::GetCapturedStdout(), "");
    EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
  }

  Scratch scratch_;
};

}  // namespace vasamesh
