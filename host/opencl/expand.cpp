/// Rounds of mesh expanding: kernels/expand.cl.

#include <bit>
#include <cstddef>

#include "opencl/opencl_backend.h"
#include "stages/expand_grid.h"

namespace vasamesh {

static_assert(sizeof(FrontVertex) == 36 && offsetof(FrontVertex, normal) == 12 &&
                  offsetof(FrontVertex, size) == 24 && offsetof(FrontVertex, corners) == 28,
              "ExpandVertex of kernels/expand_front.cl");
static_assert(sizeof(FrontCorner) == 32 && offsetof(FrontCorner, angle) == 12 &&
                  offsetof(FrontCorner, cell) == 20 && offsetof(FrontCorner, state) == 28,
              "ExpandCorner");
static_assert(sizeof(Proposal) == 120 && offsetof(Proposal, size) == 96 &&
                  offsetof(Proposal, target) == 112 && offsetof(Proposal, vertices) == 117,
              "ExpandProposal");
static_assert(sizeof(FrontStart) == 12 && sizeof(FrontCounts) == 24, "ExpandStart, ExpandCounts");
static_assert(std::endian::native == std::endian::little, "ExpandClaim");

namespace {

/// The cell of what lies in no brick.
cl_uint outside(const FieldView& field) { return static_cast<cl_uint>(cell_count(field)); }

}  // namespace

void OpenClBackend::expand_choose(const FieldView& field, std::uint32_t round, bool wake,
                                  const FrontView& front) {
  const std::size_t most = std::max<std::size_t>(front.listed.size, 1);
  const std::size_t blocks = (most + kCornerBlock - 1) / kCornerBlock;
  marks_.resize(*this, most);
  blocks_.resize(*this, blocks);
  launch("expand_measure", groups_of(most), shape_.fold_items, field, front, outside(field),
         cl_uint{round}, cl_int{wake});
  launch("expand_mark", blocks, shape_.brick_items, front, marks_.view(), blocks_.view());
  launch("expand_collect", blocks, shape_.brick_items, front,
         View<const std::uint8_t>(marks_.view()), View<const cl_uint2>(blocks_.view()));
}

void OpenClBackend::expand_claim(const FieldView& field, const FrontView& front) {
  const cl_ulong count = front.proposals.size;
  for (const char* kernel : {"expand_claim_keys", "expand_claim_corners"})
    launch(kernel, groups_of(count), shape_.fold_items, count, field, front);
}

void OpenClBackend::expand_propose(const FieldView& field, const SizeView& sizes,
                                   const FrontLimits& limits, const FrontView& front) {
  const cl_ulong count = front.proposals.size;
  launch("expand_propose", groups_of(count), shape_.fold_items, count, field, sizes, front,
         cl_float4{{limits.join_reach, limits.least_tau, limits.least_angle, limits.off_surface}});
}

void OpenClBackend::expand_add(const FieldView& field, const FrontView& front) {
  const cl_ulong count = front.proposals.size;
  launch("expand_number", 1, shape_.reduce_items, count, front);
  launch("expand_add", groups_of(count), shape_.fold_items, count, field, front, outside(field));
}

}  // namespace vasamesh
