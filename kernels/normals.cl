/// \file
/// Normal vectors: the occupancy gradient, and the covariance of neighbours of the same sheet
/// (engine/stages/normals.h). Contracts: engine/backend/backend.h.

static float normals_dot(float3 a, float3 b) { return (a.x * b.x + a.y * b.y) + a.z * b.z; }

/// Whether a unit vector points against the faces behind its point.
static bool normals_is_against(float3 outward, float3 area) {
  const float along = normals_dot(outward, area);
  return along < 0.0f && along * along > NORMALS_AGAINST_FACES * normals_dot(area, area);
}

// --- Gradient (engine/stages/gradient_table.h). ----------------------------------------------

/// One table: `reach` along each axis, (weight, moment) pairs of the voxels along y and z, and of
/// the patterns along x.
typedef struct {
  int3 reach;
  global const float2 *along_y, *along_z, *pattern;
} NormalsTable;

/// A coordinate as floor (x) and twenty-fourths (y).
static int2 normals_place(float position) {
  const int base = (int)position;
  const int fraction = (int)((position - (float)base) * (float)NORMALS_FRACTIONS + 0.5f);
  return fraction == NORMALS_FRACTIONS ? (int2)(base + 1, 0) : (int2)(base, fraction);
}

/// Bits first .. first + span - 1 of a row; in the row or its padding. At most 16.
static uint normals_row_bits(global const ulong *row, int first, int span) {
  const int word = first >> 6, shift = first & 63;
  ulong bits = row[word] >> shift;
  if (shift + span > 64) bits |= row[word + 1] << (64 - shift);
  return bits & ((1u << span) - 1);
}

/// Sum of weight * offset over the object voxels in reach of a point: towards the object.
static float3 normals_occupancy(global const ulong *object, int4 size, const NormalsTable *table,
                                float3 position) {
  const int2 x = normals_place(position.x), y = normals_place(position.y),
             z = normals_place(position.z);
  global const float2 *wy = table->along_y + y.y * NORMALS_SPAN;
  global const float2 *wz = table->along_z + z.y * NORMALS_SPAN;
  global const float2 *pattern = table->pattern + x.y * 512;
  const int first = x.x - table->reach.x, span = 2 * table->reach.x + 1;
  float3 sum = (float3)(0.0f);
  for (int k = 0; k <= 2 * table->reach.z; ++k) {
    float3 slice = (float3)(0.0f);  // moment along x, moment along y, weight
    const size_t plane = (size_t)(z.x - table->reach.z + k) * size.y;
    for (int j = 0; j <= 2 * table->reach.y; ++j) {
      const size_t row = (plane + (y.x - table->reach.y + j)) * size.w;
      const uint bits = normals_row_bits(object + row, first, span);
      if (bits == 0) continue;
      const float2 both = pattern[bits & 0xff] + pattern[256 + (bits >> 8)];
      slice.x += wy[j].x * both.y;
      slice.y += wy[j].y * both.x;
      slice.z += wy[j].x * both.x;
    }
    sum.x += wz[k].x * slice.x;
    sum.y += wz[k].x * slice.y;
    sum.z += wz[k].y * slice.z;
  }
  return sum;
}

/// A work-item a point. The tables are those of the sigma and of its half.
kernel __attribute__((ELEMENT_GROUP)) void normals_gradient(
    ulong count, int4 size, int4 wide_reach, int4 narrow_reach, VIEW(const ulong, object),
    VIEW(const float2, tables), VIEW(const float, position_x), VIEW(const float, position_y),
    VIEW(const float, position_z), VIEW(const float, area_x), VIEW(const float, area_y),
    VIEW(const float, area_z), VIEW(float, normal_x), VIEW(float, normal_y),
    VIEW(float, normal_z)) {
  const size_t i = get_global_id(0);
  if (i >= count) return;
  TAKE(object);
  TAKE(tables);
  const float3 position = (float3)(position_x[position_x_first + i], position_y[position_y_first + i],
                                   position_z[position_z_first + i]);
  const float3 area =
      (float3)(area_x[area_x_first + i], area_y[area_y_first + i], area_z[area_z_first + i]);
  float3 normal = area / sqrt(normals_dot(area, area));
  for (int wide = 1; wide >= 0; --wide) {
    NormalsTable table;
    table.reach = wide ? wide_reach.xyz : narrow_reach.xyz;
    table.along_y = tables + (wide ? 0 : NORMALS_FRACTIONS * (2 * NORMALS_SPAN + 512));
    table.along_z = table.along_y + NORMALS_FRACTIONS * NORMALS_SPAN;
    table.pattern = table.along_z + NORMALS_FRACTIONS * NORMALS_SPAN;
    const float3 inward = normals_occupancy(object, size, &table, position);
    const float square = normals_dot(inward, inward);
    if (square < NORMALS_NO_GRADIENT) continue;
    const float3 outward = inward / -sqrt(square);
    if (normals_is_against(outward, area)) continue;
    normal = outward;
    break;
  }
  normal_x[normal_x_first + i] = normal.x;
  normal_y[normal_y_first + i] = normal.y;
  normal_z[normal_z_first + i] = normal.z;
}

