/// \file
/// Counting and writing the samples of each brick (engine/stages/points.h). Contracts:
/// engine/backend/backend.h.

#define POINTS_HALO 2   // voxels round a brick that its points look at
#define POINTS_SPAN 12  // with the halo

/// Twelve bits of a row from bit `first` on, which may be outside the row.
static uint points_row_bits(global const ulong *row, int words, int first) {
  const int word = first >> 6, shift = first & 63;
  ulong bits = 0;
  if (word >= 0 && word < words) bits = row[word] >> shift;
  if (shift > 64 - POINTS_SPAN && word + 1 < words) bits |= row[word + 1] << (64 - shift);
  return bits & ((1u << POINTS_SPAN) - 1);
}

/// Row (y, z), each -2..9, of a brick of bits: voxel x is bit x + 2. size.w is the words of a row.
static uint points_load_row(global const ulong *bits, int4 size, int3 brick, int y, int z) {
  const int vy = 8 * brick.y + y, vz = 8 * brick.z + z;
  if (vy < 0 || vy >= size.y || vz < 0 || vz >= size.z) return 0;
  return points_row_bits(bits + ((size_t)vz * size.y + vy) * size.w, size.w,
                         8 * brick.x - POINTS_HALO);
}

/// A brick of bits with two voxels round it.
#define POINTS_LOAD(block, bits, size, brick)                                            \
  for (int row_ = get_local_id(0); row_ < POINTS_SPAN * POINTS_SPAN; row_ += BRICK_ITEMS) \
    block[row_] = points_load_row(bits, size, brick, row_ % POINTS_SPAN - POINTS_HALO,   \
                                  row_ / POINTS_SPAN - POINTS_HALO)

static int points_row_of(int y, int z) {
  return (y + POINTS_HALO) + POINTS_SPAN * (z + POINTS_HALO);
}

/// Outer boundary voxels of a row, bits 0..7: background with an object neighbour.
static uint points_boundary(BRICK_SHARED const uint *own) {
  const uint near = own[0] << 1 | own[0] >> 1 | own[-1] | own[1] | own[-POINTS_SPAN] |
                    own[POINTS_SPAN];
  return (near & ~own[0]) >> POINTS_HALO & 0xff;
}

/// The six object neighbours of voxel x of a row: bit 2 axis + side.
static uint points_mask(BRICK_SHARED const uint *own, int x) {
  const int bit = x + POINTS_HALO;
  return (own[0] >> (bit - 1) & 1) | (own[0] >> (bit + 1) & 1) << 1 | (own[-1] >> bit & 1) << 2 |
         (own[1] >> bit & 1) << 3 | (own[-POINTS_SPAN] >> bit & 1) << 4 |
         (own[POINTS_SPAN] >> bit & 1) << 5;
}

/// The part of a mask that a subvoxel sx + 2 sy + 4 sz shares faces with.
static uint points_subvoxel_mask(uint mask, uint subvoxel) {
  return mask & (1u << (subvoxel & 1) | 4u << (subvoxel >> 1 & 1) | 16u << (subvoxel >> 2));
}

static bool points_has_opposite_pair(uint mask) { return (mask & (mask >> 1) & 0x15) != 0; }

/// How many points a voxel with this mask gives.
static uint points_of_mask(uint mask, bool refined) {
  if (!refined) return points_has_opposite_pair(mask) ? popcount(mask) : mask != 0;
  uint count = 0;
  for (uint s = 0; s < 8; ++s) count += points_subvoxel_mask(mask, s) != 0;
  return count;
}

kernel __attribute__((PLAIN_BRICK_GROUP)) void points_count(
    int4 size, VIEW(const ulong, object), VIEW(const ulong, refine), VIEW(const int, coords),
    VIEW(uint, counts), VIEW(uint, refined)) {
  BRICK_SHARED uint block[POINTS_SPAN * POINTS_SPAN];
  BRICK_SHARED uint from_refined[BRICK_ITEMS];
  TAKE(object);
  TAKE(refine);
  TAKE(coords);
  TAKE(counts);
  const size_t brick = get_group_id(0);
  const int3 at = vload3(brick, coords);
  POINTS_LOAD(block, object, size, at);
  from_refined[get_local_id(0)] = 0;
  BRICK_SYNC();
  for (int row = get_local_id(0); row < BRICK_ROWS; row += BRICK_ITEMS) {
    const int y = row & 7, z = row >> 3;
    BRICK_SHARED const uint *own = block + points_row_of(y, z);
    const uint boundary = points_boundary(own);
    global uint *out = counts + brick * BRICK_CELLS + 8 * row;
    if (boundary == 0) {
      vstore8((uint8)(0), 0, out);
      continue;
    }
    const uint split = points_load_row(refine, size, at, y, z) >> POINTS_HALO;
    for (int x = 0; x < 8; ++x) {
      const bool fine = split >> x & 1;
      const uint count = boundary >> x & 1 ? points_of_mask(points_mask(own, x), fine) : 0;
      out[x] = count;
      if (fine) from_refined[get_local_id(0)] += count;
    }
  }
  BRICK_SYNC();
  if (get_local_id(0) != 0) return;
  uint sum = 0;
  for (int i = 0; i < BRICK_ITEMS; ++i) sum += from_refined[i];
  refined[refined_first + brick] = sum;
}

