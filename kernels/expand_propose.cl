/// \file
/// What one corner of the front does next, and whether that is good
/// (engine/stages/expand_propose.h).

#define EXPAND_NEAR 64  // edges that an item keeps; those beyond are looked up each time

/// A walk over the corners that are listed in the cells of a box.
typedef struct {
  ExpandCells cells;
  uint next;
} ExpandWalk;

/// The corners whose edges are near: the first of them, and where the walk goes on.
typedef struct {
  int count;
  uint corner[EXPAND_NEAR];
  ExpandWalk rest;
} ExpandNear;

typedef struct {
  float join_reach, least_tau, least_angle, off_surface;
} ExpandLimits;

typedef struct {
  const Field *field;
  const Sizes *sizes;
  const ExpandFront *front;
  ExpandLimits limits;
  ExpandBox claimed;
  uint corner, next, previous;
  float angle, length;
  float3 here, up;
  ExpandNear near;
} ExpandAsker;

/// What is proposed; new vertices count where it is a fan.
typedef struct {
  int kind, vertices;
  uint target;
  float3 position[EXPAND_MOST_VERTICES], normal[EXPAND_MOST_VERTICES];
  float size[EXPAND_MOST_VERTICES];
} ExpandPlan;

static uint expand_next_listed(const ExpandAsker *asker, ExpandWalk *walk) {
  while (walk->next == EXPAND_NONE) {
    const uint cell = expand_next_cell(asker->field, &walk->cells);
    if (cell == EXPAND_NONE) return EXPAND_NONE;
    walk->next = asker->front->edge_at[cell];
  }
  const uint corner = walk->next;
  walk->next = asker->front->corners[corner].next_near;
  return corner;
}

static void expand_gather(ExpandAsker *asker) {
  const ExpandBox box =
      expand_cells_round(asker->field, asker->here, EXPAND_SEARCH * asker->length);
  ExpandNear *near = &asker->near;
  near->rest.cells = expand_cells(asker->field, box);
  near->rest.next = EXPAND_NONE;
  for (near->count = 0; near->count < EXPAND_NEAR; ++near->count) {
    const uint corner = expand_next_listed(asker, &near->rest);
    if (corner == EXPAND_NONE) return;
    near->corner[near->count] = corner;
  }
}

