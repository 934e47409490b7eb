/// \file
/// The cell lattice: which bricks and nodes matter, the solid's labels, the field at the nodes.
/// Contracts: engine/backend/backend.h; bits: engine/types/lattice.h.
///
/// Round a brick of nodes 0..7 lie the nodes -4..11 and the voxels -3..5; a row of either is a bit
/// pattern, lowest first.

#define LATTICE_NODES 16
#define LATTICE_VOXELS 9
#define LATTICE_NODE_MARGIN 4
#define LATTICE_VOXEL_MARGIN 3

/// Bit i to bit 2 i.
static uint lattice_spread(uint bits) {
  bits = (bits | bits << 4) & 0x0f0f;
  bits = (bits | bits << 2) & 0x3333;
  return (bits | bits << 1) & 0x5555;
}

/// LATTICE_VOXELS voxels from (x, y, z), background outside the volume; size.w: words of a row.
static uint lattice_voxel_row(global const ulong *object, int4 size, int x, int y, int z) {
  if (y < 0 || z < 0 || y >= size.y || z >= size.z) return 0;
  const int before = x < 0 ? -x : 0, from = x + before;
  const int word = from >> 6, shift = from & 63;
  if (word >= size.w) return 0;
  global const ulong *row = object + ((size_t)z * size.y + y) * size.w;
  ulong bits = row[word] >> shift;
  if (shift > 64 - LATTICE_VOXELS && word + 1 < size.w) bits |= row[word + 1] << (64 - shift);
  return (uint)(bits << before) & ((1u << LATTICE_VOXELS) - 1);
}

#define LATTICE_LOAD(voxels, object, size, brick)                                         \
  for (int i_ = get_local_id(0); i_ < LATTICE_VOXELS * LATTICE_VOXELS; i_ += BRICK_ITEMS) \
    voxels[i_] = lattice_voxel_row(object, size, 4 * brick.x - LATTICE_VOXEL_MARGIN,      \
                                   4 * brick.y + i_ % LATTICE_VOXELS - LATTICE_VOXEL_MARGIN, \
                                   4 * brick.z + i_ / LATTICE_VOXELS - LATTICE_VOXEL_MARGIN)

static uint lattice_voxels(BRICK_SHARED const uint *voxels, int y, int z) {
  return voxels[y + LATTICE_VOXELS * z];
}

/// False where all voxels are alike, so that there is no boundary.
static bool lattice_has_boundary(BRICK_SHARED const uint *voxels) {
  uint any = 0, all = ~0u;
  for (int i = 0; i < LATTICE_VOXELS * LATTICE_VOXELS; ++i) {
    any |= voxels[i];
    all &= voxels[i];
  }
  return any != 0 && all != (1u << LATTICE_VOXELS) - 1;
}

/// The centres of faces between object and background in row (y, z) of the nodes from -4: even ones
/// lie between voxels y / 2 and y / 2 + 1 of the rows, odd ones at voxel (y + 1) / 2.
static uint lattice_face_centres(BRICK_SHARED const uint *voxels, int y, int z) {
  const int vy = (y + 1) / 2, vz = (z + 1) / 2;
  if (y & z & 1) {
    const uint v = lattice_voxels(voxels, vy, vz);
    return lattice_spread((v ^ v >> 1) & 0xff);
  }
  if (z & 1)
    return lattice_spread(
               (lattice_voxels(voxels, y / 2, vz) ^ lattice_voxels(voxels, y / 2 + 1, vz)) >> 1 &
               0xff)
           << 1;
  if (y & 1)
    return lattice_spread(
               (lattice_voxels(voxels, vy, z / 2) ^ lattice_voxels(voxels, vy, z / 2 + 1)) >> 1 &
               0xff)
           << 1;
  return 0;
}

static uint lattice_dilate_x(uint bits, int radius) {
  uint row = bits;
  for (int r = 1; r <= radius; ++r) row |= bits << r | bits >> r;
  return row & 0xffff;
}

/// Rows -4..11 along z, 0..7 along y: those along x, dilated by `radius` along y.
static uint lattice_dilate_y(BRICK_SHARED const uint *rows, int y, int z, int radius) {
  uint bits = 0;
  for (int k = -radius; k <= radius; ++k)
    bits |= rows[y + LATTICE_NODE_MARGIN + k + LATTICE_NODES * z];
  return bits;
}

static uint lattice_dilate_z(BRICK_SHARED const uint *rows, int y, int z, int radius) {
  uint bits = 0;
  for (int k = -radius; k <= radius; ++k)
    bits |= rows[y + 8 * (z + LATTICE_NODE_MARGIN + k)];
  return bits;
}

/// The brick's own nodes, 0..7, of a row from -4.
static uint lattice_own(uint bits) { return bits >> LATTICE_NODE_MARGIN & 0xff; }

