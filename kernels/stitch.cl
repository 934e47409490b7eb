/// \file
/// The triangulation of gaps by dynamic programming, a work-group a gap: eq. 6 and 7 of the paper
/// (engine/stages/triangulate_gap.h, gap_rules.h). Contract: engine/backend/backend.h.
///
/// Entry n w + i of a gap's tables belongs to the part of its polygon from corner i to i + w. Parts
/// of one width, an anti-diagonal of the usual table, need narrower ones alone: items take them in
/// turn, with a barrier between widths.

#define STITCH_NEVER 3e38f  // the measure or cost of what cannot be triangulated

/// A polygon and the rules: least cosines at corners and in the middle, reach.
typedef struct {
  Field field;
  float3 rules;
  int n;
  global const float *points, *normals;
  global const uchar *chords;
} StitchGap;

typedef struct {
  float3 product;  ///< twice the area times the normal
  float squared;   ///< its squared length
  float worst;     ///< the least product of it and a corner's normal
  bool good;
} StitchTriangle;

static float stitch_least(float a, float b) { return b < a ? b : a; }
static float stitch_most(float a, float b) { return a < b ? b : a; }

static float3 stitch_point(const StitchGap *gap, int i) { return vload3(i, gap->points); }

static float stitch_squared(float3 a) { return vec_dot(a, a); }

/// Of the edge or chord of two corners.
static float stitch_length(const StitchGap *gap, int i, int j) {
  return stitch_squared(stitch_point(gap, j) - stitch_point(gap, i));
}

/// The square of the cosine of a triangle's least angle, from the squares of its edges.
static float stitch_measure(float a, float b, float c) {
  const float low = stitch_least(a, b), high = stitch_most(a, b);
  const float least = stitch_least(low, c), longest = stitch_most(high, c);
  const float middle = stitch_most(low, stitch_least(high, c));
  const float cosine = (middle + longest) - least;
  return (cosine * cosine) / (4.0f * (middle * longest));
}

static bool stitch_is_near(FieldSample sample, float squared_reach) {
  return sample.known &&
         sample.value * sample.value <= squared_reach * stitch_squared(sample.gradient);
}

static bool stitch_is_within(float dot, float cosine, float squared) {
  const float bound = (cosine * cosine) * squared;
  return cosine < 0 ? dot > 0 || dot * dot <= bound : dot > 0 && dot * dot >= bound;
}

static bool stitch_may_join(const StitchGap *gap, int i, int j) {
  if (j - i + 1 == gap->n) return true;
  if (!gap->chords[gap->n * i + j]) return false;
  const float3 a = stitch_point(gap, i), b = stitch_point(gap, j);
  const FieldSample middle = field_sample(&gap->field, 0.5f * (a + b));
  return stitch_is_near(middle, gap->rules.z * gap->rules.z * stitch_squared(b - a));
}

/// Whether the triangle faces as the surface does at its corners.
static StitchTriangle stitch_obey_normals(const StitchGap *gap, int i, int k, int j) {
  StitchTriangle t;
  const float3 a = stitch_point(gap, i);
  t.product = vec_cross(stitch_point(gap, k) - a, stitch_point(gap, j) - a);
  t.squared = stitch_squared(t.product);
  t.worst = stitch_least(stitch_least(vec_dot(vload3(i, gap->normals), t.product),
                                      vec_dot(vload3(k, gap->normals), t.product)),
                         vec_dot(vload3(j, gap->normals), t.product));
  t.good = t.squared > 0 && stitch_is_within(t.worst, gap->rules.x, t.squared);
  return t;
}

/// Whether its middle lies near the surface and faces as it does.
static bool stitch_obeys_middle(const StitchGap *gap, int i, int k, int j, float3 product) {
  const float3 a = stitch_point(gap, i), b = stitch_point(gap, k), c = stitch_point(gap, j);
  const FieldSample middle = field_sample(&gap->field, (1.0f / 3.0f) * ((a + b) + c));
  const float longest = stitch_most(stitch_most(stitch_squared(b - a), stitch_squared(c - b)),
                                    stitch_squared(a - c));
  return stitch_is_near(middle, gap->rules.z * gap->rules.z * longest) &&
         stitch_is_within(-vec_dot(middle.gradient, product), gap->rules.y,
                          stitch_squared(middle.gradient) * stitch_squared(product));
}

static StitchGap stitch_gap(Field field, float4 rules, uint first, uint end, uint chord_first,
                            global const float *points, global const float *normals,
                            global const uchar *chords) {
  StitchGap gap;
  gap.field = field;
  gap.rules = rules.xyz;
  gap.n = end - first;
  gap.points = points + 3 * (size_t)first;
  gap.normals = normals + 3 * (size_t)first;
  gap.chords = chords + chord_first;
  return gap;
}

