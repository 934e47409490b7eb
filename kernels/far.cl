/// \file
/// Where the labels leave the segmentation too far: its marching-cubes surface is known at the
/// centres of boundary faces (its vertices) and between those of one cube (its triangles).
/// Contract: engine/backend/backend.h, lattice_mark_far; offsets: engine/stages/far_offsets.h.

#define FAR_MARGIN 4  // nodes round a brick that are at hand
#define FAR_SPAN (8 + 2 * FAR_MARGIN)
#define FAR_MISSING 0x80

/// An offset in nodes, its length in voxel lengths, and whether an edge of the lattice leads there.
typedef struct {
  int x, y, z;
  float length;
  int edge;
} FarOffset;

typedef struct {
  global const int *near;
  BRICK_SHARED const uchar *halo;  // states
  global const uchar *state;
  global const float *values;
  global const FarOffset *beside, *search;
  int beside_count, search_count;
  float3 half_scale;
  float limit;
  float edge_length[7];
} FarTest;

static int far_at(int x, int y, int z) {
  return (x + FAR_MARGIN) + FAR_SPAN * ((y + FAR_MARGIN) + FAR_SPAN * (z + FAR_MARGIN));
}

static uchar far_state(const FarTest *test, int3 at) { return test->halo[far_at(at.x, at.y, at.z)]; }

static ulong far_node(const FarTest *test, int3 at) {
  return node_at(test->near, at.x, at.y, at.z);
}

static float far_square(const FarTest *test, float3 a, float3 b) {
  const float3 d = test->half_scale * (a - b);
  return (d.x * d.x + d.y * d.y) + d.z * d.z;
}

/// How far along an edge from a to b the surface crosses it, 0 to 1.
static float far_crossing(const FarTest *test, ulong a, ulong b) {
  const float own = fabs(test->values[a]), other = fabs(test->values[b]);
  return own + other > 0 ? own / (own + other) : 0.5f;
}