// --- Writing. --------------------------------------------------------------------------------

/// Set voxels of the 5 x 5 x 5 round voxel x of a row.
static uint points_near(BRICK_SHARED const uint *own, int x) {
  uint count = 0;
  for (int dz = -2; dz <= 2; ++dz)
    for (int dy = -2; dy <= 2; ++dy)
      count += popcount(own[dy + POINTS_SPAN * dz] >> x & 0x1f);
  return count;
}

/// 1 - thin part of the object round voxel x.
static float points_thickness(BRICK_SHARED const uint *object, BRICK_SHARED const uint *thin,
                              int x) {
  const uint all = points_near(object, x);
  return all == 0 ? 0.0f : 1.0f - (float)points_near(thin, x) / (float)all;
}

/// Where the point of a cell lies along one axis and its area there. `faces` are those of the cell
/// that the mask has, `corner` the cell's corner in the voxel, in halves.
typedef struct {
  float position, area;
} PointsAlong;

static PointsAlong points_along(uint mask, int axis, int faces, int voxel, int corner, float size,
                                float face_area) {
  const int below = mask >> (2 * axis) & 1, above = mask >> (2 * axis + 1) & 1;
  const int sum = faces - below + above;
  const float mean = (float)sum / (float)(2 * faces);
  PointsAlong along;
  along.position = (float)voxel + (0.5f * (float)corner + size * mean);
  along.area = (size * size) * (face_area * (float)(below - above));
  return along;
}

typedef struct {
  global float *position[3], *area[3], *thickness;
  float face_area[3];
} PointsOutput;

/// Writes the point of a cell (a voxel, or subvoxel `side` of half its size).
static void points_write(const PointsOutput *out, uint next, const int *voxel, uint side,
                         float size, uint mask, float thickness) {
  const int faces = popcount(mask);
  for (int axis = 0; axis < 3; ++axis) {
    const PointsAlong along = points_along(mask, axis, faces, voxel[axis], side >> axis & 1, size,
                                           out->face_area[axis]);
    out->position[axis][next] = along.position;
    out->area[axis][next] = along.area;
  }
  out->thickness[next] = thickness;
}

static void points_write_voxel(const PointsOutput *out, uint next, const int *voxel, uint mask,
                               bool refined, float thickness) {
  if (refined) {
    for (uint s = 0; s < 8; ++s) {
      const uint part = points_subvoxel_mask(mask, s);
      if (part) points_write(out, next++, voxel, s, 0.5f, part, thickness);
    }
  } else if (points_has_opposite_pair(mask)) {
    for (; mask; mask &= mask - 1)
      points_write(out, next++, voxel, 0, 1.0f, mask & -mask, thickness);
  } else {
    points_write(out, next, voxel, 0, 1.0f, mask, thickness);
  }
}

kernel __attribute__((PLAIN_BRICK_GROUP)) void points_emit(
    int4 size, float4 face_area, VIEW(const ulong, object), VIEW(const ulong, thin),
    VIEW(const ulong, refine), VIEW(const int, coords), VIEW(const uint, voxel_start),
    VIEW(float, position_x), VIEW(float, position_y), VIEW(float, position_z), VIEW(float, area_x),
    VIEW(float, area_y), VIEW(float, area_z), VIEW(float, thickness)) {
  BRICK_SHARED uint block[POINTS_SPAN * POINTS_SPAN];
  BRICK_SHARED uint slender[POINTS_SPAN * POINTS_SPAN];
  TAKE(object);
  TAKE(thin);
  TAKE(refine);
  TAKE(coords);
  TAKE(voxel_start);
  const PointsOutput out = {{position_x + position_x_first, position_y + position_y_first,
                             position_z + position_z_first},
                            {area_x + area_x_first, area_y + area_y_first, area_z + area_z_first},
                            thickness + thickness_first,
                            {face_area.x, face_area.y, face_area.z}};
  const size_t brick = get_group_id(0);
  const int3 at = vload3(brick, coords);
  POINTS_LOAD(block, object, size, at);
  POINTS_LOAD(slender, thin, size, at);
  BRICK_SYNC();
  uint any_thin = 0;
  for (int i = 0; i < POINTS_SPAN * POINTS_SPAN; ++i) any_thin |= slender[i];
  for (int row = get_local_id(0); row < BRICK_ROWS; row += BRICK_ITEMS) {
    const int y = row & 7, z = row >> 3, own = points_row_of(y, z);
    const uint boundary = points_boundary(block + own);
    if (boundary == 0) continue;
    const uint split = points_load_row(refine, size, at, y, z) >> POINTS_HALO;
    for (int x = 0; x < 8; ++x) {
      if (!(boundary >> x & 1)) continue;
      const int voxel[3] = {8 * at.x + x, 8 * at.y + y, 8 * at.z + z};
      const float thick = any_thin ? points_thickness(block + own, slender + own, x) : 1.0f;
      points_write_voxel(&out, voxel_start[brick * BRICK_CELLS + 8 * row + x], voxel,
                         points_mask(block + own, x), split >> x & 1, thick);
    }
  }
}
