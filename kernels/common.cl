/// \file
/// What every kernel file starts with: one arithmetic for all devices, and bricks.
///
/// A brick is 8 x 8 x 8 cells, x fastest; row r of a brick is its cells of y = r & 7, z = r >> 3.
/// The build states the shape of the work (host/opencl/program.cpp):
///   BRICK_ITEMS  work-items a brick, one work-group: 1 on a CPU, 64 (an item a row) elsewhere;
///   SCAN_ITEMS, SCAN_RUN  work-items a block of the scan, and consecutive values an item takes;
///   FOLD_ITEMS  work-items a group of passes over elements and of a sum's folds, one an element;
///   REDUCE_ITEMS  work-items that finish a sum;
///   QUICK_BUILD  on PoCL's CPU alone, where an item takes a brick;
/// and the engine's constants that kernels need (host/opencl/constants.cpp).
/// Array arguments come in pairs, the memory object and the first element of the view in it:
/// VIEW(type, name), and TAKE(name) before the first use.

#pragma OPENCL FP_CONTRACT OFF

#define VIEW(type, name) global type *name, ulong name##_first
#define TAKE(name) name += name##_first

#define BRICK_GROUP reqd_work_group_size(BRICK_ITEMS, 1, 1)
#define ELEMENT_GROUP reqd_work_group_size(FOLD_ITEMS, 1, 1)

/// PoCL compiles a kernel when it is first launched, and optimises it once more: most of what a
/// first conversion takes. Kernels in whose own bodies little happens do without: their body is
/// compiled as it is written, and what it calls has been optimised with the program.
#ifdef QUICK_BUILD
#define AS_WRITTEN optnone
#else
#define AS_WRITTEN
#endif
#define PLAIN_BRICK_GROUP BRICK_GROUP, AS_WRITTEN
#define PLAIN_ELEMENT_GROUP ELEMENT_GROUP, AS_WRITTEN

#define BRICK_CELLS 512
#define BRICK_ROWS 64
#define NEIGHBOURS 27
#define SELF 13
#define STEP_X 1
#define STEP_Y 3
#define STEP_Z 9

/// Memory that the items of a brick share, declared at a kernel's outermost scope, and what makes
/// its contents, or those of global memory, seen by all of them. Where an item takes a brick, one
/// also takes a part of the surface or a gap.
#if BRICK_ITEMS == 1
#define BRICK_SHARED private
#define BRICK_SYNC()
#define GLOBAL_SYNC()
#else
#define BRICK_SHARED local
#define BRICK_SYNC() barrier(CLK_LOCAL_MEM_FENCE)
#define GLOBAL_SYNC() barrier(CLK_GLOBAL_MEM_FENCE)
#endif

/// The lowest bit that is set.
static int lowest_bit(uint bits) { return 31 - (int)clz(bits & -bits); }

/// Bit x where byte x of eight, each 0 or 1, is 1.
static uint byte_bits(uchar8 bytes) {
  const ulong eight = upsample(
      upsample(upsample(bytes.s7, bytes.s6), upsample(bytes.s5, bytes.s4)),
      upsample(upsample(bytes.s3, bytes.s2), upsample(bytes.s1, bytes.s0)));
  return (uint)(eight * 0x0102040810204080UL >> 56);
}

/// Byte x, from the lowest on, is 1 where bit x of eight is set, else 0.
static ulong bit_bytes(uint bits) {
  const ulong places = bits * 0x0101010101010101UL & 0x8040201008040201UL;
  return (places + 0x7f7f7f7f7f7f7f7fUL) >> 7 & 0x0101010101010101UL;
}

/// The rows with y0 <= y < y1 and z0 <= z < z1 that an item takes when items take whole rows. What
/// it holds of them is OWN_ROWS values, that of row r at OWN_ROW(r).
#define OWN_ROWS (BRICK_ROWS / BRICK_ITEMS)
#define OWN_ROW(row) ((row) / BRICK_ITEMS)
#if BRICK_ITEMS == 1
#define FOR_OWN_ROWS(y, y0, y1, z, z0, z1) \
  for (int z = (z0); z < (z1); ++z)        \
    for (int y = (y0); y < (y1); ++y)
