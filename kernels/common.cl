/// \file
/// What every kernel file starts with: one arithmetic for all devices, and bricks.
///
/// A brick is 8 x 8 x 8 cells, x fastest; row r of a brick is its cells of y = r & 7, z = r >> 3.
/// The build states the shape of the work (host/opencl/program.cpp):
///   BRICK_ITEMS  work-items a brick, one work-group: 1 on a CPU, 64 (an item a row) elsewhere;
///   SCAN_ITEMS, SCAN_RUN  work-items a block of the scan, and consecutive values an item takes;
///   FOLD_ITEMS  work-items a group of a sum's folds, one an element;
///   REDUCE_ITEMS  work-items that finish a sum.
/// Array arguments come in pairs: the memory object, and the first element of the view in it.

#pragma OPENCL FP_CONTRACT OFF

#define BRICK_CELLS 512
#define BRICK_ROWS 64
#define NEIGHBOURS 27
#define SELF 13
#define STEP_X 1
#define STEP_Y 3
#define STEP_Z 9

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
