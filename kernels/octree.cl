/// \file
/// Octree levels: unknown cells, splatting and divergence (eq. 3 and 4 of the paper), restriction
/// and prolongation of quadratic B-splines. Contracts: engine/backend/backend.h.

kernel __attribute__((BRICK_GROUP)) void octree_mark_unknown(VIEW(const int, neighbours),
                                                             int whole, VIEW(uchar, unknown)) {
  TAKE(neighbours);
  TAKE(unknown);
  const size_t brick = get_group_id(0);
  global const int *near = neighbours + brick * NEIGHBOURS + SELF;
  const bool partial = !whole;
  const bool left = partial && near[-STEP_X] < 0, right = partial && near[STEP_X] < 0;
  const uchar8 inner = (uchar8)(!left, 1, 1, 1, 1, 1, 1, !right);
  for (int row = get_local_id(0); row < BRICK_ROWS; row += BRICK_ITEMS) {
    const int y = row & 7, z = row >> 3;
    const bool lost = partial && ((y == 0 && near[-STEP_Y] < 0) || (y == 7 && near[STEP_Y] < 0) ||
                                  (z == 0 && near[-STEP_Z] < 0) || (z == 7 && near[STEP_Z] < 0));
    vstore8(lost ? (uchar8)(0) : inner, brick * BRICK_ROWS + row, unknown);
  }
}

// --- Splatting. ------------------------------------------------------------------------------

/// Quadratic B-spline of unit knots, centred.
static float8 octree_bspline(float8 t) {
  const float8 size = fabs(t), rest = 1.5f - size;
  const float8 tail = select(rest, (float8)(0.0f), rest < 0.0f);
  const float8 inner = 0.75f - t * t, outer = 0.5f * (tail * tail);
  return select(outer, inner, size < 0.5f);
}

/// The B-spline of knots `width` cells at the 8 cells of a brick along one axis, its difference
/// over each cell, and the cells that it reaches; `p` is the point's place from the brick's corner,
/// in cells.
typedef struct {
  float8 value, difference;
  int first, last;
} OctreeWeights;

static OctreeWeights octree_weights(float p, float width) {
  const float8 cell = (float8)(0, 1, 2, 3, 4, 5, 6, 7);
  const float inverse = 1.0f / width;
  const float reach = 1.5f * width + 0.5f;
  OctreeWeights w;
  w.first = max(0, (int)ceil(p - reach - 0.5f));
  w.last = min(8, (int)floor(p + reach - 0.5f) + 1);
  w.value = octree_bspline((cell + 0.5f - p) * inverse) * inverse;
  const float8 below = octree_bspline((cell - p) * inverse);
  const float8 above = octree_bspline((cell + 1.0f - p) * inverse);
  w.difference = (above - below) * inverse;
  return w;
}

static bool octree_reaches(float p, float width) {
  const float reach = 1.5f * width + 0.5f;
  return p > 0.5f - reach && p < 7.5f + reach;
}

/// Knot distance in voxel lengths: `knots` is (thin, thick).
static float octree_knots(float2 knots, float thickness) {
  const float blend = 2.0f * thickness - 0.5f;
  return knots.x + (knots.y - knots.x) * (blend < 0 ? 0.0f : blend > 1 ? 1.0f : blend);
}

/// Widths in cells, none below one.
static float octree_width(float knots, float side) {
  const float width = knots / side;
  return width < 1.0f ? 1.0f : width;
}

kernel __attribute__((BRICK_GROUP)) void poisson_splat(
    int exponent, float per_voxel, float4 cell_side, int4 reach, float2 knots,
    VIEW(const int, coords), int index_side, VIEW(const int, index), VIEW(const uint, voxel_start),
    VIEW(const float, position_x), VIEW(const float, position_y), VIEW(const float, position_z),
    VIEW(const float, area_x), VIEW(const float, area_y), VIEW(const float, area_z),
    VIEW(const float, normal_x), VIEW(const float, normal_y), VIEW(const float, normal_z),
    VIEW(const float, thickness), VIEW(float, right_hand_side)) {
  TAKE(coords);
  TAKE(index);
  TAKE(voxel_start);
  TAKE(position_x);
  TAKE(position_y);
  TAKE(position_z);
  TAKE(area_x);
  TAKE(area_y);
  TAKE(area_z);
  TAKE(normal_x);
  TAKE(normal_y);
  TAKE(normal_z);
  TAKE(thickness);
  TAKE(right_hand_side);
  const size_t brick = get_group_id(0);
  PointBox box = point_box(exponent, vload3(brick, coords), index_side,
                           index + brick * index_side * index_side * index_side, voxel_start);
  const float3 corner = convert_float3(box.low);
  point_box_grow(&box, reach.xyz);
  float8 sum[OWN_ROWS];
  for (int r = 0; r < OWN_ROWS; ++r) sum[r] = (float8)(0.0f);
  FOR_POINT_RUNS(box, run) {
    for (uint p = run.x; p < run.y; ++p) {
      const float width_of = octree_knots(knots, thickness[p]);
      const float3 at = ((float3)(position_x[p], position_y[p], position_z[p]) - corner) * per_voxel;
      const float3 width =
          (float3)(octree_width(width_of, cell_side.x), octree_width(width_of, cell_side.y),
                   octree_width(width_of, cell_side.z));
      if (!octree_reaches(at.x, width.x) || !octree_reaches(at.y, width.y) ||
          !octree_reaches(at.z, width.z))
        continue;
      const OctreeWeights wx = octree_weights(at.x, width.x), wy = octree_weights(at.y, width.y),
                          wz = octree_weights(at.z, width.z);
      const float nx = normal_x[p], ny = normal_y[p], nz = normal_z[p];
      const float weight = (area_x[p] * nx + area_y[p] * ny) + area_z[p] * nz;
      const float ax = weight * nx / cell_side.x, ay = weight * ny / cell_side.y,
                  az = weight * nz / cell_side.z;
      float value_y[8], value_z[8], difference_y[8], difference_z[8];
      vstore8(wy.value, 0, value_y);
      vstore8(wz.value, 0, value_z);
      vstore8(wy.difference, 0, difference_y);
      vstore8(wz.difference, 0, difference_z);
      FOR_OWN_ROWS(y, wy.first, wy.last, z, wz.first, wz.last) {
        const float along = ax * (value_y[y] * value_z[z]);
        const float across =
            ay * (difference_y[y] * value_z[z]) + az * (value_y[y] * difference_z[z]);
        sum[OWN_ROW(8 * z + y)] += along * wx.difference + across * wx.value;
      }
    }
  }
  for (int row = get_local_id(0), r = 0; row < BRICK_ROWS; row += BRICK_ITEMS, ++r)
    vstore8(sum[r], brick * BRICK_ROWS + row, right_hand_side);
}

