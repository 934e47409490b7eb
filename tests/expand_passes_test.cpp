/// \file
/// The passes of mesh expanding's rounds, on every backend, against one corner after the other.

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "reference/expand_reference.h"
#include "stages/expand_front.h"
#include "stages/expand_grid.h"
#include "stages/expand_patches.h"
#include "stages/expand_seeds.h"
#include "stages/hard.h"
#include "stages/mesh_parts.h"
#include "stages/sizing.h"
#include "support/analytic_lattice.h"
#include "support/backend_test.h"
#include "support/host_backend.h"

namespace vasamesh::test {
namespace {

/// A tree with its sizes, and the part of it that is meshed already, not well.
class Scene {
 public:
  explicit Scene(unsigned seed, float patches_up_to)
      : scene_(host(), {40, 40, 40}, random_tree(seed, 4, 40)),
        sizes_(make_sizes(host(), scene_.field, scene_.surface, {})) {
    std::vector<std::uint8_t> within(scene_.surface.vertex_count());
    for (std::size_t v = 0; v < within.size(); ++v)
      within[v] = scene_.surface.vertices[3 * v] < patches_up_to;
    patches_ = part_of(host(), scene_.surface, choose_triangles(host(), scene_.surface, within));
  }

  FieldView field() const { return scene_.field.view(); }
  SizeView sizes() const { return sizes_.view(scene_.field); }
  Front front(Backend& backend) const {
    Front front = take_patches(backend, field(), sizes(), patches_);
    FrontSeeds(field(), sizes(), sizes_.samples).add(backend, front);
    return front;
  }

 private:
  AnalyticScene scene_;
  SizeField sizes_;
  TriangleMesh patches_;
};

void expect_same(const FrontVertex& got, const FrontVertex& want) {
  ASSERT_EQ(got.position, want.position);
  ASSERT_EQ(got.normal, want.normal);
  ASSERT_EQ(got.size, want.size);
  ASSERT_EQ(got.corners, want.corners);
}

void expect_same(const FrontCorner& got, const FrontCorner& want) {
  ASSERT_EQ(got.state, want.state);
  ASSERT_EQ(got.vertex, want.vertex);
  if (want.state == CornerState::dead) return;
  ASSERT_EQ(got.previous, want.previous);
  ASSERT_EQ(got.next, want.next);
  ASSERT_EQ(got.wide, want.wide);
  if (want.state == CornerState::changed) return;
  ASSERT_EQ(got.angle, want.angle);
  ASSERT_EQ(got.key, want.key);
  ASSERT_EQ(got.cell, want.cell);
}

void expect_same(const Proposal& got, const Proposal& want) {
  ASSERT_EQ(got.kind, want.kind);
  if (want.kind >= Proposal::join_next) {
    ASSERT_EQ(got.target, want.target);
  }
  if (want.kind != Proposal::fan) return;
  ASSERT_EQ(got.vertices, want.vertices);
  for (int i = 0; i < want.vertices; ++i) {
    ASSERT_EQ(got.position[i], want.position[i]);
    ASSERT_EQ(got.normal[i], want.normal[i]);
    ASSERT_EQ(got.size[i], want.size[i]);
  }
}

template <class T>
void expect_all_same(const std::vector<T>& got, const std::vector<T>& want) {
  ASSERT_EQ(got.size(), want.size());
  for (std::size_t i = 0; i < want.size() && !::testing::Test::HasFatalFailure(); ++i) {
    SCOPED_TRACE(i);
    expect_same(got[i], want[i]);
  }
}

void expect_same(const PlainFront& got, const PlainFront& want) {
  ASSERT_EQ(got.listed, want.listed);
  ASSERT_EQ(got.triangles, want.triangles);
  ASSERT_NO_FATAL_FAILURE(expect_all_same(got.vertices, want.vertices));
  ASSERT_NO_FATAL_FAILURE(expect_all_same(got.corners, want.corners));
}

class ExpandPasses : public BackendTest {
 protected:
  /// One round by the passes and one by one. \return whether any corner was chosen.
  bool expect_round(const Scene& scene, std::uint32_t round, bool wake, const FrontLimits& limits,
                    Front& front) {
    PlainFront plain = plain_front(backend(), front.view());
    backend().expand_choose(scene.field(), round, wake, front.view());
    front.begin_round();
    const std::vector<std::uint32_t> chosen = choose_one_by_one(scene.field(), round, wake, plain);
    const FrontView view = front.view();
    EXPECT_EQ(to_host(backend(), view.chosen.subview(0, front.counts().chosen)), chosen);
    if (chosen.empty() || HasFailure()) return false;

    backend().expand_claim(scene.field(), view);
    const std::vector<bool> holders = holders_one_by_one(scene.field(), plain, chosen);
    expect_claims(scene.field(), view, plain, chosen, holders);
    backend().expand_propose(scene.field(), scene.sizes(), limits, view);
    const std::vector<Proposal> proposals =
        propose_one_by_one(scene.field(), scene.sizes(), limits, chosen, holders, plain);
    expect_all_same(to_host(backend(), view.proposals), proposals);
    for (const Proposal& p : proposals) ++kinds_[p.kind];

    backend().expand_add(scene.field(), view);
    add_one_by_one(chosen, proposals, plain);
    if (!HasFailure()) expect_same(plain_front(backend(), front.view()), plain);
    return !HasFailure();
  }

