/// \file
/// The project's own inputs: the same bytes again, the topology they claim, and exact surfaces that
/// are closed, lie where the shape's formula puts them and hold the voxels' volume.

#include "phantom/phantom.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <vtkCellArray.h>
#include <vtkFlyingEdges3D.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPolyData.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

#include "reference/topology.h"
#include "support/cases.h"
#include "vasamesh/errors.h"

namespace vasamesh {
namespace {

using test::count_cells;
using test::DenseVolume;

std::int64_t count_object(const Phantom& phantom) {
  return std::accumulate(phantom.voxels.begin(), phantom.voxels.end(), std::int64_t{0});
}

double voxel_volume(const Geometry& geometry) {
  return geometry.spacing[0] * geometry.spacing[1] * geometry.spacing[2];
}

std::array<double, 3> vertex(const TriangleMesh& mesh, std::uint32_t id) {
  return {mesh.vertices[3 * id], mesh.vertices[3 * id + 1], mesh.vertices[3 * id + 2]};
}

double mesh_volume(const TriangleMesh& mesh) {
  double six = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
    const auto a = vertex(mesh, mesh.triangles[t]), b = vertex(mesh, mesh.triangles[t + 1]),
               c = vertex(mesh, mesh.triangles[t + 2]);
    six += a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
           a[2] * (b[0] * c[1] - b[1] * c[0]);
  }
  return six / 6;
}

/// Edges that are not traversed once each way.
std::size_t unmatched_edges(const TriangleMesh& mesh) {
  using Edge = std::pair<std::uint32_t, std::uint32_t>;
  std::vector<Edge> there, back;
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3)
    for (int c = 0; c < 3; ++c) {
      const std::uint32_t a = mesh.triangles[t + c], b = mesh.triangles[t + (c + 1) % 3];
      there.emplace_back(a, b);
      back.emplace_back(b, a);
    }
  std::sort(there.begin(), there.end());
  std::sort(back.begin(), back.end());
  std::vector<Edge> unmatched;
  std::set_symmetric_difference(there.begin(), there.end(), back.begin(), back.end(),
                                std::back_inserter(unmatched));
  const bool repeated = std::adjacent_find(there.begin(), there.end()) != there.end();
  return unmatched.size() + repeated;
}

int euler_characteristic(const TriangleMesh& mesh) {
  return static_cast<int>(mesh.vertex_count()) - static_cast<int>(mesh.triangle_count() / 2);
}

DenseVolume dense(const Phantom& phantom) {
  const auto& size = phantom.geometry.size;
  DenseVolume volume(
      {static_cast<int>(size[0]), static_cast<int>(size[1]), static_cast<int>(size[2])});
  volume.voxels = phantom.voxels;
  return volume;
}

/// Triangles of marching cubes, of the voxels padded by nothing.
std::int64_t marching_cubes_triangles(const Phantom& phantom) {
  const auto& size = phantom.geometry.size;
  vtkNew<vtkImageData> image;
  image->SetDimensions(static_cast<int>(size[0]), static_cast<int>(size[1]),
                       static_cast<int>(size[2]));
  image->AllocateScalars(VTK_UNSIGNED_CHAR, 1);
  std::copy(phantom.voxels.begin(), phantom.voxels.end(),
            static_cast<std::uint8_t*>(image->GetScalarPointer()));
  vtkNew<vtkFlyingEdges3D> contour;
  contour->SetInputData(image);
  contour->SetValue(0, 0.5);
  contour->Update();
  return contour->GetOutput()->GetNumberOfPolys();
}

ErrorCode code_of(std::string_view name, const PhantomOptions& options) {
  try {
    make_phantom(name, options);
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    return error.code();
  }
  ADD_FAILURE() << name << ": nothing thrown";
  return ErrorCode::internal;
}

std::string label(const testing::TestParamInfo<PhantomCase>& info) { return info.param.label; }

class EveryPhantom : public testing::TestWithParam<PhantomCase> {};

TEST_P(EveryPhantom, HasZerosAndOnesOfItsGeometry) {
  const Phantom phantom = GetParam().make();
  const auto& size = phantom.geometry.size;
  EXPECT_EQ(phantom.voxels.size(), static_cast<std::size_t>(size[0] * size[1] * size[2]));
  EXPECT_LE(*std::max_element(phantom.voxels.begin(), phantom.voxels.end()), 1);
  EXPECT_GT(count_object(phantom), 0);
  for (int a = 0; a < 3; ++a)  // centred
    EXPECT_NEAR(phantom.geometry.origin[a],
                -0.5 * static_cast<double>(size[a] - 1) * phantom.geometry.spacing[a], 1e-9);
}

