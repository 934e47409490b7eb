/// \file
/// Smoothing and moves towards equal edges with projection onto the surface, a work-group a part,
/// and how far the surface is from the triangles (engine/stages/fan_moves.h, relax.h). Contract:
/// engine/backend/backend.h.
///
/// The vertices of one level have no edges in common: items take them in turn, with a barrier
/// between levels.

#define RELAX_POINT 9  // floats: position, normal, size, drift, and whether it is on the field
#define RELAX_DRIFT 7

typedef struct {
  ulong cell;
  uint place;
  uint unused;
} RelaxPlaceCell;

/// What the vertices are projected onto and how long edges shall be (RemeshGoal).
typedef struct {
  Field field;
  Sizes sizes;
  ulong cell_count;
  global const RelaxPlaceCell *cells;
  global const float *places;
} RelaxGoal;

/// A kernel's arguments that are a goal, and the goal of them.
#define RELAX_GOAL                                                                              \
  FIELD_VIEW, SIZES_VIEW, VIEW(const RelaxPlaceCell, cells), VIEW(const float, places),         \
      ulong cell_count
#define TAKE_GOAL \
  {TAKE_FIELD, TAKE_SIZES, cell_count, cells + cells_first, places + 5 * places_first}

typedef struct {
  float3 position, normal;
  float size;
} RelaxPoint;

/// The points, and the ring of one of them.
typedef struct {
  global const float *points;
  global const uint *ring;
  int triangles;
} RelaxRing;

static float relax_least(float a, float b) { return b < a ? b : a; }
static float relax_most(float a, float b) { return a < b ? b : a; }

static float3 relax_position(const RelaxRing *ring, int i) {
  return vload3(0, ring->points + RELAX_POINT * (size_t)ring->ring[i]);
}

static RelaxPoint relax_load(global const float *points, uint vertex) {
  global const float *p = points + RELAX_POINT * (size_t)vertex;
  const RelaxPoint point = {vload3(0, p), vload3(1, p), p[6]};
  return point;
}

static RelaxPoint relax_at(const RelaxRing *ring, int i) {
  return relax_load(ring->points, ring->ring[i]);
}

// --- The size at a place. ------------------------------------------------------------------------

static ulong relax_cell(float x) {
  const float most = 1 << 20, cell = floor(RELAX_PLACE_INVERSE_SIDE * x);
  return (ulong)((cell < -most ? -most : most - 1 < cell ? most - 1 : cell) + most);
}

/// The least factor of the places that hold a point; 1 where none does.
static float relax_factor(const RelaxGoal *goal, float3 p) {
  const float none = 1e9f;
  if (goal->cell_count == 0) return 1.0f;
  const ulong key = relax_cell(p.x) | relax_cell(p.y) << 21 | relax_cell(p.z) << 42;
  ulong first = 0, end = goal->cell_count;
  while (first < end) {
    const ulong middle = (first + end) / 2;
    if (goal->cells[middle].cell < key)
      first = middle + 1;
    else
      end = middle;
  }
  float factor = none;
  for (; first < goal->cell_count && goal->cells[first].cell == key; ++first) {
    global const float *place = goal->places + 5 * (size_t)goal->cells[first].place;
    const float3 to = p - vload3(0, place);
    if (vec_dot(to, to) <= place[3] * place[3]) factor = relax_least(factor, place[4]);
  }
  return factor < none ? factor : 1.0f;
}

// --- Rules of triangles (engine/stages/patch_rules.h). -------------------------------------------

static float relax_least_squared_sine(float a, float b, float c, float squared_cross) {
  const float longest_two = relax_most(relax_most(a * b, b * c), c * a);
  return longest_two > 0 ? squared_cross / longest_two : 0.0f;
}

