/// \file
/// Where the labels leave the segmentation too far: its marching-cubes surface is known at the
/// centres of boundary faces (its vertices) and between those of one cube (its triangles).
/// Contract: engine/backend/backend.h, lattice_mark_far; offsets: engine/stages/far_offsets.h;
/// cubes and their polygons' parts: engine/stages/far_cubes.h.

#define FAR_MARGIN 4  // nodes round a brick that are at hand
#define FAR_SPAN (8 + 2 * FAR_MARGIN)
#define FAR_MISSING 0x80
#define FAR_FACES 9     // face centres along each axis, from -1
#define FAR_BESIDE 343  // offsets at most, beside a node

/// An offset in nodes, its length in voxel lengths, and whether an edge of the lattice leads there.
typedef struct {
  int x, y, z;
  float length;
  int edge;
} FarOffset;

/// Two or three faces of a cube, the distances from them and from the cube's corner to their
/// middle, and where that is from the corner.
typedef struct {
  int count, face[3];
  float from_face[3], from_corner, middle[3];
} FarPart;

/// Runs of the lists of parts and of sides: the polygons of a cube.
typedef struct {
  int first_part, last_part, first_side, last_side;
} FarCube;

typedef struct {
  global const int *near;
  BRICK_SHARED const uchar *halo;       // states
  BRICK_SHARED const uint *face_rows;   // y, then z, from -1; bit x + 1: a face centre
  BRICK_SHARED const float *from_face;  // of face centres to the surface, from above
  BRICK_SHARED const short *beside_step;  // what those offsets add to an index of the halo
  global const float *values;
  global const uchar *state;
  global const FarOffset *beside, *search;
  int beside_count, search_count;
  global const FarPart *parts;
  global const FarCube *cubes;
  global const ushort *cube_parts, *cube_sides;
  float3 half_scale;
  float limit;
  float edge_length[7];
} FarTest;

static int far_at(int x, int y, int z) {
  return (x + FAR_MARGIN) + FAR_SPAN * ((y + FAR_MARGIN) + FAR_SPAN * (z + FAR_MARGIN));
}

/// What an offset adds to an index of the halo.
static int far_step(global const FarOffset *o) {
  return o->x + FAR_SPAN * (o->y + FAR_SPAN * o->z);
}

static int far_face_index(int3 at) {
  return (at.x + 1) + FAR_FACES * ((at.y + 1) + FAR_FACES * (at.z + 1));
}

static ulong far_node(const FarTest *test, int3 at) {
  return node_at(test->near, at.x, at.y, at.z);
}

/// The state of a node at most eight from the brick; FAR_MISSING where there is none.
static uchar far_state(const FarTest *test, int3 at) {
  if (min(min(at.x, at.y), at.z) >= -FAR_MARGIN && max(max(at.x, at.y), at.z) < 8 + FAR_MARGIN)
    return test->halo[far_at(at.x, at.y, at.z)];
  const ulong node = far_node(test, at);
  return node == NO_NODE ? FAR_MISSING : test->state[node];
}

/// Whether the surface crosses the edge between nodes of two states.
static bool far_differ(uchar a, uchar b) {
  return (a ^ b) & ~((a | b) / FAR_MISSING) & LATTICE_LABEL;
}

static float far_square(const FarTest *test, float3 a, float3 b) {
  const float3 d = test->half_scale * (a - b);
  return (d.x * d.x + d.y * d.y) + d.z * d.z;
}

/// How far along an edge from a to b the surface crosses it, 0 to 1.
static float far_crossing(const FarTest *test, int3 a, int3 b) {
  const float own = fabs(test->values[far_node(test, a)]),
              other = fabs(test->values[far_node(test, b)]);
  return own + other > 0 ? own / (own + other) : 0.5f;
}

/// A bound from above of a node's distance to the surface: to where it crosses an edge of the node,
/// or to a node of another label, the nearest of all; more than the limit where there is none. Any
/// bound up to FAR_ENOUGH limits will do.
static float far_surface_distance(const FarTest *test, int3 node) {
  BRICK_SHARED const uchar *own = test->halo + far_at(node.x, node.y, node.z);
  float best = 2 * test->limit;
  for (int first = 0; first < test->beside_count; first += 32) {
    const int count = min(32, test->beside_count - first);
    uint others = 0;
    for (int i = 0; i < count; ++i)
      others |= (uint)far_differ(*own, own[test->beside_step[first + i]]) << i;
    for (; others; others &= others - 1) {
      global const FarOffset *o = test->beside + first + lowest_bit(others);
      float distance = o->length;
      if (o->edge) distance *= far_crossing(test, node, node + (int3)(o->x, o->y, o->z));
      best = distance < best ? distance : best;
      if (best <= FAR_ENOUGH * test->limit) return best;
    }
  }
  return best;
}

