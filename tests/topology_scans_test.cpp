/// \file
/// The topology of real scans, from the folder that VASAMESH_TEST_DATA names: against cells counted
/// one by one, and against what is known of the scans.

#include <gtest/gtest.h>

#include <string>

#include "io/volume_reader.h"
#include "reference/topology.h"
#include "stages/points.h"
#include "stages/topology_count.h"
#include "support/dense_volume.h"
#include "support/scans.h"
#include "tbb/backend.h"

namespace vasamesh::test {
namespace {

class TopologyOfScans : public testing::Test {
 protected:
  void SetUp() override {
    if (!scan_path("")) GTEST_SKIP() << "VASAMESH_TEST_DATA is not set";
  }

  static Segmentation read(const char* name) {
    return read_segmentation(*scan_path(std::string(name) + ".nii.gz"));
  }

  Solid examine(const Segmentation& scan, Connectivity connectivity) {
    const BitVolume object = pack_volume(*backend_, scan.view());
    return examine_solid(*backend_, object.view(), scan.geometry.size, connectivity);
  }

  void expect_as_counted(const char* name, Connectivity connectivity) {
    SCOPED_TRACE(name);
    const Segmentation scan = read(name);
    DenseVolume volume({static_cast<int>(scan.geometry.size[0]),
                        static_cast<int>(scan.geometry.size[1]),
                        static_cast<int>(scan.geometry.size[2])});
    volume.voxels = scan.voxels;
    EXPECT_EQ(examine(scan, connectivity).topology,
              count_cells(volume, static_cast<int>(connectivity)));
  }

  std::shared_ptr<Backend> backend_ = make_tbb_backend(2, nullptr);
};

TEST_F(TopologyOfScans, AsCountedCellByCell) {
  expect_as_counted("willis_roi", Connectivity::vertex);
  expect_as_counted("willis_roi", Connectivity::edge);
  expect_as_counted("willis_roi", Connectivity::face);
  expect_as_counted("aorta_mra", Connectivity::vertex);
}

TEST_F(TopologyOfScans, AsIsKnown) {
  const Segmentation pulmonary = read("pulmonary_arteries");
  EXPECT_EQ(examine(pulmonary, Connectivity::vertex).findings.object_voxels, 264'804);
  EXPECT_EQ(examine(pulmonary, Connectivity::vertex).topology.pieces, 1);
  EXPECT_EQ(examine(pulmonary, Connectivity::face).topology.pieces, 99);
  const Segmentation willis = read("willis_mra");
  EXPECT_EQ(examine(willis, Connectivity::vertex).topology.pieces, 1);
  EXPECT_EQ(examine(willis, Connectivity::face).topology.pieces, 19);
  EXPECT_EQ(examine(read("aorta_mra"), Connectivity::vertex).topology.cavities, 7);
}

}  // namespace
}  // namespace vasamesh::test
