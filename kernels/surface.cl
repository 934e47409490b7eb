/// \file
/// The base surface: marching tetrahedra of the labelled cell lattice. Contracts:
/// engine/backend/backend.h; the table of cases: engine/types/tetrahedra.h.

#define SURFACE_SPAN 9    // a brick's nodes and those one further along each axis
#define SURFACE_CASE 37   // bytes of a case: its count, then twelve triangles
#define SURFACE_ABSENT 2  // for a label

/// Labels of the nodes: 0, 1 or SURFACE_ABSENT.
#define SURFACE_LOAD(labels, near, state)                                                      \
  for (int i_ = get_local_id(0); i_ < SURFACE_SPAN * SURFACE_SPAN * SURFACE_SPAN;              \
       i_ += BRICK_ITEMS) {                                                                    \
    const ulong node_ = node_at(near, i_ % SURFACE_SPAN, i_ / SURFACE_SPAN % SURFACE_SPAN,     \
                                i_ / (SURFACE_SPAN * SURFACE_SPAN));                           \
    labels[i_] = node_ == NO_NODE ? SURFACE_ABSENT : state[node_] & LATTICE_LABEL;             \
  }

/// Where corner c of the cube from a node, or the end of its edge c, is from it.
static int surface_corner(int c) {
  return (c & 1) + SURFACE_SPAN * (c >> 1 & 1) + SURFACE_SPAN * SURFACE_SPAN * (c >> 2);
}

static BRICK_SHARED const uchar *surface_node(BRICK_SHARED const uchar *labels, int row, int x) {
  return labels + x + SURFACE_SPAN * (row & 7) + SURFACE_SPAN * SURFACE_SPAN * (row >> 3);
}

/// The labels of the cube from a node; 0 (nothing to do) where a corner is not there.
static int surface_cube(BRICK_SHARED const uchar *node) {
  int cube = 0, absent = 0;
  for (int c = 0; c < 8; ++c) {
    const uchar label = node[surface_corner(c)];
    absent |= label & SURFACE_ABSENT;
    cube |= (label & 1) << c;
  }
  return absent ? 0 : cube;
}

/// The edges of a node that the labels cross: edge d is bit d - 1.
static uchar surface_edges(BRICK_SHARED const uchar *node) {
  uchar edges = 0;
  for (int d = 1; d < 8; ++d) {
    const uchar label = node[surface_corner(d)];
    if (label != SURFACE_ABSENT && label != node[0]) edges |= 1 << (d - 1);
  }
  return edges;
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
  BRICK_SHARED uchar labels[SURFACE_SPAN * SURFACE_SPAN * SURFACE_SPAN];
  BRICK_SHARED uint row_vertices[BRICK_ROWS];
  BRICK_SHARED uint row_triangles[BRICK_ROWS];
  TAKE(state);
  TAKE(cases);
  const size_t brick = get_group_id(0);
  global const int *near = neighbours + neighbours_first + brick * NEIGHBOURS;
  crossed += crossed_first + brick * BRICK_CELLS;
  node_start += node_start_first + brick * BRICK_CELLS;
  SURFACE_LOAD(labels, near, state);
  BRICK_SYNC();
  for (int row = get_local_id(0); row < BRICK_ROWS; row += BRICK_ITEMS) {
    uint vertex_count = 0, triangle_count = 0;
    for (int x = 0; x < 8; ++x) {
      BRICK_SHARED const uchar *node = surface_node(labels, row, x);
      const uchar edges = surface_edges(node);
      crossed[8 * row + x] = edges;
      vertex_count += popcount(edges);
      triangle_count += cases[SURFACE_CASE * surface_cube(node)];
    }
    row_vertices[row] = vertex_count;
    row_triangles[row] = triangle_count;
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

/// The index of the vertex on an edge (lower corner + 8 * direction) of the cube from (x, y, z).
static uint surface_vertex(global const int *near, global const uchar *crossed,
                           global const ushort *node_start, global const uint *vertex_start, int x,
                           int y, int z, int edge) {
  const int corner = edge & 7, direction = edge >> 3;
  const ulong node = node_at(near, x + (corner & 1), y + (corner >> 1 & 1), z + (corner >> 2));
  const uchar before = crossed[node] & ((1 << (direction - 1)) - 1);
  return vertex_start[node / BRICK_CELLS] + node_start[node] + popcount(before);
}

kernel __attribute__((BRICK_GROUP)) void surface_emit(
    float margin, VIEW(const int, coords), VIEW(const int, neighbours), VIEW(const uchar, state),
    VIEW(const float, values), VIEW(const uchar, cases), VIEW(const uchar, crossed),
    VIEW(const ushort, node_start), VIEW(const uint, vertex_start), VIEW(const uint, triangle_start),
    VIEW(float, vertices), VIEW(uint, triangles)) {
  BRICK_SHARED uchar labels[SURFACE_SPAN * SURFACE_SPAN * SURFACE_SPAN];
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
  SURFACE_LOAD(labels, near, state);
  BRICK_SYNC();
  for (int row = get_local_id(0); row < BRICK_ROWS; row += BRICK_ITEMS) {
    row_triangles[row] = 0;
    for (int x = 0; x < 8; ++x)
      row_triangles[row] += cases[SURFACE_CASE * surface_cube(surface_node(labels, row, x))];
  }
  BRICK_SYNC();
  if (get_local_id(0) == 0) surface_starts(row_triangles);
  BRICK_SYNC();
  for (int row = get_local_id(0); row < BRICK_ROWS; row += BRICK_ITEMS) {
    const int y = row & 7, z = row >> 3;
    size_t triangle = triangle_start[brick] + row_triangles[row];
    for (int x = 0; x < 8; ++x) {
      const size_t node = brick * BRICK_CELLS + 8 * row + x;
      size_t vertex = vertex_start[brick] + node_start[node];
      const float3 own = convert_float3(corner + (int3)(x, y, z));
      for (int d = 1; d < 8; ++d) {
        if (!(crossed[node] >> (d - 1) & 1)) continue;
        const int3 step = (int3)(d & 1, d >> 1 & 1, d >> 2);
        const float a = values[node],
                    b = values[node_at(near, x + step.x, y + step.y, z + step.z)];
        const float ratio = a / (a - b), upper = 1.0f - margin;
        const float least = ratio < margin ? margin : ratio;
        const float t = upper < least ? upper : least;
        vstore3(0.5f * (own + t * convert_float3(step)), vertex++, vertices);
      }
      global const uchar *cube = cases + SURFACE_CASE * surface_cube(surface_node(labels, row, x));
      for (int i = 0; i < 3 * cube[0]; ++i)
        triangles[3 * triangle + i] =
            surface_vertex(near, crossed, node_start, vertex_start, x, y, z, cube[1 + i]);
      triangle += cube[0];
    }
  }
}