TEST_P(EveryPhantom, IsTheSameAgain) {
  EXPECT_EQ(GetParam().make().voxels, GetParam().make().voxels);
}

TEST_P(EveryPhantom, HasTheTopologyItClaims) {
  const Phantom phantom = GetParam().make();
  const Topology counted = count_cells(dense(phantom), 26);
  if (phantom.topology) {
    EXPECT_EQ(counted.pieces, phantom.topology->pieces);
    EXPECT_EQ(counted.handles, phantom.topology->handles);
    EXPECT_EQ(counted.cavities, phantom.topology->cavities);
  } else {
    EXPECT_EQ(counted.pieces, 1) << "a tree is one piece";
  }
}

INSTANTIATE_TEST_SUITE_P(Small, EveryPhantom, testing::ValuesIn(small_cases()), label);
INSTANTIATE_TEST_SUITE_P(Accuracy, EveryPhantom, testing::ValuesIn([] {
                           std::vector<PhantomCase> cases;
                           for (const PhantomCase& c : accuracy_cases())
                             if (c.label != c.name) cases.push_back(c);
                           return cases;
                         }()),
                         label);

int count_pieces(const Phantom& phantom) {
  const std::vector<int> pieces = test::flood(dense(phantom), true, 26);
  return 1 + *std::max_element(pieces.begin(), pieces.end());
}

TEST(Trees, AreOnePieceEachAndDiffer) {
  std::vector<std::uint8_t> before;
  for (const PhantomCase& tree : tree_cases(100)) {
    const Phantom phantom = tree.make();
    EXPECT_EQ(count_pieces(phantom), 1) << tree.label;
    EXPECT_NE(phantom.voxels, before) << tree.label;
    before = phantom.voxels;
  }
}

TEST(Trees, TakeASize) {
  PhantomOptions options;
  options.size = {{41, 66, 53}};
  options.seed = 7;
  const Phantom phantom = make_phantom("tree", options);
  EXPECT_EQ(phantom.geometry.size, *options.size);
  EXPECT_EQ(count_pieces(phantom), 1);
}

struct LargeTree {
  const char* name;
  std::array<std::int64_t, 3> size;
  std::array<double, 3> spacing;
  std::int64_t least_triangles, most_triangles;
};

class PaperTree : public testing::TestWithParam<LargeTree> {};

TEST_P(PaperTree, HasTheSizeOfTable1AndIsOnePiece) {
  const LargeTree& tree = GetParam();
  const Phantom phantom = make_phantom(tree.name);
  EXPECT_EQ(phantom.geometry.size, tree.size);
  EXPECT_EQ(phantom.geometry.spacing, tree.spacing);
  const std::int64_t triangles = marching_cubes_triangles(phantom);
  EXPECT_GE(triangles, tree.least_triangles);
  EXPECT_LE(triangles, tree.most_triangles);
  EXPECT_EQ(count_pieces(phantom), 1);
}

INSTANTIATE_TEST_SUITE_P(
    Table1, PaperTree,
    testing::Values(LargeTree{"cerebral", {512, 512, 170}, {0.51, 0.51, 0.80}, 60000, 100000},
                    LargeTree{"liver", {512, 512, 279}, {0.6563, 0.6563, 0.5}, 180000, 200000},
                    LargeTree{"aorta", {512, 512, 167}, {0.961, 0.961, 1.80}, 90000, 104000}),
    [](const auto& tree) { return std::string(tree.param.name); });

class ExactSurface : public testing::TestWithParam<PhantomCase> {
 protected:
  Phantom make() const {
    PhantomOptions options = GetParam().options;
    options.exact = true;
    options.exact_step = 0.5;
    return make_phantom(GetParam().name, options);
  }
};

TEST_P(ExactSurface, IsClosedWithTheVoxelsTopologyAndVolume) {
  const Phantom phantom = make();
  ASSERT_TRUE(phantom.exact && phantom.topology);
  EXPECT_EQ(unmatched_edges(*phantom.exact), 0u);
  const Topology& wanted = *phantom.topology;
  EXPECT_EQ(euler_characteristic(*phantom.exact),
            2 * (wanted.pieces + wanted.cavities - wanted.handles));
  const double voxels = static_cast<double>(count_object(phantom)) * voxel_volume(phantom.geometry);
  EXPECT_NEAR(mesh_volume(*phantom.exact) / voxels, 1, 0.02);
}

