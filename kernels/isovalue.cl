/// \file
/// The spline at the samples, and the local isovalue: the area-weighted mean of the field at the
/// samples under a normalised kernel. Contracts: engine/backend/backend.h.

/// The three cells round a position along one axis (in cells from the brick's corner) and their
/// weights.
typedef struct {
  int first;
  float3 weight;
} IsovalueTaps;

static IsovalueTaps isovalue_taps(float p) {
  const float nearest = floor(p);
  const float t = p - (nearest + 0.5f);
  IsovalueTaps taps;
  taps.first = (int)nearest - 1;
  taps.weight = (float3)(0.5f * ((0.5f - t) * (0.5f - t)), 0.75f - t * t,
                         0.5f * ((0.5f + t) * (0.5f + t)));
  return taps;
}

static float isovalue_weight(const IsovalueTaps *taps, int i) {
  return i == 0 ? taps->weight.x : i == 1 ? taps->weight.y : taps->weight.z;
}

static float isovalue_spline(global const int *near, global const float *coefficients,
                             const IsovalueTaps *tx, const IsovalueTaps *ty,
                             const IsovalueTaps *tz) {
  float sum = 0;
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < 3; ++j) {
      const int y = ty->first + j + 8, z = tz->first + k + 8;
      float row = 0;
      for (int i = 0; i < 3; ++i) {
        const int x = tx->first + i + 8;
        const int from = near[(x >> 3) + STEP_Y * (y >> 3) + STEP_Z * (z >> 3)];
        if (from < 0) continue;
        row += isovalue_weight(tx, i) *
               coefficients[(size_t)from * BRICK_CELLS + (x & 7) + 8 * (y & 7) + 64 * (z & 7)];
      }
      sum += (isovalue_weight(ty, j) * isovalue_weight(tz, k)) * row;
    }
  return sum;
}

kernel __attribute__((BRICK_GROUP)) void poisson_sample_points(
    int exponent, float per_voxel, VIEW(const int, coords), VIEW(const int, neighbours),
    int index_side, VIEW(const int, index), VIEW(const uint, voxel_start),
    VIEW(const float, position_x), VIEW(const float, position_y), VIEW(const float, position_z),
    VIEW(const float, coefficients), VIEW(float, values)) {
  TAKE(coords);
  TAKE(neighbours);
  TAKE(index);
  TAKE(voxel_start);
  TAKE(position_x);
  TAKE(position_y);
  TAKE(position_z);
  TAKE(coefficients);
  TAKE(values);
  const size_t brick = get_group_id(0);
  const PointBox box = point_box(exponent, vload3(brick, coords), index_side,
                                 index + brick * index_side * index_side * index_side, voxel_start);
  const float3 corner = convert_float3(box.low);
  const int rows_y = box.high.y - box.low.y, rows = rows_y * (box.high.z - box.low.z);
  for (int row = get_local_id(0); row < rows; row += BRICK_ITEMS)
    for (int bx = box.low.x >> 3; bx <= (box.high.x - 1) >> 3; ++bx) {
      const uint2 run = point_run(&box, bx, box.low.y + row % rows_y, box.low.z + row / rows_y);
      for (uint p = run.x; p < run.y; ++p) {
        const float3 at =
            ((float3)(position_x[p], position_y[p], position_z[p]) - corner) * per_voxel;
        const IsovalueTaps tx = isovalue_taps(at.x), ty = isovalue_taps(at.y),
                           tz = isovalue_taps(at.z);
        values[p] = isovalue_spline(neighbours + brick * NEIGHBOURS, coefficients, &tx, &ty, &tz);
      }
    }
}