/// All corners whose edges are near, one after the other.
#define FOR_NEAR(asker, edge)                                                                  \
  ExpandWalk edge##_walk = (asker)->near.rest;                                                 \
  int edge##_i = 0;                                                                            \
  for (uint edge; (edge = edge##_i < (asker)->near.count                                       \
                              ? (asker)->near.corner[edge##_i++]                               \
                              : expand_next_listed(asker, &edge##_walk)) != EXPAND_NONE;)

static float3 expand_at(const ExpandAsker *asker, uint corner) {
  return expand_position(asker->front, corner);
}
static float3 expand_up(const ExpandAsker *asker, uint corner) {
  return expand_normal(asker->front, corner);
}
static uint expand_next_of(const ExpandAsker *asker, uint corner) {
  return asker->front->corners[corner].next;
}
static uint expand_previous_of(const ExpandAsker *asker, uint corner) {
  return asker->front->corners[corner].previous;
}
static uint expand_vertex_at(const ExpandAsker *asker, uint corner) {
  return asker->front->corners[corner].vertex;
}
static float expand_angle(const ExpandAsker *asker, uint corner, float3 from, float3 to) {
  return expand_angle_between(expand_at(asker, corner), expand_up(asker, corner), from, to);
}

static bool expand_owns(const ExpandAsker *asker, uint corner) {
  const int3 cell = expand_cell_at(asker->field, expand_at(asker, corner));
  return expand_box_holds(&asker->claimed, cell) &&
         expand_cell_index(asker->field, cell, EXPAND_NONE) != EXPAND_NONE;
}

static bool expand_is_own(const ExpandAsker *asker, uint edge) {
  return edge == asker->corner || edge == asker->previous;
}

static bool expand_good_edge(const ExpandAsker *asker, float3 a, float3 b) {
  const float most = EXPAND_LONGEST_EDGE * asker->length;
  return vec_dot(b - a, b - a) <= most * most &&
         expand_edge_on_surface(asker->field, a, b, asker->limits.off_surface);
}

static bool expand_clear_of_edges(const ExpandAsker *asker, const ExpandTriangle *triangles,
                                  int count) {
  FOR_NEAR(asker, edge) {
    if (expand_is_own(asker, edge)) continue;
    const float3 start = expand_at(asker, edge), end = expand_at(asker, expand_next_of(asker, edge));
    const float3 normal = expand_up(asker, edge);
    for (int i = 0; i < count; ++i)
      if (expand_edge_crosses(start, end, normal, &triangles[i])) return false;
  }
  return true;
}

static bool expand_room_at_next(const ExpandAsker *asker, float3 to) {
  const uint next = asker->next;
  return asker->front->corners[next].angle - expand_angle(asker, next, asker->here, to) >=
         asker->limits.least_angle;
}

static bool expand_room_at_previous(const ExpandAsker *asker, float3 to) {
  const uint previous = asker->previous;
  return asker->front->corners[previous].angle -
             expand_angle(asker, previous, to, asker->here) >=
         asker->limits.least_angle;
}

static bool expand_room_at_target(const ExpandAsker *asker, uint target, bool with_next,
                                  bool with_previous) {
  const float3 first = with_next ? expand_at(asker, asker->next) : asker->here;
  const float3 last = with_previous ? expand_at(asker, asker->previous) : asker->here;
  const uint previous = expand_previous_of(asker, target), next = expand_next_of(asker, target);
  const bool meets_before = with_next && previous == asker->next;
  const bool meets_after = with_previous && next == asker->previous;
  const float used = expand_angle(asker, target, first, last);
  const float before =
      meets_before ? 0.0f : expand_angle(asker, target, expand_at(asker, previous), first);
  const float after =
      meets_after ? 0.0f : expand_angle(asker, target, last, expand_at(asker, next));
  return before + used + after <= asker->front->corners[target].angle + EXPAND_SPARE_ANGLE &&
         (meets_before || before >= asker->limits.least_angle) &&
         (meets_after || after >= asker->limits.least_angle);
}

// --- Ears. ---------------------------------------------------------------------------------------

static bool expand_good_ear(const ExpandAsker *asker, float tau, ExpandTriangle *t) {
  t->a = asker->here;
  t->b = expand_at(asker, asker->previous);
  t->c = expand_at(asker, asker->next);
  return expand_good_triangle(t, asker->up, expand_up(asker, asker->previous),
                              expand_up(asker, asker->next), tau);
}

static int expand_try_ear(const ExpandAsker *asker) {
  ExpandTriangle t;
  if (asker->angle < asker->limits.least_angle ||
      !expand_good_ear(asker, asker->limits.least_tau, &t) ||
      !expand_room_at_next(asker, t.b) || !expand_room_at_previous(asker, t.c) ||
      !expand_good_edge(asker, t.b, t.c) || !expand_clear_of_edges(asker, &t, 1))
    return EXPAND_NOTHING;
  return EXPAND_EAR;
}

// --- Fans. ---------------------------------------------------------------------------------------

/// Places the new vertices of a fan: at equal angles, as far as the sizes ask.
static bool expand_place(const ExpandAsker *asker, int parts, ExpandPlan *plan) {
  const float3 to_next = expand_at(asker, asker->next) - asker->here;
  const float3 across = vec_normalised(to_next - vec_dot(to_next, asker->up) * asker->up);
  if (!(vec_dot(across, across) > 0)) return false;
  const float3 left = vec_cross(asker->up, across);
  const float near = 0.5f * (expand_norm(to_next) +
                             expand_norm(expand_at(asker, asker->previous) - asker->here));
  const float2 part = expand_rotation(asker->angle / (float)parts);
  float2 turn = (float2)(1.0f, 0.0f);
  plan->vertices = parts - 1;
  for (int i = 0; i < plan->vertices; ++i) {
    turn = (float2)(turn.x * part.x - turn.y * part.y, turn.y * part.x + turn.x * part.y);
    const float3 direction = turn.x * across - turn.y * left;
    const float there = sizes_at(asker->sizes, asker->here + asker->length * direction);
    const float edge = expand_clamp(0.5f * (asker->length + there), EXPAND_SMALLER * near,
                                    EXPAND_LARGER * near);
    if (!expand_place_on_surface(asker->field, asker->here, direction, edge, &plan->position[i],
                                 &plan->normal[i]))
      return false;
    plan->size[i] = sizes_at(asker->sizes, plan->position[i]);
  }
  return true;
}

/// Whether an inner vertex of this sheet lies as near as it does to any point of a regular mesh.
static bool expand_is_covered(const ExpandAsker *asker, float3 p, float3 normal) {
  const ExpandFront *front = asker->front;
  const float reach = EXPAND_COVERED * asker->length;
  ExpandCells walk = expand_cells(asker->field, expand_cells_round(asker->field, p, reach));
  for (uint cell; (cell = expand_next_cell(asker->field, &walk)) != EXPAND_NONE;)
    for (uint v = front->vertex_at[cell]; v != EXPAND_NONE; v = front->vertices[v].next_near) {
      global const ExpandVertex *vertex = front->vertices + v;
      const float3 to = vload3(0, vertex->position) - p;
      if (vec_dot(to, to) < reach * reach && vertex->corners == 0 &&
          vec_dot(vload3(0, vertex->normal), normal) > EXPAND_SAME_SHEET)
        return true;
    }
  return false;
}

/// The rule of one third of the longest edge between a fan and a boundary edge.
static bool expand_too_near(const ExpandAsker *asker, uint edge, const ExpandPlan *plan,
                            const ExpandTriangle *triangles, float longest) {
  if (!(vec_dot(expand_up(asker, edge), asker->up) > EXPAND_SAME_SHEET)) return false;
  const float3 start = expand_at(asker, edge), end = expand_at(asker, expand_next_of(asker, edge));
  const float least = EXPAND_NARROW * expand_most(longest, expand_norm(end - start));
  for (int i = 0; i < plan->vertices; ++i)
    if (expand_squared_distance(plan->position[i], start, end) < least * least) return true;
  if (expand_same(start, expand_at(asker, asker->next)) ||
      expand_same(start, expand_at(asker, asker->previous)) || expand_same(start, asker->here))
    return false;
  const bool after = edge == expand_next_of(asker, asker->next);
  const bool before = edge == expand_previous_of(asker, asker->previous);
  for (int i = after ? 1 : 0; i < plan->vertices + 1 - (before ? 1 : 0); ++i)
    if (expand_squared_distance(start, triangles[i].b, triangles[i].c) < least * least)
      return true;
  return false;
}

/// The fan's triangles, if each is good, as are the new edges. `longest` is that of their edges.
static bool expand_good_fan(const ExpandAsker *asker, const ExpandPlan *plan,
                            ExpandTriangle *triangles, float *longest) {
  const int count = plan->vertices;
  *longest = 0;
  for (int i = 0; i <= count; ++i) {
    ExpandTriangle *t = &triangles[i];
    t->a = asker->here;
    t->b = i == count ? expand_at(asker, asker->previous) : plan->position[i];
    t->c = i == 0 ? expand_at(asker, asker->next) : plan->position[i - 1];
    const float3 to = i == count ? expand_up(asker, asker->previous) : plan->normal[i];
    const float3 from = i == 0 ? expand_up(asker, asker->next) : plan->normal[i - 1];
    if (!expand_good_triangle(t, asker->up, to, from, EXPAND_FAN_TAU)) return false;
    *longest = expand_most(*longest, expand_longest_edge(t));
    if (!expand_good_edge(asker, t->c, t->b) ||
        (i < count && !expand_good_edge(asker, asker->here, t->b)))
      return false;
  }
  return true;
}

/// `narrow` tells whether a fan that would be good comes too near to the boundary.
static int expand_try_fan(const ExpandAsker *asker, const ExpandPlan *plan, bool *narrow) {
  ExpandTriangle triangles[EXPAND_MOST_VERTICES + 1];
  const int count = plan->vertices;
  float longest;
  if (!expand_good_fan(asker, plan, triangles, &longest) ||
      !expand_room_at_next(asker, plan->position[0]) ||
      !expand_room_at_previous(asker, plan->position[count - 1]))
    return EXPAND_NOTHING;
  for (int i = 0; i < count; ++i)
    if (expand_is_covered(asker, plan->position[i], plan->normal[i])) return EXPAND_NOTHING;
  *narrow = true;
  FOR_NEAR(asker, edge) {
    if (!expand_is_own(asker, edge) && expand_too_near(asker, edge, plan, triangles, longest))
      return EXPAND_NOTHING;
  }
  if (!expand_clear_of_edges(asker, triangles, count + 1)) return EXPAND_NOTHING;
  *narrow = false;
  for (int i = 0; i < count; ++i)
    if (!expand_box_holds(&asker->claimed, expand_cell_at(asker->field, plan->position[i])))
      return EXPAND_MORE_ROOM;
  return EXPAND_FAN;
}

// --- Joins. --------------------------------------------------------------------------------------

/// The corner of this sheet nearest to a place where a new vertex would lie.
static uint expand_nearest_target(const ExpandAsker *asker, float3 place, float reach) {
  uint best = EXPAND_NONE;
  float least = reach * reach;
  FOR_NEAR(asker, edge) {
    const float3 to = expand_at(asker, edge) - place;
    const float apart = vec_dot(to, to);
    if (apart > least || (apart == least && edge >= best)) continue;
    if (edge == asker->corner || edge == asker->next || edge == asker->previous) continue;
    const uint v = expand_vertex_at(asker, edge);
    if (v == expand_vertex_at(asker, asker->corner) || v == expand_vertex_at(asker, asker->next) ||
        v == expand_vertex_at(asker, asker->previous))
      continue;
    if (!(vec_dot(expand_up(asker, edge), asker->up) > EXPAND_SAME_SHEET)) continue;
    least = apart;
    best = edge;
  }
  return best;
}

static bool expand_owns_join(const ExpandAsker *asker, uint target) {
  return expand_owns(asker, asker->next) && expand_owns(asker, asker->previous) &&
         expand_owns(asker, target) && expand_owns(asker, expand_next_of(asker, target)) &&
         expand_owns(asker, expand_previous_of(asker, target));
}

static int expand_try_target(const ExpandAsker *asker, uint target, bool with_next,
                             bool with_previous) {
  const float least_tau = asker->limits.least_tau, least_angle = asker->limits.least_angle;
  const float3 to = expand_at(asker, target), up = expand_up(asker, target);
  ExpandTriangle triangles[2];
  int count = 0;
  if (with_next) {
    const bool follows = expand_next_of(asker, asker->next) == target;
    ExpandTriangle *t = &triangles[count++];
    t->a = asker->here;
    t->b = to;
    t->c = expand_at(asker, asker->next);
    if (!expand_good_triangle(t, asker->up, up, expand_up(asker, asker->next), least_tau))
      return EXPAND_NOTHING;
    if (!follows && (!expand_room_at_next(asker, to) || !expand_good_edge(asker, t->c, to)))
      return EXPAND_NOTHING;
  }
  if (with_previous) {
    const bool precedes = expand_previous_of(asker, asker->previous) == target;
    ExpandTriangle *t = &triangles[count++];
    t->a = asker->here;
    t->b = expand_at(asker, asker->previous);
    t->c = to;
    if (!expand_good_triangle(t, asker->up, expand_up(asker, asker->previous), up, least_tau))
      return EXPAND_NOTHING;
    if (!precedes && (!expand_room_at_previous(asker, to) || !expand_good_edge(asker, t->b, to)))
      return EXPAND_NOTHING;
  }
  const float to_next = expand_angle(asker, asker->corner, to, expand_at(asker, asker->next));
  const float to_previous = asker->angle - to_next;
  if (to_previous < least_angle || to_next < least_angle) return EXPAND_NOTHING;
  if (!expand_room_at_target(asker, target, with_next, with_previous) ||
      !expand_good_edge(asker, asker->here, to) ||
      !expand_clear_of_edges(asker, triangles, count))
    return EXPAND_NOTHING;
  if (!expand_owns_join(asker, target)) return EXPAND_MORE_ROOM;
  return with_next && with_previous ? EXPAND_JOIN_BOTH
         : with_next                ? EXPAND_JOIN_NEXT
                                    : EXPAND_JOIN_PREVIOUS;
}

static int expand_try_join(const ExpandAsker *asker, ExpandPlan *plan, float reach) {
  const int last = plan->vertices - 1;
  const uint by_next = expand_nearest_target(asker, plan->position[0], reach);
  const uint by_previous =
      last == 0 ? by_next : expand_nearest_target(asker, plan->position[last], reach);
  int kind = EXPAND_NOTHING;
  plan->target = by_next;
  if (by_next != EXPAND_NONE && by_next == by_previous)
    kind = expand_try_target(asker, by_next, true, true);
  if (by_next != EXPAND_NONE && kind == EXPAND_NOTHING)
    kind = expand_try_target(asker, by_next, true, false);
  if (by_previous != EXPAND_NONE && kind == EXPAND_NOTHING) {
    plan->target = by_previous;
    kind = expand_try_target(asker, by_previous, false, true);
  }
  return kind;
}

// --- All of it. ----------------------------------------------------------------------------------

/// The parts that an open angle is cut into.
static int expand_parts(float angle) {
  if (angle < EXPAND_EAR_ANGLE) return 1;
  const int parts = (int)(angle / EXPAND_PART + 0.5f);
  return parts < 2 ? 2 : EXPAND_MOST_VERTICES + 1 < parts ? EXPAND_MOST_VERTICES + 1 : parts;
}

static int expand_ask(ExpandAsker *asker, ExpandPlan *plan) {
  ExpandTriangle t;
  if (asker->next == asker->previous || asker->next == asker->corner) return EXPAND_NOTHING;
  if (!expand_owns(asker, asker->corner) || !expand_owns(asker, asker->next) ||
      !expand_owns(asker, asker->previous))
    return EXPAND_MORE_ROOM;
  if (expand_in_loop_of_three(asker->front, asker->corner) && asker->angle < EXPAND_PI)
    return expand_good_ear(asker, EXPAND_GAP_TAU * asker->limits.least_tau, &t) ? EXPAND_EAR
                                                                                : EXPAND_NOTHING;
  expand_gather(asker);
  const int parts = expand_parts(asker->angle);
  if (parts == 1) return expand_try_ear(asker);
  if (!expand_place(asker, parts, plan)) return EXPAND_NOTHING;
  const float reach = asker->limits.join_reach * asker->length;
  const int join = expand_try_join(asker, plan, reach);
  if (join != EXPAND_NOTHING) return join;
  bool narrow = false;
  const int fan = expand_try_fan(asker, plan, &narrow);
  if (fan != EXPAND_NOTHING || !narrow) return fan;
  return expand_try_join(asker, plan, EXPAND_WIDER_JOIN * reach);
}
