/// \file
/// The base surface: marching tetrahedra of the labelled cell lattice. Contracts:
/// engine/backend/backend.h; the table of cases: engine/types/tetrahedra.h.

#define SURFACE_SPAN 9   // a brick's nodes and those one further along each axis
#define SURFACE_CASE 37  // bytes of a case: its count, then twelve triangles

/// Row (y, z) of the labels, bit x, and which of the nodes are there.
typedef struct {
  uint label, known;
} SurfaceRow;

static SurfaceRow surface_load(global const int *near, global const uchar *state, int y, int z) {
  const ulong own = node_at(near, 0, y, z), next = node_at(near, 8, y, z);
  SurfaceRow row = {0, 0};
  if (own != NO_NODE) {
    row.label = byte_bits(vload8(own / 8, state) & (uchar8)(LATTICE_LABEL));
    row.known = 0xff;
  }
  if (next != NO_NODE) {
    row.label |= (uint)(state[next] & LATTICE_LABEL) << 8;
    row.known |= 0x100;
  }
  return row;
}

/// The rows 0..8 along y, then z.
#define SURFACE_LOAD(rows, near, state)                                                         \
  for (int i_ = get_local_id(0); i_ < SURFACE_SPAN * SURFACE_SPAN; i_ += BRICK_ITEMS)           \
    rows[i_] = surface_load(near, state, i_ % SURFACE_SPAN, i_ / SURFACE_SPAN)

static BRICK_SHARED const SurfaceRow *surface_row(BRICK_SHARED const SurfaceRow *rows, int row) {
  return rows + (row & 7) + SURFACE_SPAN * (row >> 3);
}

/// The nodes of a row whose edge along direction d the labels cross.
static uint surface_crossed(BRICK_SHARED const SurfaceRow *row, int d) {
  BRICK_SHARED const SurfaceRow *end = row + (d >> 1 & 1) + SURFACE_SPAN * (d >> 2);
  return (row->label ^ end->label >> (d & 1)) & end->known >> (d & 1) & 0xff;
}

/// The cubes from the nodes of a row whose corners differ and are all there.
static uint surface_mixed(BRICK_SHARED const SurfaceRow *row) {
  uint any = 0, all = ~0u, there = ~0u;
  for (int i = 0; i < 4; ++i) {
    const SurfaceRow side = row[(i & 1) + SURFACE_SPAN * (i >> 1)];
    any |= side.label | side.label >> 1;
    all &= side.label & side.label >> 1;
    there &= side.known & side.known >> 1;
  }
  return any & ~all & there & 0xff;
}

/// The labels of the cube from node x of a row.
static uint surface_cube(BRICK_SHARED const SurfaceRow *row, int x) {
  uint cube = 0;
  for (int i = 0; i < 4; ++i)
    cube |= (row[(i & 1) + SURFACE_SPAN * (i >> 1)].label >> x & 3) << 2 * i;
  return cube;
}

static uint surface_triangles(BRICK_SHARED const SurfaceRow *row, global const uchar *cases) {
  uint count = 0;
  for (uint mixed = surface_mixed(row); mixed; mixed &= mixed - 1)
    count += cases[SURFACE_CASE * surface_cube(row, lowest_bit(mixed))];
  return count;
}

/// Turns sums of rows into their starts, in place. \return the sum of all. By one item.
static uint surface_starts(BRICK_SHARED uint *rows) {
  uint sum = 0;
  for (int row = 0; row < BRICK_ROWS; ++row) {
    const uint own = rows[row];
    rows[row] = sum;
    sum += own;
  }
  return sum;
}

kernel __attribute__((BRICK_GROUP)) void surface_count(VIEW(const int, neighbours),
                                                       VIEW(const uchar, state),
                                                       VIEW(const uchar, cases),
                                                       VIEW(uchar, crossed),
                                                       VIEW(ushort, node_start),
                                                       VIEW(uint, vertices),
                                                       VIEW(uint, triangles)) {
  BRICK_SHARED SurfaceRow rows[SURFACE_SPAN * SURFACE_SPAN];
  BRICK_SHARED uint row_vertices[BRICK_ROWS];
  BRICK_SHARED uint row_triangles[BRICK_ROWS];
  TAKE(state);
  TAKE(cases);
  const size_t brick = get_group_id(0);
  global const int *near = neighbours + neighbours_first + brick * NEIGHBOURS;
  crossed += crossed_first + brick * BRICK_CELLS;
  node_start += node_start_first + brick * BRICK_CELLS;
  SURFACE_LOAD(rows, near, state);
  BRICK_SYNC();
  for (int row = get_local_id(0); row < BRICK_ROWS; row += BRICK_ITEMS) {
    BRICK_SHARED const SurfaceRow *own = surface_row(rows, row);
    ulong edges = 0;
    for (int d = 1; d < 8; ++d) edges |= bit_bytes(surface_crossed(own, d)) << (d - 1);
    for (int x = 0; x < 8; ++x) crossed[8 * row + x] = edges >> 8 * x;
    row_vertices[row] = popcount(edges);
    row_triangles[row] = surface_triangles(own, cases);
  }
  BRICK_SYNC();
  if (get_local_id(0) == 0) {
    vertices[vertices_first + brick] = surface_starts(row_vertices);
    triangles[triangles_first + brick] = surface_starts(row_triangles);
  }
  BRICK_SYNC();
  for (int row = get_local_id(0); row < BRICK_ROWS; row += BRICK_ITEMS) {
    uint next = row_vertices[row];
    for (int x = 0; x < 8; ++x) {
      node_start[8 * row + x] = next;
      next += popcount(crossed[8 * row + x]);
    }
  }
}

