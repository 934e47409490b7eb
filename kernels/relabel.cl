/// \file
/// Homotopic relabelling of the cell lattice and the local repair of its field. Contracts:
/// engine/backend/backend.h; bits: engine/types/lattice.h.

static bool relabel_is_wrong(uchar state, float value) {
  return ((state & LATTICE_LABEL) != 0) != (value > 0);
}

// --- Lists of nodes that want to flip. -------------------------------------------------------

/// Bit x of each node of a row that may change and has a label that is not its value's sign.
static uint relabel_row(global const uchar *state, global const float *values, size_t row) {
  const int8 s = convert_int8(vload8(row, state));
  const int8 label = (s & LATTICE_LABEL) != 0, inside = vload8(row, values) > 0.0f;
  const int8 wants = (label ^ inside) & ((s & LATTICE_FREE) != 0);
  const int8 bits = wants & (int8)(1, 2, 4, 8, 16, 32, 64, 128);
  const int4 four = bits.lo | bits.hi;
  return (four.x | four.y) | (four.z | four.w);
}

/// Every second bit, from bit 0 or 1 on.
static uint relabel_half(uint bits, int colour) { return bits >> (colour & 1) & 0x55; }

/// Whether a row holds nodes of a colour.
static bool relabel_has_colour(int row, int colour) {
  return (row & 1) == (colour >> 1 & 1) && (row >> 3 & 1) == colour >> 2;
}

kernel __attribute__((BRICK_GROUP)) void relabel_count(ulong bricks, VIEW(const uchar, active),
                                                       VIEW(const uchar, state),
                                                       VIEW(const float, values),
                                                       VIEW(uint, counts)) {
  BRICK_SHARED uint rows[BRICK_ROWS];
  TAKE(active);
  TAKE(state);
  TAKE(values);
  TAKE(counts);
  const size_t brick = get_group_id(0);
  const bool is_active = active[brick];
  for (int row = get_local_id(0); row < BRICK_ROWS; row += BRICK_ITEMS)
    rows[row] = is_active ? relabel_row(state, values, brick * BRICK_ROWS + row) : 0;
  BRICK_SYNC();
  for (int colour = get_local_id(0); colour < 8; colour += BRICK_ITEMS) {
    uint count = 0;
    for (int row = 0; row < BRICK_ROWS; ++row)
      if (relabel_has_colour(row, colour)) count += popcount(relabel_half(rows[row], colour));
    counts[colour * bricks + brick] = count;
  }
}

kernel __attribute__((BRICK_GROUP)) void relabel_collect(ulong bricks, VIEW(const uchar, active),
                                                         VIEW(const uchar, state),
                                                         VIEW(const float, values),
                                                         VIEW(const uint, starts),
                                                         VIEW(uint, nodes)) {
  BRICK_SHARED uint rows[BRICK_ROWS];
  TAKE(active);
  TAKE(state);
  TAKE(values);
  TAKE(starts);
  TAKE(nodes);
  const size_t brick = get_group_id(0);
  if (!active[brick]) return;
  for (int row = get_local_id(0); row < BRICK_ROWS; row += BRICK_ITEMS)
    rows[row] = relabel_row(state, values, brick * BRICK_ROWS + row);
  BRICK_SYNC();
  for (int colour = get_local_id(0); colour < 8; colour += BRICK_ITEMS) {
    uint next = starts[colour * bricks + brick];
    for (int row = 0; row < BRICK_ROWS; ++row) {
      if (!relabel_has_colour(row, colour)) continue;
      for (uint bits = relabel_half(rows[row], colour); bits; bits &= bits - 1)
        nodes[next++] = brick * BRICK_CELLS + 8 * row + (colour & 1) + lowest_bit(bits);
    }
  }
}

// --- Sweeps. ---------------------------------------------------------------------------------

#define RELABEL_RUN (RELABEL_BLOCK / BRICK_ITEMS)  // listed nodes an item takes