// --- Neighbours. -----------------------------------------------------------------------------

#define NORMALS_BLOCK (2 * NORMALS_REACH + 1)
#define NORMALS_MOST 65  // neighbours, with the point's own voxel

/// samples[i] = position and gradient of point i, side by side.
kernel __attribute__((ELEMENT_GROUP)) void normals_gather(
    ulong count, VIEW(const float, position_x), VIEW(const float, position_y),
    VIEW(const float, position_z), VIEW(const float, gradient_x), VIEW(const float, gradient_y),
    VIEW(const float, gradient_z), VIEW(float, samples)) {
  const size_t i = get_global_id(0);
  if (i >= count) return;
  const float8 sample = (float8)(
      position_x[position_x_first + i], position_y[position_y_first + i],
      position_z[position_z_first + i], 0.0f, gradient_x[gradient_x_first + i],
      gradient_y[gradient_y_first + i], gradient_z[gradient_z_first + i], 0.0f);
  vstore8(sample, i, samples + samples_first);
}

/// A neighbour: the samples of one voxel that agree with the point, at their mean; `index` is that
/// of the first of them and breaks ties.
typedef struct {
  float distance;  // squared
  uint index;
  float3 offset;   // voxel lengths
} NormalsNeighbour;

/// A voxel with samples in reach of another: first and last + 1, and its place in the block.
typedef struct {
  uint first, last;
  uchar x, y, z;
} NormalsCandidate;

static bool normals_before(const NormalsNeighbour *a, const NormalsNeighbour *b) {
  return a->distance < b->distance || (a->distance == b->distance && a->index < b->index);
}

/// 0, -1, 1, -2, 2 ..: the nearest rows first.
static int normals_outwards(int i) { return i & 1 ? -(i + 1) / 2 : i / 2; }

/// The voxels in reach of voxel (x, y, z) of a brick that have samples. \return how many.
static int normals_collect(global const int *near, global const uint *voxel_start, int x, int y,
                           int z, NormalsCandidate *candidates) {
  int count = 0;
  for (int k = 0; k < NORMALS_BLOCK; ++k)
    for (int j = 0; j < NORMALS_BLOCK; ++j) {
      const int dy = normals_outwards(j), dz = normals_outwards(k);
      const int row = 8 * ((y + dy) & 7) + 64 * ((z + dz) & 7);
      for (int bx = (x - NORMALS_REACH) >> 3; bx <= (x + NORMALS_REACH) >> 3; ++bx) {
        const int brick =
            near[SELF + bx + STEP_Y * ((y + dy) >> 3) + STEP_Z * ((z + dz) >> 3)];
        if (brick < 0) continue;
        global const uint *start = voxel_start + (size_t)brick * BRICK_CELLS + row;
        const int first = max(x - NORMALS_REACH - 8 * bx, 0),
                  last = min(x + NORMALS_REACH - 8 * bx, 7);
        if (start[first] == start[last + 1]) continue;
        for (int i = first; i <= last; ++i) {
          if (start[i] == start[i + 1]) continue;
          candidates[count].first = start[i];
          candidates[count].last = start[i + 1];
          candidates[count].x = i + 8 * bx - x + NORMALS_REACH;
          candidates[count].y = dy + NORMALS_REACH;
          candidates[count].z = dz + NORMALS_REACH;
          ++count;
        }
      }
    }
  return count;
}