// --- Between levels. -------------------------------------------------------------------------

static float8 octree_restrict_four(float8 a, float8 b, float8 c, float8 d) {
  return 0.25f * (a + d) + 0.75f * (b + c);
}

/// An axis at a time, from the 18 x 18 x 18 fine cells over the brick and one round it.
kernel __attribute__((BRICK_GROUP)) void poisson_restrict(VIEW(const int, children),
                                                          VIEW(const float, fine),
                                                          VIEW(float, coarse)) {
  BRICK_SHARED float8 along_x[18 * 18];
  BRICK_SHARED float8 along_y[18 * 8];
  TAKE(children);
  TAKE(fine);
  TAKE(coarse);
  const size_t brick = get_group_id(0);
  global const int *table = children + brick * 64;
  for (int i = get_local_id(0); i < 18 * 18; i += BRICK_ITEMS) {
    const int y = i % 18 + 7, z = i / 18 + 7;
    const float first = table_cell(fine, table, 4, 7, y, z),
                last = table_cell(fine, table, 4, 24, y, z);
    const float8 u = table_row(fine, table, 4, 1, y, z), v = table_row(fine, table, 4, 2, y, z);
    along_x[i] =
        octree_restrict_four((float8)(first, u.s1357, v.s13, v.s5), (float8)(u.s0246, v.s0246),
                             (float8)(u.s1357, v.s1357), (float8)(u.s24, u.s6, v.s0246, last));
  }
  BRICK_SYNC();
  for (int i = get_local_id(0); i < 18 * 8; i += BRICK_ITEMS) {
    const int from = 18 * (i >> 3) + 2 * (i & 7);
    along_y[i] = octree_restrict_four(along_x[from], along_x[from + 1], along_x[from + 2],
                                      along_x[from + 3]);
  }
  BRICK_SYNC();
  for (int row = get_local_id(0); row < BRICK_ROWS; row += BRICK_ITEMS) {
    const int from = 16 * (row >> 3) + (row & 7);
    const float8 value = octree_restrict_four(along_y[from], along_y[from + 8], along_y[from + 16],
                                              along_y[from + 24]);
    vstore8(value, brick * BRICK_ROWS + row, coarse);
  }
}

static float8 octree_refine(float8 own, float8 other) { return 0.75f * own + 0.25f * other; }

/// Of six coarse cells, the one that holds fine cell `i` of 0..7, and the other one near it.
static int octree_own(int i) { return (i >> 1) + 1; }
static int octree_other(int i) { return i & 1 ? (i >> 1) + 2 : i >> 1; }

/// An axis at a time, from the 6 x 6 x 6 coarse cells over the brick and one round it.
kernel __attribute__((BRICK_GROUP)) void poisson_prolong(VIEW(const int, coords),
                                                         VIEW(const int, parents),
                                                         VIEW(const float, coarse),
                                                         VIEW(float, fine)) {
  BRICK_SHARED float8 along_x[6 * 6];
  BRICK_SHARED float8 along_y[6 * 8];
  TAKE(coords);
  TAKE(parents);
  TAKE(coarse);
  TAKE(fine);
  const size_t brick = get_group_id(0);
  global const int *table = parents + brick * NEIGHBOURS;
  const int3 octant = vload3(brick, coords) & 1;
  for (int i = get_local_id(0); i < 6 * 6; i += BRICK_ITEMS) {
    const float8 c = table_octant_row(coarse, table, octant, i % 6, i / 6);
    along_x[i] = octree_refine(c.s11223344, c.s02132435);
  }
  BRICK_SYNC();
  for (int i = get_local_id(0); i < 6 * 8; i += BRICK_ITEMS) {
    const int y = i & 7, z = i >> 3;
    along_y[i] = octree_refine(along_x[6 * z + octree_own(y)], along_x[6 * z + octree_other(y)]);
  }
  BRICK_SYNC();
  for (int row = get_local_id(0); row < BRICK_ROWS; row += BRICK_ITEMS) {
    const int y = row & 7, z = row >> 3;
    const float8 value =
        octree_refine(along_y[8 * octree_own(z) + y], along_y[8 * octree_other(z) + y]);
    vstore8(value, brick * BRICK_ROWS + row, fine);
  }
}