/// The labels of a node's 14 neighbours; a missing one takes part as outside.
static uint relabel_link(global const int *neighbours, global const uchar *state, uint node) {
  global const int *near = neighbours + (size_t)(node / BRICK_CELLS) * NEIGHBOURS;
  const int x = node & 7, y = node >> 3 & 7, z = node >> 6 & 7;
  const bool inner = x > 0 && x < 7 && y > 0 && y < 7 && z > 0 && z < 7;
  uint labels = 0;
  for (int i = 0; i < 14; ++i) {
    const int3 o = link_offset(i);
    const ulong other = inner ? (ulong)node + o.x + 8 * o.y + 64 * o.z
                              : node_at(near, x + o.x, y + o.y, z + o.z);
    if (other != NO_NODE) labels |= (state[other] & LATTICE_LABEL) << i;
  }
  return labels;
}

/// Flips; left[block] = how many of the block's nodes it leaves.
kernel __attribute__((BRICK_GROUP)) void relabel_sweep(
    float threshold, ulong count, VIEW(const int, neighbours), VIEW(const uchar, simple),
    VIEW(const float, values), VIEW(const uint, nodes), VIEW(uchar, state), VIEW(uint, left)) {
  BRICK_SHARED uint item_left[BRICK_ITEMS];
  TAKE(neighbours);
  TAKE(simple);
  TAKE(values);
  TAKE(nodes);
  TAKE(state);
  const size_t first = get_group_id(0) * RELABEL_BLOCK + get_local_id(0) * RELABEL_RUN;
  uint rest = 0;
  for (size_t i = first; i < min((ulong)first + RELABEL_RUN, count); ++i) {
    const uint node = nodes[i];
    const float value = values[node];
    ++rest;
    if (fabs(value) < threshold || !relabel_is_wrong(state[node], value)) continue;
    if (!simple[relabel_link(neighbours, state, node)]) continue;
    state[node] ^= LATTICE_LABEL;
    --rest;
  }
  item_left[get_local_id(0)] = rest;
  BRICK_SYNC();
  if (get_local_id(0) != 0) return;
  for (int i = 1; i < BRICK_ITEMS; ++i) rest += item_left[i];
  left[left_first + get_group_id(0)] = rest;
}

/// The nodes that a sweep left, from starts[block] on.
kernel __attribute__((BRICK_GROUP)) void relabel_compact(
    ulong count, VIEW(const float, values), VIEW(const uchar, state), VIEW(const uint, nodes),
    VIEW(const uint, starts), VIEW(uint, left)) {
  BRICK_SHARED uint item_left[BRICK_ITEMS];
  TAKE(values);
  TAKE(state);
  TAKE(nodes);
  TAKE(left);
  const size_t first = get_group_id(0) * RELABEL_BLOCK + get_local_id(0) * RELABEL_RUN;
  const size_t end = min((ulong)first + RELABEL_RUN, count);
  uint rest = 0;
  for (size_t i = first; i < end; ++i) rest += relabel_is_wrong(state[nodes[i]], values[nodes[i]]);
  item_left[get_local_id(0)] = rest;
  BRICK_SYNC();
  uint next = starts[starts_first + get_group_id(0)];
  for (size_t i = 0; i < get_local_id(0); ++i) next += item_left[i];
  for (size_t i = first; i < end; ++i)
    if (relabel_is_wrong(state[nodes[i]], values[nodes[i]])) left[next++] = nodes[i];
}

// --- Repair. ---------------------------------------------------------------------------------

kernel __attribute__((ELEMENT_GROUP)) void relabel_mark(ulong count, uchar mark,
                                                        VIEW(const uint, nodes),
                                                        VIEW(uchar, marks)) {
  const size_t i = get_global_id(0);
  if (i < count) marks[marks_first + nodes[nodes_first + i]] = mark;
}

static float relabel_width(global const float *values, ulong node, ulong below, ulong above) {
  const float own = fabs(values[node]);
  return 0.5f * (own / (own + fabs(values[below])) + own / (own + fabs(values[above])));
}