kernel __attribute__((BRICK_GROUP)) void isovalue_splat(
    int exponent, float per_voxel, int reach, VIEW(const int, coords), int index_side,
    VIEW(const int, index), VIEW(const uint, voxel_start), VIEW(const float, position_x),
    VIEW(const float, position_y), VIEW(const float, position_z), VIEW(const float, weights),
    VIEW(const float, values), VIEW(float, numerator), VIEW(float, denominator)) {
  TAKE(coords);
  TAKE(index);
  TAKE(voxel_start);
  TAKE(position_x);
  TAKE(position_y);
  TAKE(position_z);
  TAKE(weights);
  TAKE(values);
  TAKE(numerator);
  TAKE(denominator);
  const size_t brick = get_group_id(0);
  PointBox box = point_box(exponent, vload3(brick, coords), index_side,
                           index + brick * index_side * index_side * index_side, voxel_start);
  const float3 corner = convert_float3(box.low);
  point_box_grow(&box, (int3)(reach));
  float num[8 * OWN_ROWS], den[8 * OWN_ROWS];
  for (int i = 0; i < 8 * OWN_ROWS; ++i) num[i] = den[i] = 0.0f;
  FOR_POINT_RUNS(box, run) {
    for (uint p = run.x; p < run.y; ++p) {
      const float weight = weights[p], value = values[p];
      if (weight == 0) continue;
      const float3 at =
          ((float3)(position_x[p], position_y[p], position_z[p]) - corner) * per_voxel;
      const IsovalueTaps tx = isovalue_taps(at.x), ty = isovalue_taps(at.y),
                         tz = isovalue_taps(at.z);
      FOR_OWN_ROWS(y, max(ty.first, 0), min(ty.first + 3, 8), z, max(tz.first, 0),
                   min(tz.first + 3, 8)) {
        const float across =
            isovalue_weight(&ty, y - ty.first) * isovalue_weight(&tz, z - tz.first);
        const int row = 8 * OWN_ROW(8 * z + y);
        for (int x = max(tx.first, 0); x < min(tx.first + 3, 8); ++x) {
          const float w = weight * (isovalue_weight(&tx, x - tx.first) * across);
          num[row + x] += w * value;
          den[row + x] += w;
        }
      }
    }
  }
  for (int row = get_local_id(0), r = 0; row < BRICK_ROWS; row += BRICK_ITEMS, ++r) {
    vstore8(vload8(r, num), brick * BRICK_ROWS + row, numerator);
    vstore8(vload8(r, den), brick * BRICK_ROWS + row, denominator);
  }
}

kernel __attribute__((BRICK_GROUP)) void isovalue_smooth(VIEW(const int, neighbours), int axis,
                                                         float tap, VIEW(const float, in),
                                                         VIEW(float, out)) {
  TAKE(neighbours);
  TAKE(in);
  TAKE(out);
  const size_t brick = get_group_id(0);
  global const int *near = neighbours + brick * NEIGHBOURS;
  const float keep = 1.0f - 2.0f * tap;
  for (int row = get_local_id(0); row < BRICK_ROWS; row += BRICK_ITEMS) {
    const int y = row & 7, z = row >> 3;
    const float8 own = brick_row(in, near, y, z);
    float8 low, high;
    if (axis == 0) {
      low = (float8)(brick_cell_beside(in, near, -1, 7, row), own.s0123, own.s45, own.s6);
      high = (float8)(own.s1234, own.s56, own.s7, brick_cell_beside(in, near, 1, 0, row));
    } else {
      low = brick_row(in, near, y - (axis == 1), z - (axis == 2));
      high = brick_row(in, near, y + (axis == 1), z + (axis == 2));
    }
    vstore8(keep * own + tap * (low + high), brick * BRICK_ROWS + row, out);
  }
}

kernel __attribute__((BRICK_GROUP)) void isovalue_divide(float fallback,
                                                         VIEW(const float, denominator),
                                                         VIEW(float, numerator)) {
  const float small = 1e-4f;
  TAKE(denominator);
  TAKE(numerator);
  const size_t first = get_group_id(0) * BRICK_ROWS;
  for (int row = get_local_id(0); row < BRICK_ROWS; row += BRICK_ITEMS) {
    const float8 above = vload8(first + row, numerator), below = vload8(first + row, denominator);
    vstore8((above + small * fallback) / (below + small), first + row, numerator);
  }
}