/// The polygon's edges need no triangles.
static void stitch_start(int n, global float *least, global float *sum) {
  for (int i = get_local_id(0); i + 1 < n; i += get_local_size(0)) {
    least[n + i] = 0.0f;
    sum[n + i] = 0.0f;
  }
  GLOBAL_SYNC();
}

/// The n - 2 triangles in order: a part's first one is known when its own turn comes, until then
/// its place holds its ends.
static void stitch_trace(int n, global const ushort *via, global ushort *triangles) {
  triangles[0] = 0;
  triangles[2] = n - 1;
  for (int t = 0; t < n - 2; ++t) {
    global ushort *triangle = triangles + 3 * t;
    const int i = triangle[0], j = triangle[2], k = via[n * (j - i) + i];
    triangle[1] = k;
    if (k - i > 1) {
      triangle[3] = i;
      triangle[5] = k;
    }
    if (j - k > 1) {
      triangle[3 * (k - i)] = k;
      triangle[3 * (k - i) + 2] = j;
    }
  }
}

/// The largest least angle of part (i, j), and its third corner.
static void stitch_minimise_measure(const StitchGap *gap, int i, int j, global float *least,
                                    global ushort *via) {
  const int n = gap->n, width = j - i;
  float best = STITCH_NEVER;
  int at = 0;
  if (stitch_may_join(gap, i, j)) {
    const float across = stitch_length(gap, i, j);
    for (int k = i + 1; k < j; ++k) {
      const float parts = stitch_most(least[n * (k - i) + i], least[n * (j - k) + k]);
      const float own =
          stitch_measure(stitch_length(gap, i, k), stitch_length(gap, j, k), across);
      const float measure = stitch_most(parts, own);
      if (!(measure < best)) continue;
      const StitchTriangle t = stitch_obey_normals(gap, i, k, j);
      if (!t.good || !stitch_obeys_middle(gap, i, k, j, t.product)) continue;
      best = measure;
      at = k;
    }
  }
  least[n * width + i] = best;
  via[n * width + i] = at;
}

/// The least cost of part (i, j) with triangles of that measure or better, and its third corner.
static void stitch_minimise_cost(const StitchGap *gap, int i, int j, float allowed,
                                 global const float *least, global float *sum,
                                 global ushort *via) {
  const int n = gap->n, width = j - i;
  float best = STITCH_NEVER;
  int at = 0;
  if (least[n * width + i] <= allowed) {
    const float c = stitch_length(gap, i, j);
    for (int k = i + 1; k < j; ++k) {
      const float parts = sum[n * (k - i) + i] + sum[n * (j - k) + k];
      if (!(parts < best)) continue;
      const float a = stitch_length(gap, i, k), b = stitch_length(gap, j, k);
      if (!(stitch_measure(a, b, c) <= allowed)) continue;
      const StitchTriangle t = stitch_obey_normals(gap, i, k, j);
      if (!t.good) continue;
      const float twice_area = sqrt(t.squared), cosine = t.worst / twice_area;
      const float cost = parts + (((a + b) + c) / twice_area) * (2.0f - cosine);
      if (!(cost < best) || !stitch_obeys_middle(gap, i, k, j, t.product)) continue;
      best = cost;
      at = k;
    }
  }
  sum[n * width + i] = best;
  via[n * width + i] = at;
}

/// What both kernels take; gap_first: the first gap of these groups.
#define STITCH_GAPS                                                                          \
  uint gap_first, float4 rules, FIELD_VIEW, VIEW(const uint, first),                         \
      VIEW(const uint, chord_first), VIEW(const float, points), VIEW(const float, normals),  \
      VIEW(const uchar, chords)

/// This group's gap g, and where its tables start.
#define STITCH_TAKE_GAP                                                                      \
  const size_t g = gap_first + get_group_id(0);                                              \
  TAKE(first);                                                                               \
  TAKE(chord_first);                                                                         \
  const size_t table = chord_first[g];                                                       \
  const Field field = TAKE_FIELD;                                                            \
  const StitchGap gap =                                                                      \
      stitch_gap(field, rules, first[g], first[g + 1], chord_first[g], points + 3 * points_first, \
                 normals + 3 * normals_first, chords + chords_first);                        \
  const int n = gap.n

/// The largest least angle, then the least cost among those.
kernel __attribute__((AS_WRITTEN)) void stitch_exact(STITCH_GAPS, VIEW(float, least),
                                                     VIEW(float, sum), VIEW(ushort, via),
                                                     VIEW(uchar, closed), VIEW(ushort, triangles)) {
  STITCH_TAKE_GAP;
  least += least_first + table;
  sum += sum_first + table;
  via += via_first + table;
  stitch_start(n, least, sum);
  for (int width = 2; width < n; ++width) {
    for (int i = get_local_id(0); i + width < n; i += get_local_size(0))
      stitch_minimise_measure(&gap, i, i + width, least, via);
    GLOBAL_SYNC();
  }
  const float allowed = least[n * (n - 1)];
  const int end = allowed < STITCH_NEVER ? n : 0;
  for (int width = 2; width < end; ++width) {
    for (int i = get_local_id(0); i + width < n; i += get_local_size(0))
      stitch_minimise_cost(&gap, i, i + width, allowed, least, sum, via);
    GLOBAL_SYNC();
  }
  if (get_local_id(0) != 0) return;
  closed[closed_first + g] = end > 0;
  if (end > 0) stitch_trace(n, via, triangles + triangles_first + 3 * (first[g] - 2 * g));
}