static float relax_quality(RelaxPoint a, RelaxPoint b, RelaxPoint c) {
  const float3 ab = b.position - a.position, bc = c.position - b.position,
               ca = a.position - c.position;
  const float3 normal = vec_cross(ab, bc);
  const float squared_cross = vec_dot(normal, normal);
  const float facing = relax_least(relax_least(vec_dot(normal, a.normal), vec_dot(normal, b.normal)),
                                   vec_dot(normal, c.normal));
  if (!(facing > 0 && facing * facing >= RELAX_LEAST_FACING * RELAX_LEAST_FACING * squared_cross))
    return squared_cross > 0 ? facing / sqrt(squared_cross) - 1 : -2.0f;
  return relax_least_squared_sine(vec_dot(ab, ab), vec_dot(bc, bc), vec_dot(ca, ca), squared_cross);
}

/// The least quality of the triangles that face as the surface does.
static float relax_facing_quality(const RelaxRing *ring, RelaxPoint p) {
  float least = 1;
  for (int i = 0; i < ring->triangles; ++i) {
    const float quality = relax_quality(p, relax_at(ring, i), relax_at(ring, i + 1));
    if (quality >= 0) least = relax_least(least, quality);
  }
  return least;
}

static bool relax_may_move(const RelaxRing *ring, RelaxPoint p, RelaxPoint moved, float limit) {
  for (int i = 0; i < ring->triangles; ++i) {
    const RelaxPoint b = relax_at(ring, i), c = relax_at(ring, i + 1);
    const float quality = relax_quality(moved, b, c);
    if (quality >= limit) continue;
    const float before = relax_quality(p, b, c);
    if (!(before < 0 && quality >= before)) return false;
  }
  return true;
}

/// Puts a point near the surface onto it, if the field is of use there.
static bool relax_onto_surface(const RelaxGoal *goal, float reach, RelaxPoint *point) {
  float3 position = point->position;
  const FieldSample sample = field_project(&goal->field, reach, RELAX_STEPS, &position);
  const float slope = sqrt(vec_dot(sample.gradient, sample.gradient));
  if (!sample.known || !(slope >= RELAX_LEAST_SLOPE) ||
      !(-vec_dot(sample.gradient, point->normal) >= RELAX_LEAST_AGREEMENT * slope))
    return false;
  point->position = position;
  point->normal = (-1 / slope) * sample.gradient;
  point->size = RELAX_LENGTH_FACTOR * relax_factor(goal, position) *
                sizes_at(&goal->sizes, position);
  return true;
}

static void relax_store(global float *points, uint vertex, RelaxPoint point) {
  global float *p = points + RELAX_POINT * (size_t)vertex;
  vstore3(point.position, 0, p);
  vstore3(point.normal, 1, p);
  p[6] = point.size;
  p[RELAX_DRIFT] = 0.0f;
}

// --- Smoothing. ----------------------------------------------------------------------------------

static float3 relax_fan_centre(const RelaxRing *ring, RelaxPoint p) {
  float3 sum = 0.0f;
  float weights = 0;
  for (int i = 0; i < ring->triangles; ++i) {
    const RelaxPoint q = relax_at(ring, i), r = relax_at(ring, i + 1);
    const float3 a = q.position - p.position, b = r.position - p.position, c = vec_cross(a, b);
    const float size = (p.size + q.size) + r.size;
    const float weight = sqrt(vec_dot(c, c)) / (size * size);
    sum = sum + weight * (a + b);
    weights += 3 * weight;
  }
  return weights > 0 ? (1.0f / weights) * sum : (float3)(0.0f);
}

static float3 relax_border_step(const RelaxRing *ring, RelaxPoint p) {
  const float3 middle =
      0.5f * (relax_position(ring, ring->triangles) + relax_position(ring, 0));
  return 0.5f * (middle - p.position);
}