// --- Marching cubes round lattice corners. ---------------------------------------------------

/// The twelve edges of a marching cube: the faces between its voxels.
constant char far_faces[12][3] = {{0, -1, -1}, {0, 1, -1},  {0, -1, 1}, {0, 1, 1},
                                  {-1, 0, -1}, {1, 0, -1},  {-1, 0, 1}, {1, 0, 1},
                                  {-1, -1, 0}, {1, -1, 0},  {-1, 1, 0}, {1, 1, 0}};

static int3 far_face(int i) {
  return (int3)(far_faces[i][0], far_faces[i][1], far_faces[i][2]);
}

/// The face centres of row (y, z) from a corner: bit 0 one before it.
static uint far_face_row(const FarTest *test, int3 corner, int y, int z) {
  return test->face_rows[(corner.y + y + 1) + FAR_FACES * (corner.z + z + 1)] >> corner.x;
}

/// The crossed faces of the cube round a corner, as bits.
static uint far_crossed(const FarTest *test, int3 corner) {
  uint crossed = 0;
  for (int i = 0; i < 4; ++i) {  // between the other axes' voxels, then along x
    const int a = i & 1 ? 1 : -1, b = i & 2 ? 1 : -1;
    crossed |= (far_face_row(test, corner, a, b) >> 1 & 1) << i;
    const uint row = i < 2 ? far_face_row(test, corner, 0, a) : far_face_row(test, corner, a, 0);
    crossed |= ((row & 1) | (row >> 1 & 2)) << (4 + 2 * i);
  }
  return crossed;
}

static FarCube far_cube_round(const FarTest *test, int3 corner) {
  int voxels = 0;
  for (int v = 0; v < 8; ++v) {
    const int at = far_at(corner.x + (v & 1 ? 1 : -1), corner.y + (v & 2 ? 1 : -1),
                          corner.z + (v & 4 ? 1 : -1));
    voxels |= ((test->halo[at] & LATTICE_SOLID) != 0) << v;
  }
  return test->cubes[voxels];
}

/// Whether the surface crosses an edge of a node near a corner within the limit of a point.
static bool far_crossing_near(const FarTest *test, int3 corner, float3 point) {
  for (int i = 0; i < test->search_count; ++i) {
    const int3 at = corner + (int3)(test->search[i].x, test->search[i].y, test->search[i].z);
    if (min(min(at.x, at.y), at.z) < -7 || max(max(at.x, at.y), at.z) > 14) continue;
    const uchar own = far_state(test, at);
    for (int d = 0; d < 7; ++d) {
      const int3 o = link_offset(d);
      if (!far_differ(own, far_state(test, at + o))) continue;
      const float t = far_crossing(test, at, at + o);
      const float3 p = convert_float3(at) + t * convert_float3(o);
      if (far_square(test, p, point) <= test->limit * test->limit) return true;
    }
  }
  return false;
}

static bool far_takes_part(global const FarPart *part, uint crossed) {
  bool all = true;
  for (int k = 0; k < part->count; ++k) all = all && (crossed >> part->face[k] & 1);
  return all;
}

/// Whether the surface near one of a part's faces is near its middle.
static bool far_face_near(const FarTest *test, int3 corner, global const FarPart *part) {
  for (int k = 0; k < part->count; ++k) {
    const int face = far_face_index(corner + far_face(part->face[k]));
    if (test->from_face[face] + part->from_face[k] <= test->limit) return true;
  }
  return false;
}

/// Whether a polygon of the marching cube round a corner is far from the surface, in its middle or
/// between two of its corners. Faces that do not count any more take no part.
static bool far_cube(const FarTest *test, int3 corner) {
  const uint crossed = far_crossed(test, corner);
  if (popcount(crossed) < 3) return false;
  const FarCube cube = far_cube_round(test, corner);
  float from_corner = -1;  // not looked for
  for (int p = cube.first_part; p < cube.last_part; ++p) {
    global const FarPart *part = test->parts + test->cube_parts[p];
    if (!far_takes_part(part, crossed) || far_face_near(test, corner, part)) continue;
    if (from_corner < 0) from_corner = far_surface_distance(test, corner);
    if (from_corner + part->from_corner <= test->limit) continue;
    const float3 middle = vload3(0, part->middle);
    if (!far_crossing_near(test, corner, convert_float3(corner) + middle)) return true;
  }
  return false;
}

// --- Relabelled nodes. -----------------------------------------------------------------------

/// Whether a face centre lies within the limit of a point at most `away` from the node.
static bool far_face_centre_near(const FarTest *test, int3 node, float3 point, float away) {
  for (int i = 0; i < test->search_count; ++i) {
    global const FarOffset *o = test->search + i;
    if (o->length > test->limit + away) return false;
    const int3 at = node + (int3)(o->x, o->y, o->z);
    if ((far_state(test, at) & LATTICE_FACE_CENTRE) &&
        far_square(test, convert_float3(at), point) <= test->limit * test->limit)
      return true;
  }
  return false;
}