/// Where the vertices of the edges of a cube's corners begin, and which edges have one; the last
/// corner has none in the cube.
typedef struct {
  uint first[7];
  uint edges[7];
} SurfaceCube;

/// The index of the vertex on an edge (lower corner + 8 * direction) of a cube.
static uint surface_vertex(const SurfaceCube *cube, int edge) {
  const int corner = edge & 7, direction = edge >> 3;
  return cube->first[corner] + popcount(cube->edges[corner] & ((1u << (direction - 1)) - 1));
}

kernel __attribute__((BRICK_GROUP)) void surface_emit(
    float margin, VIEW(const int, coords), VIEW(const int, neighbours), VIEW(const uchar, state),
    VIEW(const float, values), VIEW(const uchar, cases), VIEW(const uchar, crossed),
    VIEW(const ushort, node_start), VIEW(const uint, vertex_start), VIEW(const uint, triangle_start),
    VIEW(float, vertices), VIEW(uint, triangles)) {
  BRICK_SHARED SurfaceRow rows[SURFACE_SPAN * SURFACE_SPAN];
  BRICK_SHARED uint row_triangles[BRICK_ROWS];
  TAKE(coords);
  TAKE(state);
  TAKE(values);
  TAKE(cases);
  TAKE(crossed);
  TAKE(node_start);
  TAKE(vertex_start);
  TAKE(triangle_start);
  TAKE(vertices);
  TAKE(triangles);
  const size_t brick = get_group_id(0);
  if (vertex_start[brick] == vertex_start[brick + 1] &&
      triangle_start[brick] == triangle_start[brick + 1])
    return;
  global const int *near = neighbours + neighbours_first + brick * NEIGHBOURS;
  const int3 corner = 8 * vload3(brick, coords);
  SURFACE_LOAD(rows, near, state);
  BRICK_SYNC();
  for (int row = get_local_id(0); row < BRICK_ROWS; row += BRICK_ITEMS)
    row_triangles[row] = surface_triangles(surface_row(rows, row), cases);
  BRICK_SYNC();
  if (get_local_id(0) == 0) surface_starts(row_triangles);
  BRICK_SYNC();
  for (int row = get_local_id(0); row < BRICK_ROWS; row += BRICK_ITEMS) {
    BRICK_SHARED const SurfaceRow *own_row = surface_row(rows, row);
    const int y = row & 7, z = row >> 3;
    uint with_vertices = 0;
    for (int d = 1; d < 8; ++d) with_vertices |= surface_crossed(own_row, d);
    for (; with_vertices; with_vertices &= with_vertices - 1) {
      const int x = lowest_bit(with_vertices);
      const size_t node = brick * BRICK_CELLS + 8 * row + x;
      size_t vertex = vertex_start[brick] + node_start[node];
      const float3 own = convert_float3(corner + (int3)(x, y, z));
      for (uint edges = crossed[node]; edges; edges &= edges - 1) {
        const int d = lowest_bit(edges) + 1;
        const int3 step = (int3)(d & 1, d >> 1 & 1, d >> 2);
        const float a = values[node],
                    b = values[node_at(near, x + step.x, y + step.y, z + step.z)];
        const float ratio = a / (a - b), upper = 1.0f - margin;
        const float least = ratio < margin ? margin : ratio;
        const float t = upper < least ? upper : least;
        vstore3(0.5f * (own + t * convert_float3(step)), vertex++, vertices);
      }
    }
    size_t next = 3 * (size_t)(triangle_start[brick] + row_triangles[row]);
    for (uint mixed = surface_mixed(own_row); mixed; mixed &= mixed - 1) {
      const int x = lowest_bit(mixed);
      SurfaceCube ends;
      for (int c = 0; c < 7; ++c) {
        const ulong node = node_at(near, x + (c & 1), y + (c >> 1 & 1), z + (c >> 2));
        ends.edges[c] = crossed[node];
        ends.first[c] = vertex_start[node / BRICK_CELLS] + node_start[node];
      }
      global const uchar *cube = cases + SURFACE_CASE * surface_cube(own_row, x);
      for (int i = 0; i < 3 * cube[0]; ++i) triangles[next++] = surface_vertex(&ends, cube[1 + i]);
    }
  }
}