static void relax_smooth_vertex(const RelaxGoal *goal, const RelaxRing *ring, uint vertex,
                                global float *points) {
  const RelaxPoint p = relax_load(points, vertex);
  const bool is_border = ring->ring[0] != ring->ring[ring->triangles];
  float3 step = is_border ? relax_border_step(ring, p) : relax_fan_centre(ring, p);
  step = step - vec_dot(step, p.normal) * p.normal;
  const float length = sqrt(vec_dot(step, step)), most = RELAX_LARGEST_STEP * p.size;
  if (length > most) step = (most / length) * step;
  const float limit = relax_least(RELAX_SQUARED_SINE25, relax_facing_quality(ring, p));
  for (int tries = 0; tries < 2; ++tries) {
    RelaxPoint moved = p;
    moved.position = p.position + (tries ? 0.5f : 1.0f) * step;
    if (!relax_onto_surface(goal, RELAX_SMOOTHING_REACH, &moved) ||
        !relax_may_move(ring, p, moved, limit))
      continue;
    relax_store(points, vertex, moved);
    return;
  }
}

// --- Equal edges. --------------------------------------------------------------------------------

static float relax_equality(const RelaxRing *ring, float3 p) {
  float sum = 0;
  for (int i = 0; i < ring->triangles; ++i) {
    const float3 pq = relax_position(ring, i) - p,
                 qr = relax_position(ring, i + 1) - relax_position(ring, i),
                 rp = p - relax_position(ring, i + 1);
    const float a = vec_dot(pq, pq), b = vec_dot(qr, qr), c = vec_dot(rp, rp);
    const float longest = relax_most(relax_most(a, b), c);
    if (longest > 0)
      sum += relax_least(relax_least(relax_least(a, b), c) / longest, RELAX_ENOUGH_EQUALITY);
  }
  return sum;
}

/// Compass search across the normal of p for the place with the most equal edges.
static float3 relax_most_equal_place(const RelaxRing *ring, RelaxPoint p) {
  const float diagonal = 0.70710678f, small_gain = 1e-3f;
  const float cosine[8] = {1, diagonal, 0, -diagonal, -1, -diagonal, 0, diagonal};
  const float sine[8] = {0, diagonal, 1, diagonal, 0, -diagonal, -1, -diagonal};
  float3 place = p.position;
  float best = relax_equality(ring, place);
  if (best >= RELAX_ENOUGH_EQUALITY * (float)ring->triangles - small_gain) return place;
  const float3 axis = p.normal.x * p.normal.x < 0.5f ? (float3)(1, 0, 0) : (float3)(0, 1, 0);
  const float3 u = vec_normalised(vec_cross(p.normal, axis)), w = vec_cross(p.normal, u);
  for (int tries = 0; tries < 2; ++tries) {
    const float step = tries ? 0.04f : 0.08f;
    const float3 from = place;
    for (int i = 0; i < 8; ++i) {
      const float3 q = from + (step * p.size) * (cosine[i] * u + sine[i] * w);
      const float equality = relax_equality(ring, q);
      if (!(equality > best)) continue;
      best = equality;
      place = q;
    }
  }
  return place;
}

static void relax_equalise_vertex(const RelaxGoal *goal, const RelaxRing *ring, uint vertex,
                                  bool onto, global float *points) {
  const RelaxPoint p = relax_load(points, vertex);
  RelaxPoint moved = p;
  moved.position = relax_most_equal_place(ring, p);
  if (moved.position.x == p.position.x && moved.position.y == p.position.y &&
      moved.position.z == p.position.z)
    return;
  if (onto && !relax_onto_surface(goal, RELAX_EQUALISING_REACH, &moved)) return;
  if (!(relax_equality(ring, moved.position) > relax_equality(ring, p.position))) return;
  if (!relax_may_move(ring, p, moved,
                      relax_least(RELAX_SQUARED_SINE40, relax_facing_quality(ring, p))))
    return;
  if (onto)
    relax_store(points, vertex, moved);
  else
    vstore3(moved.position, 0, points + RELAX_POINT * (size_t)vertex);
}