static float far_square_to_segment(const FarTest *test, float3 p, float3 a, float3 b) {
  const float3 from_a = test->half_scale * (p - a), side = test->half_scale * (b - a);
  const float along = ((0.0f + from_a.x * side.x) + from_a.y * side.y) + from_a.z * side.z;
  const float length = ((0.0f + side.x * side.x) + side.y * side.y) + side.z * side.z;
  const float ratio = along / length;
  const float t = ratio < 0.0f ? 0.0f : 1.0f < ratio ? 1.0f : ratio;
  return far_square(test, p, a + t * (b - a));
}

/// Whether a side of a marching cube's polygons lies within the limit of a point.
static bool far_side_near(const FarTest *test, float3 point) {
  const int3 middle = 2 * convert_int3(floor(0.5f * point + 0.5f));
  for (int k = 0; k < 27; ++k) {
    const int3 corner = middle + 2 * (int3)(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
    const FarCube cube = far_cube_round(test, corner);
    for (int s = cube.first_side; s < cube.last_side; ++s) {
      const int3 a = corner + far_face(test->cube_sides[s] & 15),
                 b = corner + far_face(test->cube_sides[s] >> 4);
      if ((far_state(test, a) & far_state(test, b) & LATTICE_FACE_CENTRE) &&
          far_square_to_segment(test, point, convert_float3(a), convert_float3(b)) <=
              test->limit * test->limit)
        return true;
    }
  }
  return false;
}

static bool far_crossings(const FarTest *test, int3 node) {
  const uchar own = far_state(test, node);
  for (int i = 0; i < 14; ++i) {
    const int3 o = link_offset(i);
    const uchar other = far_state(test, node + o);
    if (!far_differ(own, other) || (other & LATTICE_FACE_CENTRE)) continue;
    const float t = far_crossing(test, node, node + o);
    const float3 point = convert_float3(node) + t * convert_float3(o);
    if (!far_face_centre_near(test, node, point, test->edge_length[i % 7]) &&
        !far_side_near(test, point))
      return true;
  }
  return false;
}

/// Bit x where node x of a row of states has a bit.
static uint far_bits(BRICK_SHARED const uchar *row, uchar bit) {
  return byte_bits(vload8(0, row) / bit & (uchar8)(1));
}

/// The nodes of a row of a brick that lie in some of its octants (bit dx + 2 dy + 4 dz), bit x.
static uint far_octant_row(uint octants, int y, int z) {
  const uint along = octants >> (2 * (y >> 2) + 4 * (z >> 2));
  return (along & 1) * 0x0f | (along >> 1 & 1) * 0xf0;
}

/// Those of row (y, z), each -1..7, that lie there or one node beside, bit x + 1.
static uint far_beside_octants(uint octants, int y, int z) {
  uint row = 0;
  for (int i = 0; i < 4; ++i)
    row |= far_octant_row(octants, i & 1 ? max(y - 1, 0) : min(y + 1, 7),
                          i & 2 ? max(z - 1, 0) : min(z + 1, 7));
  return row | row << 1 | row << 2;
}

/// Row (y, z) of the face centres from -1, and the distances of those that are asked for.
static uint far_measure_faces(const FarTest *test, uint octants, int y, int z,
                              BRICK_SHARED float *from_face) {
  BRICK_SHARED const uchar *row = test->halo + far_at(-1, y, z);
  const uint faces =
      far_bits(row, LATTICE_FACE_CENTRE) | (uint)((row[8] & LATTICE_FACE_CENTRE) != 0) << 8;
  for (uint rest = faces & far_beside_octants(octants, y, z); rest; rest &= rest - 1) {
    const int3 at = (int3)(lowest_bit(rest) - 1, y, z);
    from_face[far_face_index(at)] = far_surface_distance(test, at);
  }
  return faces;
}

/// The nodes of row (y, z) that are far, of those in some octants.
static uint far_row_marks(const FarTest *test, uint octants, int y, int z) {
  const uint asked = far_octant_row(octants, y, z);
  BRICK_SHARED const uchar *row = test->halo + far_at(0, y, z);
  const uint centres = far_bits(row, LATTICE_FACE_CENTRE);
  uint far = 0;
  for (uint rest = centres & asked; rest; rest &= rest - 1) {
    const int x = lowest_bit(rest);
    far |= (uint)(test->from_face[far_face_index((int3)(x, y, z))] > test->limit) << x;
  }
  if (!((y | z) & 1))
    for (int x = 0; x < 8; x += 2)
      if (asked >> x & 1) far |= (uint)far_cube(test, (int3)(x, y, z)) << x;
  // The crossings of relabelled nodes' edges. Only such nodes have far ones.
  const uint relabelled = far_bits(row, LATTICE_LABEL) ^ far_bits(row, LATTICE_SOLID);
  for (uint rest = relabelled & asked & ~centres & ~far; rest; rest &= rest - 1) {
    const int x = lowest_bit(rest);
    far |= (uint)far_crossings(test, (int3)(x, y, z)) << x;
  }
  return far;
}

/// Eight states of a row of the brick, or of the one beside it along x by `bx`.
static uchar8 far_row(global const int *near, global const uchar *state, int bx, int y, int z) {
  const ulong node = node_at(near, 8 * bx, y, z);
  return node == NO_NODE ? (uchar8)(FAR_MISSING) : vload8(node / 8, state);
}

/// Rows of eight states, of the bricks with this neighbour table, to their place in the halo.
#define FAR_LOAD(halo, near, state)                                                              \
  for (int i_ = get_local_id(0); i_ < FAR_SPAN * FAR_SPAN; i_ += BRICK_ITEMS) {                   \
    const int y_ = i_ % FAR_SPAN - FAR_MARGIN, z_ = i_ / FAR_SPAN - FAR_MARGIN;                   \
    BRICK_SHARED uchar *row_ = halo + far_at(0, y_, z_);                                          \
    vstore4(far_row(near, state, -1, y_, z_).hi, 0, row_ - 4);                                    \
    vstore8(far_row(near, state, 0, y_, z_), 0, row_);                                            \
    vstore4(far_row(near, state, 1, y_, z_).lo, 0, row_ + 8);                                     \
  }

/// counts[brick]: how many nodes are marked.
kernel __attribute__((PLAIN_BRICK_GROUP)) void lattice_mark_far(
    float4 half_scale, float limit, float8 edge_length, int beside_count, int search_count,
    VIEW(const FarOffset, beside), VIEW(const FarOffset, search), VIEW(const FarPart, parts),
    VIEW(const FarCube, cubes), VIEW(const ushort, cube_parts), VIEW(const ushort, cube_sides),
    VIEW(const int, neighbours), VIEW(const uchar, active), VIEW(const uchar, state),
    VIEW(const float, values), VIEW(uchar, marks), VIEW(uint, counts)) {
  BRICK_SHARED uchar halo[FAR_SPAN * FAR_SPAN * FAR_SPAN];
  BRICK_SHARED uint face_rows[FAR_FACES * FAR_FACES];
  BRICK_SHARED float from_face[FAR_FACES * FAR_FACES * FAR_FACES];
  BRICK_SHARED short beside_step[FAR_BESIDE];
  BRICK_SHARED uint item_count[BRICK_ITEMS];
  TAKE(state);
  const size_t brick = get_group_id(0);
  global const int *near = neighbours + neighbours_first + brick * NEIGHBOURS;
  marks += marks_first + brick * BRICK_CELLS;
  uint count = 0;
  const uint octants = active[active_first + brick];
  if (octants) {
    FAR_LOAD(halo, near, state);
    for (int i = get_local_id(0); i < beside_count; i += BRICK_ITEMS)
      beside_step[i] = far_step(beside + beside_first + i);
    BRICK_SYNC();
    FarTest test = {near,
                    halo,
                    face_rows,
                    from_face,
                    beside_step,
                    values + values_first,
                    state,
                    beside + beside_first,
                    search + search_first,
                    beside_count,
                    search_count,
                    parts + parts_first,
                    cubes + cubes_first,
                    cube_parts + cube_parts_first,
                    cube_sides + cube_sides_first,
                    half_scale.xyz,
                    limit};
    vstore4(edge_length.s0123, 0, test.edge_length);
    vstore3(edge_length.s456, 0, test.edge_length + 4);
    for (int i = get_local_id(0); i < FAR_FACES * FAR_FACES; i += BRICK_ITEMS)
      face_rows[i] =
          far_measure_faces(&test, octants, i % FAR_FACES - 1, i / FAR_FACES - 1, from_face);
    BRICK_SYNC();
    for (int row = get_local_id(0); row < BRICK_ROWS; row += BRICK_ITEMS) {
      const uint far = far_row_marks(&test, octants, row & 7, row >> 3);
      vstore8(as_uchar8(bit_bytes(far) * LATTICE_FAR_MARK), row, marks);
      count += popcount(far);
    }
  } else {
    for (int row = get_local_id(0); row < BRICK_ROWS; row += BRICK_ITEMS)
      vstore8((uchar8)(0), row, marks);
  }
  item_count[get_local_id(0)] = count;
  BRICK_SYNC();
  if (get_local_id(0) != 0) return;
  for (int i = 1; i < BRICK_ITEMS; ++i) count += item_count[i];
  counts[counts_first + brick] = count;
}
