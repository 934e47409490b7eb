/// \file
/// Pairs of triangles that may intersect, a work-item a leaf of the tree of boxes
/// (engine/stages/candidate_pairs.h, triangle_tree.h). Contract: engine/backend/backend.h.

#define VERIFY_NODE 48   // floats: the lows of eight boxes along x, y, z, then the highs
#define VERIFY_STACK 96  // seven entries a level stay

typedef struct {
  global const float *vertices;
  global const uint *triangles, *order;
  global const float *nodes;
  global const uint *level_first;
  ulong triangle_count;
  int levels;
} VerifyTree;

/// The corners of two triangles, those that they share first, relative to the first of `a`.
typedef struct {
  float3 a[3], b[3];
  float extent;
  int common;
} VerifyPair;

static float verify_least(float a, float b) { return b < a ? b : a; }
static float verify_most(float a, float b) { return a < b ? b : a; }

static float verify_largest(float3 a) {
  return verify_most(verify_most(fabs(a.x), fabs(a.y)), fabs(a.z));
}

// --- Whether two triangles are certainly apart. --------------------------------------------------

static float verify_dot_error(float3 axis, float extent) {
  return VERIFY_DOT_ERROR * ((fabs(axis.x) + fabs(axis.y)) + fabs(axis.z)) * extent;
}

static bool verify_separates(float3 axis, const VerifyPair *pair) {
  const float a0 = vec_dot(axis, pair->a[0]), a1 = vec_dot(axis, pair->a[1]),
              a2 = vec_dot(axis, pair->a[2]);
  const float b0 = vec_dot(axis, pair->b[0]), b1 = vec_dot(axis, pair->b[1]),
              b2 = vec_dot(axis, pair->b[2]);
  const float error = 2 * verify_dot_error(axis, pair->extent);
  return verify_least(verify_least(a0, a1), a2) >
             verify_most(verify_most(b0, b1), b2) + error ||
         verify_least(verify_least(b0, b1), b2) > verify_most(verify_most(a0, a1), a2) + error;
}

static bool verify_are_disjoint(const VerifyPair *pair) {
  float3 e[3], f[3];
  for (int i = 0; i < 3; ++i) {
    const int next = i < 2 ? i + 1 : 0;
    e[i] = pair->a[next] - pair->a[i];
    f[i] = pair->b[next] - pair->b[i];
  }
  const float3 n = vec_cross(e[0], e[1]), o = vec_cross(f[0], f[1]);
  if (verify_separates(n, pair) || verify_separates(o, pair)) return true;
  for (int i = 0; i < 3; ++i)
    if (verify_separates(vec_cross(n, e[i]), pair)) return true;
  for (int i = 0; i < 3; ++i)
    if (verify_separates(vec_cross(o, f[i]), pair)) return true;
  for (int i = 0; i < 9; ++i)
    if (verify_separates(vec_cross(e[i / 3], f[i % 3]), pair)) return true;
  return false;
}

static bool verify_same_side(float x, float y, float error) {
  return (x > error && y > error) || (x < -error && y < -error);
}

static bool verify_divides(float3 axis, const VerifyPair *pair) {
  const float error = verify_dot_error(axis, pair->extent);
  return vec_dot(axis, pair->a[1]) > error && vec_dot(axis, pair->a[2]) > error &&
         vec_dot(axis, pair->b[1]) < -error && vec_dot(axis, pair->b[2]) < -error;
}

static float3 verify_unit(float3 a) { return (1.0f / sqrt(vec_dot(a, a))) * a; }

static bool verify_meet_in_vertex(const VerifyPair *pair) {
  const float3 a = pair->a[1], b = pair->a[2], c = pair->b[1], d = pair->b[2];
  if (verify_divides((a + b) - (c + d), pair)) return true;
  const float m = pair->extent, error = VERIFY_DETERMINANT_ERROR * ((m * m) * m);
  const float3 n = vec_cross(a, b), o = vec_cross(c, d);
  return verify_same_side(vec_dot(n, c), vec_dot(n, d), error) ||
         verify_same_side(vec_dot(o, a), vec_dot(o, b), error) ||
         verify_divides((verify_unit(a) + verify_unit(b)) - (verify_unit(c) + verify_unit(d)),
                        pair);
}

static bool verify_are_unfolded(const VerifyPair *pair) {
  const float3 edge = pair->a[1], a = pair->a[2], b = pair->b[2];
  const float m = pair->extent;
  const float3 n = vec_cross(edge, a);
  return vec_dot(n, vec_cross(edge, b)) < -VERIFY_CROSS_DOT_ERROR * ((m * m) * (m * m)) ||
         fabs(vec_dot(n, b)) > VERIFY_DETERMINANT_ERROR * ((m * m) * m);
}

static VerifyPair verify_pair(const VerifyTree *tree, uint first, uint second) {
  uint p[3], q[3];
  for (int i = 0; i < 3; ++i) {
    p[i] = tree->triangles[3 * (size_t)first + i];
    q[i] = tree->triangles[3 * (size_t)second + i];
  }
  VerifyPair pair;
  pair.common = 0;
  for (int i = pair.common; i < 3; ++i)
    for (int j = pair.common; j < 3; ++j) {
      if (p[i] != q[j]) continue;
      const uint shared = p[i], beside_p = p[pair.common], beside_q = q[pair.common];
      p[i] = beside_p;
      q[j] = beside_q;
      p[pair.common] = q[pair.common] = shared;
      ++pair.common;
      break;
    }
  const float3 origin = vload3(p[0], tree->vertices);
  pair.extent = 0;
  for (int i = 0; i < 3; ++i) {
    pair.a[i] = vload3(p[i], tree->vertices) - origin;
    pair.b[i] = vload3(q[i], tree->vertices) - origin;
    pair.extent = verify_most(verify_most(pair.extent, verify_largest(pair.a[i])),
                              verify_largest(pair.b[i]));
  }
  return pair;
}