/// The vertices of one part, level by level.
#define RELAX_PART(move)                                                                        \
  const RelaxGoal goal = TAKE_GOAL;                                                             \
  points += RELAX_POINT * points_first;                                                         \
  TAKE(part_level);                                                                             \
  TAKE(level_first);                                                                            \
  TAKE(vertex);                                                                                 \
  TAKE(ring_start);                                                                             \
  TAKE(rings);                                                                                  \
  const size_t part = get_group_id(0);                                                          \
  const uint first_level = part_level[part], end_level = part_level[part + 1];                  \
  for (int pass = 0; pass < passes; ++pass)                                                     \
    for (uint level = first_level; level < end_level; ++level) {                                \
      const uint end = level_first[level + 1];                                                  \
      for (uint f = level_first[level] + get_local_id(0); f < end; f += BRICK_ITEMS) {          \
        const RelaxRing own = {points, rings + ring_start[f],                                    \
                               (int)(ring_start[f + 1] - ring_start[f]) - 1};                   \
        move(&goal, &own, vertex[f], points);                                                   \
      }                                                                                         \
      GLOBAL_SYNC();                                                                            \
    }

kernel __attribute__((PLAIN_BRICK_GROUP)) void relax_smooth(
    RELAX_GOAL, VIEW(const uint, part_level), VIEW(const uint, level_first),
    VIEW(const uint, vertex), VIEW(const uint, ring_start), VIEW(const uint, rings), int passes,
    VIEW(float, points)) {
  RELAX_PART(relax_smooth_vertex)
}

kernel __attribute__((PLAIN_BRICK_GROUP)) void relax_equalise(
    RELAX_GOAL, VIEW(const uint, part_level), VIEW(const uint, level_first),
    VIEW(const uint, vertex), VIEW(const uint, ring_start), VIEW(const uint, rings), int passes,
    int onto, VIEW(float, points)) {
#define RELAX_EQUALISE(goal, ring, vertex, points) \
  relax_equalise_vertex(goal, ring, vertex, onto != 0, points)
  RELAX_PART(RELAX_EQUALISE)
}

// --- Gaps. ---------------------------------------------------------------------------------------

/// How far the surface lies outside of the midpoint between two points of it.
static bool relax_find_gap(const Field *field, RelaxPoint a, RelaxPoint b, float *gap) {
  const float3 middle = 0.5f * (a.position + b.position);
  float3 foot = middle;
  if (!field_project(field, RELAX_GAP_REACH, RELAX_GAP_STEPS, &foot).known) return false;
  *gap = vec_dot(foot - middle, vec_normalised(a.normal + b.normal));
  return true;
}

/// A work-item a fan.
kernel __attribute__((ELEMENT_GROUP)) void relax_gaps(ulong count, FIELD_VIEW,
                                                      VIEW(const uint, vertex),
                                                      VIEW(const uint, ring_start),
                                                      VIEW(const uint, rings),
                                                      VIEW(const float, points),
                                                      VIEW(float, gaps)) {
  const size_t fan = get_global_id(0);
  if (fan >= count) return;
  TAKE(vertex);
  TAKE(ring_start);
  TAKE(rings);
  points += RELAX_POINT * points_first;
  const Field field = TAKE_FIELD;
  const RelaxRing ring = {points, rings + ring_start[fan],
                          (int)(ring_start[fan + 1] - ring_start[fan]) - 1};
  const RelaxPoint p = relax_load(points, vertex[fan]);
  float sum = 0, weights = 0;
  float3 before = relax_position(&ring, ring.triangles - 1);
  for (int i = 0; i < ring.triangles; ++i) {
    const RelaxPoint q = relax_at(&ring, i);
    const float3 edge = q.position - p.position, after = relax_position(&ring, i + 1);
    const float3 one = vec_cross(edge, after - p.position),
                 other = vec_cross(edge, before - p.position);
    const float weight = sqrt(vec_dot(one, one)) + sqrt(vec_dot(other, other));
    before = q.position;
    float gap = 0;
    if (!relax_find_gap(&field, p, q, &gap)) continue;
    sum += weight * gap;
    weights += weight;
  }
  gaps[gaps_first + fan] = weights > 0 ? sum / weights : 0.0f;
}