INSTANTIATE_TEST_SUITE_P(Accuracy, ExactSurface, testing::ValuesIn(accuracy_cases()), label);

TEST(ExactSurfaces, OfABallLiesOnTheSphere) {
  PhantomOptions options;
  options.exact = true;
  options.radius = 6;
  const Phantom phantom = make_phantom("sphere", options);
  const TriangleMesh& mesh = *phantom.exact;
  std::array<double, 3> centre{0, 0, 0};
  std::array<double, 3> low = vertex(mesh, 0), high = low;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
    for (int a = 0; a < 3; ++a) {
      low[a] = std::min(low[a], vertex(mesh, v)[a]);
      high[a] = std::max(high[a], vertex(mesh, v)[a]);
    }
  for (int a = 0; a < 3; ++a) centre[a] = 0.5 * (low[a] + high[a]);
  const double radius = 6 * 0.8;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    const auto p = vertex(mesh, v);
    const double away = std::hypot(p[0] - centre[0], p[1] - centre[1], p[2] - centre[2]);
    ASSERT_NEAR(away, radius, 0.002 * 0.8);
  }
}

TEST(ExactSurfaces, OfACutTubeEndAtTheBorderOfTheVoxels) {
  PhantomOptions options;
  options.exact = true;
  const Phantom phantom = make_phantom("cut_tube", options);
  const Geometry& geometry = phantom.geometry;
  int on_border = 0;
  for (std::size_t v = 0; v < phantom.exact->vertices.size(); ++v) {
    const int a = static_cast<int>(v % 3);
    const double limit = 0.5 * static_cast<double>(geometry.size[a]) * geometry.spacing[a];
    const double x = std::abs(phantom.exact->vertices[v]);
    ASSERT_LE(x, limit + 1e-4);
    on_border += x > limit - 1e-4;
  }
  EXPECT_GT(on_border, 100);
}

TEST(ExactSurfaces, AreMadeOnRequestOnly) {
  const Phantom phantom = make_phantom("torus");
  EXPECT_TRUE(phantom.has_exact);
  EXPECT_FALSE(phantom.exact);
  PhantomOptions options;
  options.exact = true;
  EXPECT_FALSE(make_phantom("speckle", options).exact);
}

TEST(TwoTubes, AreOneVoxelApart) {
  const Phantom phantom = make_phantom("two_tubes");
  const auto& size = phantom.geometry.size;
  const std::int64_t i = size[0] / 2;
  std::int64_t least = size[1];
  for (std::int64_t k = 0; k < size[2]; ++k) {
    std::int64_t last = -1;
    for (std::int64_t j = 0; j < size[1]; ++j) {
      if (!phantom.voxels[i + size[0] * (j + size[1] * k)]) continue;
      if (last >= 0 && j - last > 1) least = std::min(least, j - last - 1);
      last = j;
    }
  }
  EXPECT_EQ(least, 1);
}

TEST(Options, OutOfRangeOrWithoutMeaningAreRefused) {
  PhantomOptions size, spacing, radius, step;
  size.size = {{10, 64, 64}};
  EXPECT_EQ(code_of("tree", size), ErrorCode::usage);
  size.size = {{64, 64, 64}};
  EXPECT_EQ(code_of("sphere", size), ErrorCode::usage);
  spacing.spacing = {{1, -1, 1}};
  EXPECT_EQ(code_of("sphere", spacing), ErrorCode::usage);
  spacing.spacing = {{1, 1, 1}};
  EXPECT_EQ(code_of("liver", spacing), ErrorCode::usage);
  spacing.spacing = {{0.5, 20, 0.5}};
  EXPECT_EQ(code_of("sphere", spacing), ErrorCode::usage);
  size.size = {{24, 24, 24}};
  size.radius = 12;
  EXPECT_EQ(code_of("tree", size), ErrorCode::usage) << "no room for such a tree";
  radius.radius = std::nan("");
  EXPECT_EQ(code_of("helix", radius), ErrorCode::usage);
  radius.radius = 4;
  EXPECT_EQ(code_of("speckle", radius), ErrorCode::usage);
  step.exact_step = 2;
  EXPECT_EQ(code_of("sphere", step), ErrorCode::usage);
}

TEST(Names, UnknownOneIsAnsweredByTheList) {
  try {
    make_phantom("spline");
    FAIL() << "nothing thrown";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::usage);
    for (const std::string& name : phantom_names())
      EXPECT_THAT(error.what(), testing::HasSubstr(name));
  }
}

}  // namespace
}  // namespace vasamesh