  /// Those that hold all that they claim are those that the claims of the cells say.
  void expect_claims(const FieldView& field, const FrontView& view, const PlainFront& plain,
                     const std::vector<std::uint32_t>& chosen, const std::vector<bool>& holders) {
    const std::vector<std::uint64_t> claims = to_host(backend(), view.claims);
    for (std::size_t i = 0; i < chosen.size(); ++i) {
      const FrontCorner& corner = plain.corners[chosen[i]];
      const FrontVertex& v = plain.vertices[corner.vertex];
      const std::uint64_t own = std::uint64_t{corner.key} << 32 | chosen[i];
      bool holds = true;
      for_cells(field, cells_round(field, v.position, (corner.wide ? 2.9f : 1.25f) * v.size),
                [&](std::size_t cell) {
                  EXPECT_GE(claims[cell], own);
                  holds = holds && claims[cell] == own;
                });
      ASSERT_EQ(holds, holders[i]) << i;
    }
  }

  std::map<Proposal::Kind, int> kinds_;
};

TEST_P(ExpandPasses, RoundsAsOneByOne) {
  const Scene scene(5, 14);
  Front front = scene.front(backend());
  std::uint32_t round = 1;
  while (expect_round(scene, round, false, {}, front)) ++round;
  ASSERT_FALSE(HasFailure()) << "round " << round;
  EXPECT_GT(round, 10u);
  // Again with less regular triangles, all corners awake.
  const FrontLimits last = {1.3f, 0.3f, 0.35f, 0.28f};
  for (bool wake = true; expect_round(scene, round, wake, last, front); ++round) wake = false;
  ASSERT_FALSE(HasFailure()) << "round " << round;
  EXPECT_EQ(kinds_.size(), 7u);  // every kind
  EXPECT_GT(kinds_[Proposal::fan], 100);
}

/// Keys that agree in round, rank and chance: the higher corner holds the cells.
TEST_P(ExpandPasses, EqualKeysAreToldApartByTheirCorners) {
  const Scene scene(3, 0);
  Front front = scene.front(backend());
  backend().expand_choose(scene.field(), 1, true, front.view());
  front.begin_round();
  const FrontView view = front.view();
  const std::uint32_t count = front.counts().chosen;
  ASSERT_GT(count, 3u);
  PlainFront plain = plain_front(backend(), view);
  const std::vector<std::uint32_t> chosen = to_host(backend(), view.chosen.subview(0, count));
  for (const std::uint32_t c : chosen) {
    plain.corners[c].key = 0x10ffffu;
    plain.corners[c].wide = 1;  // so that they meet
  }
  backend().upload<FrontCorner>(view.corners.subview(0, plain.corners.size()), plain.corners);
  backend().expand_claim(scene.field(), view);
  const std::vector<bool> holders = holders_one_by_one(scene.field(), plain, chosen);
  EXPECT_LT(std::count(holders.begin(), holders.end(), true), static_cast<int>(count));
  expect_claims(scene.field(), view, plain, chosen, holders);
}

TEST_P(ExpandPasses, OfNothing) {
  const Scene scene(5, 14);
  Front front(backend(), scene.field());
  backend().expand_choose(scene.field(), 1, true, front.view());
  front.begin_round();
  EXPECT_EQ(front.counts().chosen, 0u);
  EXPECT_EQ(front.counts().listed, 0u);
}

INSTANTIATE_TEST_SUITE_P(Backends, ExpandPasses, ::testing::ValuesIn(backend_names()), test_name);

}  // namespace
}  // namespace vasamesh::test