/// Fills `along_y` (8 x 16 rows) with the face centres dilated along x and y.
#define LATTICE_DILATE(voxels, radius, along_x, along_y)                                      \
  for (int i_ = get_local_id(0); i_ < LATTICE_NODES * LATTICE_NODES; i_ += BRICK_ITEMS)       \
    along_x[i_] = lattice_dilate_x(                                                           \
        lattice_face_centres(voxels, i_ % LATTICE_NODES, i_ / LATTICE_NODES), (radius).x);    \
  BRICK_SYNC();                                                                               \
  for (int i_ = get_local_id(0); i_ < 8 * LATTICE_NODES; i_ += BRICK_ITEMS)                   \
    along_y[i_] = lattice_dilate_y(along_x, i_ & 7, i_ >> 3, (radius).y);                     \
  BRICK_SYNC()

kernel __attribute__((PLAIN_BRICK_GROUP)) void lattice_mark(int4 size, int4 radius,
                                                            VIEW(const ulong, object),
                                                            VIEW(const int, coords),
                                                            VIEW(uchar, used)) {
  BRICK_SHARED uint voxels[LATTICE_VOXELS * LATTICE_VOXELS];
  BRICK_SHARED uint along_x[LATTICE_NODES * LATTICE_NODES];
  BRICK_SHARED uint along_y[8 * LATTICE_NODES];
  TAKE(object);
  TAKE(coords);
  const size_t brick = get_group_id(0);
  const int3 at = vload3(brick, coords);
  const int3 reach = radius.xyz + 1;
  LATTICE_LOAD(voxels, object, size, at);
  BRICK_SYNC();
  uint found = 0;
  if (lattice_has_boundary(voxels)) {
    LATTICE_DILATE(voxels, reach, along_x, along_y);
    for (int row = 0; row < BRICK_ROWS; ++row)
      found |= lattice_own(lattice_dilate_z(along_y, row & 7, row >> 3, reach.z));
  }
  if (get_local_id(0) == 0) used[used_first + brick] = found != 0;
}

// --- Labels. ---------------------------------------------------------------------------------

/// Labels of the nodes 0..7 of a row from the voxels that they touch: inside when any of them is
/// object, or (`all`) when all are. Node y even touches the voxel rows y / 2 + 2 and y / 2 + 3.
static uint lattice_label_row(BRICK_SHARED const uint *voxels, bool all, int y, int z) {
  const int y1 = y / 2 + LATTICE_VOXEL_MARGIN, z1 = z / 2 + LATTICE_VOXEL_MARGIN;
  const int y0 = y & 1 ? y1 : y1 - 1, z0 = z & 1 ? z1 : z1 - 1;
  const uint a = lattice_voxels(voxels, y0, z0), b = lattice_voxels(voxels, y1, z0),
             c = lattice_voxels(voxels, y0, z1), d = lattice_voxels(voxels, y1, z1);
  const uint u = all ? a & b & c & d : a | b | c | d;
  const uint between = all ? u >> 2 & u >> 3 : u >> 2 | u >> 3;
  return lattice_spread(between & 15) | lattice_spread(u >> 3 & 15) << 1;
}

/// The corner nodes of a row (y and z even, 0 to 8) that two object voxels alone touch, opposite
/// over the corner; bits 0, 2 .. 8.
static uint lattice_contacts(BRICK_SHARED const uint *voxels, int y, int z) {
  const int y1 = y / 2 + LATTICE_VOXEL_MARGIN, z1 = z / 2 + LATTICE_VOXEL_MARGIN;
  uint contacts = 0;
  for (int x = 0; x <= 8; x += 2) {
    const int x0 = x / 2 + LATTICE_VOXEL_MARGIN - 1;
    uint corner = 0;
    for (int k = 0; k < 4; ++k)
      corner |= (lattice_voxels(voxels, y1 - 1 + k % 2, z1 - 1 + k / 2) >> x0 & 3) << 2 * k;
    if (corner == 0x81 || corner == 0x42 || corner == 0x24 || corner == 0x18) contacts |= 1u << x;
  }
  return contacts;
}

/// The nodes of a row at such contacts: the corners, and the edges that end there.
static uint lattice_trimmed(BRICK_SHARED const uint *voxels, int y, int z) {
  if (y & z & 1) return 0;
  if (y & 1) return lattice_contacts(voxels, y - 1, z) | lattice_contacts(voxels, y + 1, z);
  if (z & 1) return lattice_contacts(voxels, y, z - 1) | lattice_contacts(voxels, y, z + 1);
  const uint corners = lattice_contacts(voxels, y, z);
  return corners | corners << 1 | corners >> 1;
}

static uint lattice_solid(BRICK_SHARED const uint *voxels, int connectivity, int y, int z) {
  const uint row = lattice_label_row(voxels, connectivity == 6, y, z);
  return connectivity == 18 ? row & ~lattice_trimmed(voxels, y, z) : row;
}