/// Whether the surface is narrow at a voxel centre, whose x, y and z are odd.
static bool relabel_is_narrow(global const int *neighbours, global const uchar *simple,
                              global const uchar *state, global const float *values, float across,
                              float sheet, uint brick, int3 at) {
  global const int *near = neighbours + (size_t)brick * NEIGHBOURS;
  const uint node = brick * BRICK_CELLS + at.x + 8 * at.y + 64 * at.z;
  const uchar own = state[node];
  const bool inside = (own & LATTICE_LABEL) != 0;
  if (inside != ((own & LATTICE_SOLID) != 0)) return false;
  int closed = 0;
  bool narrow = false, thin_sheet = false;
  for (int axis = 0; axis < 3; ++axis) {
    const int3 along = (int3)(axis == 0, axis == 1, axis == 2);
    const ulong below = node_at(near, at.x - along.x, at.y - along.y, at.z - along.z);
    if (((state[below] ^ own) & LATTICE_LABEL) == 0) continue;
    const ulong above = node_at(near, at.x + along.x, at.y + along.y, at.z + along.z);
    if (above == NO_NODE || ((state[above] ^ own) & LATTICE_LABEL) == 0) continue;
    ++closed;
    const float width = relabel_width(values, node, below, above);
    narrow = narrow || width < across;
    thin_sheet = thin_sheet || width < sheet;
  }
  return ((closed >= 2 && narrow) || (inside && thin_sheet)) &&
         !simple[relabel_link(neighbours, state, node)];
}

/// counts[brick]: of the nodes that got a mark.
kernel __attribute__((BRICK_GROUP)) void lattice_mark_narrow(
    float across, float sheet, VIEW(const int, neighbours), VIEW(const uchar, active),
    VIEW(const uchar, simple), VIEW(const uchar, state), VIEW(const float, values),
    VIEW(uchar, marks), VIEW(uint, counts)) {
  BRICK_SHARED uint item_count[BRICK_ITEMS];
  TAKE(neighbours);
  TAKE(simple);
  TAKE(state);
  TAKE(values);
  const size_t brick = get_group_id(0);
  const uint octants = active[active_first + brick];
  marks += marks_first + brick * BRICK_CELLS;
  uint count = 0;
  for (int i = get_local_id(0); i < BRICK_CELLS / 8; i += BRICK_ITEMS) {
    const int3 at = 2 * (int3)(i & 3, i >> 2 & 3, i >> 4) + 1;
    const int octant = (at.x >> 2) + 2 * (at.y >> 2) + 4 * (at.z >> 2);
    if (!(octants >> octant & 1)) continue;
    if (!relabel_is_narrow(neighbours, simple, state, values, across, sheet, brick, at)) continue;
    marks[at.x + 8 * at.y + 64 * at.z] = LATTICE_STUCK_MARK;
    ++count;
  }
  item_count[get_local_id(0)] = count;
  BRICK_SYNC();
  if (get_local_id(0) != 0) return;
  for (int i = 1; i < BRICK_ITEMS; ++i) count += item_count[i];
  counts[counts_first + brick] = count;
}

/// A work-item a brick.
kernel __attribute__((ELEMENT_GROUP)) void relabel_find_marked(ulong bricks,
                                                               VIEW(const uchar, marks),
                                                               VIEW(uchar, marked)) {
  const size_t brick = get_global_id(0);
  if (brick >= bricks) return;
  marks += marks_first + brick * BRICK_CELLS;
  uchar16 found = (uchar16)(0);
  for (int i = 0; i < BRICK_CELLS / 16; ++i) found |= vload16(i, marks);
  const uchar8 eight = found.lo | found.hi;
  const uchar4 four = eight.lo | eight.hi;
  marked[marked_first + brick] = ((four.x | four.y) | (four.z | four.w)) != 0;
}

/// Half the width of the tent along one axis: how far the voxel centres that take part lie from
/// node `at`, and their weights. Centres are the odd nodes.
typedef struct {
  int count, first, step;
  float weight[3];
} RelabelTaps;

static RelabelTaps relabel_taps(int at, bool smooth) {
  RelabelTaps taps = {1, 0, 2, {1.0f, 0.0f, 0.0f}};
  if (!(at & 1)) {
    taps.count = 2;
    taps.first = -1;
    taps.weight[0] = taps.weight[1] = 0.5f;
  } else if (smooth) {
    taps.count = 3;
    taps.first = -2;
    taps.weight[0] = taps.weight[2] = 0.125f;
    taps.weight[1] = 0.75f;
  }
  return taps;
}