/// A bound from above of a node's distance to the surface: to where it crosses an edge of the node,
/// or to a node of another label, the nearest of all; more than the limit where there is none. Any
/// bound up to `enough` will do.
static float far_surface_distance(const FarTest *test, int3 node, float enough) {
  const uchar own = far_state(test, node);
  const ulong index = far_node(test, node);
  float best = 2 * test->limit;
  for (int i = 0; i < test->beside_count; ++i) {
    const FarOffset o = test->beside[i];
    const int3 at = node + (int3)(o.x, o.y, o.z);
    const uchar other = far_state(test, at);
    if (!((other ^ own) & LATTICE_LABEL) || (other & FAR_MISSING)) continue;
    float distance = o.length;
    if (o.edge) distance *= far_crossing(test, index, far_node(test, at));
    best = distance < best ? distance : best;
    if (best <= enough) break;
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

static float3 far_face_at(int3 corner, int i) { return convert_float3(corner + far_face(i)); }

/// The boundary faces of a marching cube and the sides of its polygons: on each of the cube's six
/// sides up to two, from face to face, that part object from background.
typedef struct {
  uint crossed;  // bit i: face i
  int count;     // crossed ones
  int side_count;
  uchar sides[12][2];
} FarCube;

static int far_join(int p, int q) { return p == q || q == 0 ? p : p == 0 ? q : 0; }

/// The two sides that part the object's corners of an ambiguous side from each other.
static void far_add_parted(const FarTest *test, int3 corner, const int *side, FarCube *cube) {
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < i; ++j) {
      // The voxel that both touch; parallel edges of the cube's side touch none.
      const int3 a = far_face(side[i]), b = far_face(side[j]);
      const int3 voxel = (int3)(far_join(a.x, b.x), far_join(a.y, b.y), far_join(a.z, b.z));
      if (voxel.x == 0 || voxel.y == 0 || voxel.z == 0) continue;
      if (!(far_state(test, corner + voxel) & LATTICE_SOLID)) continue;
      cube->sides[cube->side_count][0] = side[i];
      cube->sides[cube->side_count++][1] = side[j];
    }
}

static void far_cube_round(const FarTest *test, int3 corner, FarCube *cube) {
  cube->crossed = 0;
  cube->side_count = 0;
  for (int i = 0; i < 12; ++i)
    cube->crossed |= (uint)((far_state(test, corner + far_face(i)) & LATTICE_FACE_CENTRE) != 0)
                     << i;
  cube->count = popcount(cube->crossed);
  if (cube->count < 3) return;
  for (int s = 0; s < 6; ++s) {
    int found[4], count = 0;
    for (int i = 0; i < 12; ++i)
      if ((cube->crossed >> i & 1) && far_faces[i][s / 2] == (s % 2 ? 1 : -1)) found[count++] = i;
    if (count == 2) {
      cube->sides[cube->side_count][0] = found[0];
      cube->sides[cube->side_count++][1] = found[1];
    }
    if (count == 4) far_add_parted(test, corner, found, cube);
  }
}

/// Whether the surface crosses an edge of a node near a corner within the limit of a point.
static bool far_crossing_near(const FarTest *test, int3 corner, float3 point) {
  for (int i = 0; i < test->search_count; ++i) {
    const int3 at = corner + (int3)(test->search[i].x, test->search[i].y, test->search[i].z);
    if (min(min(at.x, at.y), at.z) < -7 || max(max(at.x, at.y), at.z) > 14) continue;
    const ulong own = far_node(test, at);
    if (own == NO_NODE) continue;
    for (int d = 0; d < 7; ++d) {
      const int3 o = link_offset(d);
      const ulong other = far_node(test, at + o);
      if (other == NO_NODE || !((test->state[own] ^ test->state[other]) & LATTICE_LABEL)) continue;
      const float t = far_crossing(test, own, other);
      const float3 p = convert_float3(at) + t * convert_float3(o);
      if (far_square(test, p, point) <= test->limit * test->limit) return true;
    }
  }
  return false;
}

/// The distances from a corner and from its cube's faces to the surface, from above.
typedef struct {
  int3 corner;
  float from_corner;
  float from_face[12];
} FarDistances;

/// Whether the middle of `size` of the cube's faces is far from the surface.
static bool far_middle(const FarTest *test, const FarDistances *distances, const int *faces,
                       int size) {
  float3 middle = (float3)(0.0f);
  for (int k = 0; k < size; ++k)
    middle += far_face_at(distances->corner, faces[k]) / (float)size;
  for (int k = 0; k < size; ++k) {
    const float3 face = far_face_at(distances->corner, faces[k]);
    if (distances->from_face[faces[k]] + sqrt(far_square(test, face, middle)) <= test->limit)
      return false;
  }
  const float3 corner = convert_float3(distances->corner);
  if (distances->from_corner + sqrt(far_square(test, corner, middle)) <= test->limit) return false;
  return !far_crossing_near(test, distances->corner, middle);
}

static bool far_polygon(const FarTest *test, const FarDistances *distances, const int *polygon,
                        int size) {
  for (int i = 0; i < size; ++i)
    for (int j = 0; j < i; ++j) {
      int faces[3] = {polygon[i], polygon[j], 0};
      if (far_middle(test, distances, faces, 2)) return true;
      for (int k = 0; k < j; ++k) {
        faces[2] = polygon[k];
        if (far_middle(test, distances, faces, 3)) return true;
      }
    }
  return false;
}

/// A corner of the polygon that a side joins to corner i and that is not in `seen`; -1 for none.
static int far_next_corner(const FarCube *cube, uint seen, int i) {
  for (int s = 0; s < cube->side_count; ++s) {
    const int a = cube->sides[s][0], b = cube->sides[s][1];
    const int other = a == i ? b : b == i ? a : -1;
    if (other >= 0 && !(seen >> other & 1)) return other;
  }
  return -1;
}

/// Whether a polygon of the marching cube round a corner is far from the surface, in its middle or
/// between two of its corners.
static bool far_cube(const FarTest *test, int3 corner) {
  FarCube cube;
  far_cube_round(test, corner, &cube);
  if (cube.count < 3) return false;
  FarDistances distances;
  distances.corner = corner;
  distances.from_corner = far_surface_distance(test, corner, 0.35f * test->limit);
  for (int i = 0; i < 12; ++i)
    if (cube.crossed >> i & 1)
      distances.from_face[i] =
          far_surface_distance(test, corner + far_face(i), 0.35f * test->limit);
  uint seen = 0;
  for (int first = 0; first < 12; ++first) {
    if (!(cube.crossed >> first & 1) || (seen >> first & 1)) continue;
    int polygon[12], size = 0;
    for (int i = first; i >= 0; i = far_next_corner(&cube, seen, i)) {
      seen |= 1u << i;
      polygon[size++] = i;
    }
    if (far_polygon(test, &distances, polygon, size)) return true;
  }
  return false;
}

// --- Relabelled nodes. -----------------------------------------------------------------------

/// Whether a face centre lies within the limit of a point at most `away` from the node.
static bool far_face_centre_near(const FarTest *test, int3 node, float3 point, float away) {
  for (int i = 0; i < test->search_count; ++i) {
    const FarOffset o = test->search[i];
    if (o.length > test->limit + away) return false;
    const int3 at = node + (int3)(o.x, o.y, o.z);
    const ulong other = far_node(test, at);
    if (other == NO_NODE || !(test->state[other] & LATTICE_FACE_CENTRE)) continue;
    if (far_square(test, convert_float3(at), point) <= test->limit * test->limit) return true;
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
    FarCube cube;
    far_cube_round(test, corner, &cube);
    for (int s = 0; s < cube.side_count; ++s)
      if (far_square_to_segment(test, point, far_face_at(corner, cube.sides[s][0]),
                                far_face_at(corner, cube.sides[s][1])) <=
          test->limit * test->limit)
        return true;
  }
  return false;
}

static bool far_crossings(const FarTest *test, int3 node) {
  const ulong own = far_node(test, node);
  for (int i = 0; i < 14; ++i) {
    const int3 o = link_offset(i);
    const ulong other = far_node(test, node + o);
    if (other == NO_NODE || !((test->state[own] ^ test->state[other]) & LATTICE_LABEL) ||
        (test->state[other] & LATTICE_FACE_CENTRE))
      continue;
    const float t = far_crossing(test, own, other);
    const float3 point = convert_float3(node) + t * convert_float3(o);
    if (!far_face_centre_near(test, node, point, test->edge_length[i % 7]) &&
        !far_side_near(test, point))
      return true;
  }
  return false;
}

static bool far_is_far(const FarTest *test, int3 node) {
  const uchar own = far_state(test, node);
  if (own & LATTICE_FACE_CENTRE)
    return far_surface_distance(test, node, test->limit) > test->limit;
  if (!((node.x | node.y | node.z) & 1) && far_cube(test, node)) return true;
  // A relabelled node: the crossings of its edges. Only such nodes have far ones.
  return (own & LATTICE_LABEL) != (own >> 1 & 1) && far_crossings(test, node);
}

/// counts[brick]: how many nodes are marked.
kernel __attribute__((BRICK_GROUP)) void lattice_mark_far(
    float4 half_scale, float limit, float8 edge_length, int beside_count, int search_count,
    VIEW(const FarOffset, beside), VIEW(const FarOffset, search), VIEW(const int, neighbours),
    VIEW(const uchar, active), VIEW(const uchar, state), VIEW(const float, values),
    VIEW(uchar, marks), VIEW(uint, counts)) {
  BRICK_SHARED uchar halo[FAR_SPAN * FAR_SPAN * FAR_SPAN];
  BRICK_SHARED uint item_count[BRICK_ITEMS];
  TAKE(state);
  const size_t brick = get_group_id(0);
  global const int *near = neighbours + neighbours_first + brick * NEIGHBOURS;
  marks += marks_first + brick * BRICK_CELLS;
  uint count = 0;
  if (active[active_first + brick]) {
    for (int i = get_local_id(0); i < FAR_SPAN * FAR_SPAN * FAR_SPAN; i += BRICK_ITEMS) {
      const ulong node = node_at(near, i % FAR_SPAN - FAR_MARGIN,
                                 i / FAR_SPAN % FAR_SPAN - FAR_MARGIN,
                                 i / (FAR_SPAN * FAR_SPAN) - FAR_MARGIN);
      halo[i] = node == NO_NODE ? FAR_MISSING : state[node];
    }
    BRICK_SYNC();
    FarTest test = {near,         halo,         state,        values + values_first,
                    beside + beside_first, search + search_first, beside_count, search_count,
                    half_scale.xyz, limit};
    vstore4(edge_length.s0123, 0, test.edge_length);
    vstore3(edge_length.s456, 0, test.edge_length + 4);
    for (int cell = get_local_id(0); cell < BRICK_CELLS; cell += BRICK_ITEMS) {
      const bool far = far_is_far(&test, (int3)(cell & 7, cell >> 3 & 7, cell >> 6));
      marks[cell] = far ? LATTICE_FAR_MARK : 0;
      count += far;
    }
  } else {
    for (int cell = get_local_id(0); cell < BRICK_CELLS; cell += BRICK_ITEMS) marks[cell] = 0;
  }
  item_count[get_local_id(0)] = count;
  BRICK_SYNC();
  if (get_local_id(0) != 0) return;
  for (int i = 1; i < BRICK_ITEMS; ++i) count += item_count[i];
  counts[counts_first + brick] = count;
}