#else
#define FOR_OWN_ROWS(y, y0, y1, z, z0, z1)                                          \
  for (int row_ = get_local_id(0); row_ < BRICK_ROWS; row_ += BRICK_ITEMS)          \
    for (int y = row_ & 7, z = row_ >> 3, once_ = 1;                                \
         once_ && y >= (y0) && y < (y1) && z >= (z0) && z < (z1); once_ = 0)
#endif

/// Row (y, z), each -1..8, of the brick with this neighbour table, or of the brick next to it;
/// zeros where there is none.
static float8 brick_row(global const float *field, global const int *near, int y, int z) {
  const int brick = near[SELF + STEP_Y * (y >> 3) + STEP_Z * (z >> 3)];
  if (brick < 0) return (float8)(0.0f);
  return vload8((size_t)brick * BRICK_ROWS + (y & 7) + 8 * (z & 7), field);
}

/// Cell (x, y, z) of the brick next to it along x by `step`, -1 or 1; zero where there is none.
static float brick_cell_beside(global const float *field, global const int *near, int step, int x,
                               int row) {
  const int brick = near[SELF + step * STEP_X];
  if (brick < 0) return 0.0f;
  return field[(size_t)brick * BRICK_CELLS + 8 * row + x];
}

/// Row (y, z) of the bricks in a table of `side` along each axis, x brick `x`; zeros where there is
/// none. y and z count cells from the table's corner.
static float8 table_row(global const float *field, global const int *table, int side, int x, int y,
                         int z) {
  const int brick = table[x + side * ((y >> 3) + side * (z >> 3))];
  if (brick < 0) return (float8)(0.0f);
  return vload8((size_t)brick * BRICK_ROWS + (y & 7) + 8 * (z & 7), field);
}

static float table_cell(global const float *field, global const int *table, int side, int x, int y,
                         int z) {
  const int brick = table[(x >> 3) + side * ((y >> 3) + side * (z >> 3))];
  if (brick < 0) return 0.0f;
  return field[(size_t)brick * BRICK_CELLS + (x & 7) + 8 * ((y & 7) + 8 * (z & 7))];
}

/// Six cells along x: of the octant of the middle one of 27 bricks, and the one before and behind;
/// row (y, z), 0..5, is counted likewise.
static float8 table_octant_row(global const float *field, global const int *table, int3 octant,
                               int y, int z) {
  const int ty = y + 4 * octant.y + 7, tz = z + 4 * octant.z + 7;
  const float8 own = table_row(field, table, 3, 1, ty, tz);
  const float beside = table_cell(field, table, 3, octant.x ? 16 : 7, ty, tz);
  return octant.x ? (float8)(own.s3456, own.s7, beside, 0.0f, 0.0f)
                  : (float8)(beside, own.s0123, own.s4, 0.0f, 0.0f);
}

/// Sum of a brick's products: lane x adds its 64 cells in order of the rows, then the lanes are
/// added pairwise. `BRICK_SUM(sum)` declares the memory at the kernel's outermost scope,
/// brick_sum_add takes each row once, brick_sum_finish is called by every item and returns the sum
/// to item 0.
static float brick_sum_lanes(float8 v) {
  return ((v.s0 + v.s4) + (v.s2 + v.s6)) + ((v.s1 + v.s5) + (v.s3 + v.s7));
}

#if BRICK_ITEMS == 1

#define BRICK_SUM(sum) float8 sum[1] = {(float8)(0.0f)}

static void brick_sum_add(float8 *sum, int row, float8 products) { sum[0] += products; }

static float brick_sum_finish(float8 *sum) { return brick_sum_lanes(sum[0]); }

#else

#define BRICK_SUM(sum) local float sum[BRICK_CELLS]

static void brick_sum_add(local float *sum, int row, float8 products) {
  vstore8(products, row, sum);
}