/// The occupancy minus one half at a node: its zero set lies on the voxels' faces where they are
/// flat.
static float relabel_occupancy(global const int *near, global const uchar *state, bool solid, int x,
                               int y, int z, bool smooth) {
  const RelabelTaps tx = relabel_taps(x, smooth), ty = relabel_taps(y, smooth),
                    tz = relabel_taps(z, smooth);
  float sum = 0;
  for (int k = 0; k < tz.count; ++k)
    for (int j = 0; j < ty.count; ++j)
      for (int i = 0; i < tx.count; ++i) {
        const ulong voxel = node_at(near, x + tx.first + i * tx.step, y + ty.first + j * ty.step,
                                    z + tz.first + k * tz.step);
        const bool object = voxel == NO_NODE ? solid : (state[voxel] & LATTICE_SOLID) != 0;
        if (object) sum += tx.weight[i] * (ty.weight[j] * tz.weight[k]);
      }
  return sum - 0.5f;
}

/// The occupancy, smooth or not; when `keep`, on the side of the solid's label, and the sharp one
/// for solid nodes that the smooth one would lose.
static float relabel_solid_field(global const int *near, global const uchar *state, bool solid,
                                 int x, int y, int z, bool smooth, bool keep) {
  const float least = RELABEL_LEAST_OCCUPANCY;
  float field = relabel_occupancy(near, state, solid, x, y, z, smooth);
  if (!keep) return field;
  if (!solid) return -least < field ? -least : field;
  if (smooth && field < least) field = relabel_occupancy(near, state, solid, x, y, z, false);
  return field < least ? least : field;
}

#define RELABEL_SPAN 24  // nodes of three bricks

/// Bit x where byte x of eight marks is `mark`, or, for 0, where it is not 0.
static uint relabel_bits(uchar8 marks, uchar mark) {
  const char8 found = mark ? marks == (uchar8)(mark) : marks != (uchar8)(0);
  return byte_bits(as_uchar8(found) & (uchar8)(1));
}

/// The marked nodes (bit x + 8) of row (y, z), each -8..15: x all of them, y the stuck ones.
static uint2 relabel_marks(global const int *near, global const uchar *marked,
                           global const uchar *marks, int y, int z) {
  uint2 bits = (uint2)(0);
  for (int bx = -1; bx <= 1; ++bx) {
    const int brick = near[SELF + bx * STEP_X + STEP_Y * (y >> 3) + STEP_Z * (z >> 3)];
    if (brick < 0 || !marked[brick]) continue;
    const uchar8 row = vload8((size_t)brick * BRICK_ROWS + (y & 7) + 8 * (z & 7), marks);
    bits |= (uint2)(relabel_bits(row, 0), relabel_bits(row, LATTICE_STUCK_MARK)) << 8 * (bx + 1);
  }
  return bits;
}

/// Square of the distance along x from a node to the nearest of a row's bits; large where there is
/// none.
static int relabel_nearest(uint bits, int x) {
  const int at = x + 8;
  const uint below = bits & ((2u << at) - 1), above = bits >> at;
  int least = 1 << 10;
  if (below) least = at - (31 - (int)clz(below));
  if (above) least = min(least, lowest_bit(above));
  return least * least;
}

/// Whether a row of nodes has marks at most `reach` rows away along y and z.
static bool relabel_any_near(BRICK_SHARED const uint2 *rows, int reach, int row) {
  uint any = 0;
  for (int dz = -reach; dz <= reach; ++dz)
    for (int dy = -reach; dy <= reach; ++dy)
      any |= rows[((row & 7) + dy + 8) + RELABEL_SPAN * ((row >> 3) + dz + 8)].x;
  return any != 0;
}