kernel __attribute__((PLAIN_BRICK_GROUP)) void lattice_label(
    int4 size, int connectivity, int4 radius, VIEW(const ulong, object), VIEW(const int, coords),
    VIEW(uchar, state)) {
  BRICK_SHARED uint voxels[LATTICE_VOXELS * LATTICE_VOXELS];
  BRICK_SHARED uint along_x[LATTICE_NODES * LATTICE_NODES];
  BRICK_SHARED uint along_y[8 * LATTICE_NODES];
  TAKE(object);
  TAKE(coords);
  TAKE(state);
  const size_t brick = get_group_id(0);
  const int3 at = vload3(brick, coords);
  LATTICE_LOAD(voxels, object, size, at);
  BRICK_SYNC();
  LATTICE_DILATE(voxels, radius, along_x, along_y);
  const uint8 bit = (uint8)(0, 1, 2, 3, 4, 5, 6, 7);
  for (int row = get_local_id(0); row < BRICK_ROWS; row += BRICK_ITEMS) {
    const int y = row & 7, z = row >> 3;
    const uint8 solid = lattice_solid(voxels, connectivity, y, z);
    const uint8 may_change = lattice_own(lattice_dilate_z(along_y, y, z, radius.z));
    const uint8 centre = lattice_own(
        lattice_face_centres(voxels, y + LATTICE_NODE_MARGIN, z + LATTICE_NODE_MARGIN));
    const uint8 bits = (solid >> bit & 1) * (LATTICE_LABEL | LATTICE_SOLID) |
                       (may_change >> bit & 1) * LATTICE_FREE |
                       (centre >> bit & 1) * LATTICE_FACE_CENTRE;
    vstore8(convert_uchar8(bits), brick * BRICK_ROWS + row, state);
  }
}

// --- The field at the nodes. -----------------------------------------------------------------

/// The spline between cells (even node) or at a cell's centre (odd node).
static float8 lattice_between(float8 below, float8 own) { return 0.5f * (below + own); }
static float8 lattice_centred(float8 below, float8 own, float8 above) {
  return 0.125f * (below + above) + 0.75f * own;
}
static float8 lattice_node(int node, float8 below, float8 own, float8 above) {
  return node & 1 ? lattice_centred(below, own, above) : lattice_between(below, own);
}

/// The refined level has the cells on both sides of each node: the brick and the seven below it.
static bool lattice_refined_here(global const int *near) {
  for (int n = 0; n < 8; ++n)
    if (near[SELF - (n & 1) * STEP_X - (n >> 1 & 1) * STEP_Y - (n >> 2) * STEP_Z] < 0) return false;
  return true;
}

kernel __attribute__((PLAIN_BRICK_GROUP)) void lattice_sample(VIEW(const int, coords),
                                                              VIEW(const int, in_regular),
                                                              VIEW(const float, regular),
                                                              VIEW(const int, in_refined),
                                                              VIEW(const float, refined),
                                                              VIEW(float, values)) {
  BRICK_SHARED float8 along_x[9 * 9];
  BRICK_SHARED float8 along_y[9 * 8];
  TAKE(coords);
  TAKE(in_regular);
  TAKE(regular);
  TAKE(in_refined);
  TAKE(refined);
  TAKE(values);
  const size_t brick = get_group_id(0);
  global const int *fine = in_refined + brick * NEIGHBOURS;
  global const int *near = in_regular + brick * NEIGHBOURS;
  const int3 octant = vload3(brick, coords) & 1;
  const bool is_fine = lattice_refined_here(fine);
  const int side = is_fine ? 9 : 6;  // cells along y and z: of -1..7, or of the octant and round it
  for (int i = get_local_id(0); i < side * side; i += BRICK_ITEMS) {
    const int y = i % side, z = i / side;
    if (is_fine) {
      const float8 own = table_row(refined, fine, 3, 1, y + 7, z + 7);
      const float below = table_cell(refined, fine, 3, 7, y + 7, z + 7);
      along_x[i] = lattice_between((float8)(below, own.s0123, own.s45, own.s6), own);
    } else {
      const float8 c = table_octant_row(regular, near, octant, y, z);
      const float8 between = lattice_between(c.s00112233, c.s11223344);
      const float8 centred = lattice_centred(c.s00112233, c.s11223344, c.s22334455);
      along_x[i] = (float8)(between.s0, centred.s1, between.s2, centred.s3, between.s4, centred.s5,
                            between.s6, centred.s7);
    }
  }
  BRICK_SYNC();
  for (int i = get_local_id(0); i < side * 8; i += BRICK_ITEMS) {
    const int y = i & 7, z = i >> 3;
    BRICK_SHARED const float8 *row = along_x + side * z + (is_fine ? y : y / 2);
    along_y[i] = is_fine ? lattice_between(row[0], row[1])
                         : lattice_node(y, row[0], row[1], y & 1 ? row[2] : row[1]);
  }
  BRICK_SYNC();
  for (int i = get_local_id(0); i < BRICK_ROWS; i += BRICK_ITEMS) {
    const int y = i & 7, z = i >> 3;
    BRICK_SHARED const float8 *row = along_y + 8 * (is_fine ? z : z / 2) + y;
    const float8 value = is_fine ? lattice_between(row[0], row[8])
                                 : lattice_node(z, row[0], row[8], z & 1 ? row[16] : row[8]);
    vstore8(value, brick * BRICK_ROWS + i, values);
  }
}