static bool verify_certainly_apart(const VerifyPair *pair) {
  if (!(pair->extent >= VERIFY_LEAST_EXTENT && pair->extent <= VERIFY_MOST_EXTENT)) return false;
  if (pair->common == 0) return verify_are_disjoint(pair);
  if (pair->common == 1) return verify_meet_in_vertex(pair);
  return pair->common == 2 && verify_are_unfolded(pair);
}

// --- Boxes. --------------------------------------------------------------------------------------

/// Bit i is set when box i of a node meets the box.
static uint verify_meeting(global const float *node, float3 low, float3 high) {
  uint mask = 0;
  for (int i = 0; i < 8; ++i) {
    const float x = verify_most(node[i] - high.x, low.x - node[24 + i]);
    const float y = verify_most(node[8 + i] - high.y, low.y - node[32 + i]);
    const float z = verify_most(node[16 + i] - high.z, low.z - node[40 + i]);
    mask |= (verify_most(verify_most(x, y), z) <= 0 ? 1u : 0u) << i;
  }
  return mask;
}

/// The pairs of a leaf's triangles with those of another leaf or itself that are not apart; written
/// where `pairs` is not null. \return how many.
static uint verify_leaves(const VerifyTree *tree, uint leaf, uint other, global uint *pairs) {
  global const float *node = tree->nodes + VERIFY_NODE * (size_t)leaf;
  uint found = 0;
  for (uint i = 0; i < 8 && 8 * (ulong)leaf + i < tree->triangle_count; ++i) {
    uint hits = verify_meeting(tree->nodes + VERIFY_NODE * (size_t)other,
                               (float3)(node[i], node[8 + i], node[16 + i]),
                               (float3)(node[24 + i], node[32 + i], node[40 + i]));
    if (other == leaf) hits &= ~((2u << i) - 1);
    for (uint j = 0; j < 8; ++j) {
      if (!(hits >> j & 1)) continue;
      const uint first = tree->order[8 * (size_t)leaf + i];
      const uint second = tree->order[8 * (size_t)other + j];
      const VerifyPair pair = verify_pair(tree, first, second);
      if (verify_certainly_apart(&pair)) continue;
      if (pairs) vstore2((uint2)(first, second), found, pairs);
      ++found;
    }
  }
  return found;
}

/// The pairs of a leaf with itself and with later ones.
static uint verify_leaf(const VerifyTree *tree, uint leaf, global uint *pairs) {
  global const float *own = tree->nodes + VERIFY_NODE * (size_t)leaf;
  float3 low = INFINITY, high = -INFINITY;
  for (int i = 0; i < 8; ++i) {
    low.x = verify_least(low.x, own[i]);
    low.y = verify_least(low.y, own[8 + i]);
    low.z = verify_least(low.z, own[16 + i]);
    high.x = verify_most(high.x, own[24 + i]);
    high.y = verify_most(high.y, own[32 + i]);
    high.z = verify_most(high.z, own[40 + i]);
  }
  int stack_level[VERIFY_STACK];
  uint stack_node[VERIFY_STACK];
  int size = 1;
  uint found = 0;
  stack_level[0] = tree->levels - 1;
  stack_node[0] = 0;
  while (size > 0) {
    const int level = stack_level[--size];
    const uint node = stack_node[size];
    if (level == 0) {
      found += verify_leaves(tree, leaf, node, pairs ? pairs + 2 * (size_t)found : pairs);
      continue;
    }
    const size_t at = tree->level_first[level] + node;
    const uint hits = verify_meeting(tree->nodes + VERIFY_NODE * at, low, high);
    for (uint i = 0; i < 8; ++i) {
      const ulong child = 8 * (ulong)node + i;
      const ulong last = ((child + 1) << 3 * (level - 1)) - 1;
      if (!(hits >> i & 1) || last < leaf) continue;
      stack_level[size] = level - 1;
      stack_node[size++] = child;
    }
  }
  return found;
}

#define VERIFY_TREE                                                                             \
  VIEW(const float, vertices), VIEW(const uint, triangles), VIEW(const uint, order),            \
      VIEW(const float, nodes), VIEW(const uint, level_first), ulong triangle_count, int levels
#define TAKE_TREE                                                                               \
  {vertices + vertices_first,   triangles + triangles_first,                                    \
   order + order_first,         nodes + VERIFY_NODE * nodes_first,                              \
   level_first + level_first_first, triangle_count, levels}

kernel __attribute__((PLAIN_ELEMENT_GROUP)) void verify_count_pairs(ulong leaves, VERIFY_TREE,
                                                                    VIEW(uint, counts)) {
  const size_t leaf = get_global_id(0);
  if (leaf >= leaves) return;
  const VerifyTree tree = TAKE_TREE;
  counts[counts_first + leaf] = verify_leaf(&tree, leaf, 0);
}

kernel __attribute__((PLAIN_ELEMENT_GROUP)) void verify_collect_pairs(ulong leaves, VERIFY_TREE,
                                                                      VIEW(const uint, starts),
                                                                      VIEW(uint, pairs)) {
  const size_t leaf = get_global_id(0);
  if (leaf >= leaves) return;
  TAKE(starts);
  if (starts[leaf + 1] == starts[leaf]) return;
  const VerifyTree tree = TAKE_TREE;
  verify_leaf(&tree, leaf, pairs + pairs_first + 2 * (size_t)starts[leaf]);
}