/// The squares of a node's distances to the nearest mark and to the nearest stuck one, of those.
static int2 relabel_nearest_marks(BRICK_SHARED const uint2 *rows, int reach, int x, int row) {
  int2 least = (int2)(1 << 20);
  for (int dz = -reach; dz <= reach; ++dz)
    for (int dy = -reach; dy <= reach; ++dy) {
      const uint2 marks = rows[((row & 7) + dy + 8) + RELABEL_SPAN * ((row >> 3) + dz + 8)];
      if (marks.x == 0) continue;
      const int across = dy * dy + dz * dz;
      least.x = min(least.x, across + relabel_nearest(marks.x, x));
      least.y = min(least.y, across + relabel_nearest(marks.y, x));
    }
  return least;
}

kernel __attribute__((PLAIN_BRICK_GROUP)) void lattice_blend(
    float radius, float strength, int smooth, VIEW(const int, neighbours), VIEW(const uchar, marked),
    VIEW(const uchar, marks), VIEW(const uchar, state), VIEW(float, values),
    VIEW(uchar, changed)) {
  BRICK_SHARED uint2 rows[RELABEL_SPAN * RELABEL_SPAN];
  BRICK_SHARED uint item_within[BRICK_ITEMS];
  TAKE(marked);
  TAKE(marks);
  TAKE(state);
  const size_t brick = get_group_id(0);
  global const int *near = neighbours + neighbours_first + brick * NEIGHBOURS;
  values += values_first + brick * BRICK_CELLS;
  bool found = false;
  for (int n = 0; n < NEIGHBOURS; ++n) found = found || (near[n] >= 0 && marked[near[n]]);
  const int reach = (int)ceil(radius) - 1, side = found ? 8 + 2 * reach : 0;
  for (int i = get_local_id(0); i < side * side; i += BRICK_ITEMS) {
    const int y = i % side - reach, z = i / side - reach;
    rows[(y + 8) + RELABEL_SPAN * (z + 8)] = relabel_marks(near, marked, marks, y, z);
  }
  BRICK_SYNC();
  const float inverse = 1.0f / (radius * radius);
  uint within = 0;
  for (int row = get_local_id(0); found && row < BRICK_ROWS; row += BRICK_ITEMS) {
    if (!relabel_any_near(rows, reach, row)) continue;
    for (int x = 0; x < 8; ++x) {
      const int2 least = relabel_nearest_marks(rows, reach, x, row);
      const float rest = 1.0f - (float)least.x * inverse;
      if (rest <= 0) continue;
      within |= 1u << ((x >> 2) + 2 * (row >> 2 & 1) + 4 * (row >> 5));
      const bool keep = (float)least.y < radius * radius;
      const float blend = strength * (rest * rest);
      const int cell = 8 * row + x;
      const bool solid = (state[brick * BRICK_CELLS + cell] & LATTICE_SOLID) != 0;
      values[cell] = (1.0f - blend) * values[cell] +
                     blend * relabel_solid_field(near, state, solid, x, row & 7, row >> 3, smooth,
                                                 keep);
    }
  }
  item_within[get_local_id(0)] = within;
  BRICK_SYNC();
  if (get_local_id(0) != 0) return;
  for (int i = 1; i < BRICK_ITEMS; ++i) within |= item_within[i];
  changed[changed_first + brick] = within;
}

/// counts[brick]: of the free nodes that got a value of their label's sign.
kernel __attribute__((BRICK_GROUP)) void lattice_clamp(float least, VIEW(const uchar, state),
                                                       VIEW(float, values), VIEW(uint, counts)) {
  BRICK_SHARED uint item_count[BRICK_ITEMS];
  const size_t brick = get_group_id(0);
  state += state_first + brick * BRICK_CELLS;
  values += values_first + brick * BRICK_CELLS;
  uint count = 0;
  for (int cell = get_local_id(0); cell < BRICK_CELLS; cell += BRICK_ITEMS) {
    const bool held = relabel_is_wrong(state[cell], values[cell]);
    if (!held && values[cell] != 0) continue;
    values[cell] = state[cell] & LATTICE_LABEL ? least : -least;
    count += held && (state[cell] & LATTICE_FREE);
  }
  item_count[get_local_id(0)] = count;
  BRICK_SYNC();
  if (get_local_id(0) != 0) return;
  for (int i = 1; i < BRICK_ITEMS; ++i) count += item_count[i];
  counts[counts_first + brick] = count;
}
