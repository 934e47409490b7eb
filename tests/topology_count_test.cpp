/// \file
/// The topology of a segmentation by runs, against flood fills and cells counted one by one,
/// against the simplices of the cell lattice, and on shapes whose numbers are known.

#include "stages/topology_count.h"

#include <gtest/gtest.h>

#include "reference/topology.h"
#include "support/dense_volume.h"
#include "tbb/backend.h"

namespace vasamesh {

/// Tells the numbers in a failure.
void PrintTo(const Topology& t, std::ostream* out) {
  *out << t.pieces << " pieces, " << t.handles << " handles, " << t.cavities << " cavities";
}

namespace test {
namespace {

constexpr int kConnectivities[] = {26, 18, 6};

class TopologyCount : public testing::Test {
 protected:
  Solid examine(const DenseVolume& volume, int connectivity) {
    bits_ = pack_plainly(*backend_, volume);
    return examine_solid(*backend_, bits_.view(), volume.size64(),
                         static_cast<Connectivity>(connectivity));
  }

  std::shared_ptr<Backend> backend_ = make_tbb_backend(2, nullptr);
  BitVolume bits_;
};

Topology sum_of(const Piece& piece) { return {1, piece.handles, piece.cavities}; }

DenseVolume ring() {
  return DenseVolume({5, 5, 3}).box({0, 0, 0}, {4, 4, 2}).box({1, 1, 0}, {3, 3, 2}, false);
}

TEST_F(TopologyCount, RandomVolumesOfAllDensities) {
  unsigned seed = 1;
  for (double density : {0.02, 0.1, 0.3, 0.5, 0.6, 0.8, 0.95, 1.0})
    for (const std::array<int, 3>& size :
         {std::array{1, 1, 1}, {9, 7, 5}, {71, 3, 4}, {5, 21, 19}, {12, 1, 12}}) {
      const DenseVolume volume = random_volume(size, density, ++seed);
      for (int connectivity : kConnectivities) {
        SCOPED_TRACE(testing::Message() << "density " << density << ", size " << size[0] << " "
                                        << size[1] << " " << size[2] << ", " << connectivity);
        const Solid solid = examine(volume, connectivity);
        EXPECT_EQ(solid.topology, count_cells(volume, connectivity));
        EXPECT_EQ(solid.topology, count_lattice(volume, connectivity));
      }
    }
}

TEST_F(TopologyCount, EachPieceByItself) {
  for (double density : {0.06, 0.15, 0.85})
    for (int connectivity : kConnectivities) {
      const DenseVolume volume = random_volume({14, 11, 12}, density, 77);
      SCOPED_TRACE(testing::Message() << "density " << density << ", " << connectivity);
      const Solid solid = examine(volume, connectivity);
      const std::vector<Topology> wanted = count_cells_by_piece(volume, connectivity);
      ASSERT_EQ(solid.findings.pieces.size(), wanted.size());
      for (std::size_t p = 0; p < wanted.size(); ++p)
        EXPECT_EQ(sum_of(solid.findings.pieces[p]), wanted[p]) << "piece " << p;
    }
}

TEST_F(TopologyCount, PiecesOfVoxelsAsFlooded) {
  const DenseVolume volume = random_volume({70, 9, 20}, 0.2, 5);
  for (int connectivity : kConnectivities) {
    const Solid solid = examine(volume, connectivity);
    const std::vector<int> component = flood(volume, true, connectivity);
    std::vector<std::int64_t> voxels(solid.findings.pieces.size(), 0);
    std::size_t i = 0;
    for (int z = 0; z < volume.size[2]; ++z)
      for (int y = 0; y < volume.size[1]; ++y)
        for (int x = 0; x < volume.size[0]; ++x, ++i) {
          ASSERT_EQ(solid.lookup.at(x + kPad, y + kPad, z + kPad), component[i]);
          if (component[i] >= 0) ++voxels[component[i]];
        }
    for (std::size_t p = 0; p < voxels.size(); ++p)
      EXPECT_EQ(solid.findings.pieces[p].voxels, voxels[p]);
    EXPECT_EQ(solid.lookup.at(0, 0, 0), PieceLookup::kNone);
    EXPECT_EQ(solid.lookup.at(8, -1, 8), PieceLookup::kNone);
    EXPECT_EQ(solid.lookup.at(8, 8, 1000), PieceLookup::kNone);
  }
}

TEST_F(TopologyCount, HandShapes) {
  EXPECT_EQ(examine(ring(), 26).topology, (Topology{1, 1, 0}));
  const DenseVolume hollow =
      DenseVolume({5, 5, 5}).box({0, 0, 0}, {4, 4, 4}).box({1, 1, 1}, {3, 3, 3}, false);
  EXPECT_EQ(examine(hollow, 26).topology, (Topology{1, 0, 1}));
  DenseVolume island = hollow;
  island.at(2, 2, 2) = 1;
  EXPECT_EQ(examine(island, 26).topology, (Topology{2, 0, 1}));
  EXPECT_EQ(examine(DenseVolume({6, 6, 6}).box({0, 0, 0}, {5, 5, 5}), 6).topology,
            (Topology{1, 0, 0}));
  EXPECT_EQ(examine(DenseVolume({4, 4, 4}), 26).topology, (Topology{0, 0, 0}));
}

TEST_F(TopologyCount, CavityBelongsToThePieceRoundIt) {
  DenseVolume nested = DenseVolume({13, 13, 13}).box({0, 0, 0}, {12, 12, 12});
  nested.box({1, 1, 1}, {11, 11, 11}, false).box({3, 3, 3}, {9, 9, 9});
  nested.box({5, 5, 5}, {7, 7, 7}, false).box({8, 8, 8}, {8, 8, 8}, false);
  const Solid solid = examine(nested, 26);
  ASSERT_EQ(solid.findings.pieces.size(), 2u);
  EXPECT_EQ(sum_of(solid.findings.pieces[0]), (Topology{1, 0, 1}));
  EXPECT_EQ(sum_of(solid.findings.pieces[1]), (Topology{1, 0, 2}));
  EXPECT_EQ(solid.findings.cavities.count, 3);
  EXPECT_EQ(solid.findings.cavities.place, (std::array<std::int64_t, 3>{1, 1, 1}));
}

TEST_F(TopologyCount, ContactsJoinByConnectivity) {
  DenseVolume volume({9, 4, 4});
  volume.box({0, 0, 0}, {1, 1, 1}).box({2, 2, 0}, {3, 3, 1});  // over an edge of two voxels
  volume.at(6, 0, 2) = volume.at(7, 1, 3) = 1;                 // over a corner
  EXPECT_EQ(examine(volume, 26).topology.pieces, 2);
  EXPECT_EQ(examine(volume, 18).topology.pieces, 3);
  EXPECT_EQ(examine(volume, 6).topology.pieces, 4);
  const InputFindings found = examine(volume, 26).findings;
  EXPECT_EQ(found.edge_contacts.count, 2);
  EXPECT_EQ(found.edge_contacts.place, (std::array<std::int64_t, 3>{1, 1, 0}));
  EXPECT_EQ(found.corner_contacts.count, 1);
  EXPECT_EQ(found.corner_contacts.place, (std::array<std::int64_t, 3>{6, 0, 2}));
}

TEST_F(TopologyCount, SpecksBorderAndOneVoxelParts) {
  DenseVolume volume({12, 12, 12});
  volume.box({2, 2, 2}, {5, 5, 5});    // a block of 64
  volume.box({6, 3, 3}, {11, 3, 3});   // a line of six to the border
  volume.at(0, 10, 10) = 1;            // a speck on the border
  volume.box({9, 9, 6}, {10, 10, 7});  // a block of eight
  const InputFindings found = examine(volume, 26).findings;
  EXPECT_EQ(found.object_voxels, 64 + 6 + 1 + 8);
  EXPECT_EQ(found.specks.count, 1);
  EXPECT_EQ(found.specks.place, (std::array<std::int64_t, 3>{0, 10, 10}));
  EXPECT_EQ(found.border_contacts.count, 2);
  EXPECT_EQ(found.border_contacts.place, (std::array<std::int64_t, 3>{11, 3, 3}));
  EXPECT_EQ(found.one_voxel_parts.count, 7);
  EXPECT_EQ(found.one_voxel_parts.place, (std::array<std::int64_t, 3>{6, 3, 3}));
}

TEST_F(TopologyCount, OneVoxelPartsAndBorderAsCountedPlainly) {
  for (double density : {0.3, 0.7, 0.9}) {
    const DenseVolume v = random_volume({67, 6, 18}, density, 9);
    std::int64_t thin = 0, border = 0;
    for (int z = 0; z < v.size[2]; ++z)
      for (int y = 0; y < v.size[1]; ++y)
        for (int x = 0; x < v.size[0]; ++x) {
          if (!v.object(x, y, z)) continue;
          bool in_block = false;
          for (int corner = 0; corner < 8; ++corner) {
            bool full = true;
            for (int o = 0; o < 8; ++o)
              full &= v.object(x - (corner & 1) + (o & 1), y - (corner >> 1 & 1) + (o >> 1 & 1),
                               z - (corner >> 2) + (o >> 2));
            in_block |= full;
          }
          thin += !in_block;
          border += x == 0 || y == 0 || z == 0 || x == v.size[0] - 1 || y == v.size[1] - 1 ||
                    z == v.size[2] - 1;
        }
    const InputFindings found = examine(v, 26).findings;
    EXPECT_EQ(found.one_voxel_parts.count, thin);
    EXPECT_EQ(found.border_contacts.count, border);
  }
}

TEST_F(TopologyCount, BlocksOfEnlargedLabels) {
  const DenseVolume small = random_volume({12, 11, 10}, 0.3, 4);
  for (const std::array<int, 3>& block : {std::array{2, 2, 2}, {1, 1, 4}, {3, 2, 1}}) {
    DenseVolume large = enlarged(small, block);
    const std::array<std::int64_t, 3> wanted = {block[0], block[1], block[2]};
    EXPECT_EQ(examine(large, 26).findings.blocks, wanted);
    large.at(5, 5, 5) = !large.object(5, 5, 5);  // one voxel that is no block
    const std::array<std::int64_t, 3> none = {1, 1, 1};
    EXPECT_EQ(examine(large, 26).findings.blocks, none);
  }
  DenseVolume box({20, 20, 20});
  box.box({4, 4, 4}, {15, 15, 15});
  EXPECT_EQ(examine(box, 26).findings.blocks, (std::array<std::int64_t, 3>{1, 1, 1}));
}

TEST_F(TopologyCount, DropsSmallComponents) {
  DenseVolume volume({20, 8, 8});
  volume.box({0, 0, 0}, {3, 3, 3}).box({8, 0, 0}, {9, 1, 0});
  volume.at(15, 5, 5) = 1;
  Solid solid = examine(volume, 26);
  solid.findings.anisotropy = 2;
  const Finding dropped =
      drop_small_components(*backend_, bits_, volume.size64(), Connectivity::vertex, 5, solid);
  EXPECT_EQ(dropped.count, 2);
  EXPECT_EQ(dropped.place, (std::array<std::int64_t, 3>{8, 0, 0}));
  EXPECT_EQ(solid.findings.dropped.count, 2);
  EXPECT_EQ(solid.findings.anisotropy, 2);
  EXPECT_EQ(solid.findings.object_voxels, 64);
  EXPECT_EQ(solid.topology, (Topology{1, 0, 0}));
  EXPECT_FALSE(bits_.view().test(15 + kPad, 5 + kPad, 5 + kPad));
  EXPECT_TRUE(bits_.view().test(kPad, kPad, kPad));
}

TEST_F(TopologyCount, SameForAnyNumberOfThreads) {
  const DenseVolume volume = random_volume({40, 40, 90}, 0.25, 3);
  const Solid two = examine(volume, 26);
  bits_ = {};  // they go back to the backend that they came from
  backend_ = make_tbb_backend(1, nullptr);
  const Solid one = examine(volume, 26);
  EXPECT_EQ(one.topology, two.topology);
  EXPECT_EQ(one.lookup.piece, two.lookup.piece);
  EXPECT_EQ(one.findings.edge_contacts.place, two.findings.edge_contacts.place);
  EXPECT_EQ(one.findings.corner_contacts.count, two.findings.corner_contacts.count);
}

}  // namespace
}  // namespace test
}  // namespace vasamesh
