#include "support/invariants.h"

#include <gtest/gtest.h>

#include "stages/points.h"
#include "support/host_backend.h"

namespace vasamesh::test {

CheckReport check(const TriangleMesh& mesh, const SolidMatch* wanted) {
  return check_surface(host(), mesh, wanted);
}

void expect_good_surface(const TriangleMesh& mesh) {
  const CheckReport report = check(mesh);
  EXPECT_TRUE(report.passed) << report.reason;
}

void expect_good_surface(const TriangleMesh& mesh, const SolidMatch& wanted) {
  const CheckReport report = check(mesh, &wanted);
  EXPECT_TRUE(report.passed) << report.reason;
}

void expect_good_surface(const TriangleMesh& mesh, const Topology& wanted) {
  const CheckReport report = check(mesh);
  EXPECT_TRUE(report.passed) << report.reason;
  EXPECT_EQ(report.topology.pieces, wanted.pieces);
  EXPECT_EQ(report.topology.handles, wanted.handles);
  EXPECT_EQ(report.topology.cavities, wanted.cavities);
}

void expect_good_surface(const TriangleMesh& mesh, const VolumeView& volume,
                         Connectivity connectivity, Space space) {
  const BitVolume object = pack_volume(host(), volume);
  const Solid solid = examine_solid(host(), object.view(), volume.geometry.size, connectivity);
  expect_good_surface(mesh, SolidMatch{&solid, volume.geometry, space});
}

}  // namespace vasamesh::test