static float brick_sum_finish(local float *sum) {
  const int lane = get_local_id(0);
  barrier(CLK_LOCAL_MEM_FENCE);
  if (lane < 8) {
    float total = 0.0f;
    for (int row = 0; row < BRICK_ROWS; ++row) total += sum[8 * row + lane];
    sum[lane] = total;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  return lane == 0 ? brick_sum_lanes(vload8(0, sum)) : 0.0f;
}

#endif

// --- Points near a brick (engine/types/point_cloud.h, PointIndex). -----------------------------

/// The voxels low <= voxel < high near a brick of a level, and where their points are.
typedef struct {
  int3 low, high, base;
  int side;
  global const int *table;
  global const uint *voxel_start;
} PointBox;

/// The first voxel of a level's brick along one axis.
static int first_voxel(int exponent, int brick) {
  return exponent < 0 ? brick * 8 >> -exponent : brick * (8 << exponent);
}

/// The brick's own voxels.
static PointBox point_box(int exponent, int3 coord, int side, global const int *table,
                          global const uint *voxel_start) {
  PointBox box;
  box.low = (int3)(first_voxel(exponent, coord.x), first_voxel(exponent, coord.y),
                   first_voxel(exponent, coord.z));
  box.high = (int3)(first_voxel(exponent, coord.x + 1), first_voxel(exponent, coord.y + 1),
                    first_voxel(exponent, coord.z + 1));
  box.base = (box.low >> 3) - 1;
  box.side = side;
  box.table = table;
  box.voxel_start = voxel_start;
  return box;
}

/// Adds `reach` voxels on each side, as far as the table goes.
static void point_box_grow(PointBox *box, int3 reach) {
  box->low = max(box->low - reach, box->base * 8);
  box->high = min(box->high + reach, (box->base + box->side) * 8);
}

/// First and last + 1 of the points of a row's voxels in point brick bx.
static uint2 point_run(const PointBox *box, int bx, int y, int z) {
  const int3 at = (int3)(bx, y >> 3, z >> 3) - box->base;
  const int found = box->table[at.x + box->side * (at.y + box->side * at.z)];
  if (found < 0) return (uint2)(0, 0);
  global const uint *start = box->voxel_start + (size_t)found * BRICK_CELLS + 8 * (y & 7) +
                             64 * (z & 7);
  return (uint2)(start[max(box->low.x - 8 * bx, 0)], start[min(box->high.x - 8 * bx, 8)]);
}

/// All runs of a box in the order of their rows: z, y, then point bricks along x.
#define FOR_POINT_RUNS(box, run)                                                            \
  for (int run##_z = (box).low.z; run##_z < (box).high.z; ++run##_z)                        \
    for (int run##_y = (box).low.y; run##_y < (box).high.y; ++run##_y)                      \
      for (int run##_x = (box).low.x >> 3; run##_x <= ((box).high.x - 1) >> 3; ++run##_x)   \
        for (uint2 run = point_run(&(box), run##_x, run##_y, run##_z); run.x < run.y;       \
             run.x = run.y)

// --- Nodes of the cell lattice (engine/types/lattice.h). --------------------------------------

#define NO_NODE ULONG_MAX

/// Index (512 * brick + cell) of the node at (x, y, z), each -8..15 from the corner of the brick
/// with this neighbour table; NO_NODE where its brick is not there.
static ulong node_at(global const int *near, int x, int y, int z) {
  const int brick = near[SELF + (x >> 3) + STEP_Y * (y >> 3) + STEP_Z * (z >> 3)];
  if (brick < 0) return NO_NODE;
  return (ulong)brick * BRICK_CELLS + (x & 7) + 8 * (y & 7) + 64 * (z & 7);
}

/// Of the 14 neighbours of a node in its link, the i-th: bit masks 1..7, then their negatives.
static int3 link_offset(int i) {
  const int mask = i % 7 + 1, sign = i < 7 ? 1 : -1;
  return (int3)(mask & 1, mask >> 1 & 1, mask >> 2) * sign;
}