/// Square of the distance from a point to the slab of a voxel along one axis.
static float normals_gap(float position, int voxel, float scale) {
  const float below = (float)voxel - position, above = position - (float)(voxel + 1);
  const float outside = below < above ? above : below;
  const float gap = (outside < 0.0f ? 0.0f : outside) * scale;
  return gap * gap;
}

/// The neighbour that one voxel's samples make; false where none of them agrees.
static bool normals_neighbour(global const float *samples, uint first, uint last, float3 position,
                              float3 gradient, float3 scale, NormalsNeighbour *neighbour) {
  float3 sum = (float3)(0.0f);
  float agreeing = 0;
  for (uint i = first; i < last; ++i) {
    const float8 sample = vload8(i, samples);
    const float agrees = normals_dot(sample.s456, gradient) > NORMALS_SAME_SHEET ? 1.0f : 0.0f;
    sum += agrees * (sample.s012 - position);
    agreeing += agrees;
  }
  if (agreeing == 0) return false;
  neighbour->offset = (sum / agreeing) * scale;
  neighbour->distance = normals_dot(neighbour->offset, neighbour->offset);
  neighbour->index = first;
  return true;
}

/// Puts a neighbour among the `most` nearest, which are in order. \return how many there are.
static int normals_offer(const NormalsNeighbour *found, int most, NormalsNeighbour *nearest,
                         int count) {
  if (count == most && !normals_before(found, &nearest[count - 1])) return count;
  int i = count == most ? count - 1 : count++;
  for (; i > 0 && normals_before(found, &nearest[i - 1]); --i) nearest[i] = nearest[i - 1];
  nearest[i] = *found;
  return count;
}

/// The `most` nearest neighbours among the candidates; skips voxels that are farther than those at
/// hand. `voxel` is the point's own. \return how many there are.
static int normals_find(global const float *samples, const NormalsCandidate *candidates,
                        int candidate_count, int3 voxel, float3 position, float3 gradient,
                        float3 scale, int most, NormalsNeighbour *nearest) {
  const float safe = 1.001f;  // covers the rounding of distances
  float gap[3][NORMALS_BLOCK];
  for (int i = 0; i < NORMALS_BLOCK; ++i) {
    gap[0][i] = normals_gap(position.x, voxel.x + i - NORMALS_REACH, scale.x);
    gap[1][i] = normals_gap(position.y, voxel.y + i - NORMALS_REACH, scale.y);
    gap[2][i] = normals_gap(position.z, voxel.z + i - NORMALS_REACH, scale.z);
  }
  int count = 0;
  for (int c = 0; c < candidate_count; ++c) {
    const NormalsCandidate at = candidates[c];
    if (count == most &&
        (gap[0][at.x] + gap[1][at.y]) + gap[2][at.z] > safe * nearest[count - 1].distance)
      continue;
    NormalsNeighbour found;
    if (normals_neighbour(samples, at.first, at.last, position, gradient, scale, &found))
      count = normals_offer(&found, most, nearest, count);
  }
  return count;
}

// --- Covariance. -----------------------------------------------------------------------------

/// One Jacobi rotation that zeroes a[p][q]; r is the third index (engine/stages/jacobi.h).
static void normals_rotate(float a[3][3], float v[3][3], int p, int q, int r, float least) {
  const float apq = a[p][q];
  if (fabs(apq) <= least) return;
  const float theta = (a[q][q] - a[p][p]) / (2.0f * apq);
  const float size = 1.0f / (fabs(theta) + sqrt(theta * theta + 1.0f));
  const float t = theta < 0.0f ? -size : size;
  const float c = 1.0f / sqrt(t * t + 1.0f);
  const float s = t * c;
  a[p][p] = a[p][p] - t * apq;
  a[q][q] = a[q][q] + t * apq;
  a[p][q] = a[q][p] = 0.0f;
  const float arp = a[r][p], arq = a[r][q];
  a[r][p] = a[p][r] = c * arp - s * arq;
  a[r][q] = a[q][r] = s * arp + c * arq;
  for (int i = 0; i < 3; ++i) {
    const float vip = v[i][p], viq = v[i][q];
    v[i][p] = c * vip - s * viq;
    v[i][q] = s * vip + c * viq;
  }
}