/// Tables of the paper's one pass.
typedef struct {
  global float *least, *sum, *turn, *top;
  global ushort *via;
} StitchTables;

static float stitch_turn_at(float turn, float3 neighbour, float3 normal) {
  return stitch_squared(neighbour) > 0 ? stitch_most(turn, -vec_dot(neighbour, normal)) : turn;
}

/// Minus the cosine of the largest dihedral angle of part (i, j) with corner k, whose triangle has
/// that normal.
static float stitch_largest_turn(const StitchGap *gap, const StitchTables *tables,
                                 global const float *across, int i, int k, int j, float3 normal) {
  const int n = gap->n, before = n * (k - i) + i, after = n * (j - k) + k;
  float turn = stitch_most(k - i > 1 ? tables->turn[before] : -1.0f,
                           j - k > 1 ? tables->turn[after] : -1.0f);
  turn = stitch_turn_at(turn, k - i > 1 ? vload3(before, tables->top) : vload3(i, across), normal);
  turn = stitch_turn_at(turn, j - k > 1 ? vload3(after, tables->top) : vload3(k, across), normal);
  return j - i + 1 == n ? stitch_turn_at(turn, vload3(j, across), normal) : turn;
}

/// The best of part (i, j) by least angle, then turn, then area.
static void stitch_minimise_all(const StitchGap *gap, const StitchTables *tables,
                                global const float *across, int i, int j) {
  const int n = gap->n, entry = n * (j - i) + i;
  float least = STITCH_NEVER, turn = STITCH_NEVER, area = STITCH_NEVER;
  int via = 0;
  const float c = stitch_length(gap, i, j);
  const int end = stitch_may_join(gap, i, j) ? j : i;
  for (int k = i + 1; k < end; ++k) {
    const int left = n * (k - i) + i, right = n * (j - k) + k;
    const float own = stitch_measure(stitch_length(gap, i, k), stitch_length(gap, k, j), c);
    const float measure = stitch_most(stitch_most(tables->least[left], tables->least[right]), own);
    if (!(measure <= least) || !(measure < STITCH_NEVER)) continue;
    const StitchTriangle t = stitch_obey_normals(gap, i, k, j);
    if (!t.good) continue;
    const float twice_area = sqrt(t.squared);
    const float3 normal = (1.0f / twice_area) * t.product;
    const float turned = stitch_largest_turn(gap, tables, across, i, k, j, normal);
    const float sum = (tables->sum[left] + tables->sum[right]) + 0.5f * twice_area;
    const bool better = measure < least || turned < turn || (turned == turn && sum < area);
    if (!better || !stitch_obeys_middle(gap, i, k, j, t.product)) continue;
    least = measure;
    turn = turned;
    area = sum;
    via = k;
    vstore3(normal, entry, tables->top);
  }
  tables->least[entry] = least;
  tables->sum[entry] = area;
  tables->turn[entry] = turn;
  tables->via[entry] = via;
}

/// The paper's single pass: angle, turn and area in one order, part by part.
kernel __attribute__((AS_WRITTEN)) void stitch_paper(STITCH_GAPS, VIEW(const float, across),
                                                     VIEW(float, least), VIEW(float, sum),
                                                     VIEW(float, turn), VIEW(float, top),
                                                     VIEW(ushort, via), VIEW(uchar, closed),
                                                     VIEW(ushort, triangles)) {
  STITCH_TAKE_GAP;
  across += 3 * (across_first + first[g]);
  StitchTables tables;
  tables.least = least + least_first + table;
  tables.sum = sum + sum_first + table;
  tables.turn = turn + turn_first + table;
  tables.top = top + 3 * (top_first + table);
  tables.via = via + via_first + table;
  stitch_start(n, tables.least, tables.sum);
  for (int width = 2; width < n; ++width) {
    for (int i = get_local_id(0); i + width < n; i += get_local_size(0))
      stitch_minimise_all(&gap, &tables, across, i, i + width);
    GLOBAL_SYNC();
  }
  if (get_local_id(0) != 0) return;
  const bool found = tables.least[n * (n - 1)] < STITCH_NEVER;
  closed[closed_first + g] = found;
  if (found) stitch_trace(n, tables.via, triangles + triangles_first + 3 * (first[g] - 2 * g));
}