/// The eigenvector of the smallest eigenvalue of a symmetric matrix.
static float3 normals_least_eigenvector(float a[3][3]) {
  float v[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const float least = 1e-7f * ((a[0][0] + a[1][1]) + a[2][2]);
  for (int sweep = 0; sweep < NORMALS_SWEEPS; ++sweep) {
    normals_rotate(a, v, 0, 1, 2, least);
    normals_rotate(a, v, 0, 2, 1, least);
    normals_rotate(a, v, 1, 2, 0, least);
  }
  int order[3] = {0, 1, 2};
  for (int pass = 0; pass < 3; ++pass) {
    const int i = pass & 1, swapped = order[i];
    if (a[order[i + 1]][order[i + 1]] >= a[swapped][swapped]) continue;
    order[i] = order[i + 1];
    order[i + 1] = swapped;
  }
  const int column = order[0];
  return (float3)(v[0][column], v[1][column], v[2][column]);
}

/// The normal of the plane through the neighbours; the gradient where that is against the faces.
static float3 normals_plane(const NormalsNeighbour *nearest, int neighbours, float3 gradient,
                            float3 area) {
  const float count = (float)neighbours;
  float3 mean = (float3)(0.0f);
  for (int n = 0; n < neighbours; ++n) mean += nearest[n].offset;
  mean = mean / count;
  const float3 g = gradient;
  const float weight = NORMALS_TANGENT_WEIGHT * count;
  float xx = weight * (1.0f - g.x * g.x), xy = -weight * (g.x * g.y), xz = -weight * (g.x * g.z);
  float yy = weight * (1.0f - g.y * g.y), yz = -weight * (g.y * g.z);
  float zz = weight * (1.0f - g.z * g.z);
  for (int n = 0; n < neighbours; ++n) {
    const float3 d = nearest[n].offset - mean;
    xx += d.x * d.x;
    xy += d.x * d.y;
    xz += d.x * d.z;
    yy += d.y * d.y;
    yz += d.y * d.z;
    zz += d.z * d.z;
  }
  float matrix[3][3] = {{xx, xy, xz}, {xy, yy, yz}, {xz, yz, zz}};
  const float3 v = normals_least_eigenvector(matrix);
  const float length = sqrt(normals_dot(v, v));
  const float3 normal = v / (normals_dot(v, gradient) < 0.0f ? -length : length);
  return normals_is_against(normal, area) ? gradient : normal;
}

/// An item takes whole voxels: the candidates of their points are the same.
kernel __attribute__((PLAIN_BRICK_GROUP)) void normals_covariance(
    int most, float4 scale, VIEW(const float, samples), VIEW(const int, coords),
    VIEW(const int, neighbours), VIEW(const uint, voxel_start), VIEW(const float, area_x),
    VIEW(const float, area_y), VIEW(const float, area_z), VIEW(float, normal_x),
    VIEW(float, normal_y), VIEW(float, normal_z)) {
  NormalsCandidate candidates[NORMALS_BLOCK * NORMALS_BLOCK * NORMALS_BLOCK];
  NormalsNeighbour nearest[NORMALS_MOST];
  TAKE(samples);
  TAKE(coords);
  TAKE(neighbours);
  TAKE(voxel_start);
  const size_t brick = get_group_id(0);
  const int3 corner = 8 * vload3(brick, coords);
  global const uint *start = voxel_start + brick * BRICK_CELLS;
  for (int voxel = get_local_id(0); voxel < BRICK_CELLS; voxel += BRICK_ITEMS) {
    if (start[voxel] == start[voxel + 1]) continue;
    const int x = voxel & 7, y = voxel >> 3 & 7, z = voxel >> 6;
    const int count =
        normals_collect(neighbours + brick * NEIGHBOURS, voxel_start, x, y, z, candidates);
    for (uint i = start[voxel]; i < start[voxel + 1]; ++i) {
      const float8 own = vload8(i, samples);
      const int found = normals_find(samples, candidates, count, corner + (int3)(x, y, z), own.s012,
                                     own.s456, scale.xyz, most, nearest);
      const float3 area =
          (float3)(area_x[area_x_first + i], area_y[area_y_first + i], area_z[area_z_first + i]);
      const float3 normal = normals_plane(nearest, found, own.s456, area);
      normal_x[normal_x_first + i] = normal.x;
      normal_y[normal_y_first + i] = normal.y;
      normal_z[normal_z_first + i] = normal.z;
    }
  }
}
