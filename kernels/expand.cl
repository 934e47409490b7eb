/// \file
/// Rounds of mesh expanding (engine/stages/expand_steps.h): who may propose, and what is added.
/// Contract: engine/backend/backend.h.

// --- Choice. -------------------------------------------------------------------------------------

/// Which corners go first: those that close, then the narrow ones.
static uint expand_rank(const ExpandFront *front, uint corner) {
  if (expand_in_loop_of_three(front, corner)) return 7;
  const float angle = front->corners[corner].angle;
  return 1 + (uint)(angle < 3.9f) + (uint)(angle < 3.4f) + (uint)(angle < 2.75f) +
         (uint)(angle < 2.2f) + (uint)(angle < 1.75f);
}

/// Mixes the bits of an index, so that neighbours are not served in order.
static uint expand_scramble(uint x) {
  x ^= x >> 16;
  x *= 0x7feb352du;
  x ^= x >> 15;
  x *= 0x846ca68bu;
  return x ^ x >> 16;
}

/// A work-item a corner of the list.
kernel __attribute__((ELEMENT_GROUP)) void expand_measure(FIELD_VIEW, FRONT_VIEW, uint outside,
                                                          uint round, int wake) {
  const Field field = TAKE_FIELD;
  const ExpandFront front = TAKE_FRONT;
  if (get_global_id(0) >= front.counts->listed) return;
  const uint corner = front.listed[get_global_id(0)];
  global ExpandCorner *c = front.corners + corner;
  if (c->cell != EXPAND_NONE) front.edge_at[c->cell] = EXPAND_NONE;
  c->key = 0;
  if (c->state == EXPAND_DEAD) return;
  if (wake || c->state == EXPAND_CHANGED) {
    const float3 here = expand_position(&front, corner), end = expand_position(&front, c->next);
    c->angle = expand_angle_between(here, expand_normal(&front, corner),
                                    expand_position(&front, c->previous), end);
    c->cell =
        expand_cell_index(&field, expand_cell_at(&field, 0.5f * (here + end)), outside);
    c->state = EXPAND_ACTIVE;
    c->wide = 0;
  }
  if (c->state != EXPAND_ACTIVE) return;
  const uint mixed = expand_scramble(corner + 0x9e3779b9u * round);
  c->key = round << 20 | expand_rank(&front, corner) << 16 | (mixed & 0xffffu);
}

/// Whether a corner's claim is at least as high as another's.
static bool expand_goes_before(const ExpandFront *front, uint corner, uint other) {
  const uint key = front->corners[corner].key, other_key = front->corners[other].key;
  return key > other_key || (key == other_key && corner >= other);
}

static bool expand_goes_first(const ExpandFront *front, uint corner) {
  global const ExpandCorner *c = front->corners + corner;
  return c->key && expand_goes_before(front, corner, c->previous) &&
         expand_goes_before(front, corner, c->next) &&
         expand_goes_before(front, corner, front->corners[c->previous].previous) &&
         expand_goes_before(front, corner, front->corners[c->next].next);
}

/// The part of a list of `count` that an item of a group takes.
static uint2 expand_run(uint count) {
  const uint run = EXPAND_BLOCK / BRICK_ITEMS;
  const uint first = get_group_id(0) * EXPAND_BLOCK + get_local_id(0) * run;
  return (uint2)(min(first, count), min(first + run, count));
}

/// The sums over the items of a group that come before this one; `own` of all items at the end.
static uint2 expand_sum_before(BRICK_SHARED uint2 *item_sum, uint2 *own) {
  const int item = get_local_id(0);
  item_sum[item] = *own;
  BRICK_SYNC();
  uint2 before = (uint2)(0), all = (uint2)(0);
  for (int i = 0; i < BRICK_ITEMS; ++i) {
    if (i == item) before = all;
    all += item_sum[i];
  }
  *own = all;
  return before;
}

/// Lists the edges of the cells. marks[i] is 1 where the i-th of the list is kept, 3 where it is
/// chosen; blocks[b] counts both in a block of the list. A work-group a block.
kernel __attribute__((BRICK_GROUP)) void expand_mark(FRONT_VIEW, VIEW(uchar, marks),
                                                     VIEW(uint2, blocks)) {
  BRICK_SHARED uint2 item_sum[BRICK_ITEMS];
  const ExpandFront front = TAKE_FRONT;
  TAKE(marks);
  const uint2 run = expand_run(front.counts->listed);
  uint2 sum = (uint2)(0);
  for (uint i = run.x; i < run.y; ++i) {
    const uint corner = front.listed[i];
    global ExpandCorner *c = front.corners + corner;
    marks[i] = 0;
    if (c->state == EXPAND_DEAD) continue;
    c->next_near = atomic_xchg(front.edge_at + c->cell, corner);
    marks[i] = expand_goes_first(&front, corner) ? 3 : 1;
    sum += (uint2)(1, marks[i] >> 1);
  }
  expand_sum_before(item_sum, &sum);
  if (get_local_id(0) == 0) blocks[blocks_first + get_group_id(0)] = sum;
}

/// Writes both lists, a work-group a block; the last counts them.
kernel __attribute__((BRICK_GROUP)) void expand_collect(FRONT_VIEW, VIEW(const uchar, marks),
                                                        VIEW(const uint2, blocks)) {
  BRICK_SHARED uint2 item_sum[BRICK_ITEMS], item_before[BRICK_ITEMS];
  const ExpandFront front = TAKE_FRONT;
  TAKE(marks);
  TAKE(blocks);
  const uint2 run = expand_run(front.counts->listed);
  uint2 sum = (uint2)(0), start = (uint2)(0);
  for (uint i = run.x; i < run.y; ++i) sum += (uint2)(marks[i] & 1, marks[i] >> 1);
  for (uint b = get_local_id(0); b < get_group_id(0); b += BRICK_ITEMS) start += blocks[b];
  const uint2 before = expand_sum_before(item_sum, &sum);
  expand_sum_before(item_before, &start);
  uint2 next = start + before;
  for (uint i = run.x; i < run.y; ++i) {
    if (marks[i] & 1) front.alive[next.x++] = front.listed[i];
    if (marks[i] & 2) front.chosen[next.y++] = front.listed[i];
  }
  if (get_group_id(0) + 1 < get_num_groups(0) || get_local_id(0) != 0) return;
  front.counts->alive = start.x + sum.x;
  front.counts->chosen = start.y + sum.y;
}

// --- Claims, the higher number first and then the lower: devices need no atomics of 64 bits. -----

/// A work-item a chosen corner.
kernel __attribute__((ELEMENT_GROUP)) void expand_claim_keys(ulong count, FIELD_VIEW, FRONT_VIEW) {
  if (get_global_id(0) >= count) return;
  const Field field = TAKE_FIELD;
  const ExpandFront front = TAKE_FRONT;
  const uint corner = front.chosen[get_global_id(0)], key = front.corners[corner].key;
  ExpandCells walk = expand_cells(&field, expand_claimed(&field, &front, corner));
  for (uint cell; (cell = expand_next_cell(&field, &walk)) != EXPAND_NONE;) {
    atomic_max(&front.claims[cell].key, key);
    front.claims[cell].corner = 0;
  }
}

/// Of the corners with the highest key, the highest.
kernel __attribute__((ELEMENT_GROUP)) void expand_claim_corners(ulong count, FIELD_VIEW,
                                                                FRONT_VIEW) {
  if (get_global_id(0) >= count) return;
  const Field field = TAKE_FIELD;
  const ExpandFront front = TAKE_FRONT;
  const uint corner = front.chosen[get_global_id(0)], key = front.corners[corner].key;
  ExpandCells walk = expand_cells(&field, expand_claimed(&field, &front, corner));
  for (uint cell; (cell = expand_next_cell(&field, &walk)) != EXPAND_NONE;)
    if (front.claims[cell].key == key) atomic_max(&front.claims[cell].corner, corner);
}

static bool expand_holds_cells(const Field *field, const ExpandFront *front, uint corner,
                               ExpandBox claimed) {
  const uint key = front->corners[corner].key;
  ExpandCells walk = expand_cells(field, claimed);
  for (uint cell; (cell = expand_next_cell(field, &walk)) != EXPAND_NONE;)
    if (front->claims[cell].key != key || front->claims[cell].corner != corner) return false;
  return true;
}

// --- Proposals. ----------------------------------------------------------------------------------

/// What becomes of a corner that proposes nothing.
static void expand_settle(global ExpandCorner *c, int kind) {
  if (kind == EXPAND_NOTHING || (kind == EXPAND_MORE_ROOM && c->wide)) c->state = EXPAND_FROZEN;
  if (kind == EXPAND_MORE_ROOM) c->wide = 1;
}

static ExpandStart expand_needs(const ExpandFront *front, uint corner, const ExpandPlan *plan) {
  global const ExpandCorner *c = front->corners + corner;
  const bool follows = front->corners[c->next].next == plan->target;
  const bool precedes = front->corners[c->previous].previous == plan->target;
  ExpandStart needs = {0, 0, 0};
  if (plan->kind == EXPAND_FAN) needs.vertex = needs.corner = plan->vertices;
  if (plan->kind == EXPAND_JOIN_NEXT || plan->kind == EXPAND_JOIN_BOTH) needs.corner = !follows;
  if (plan->kind == EXPAND_JOIN_PREVIOUS) needs.corner = !precedes;
  if (plan->kind >= EXPAND_EAR) needs.triangle = 1;
  if (plan->kind == EXPAND_JOIN_BOTH) needs.triangle = 2;
  if (plan->kind == EXPAND_FAN) needs.triangle = plan->vertices + 1;
  return needs;
}

static void expand_store(const ExpandPlan *plan, global ExpandProposal *proposal) {
  proposal->kind = plan->kind;
  proposal->target = plan->target;
  if (plan->kind != EXPAND_FAN) return;
  proposal->vertices = plan->vertices;
  for (int i = 0; i < plan->vertices; ++i) {
    vstore3(plan->position[i], 0, proposal->position[i]);
    vstore3(plan->normal[i], 0, proposal->normal[i]);
    proposal->size[i] = plan->size[i];
  }
}

/// A work-item a chosen corner.
kernel __attribute__((PLAIN_ELEMENT_GROUP)) void expand_propose(ulong count, FIELD_VIEW, SIZES_VIEW,
                                                                FRONT_VIEW, float4 limits) {
  const size_t i = get_global_id(0);
  if (i >= count) return;
  const Field field = TAKE_FIELD;
  const Sizes size_field = TAKE_SIZES;
  const ExpandFront front = TAKE_FRONT;
  const uint corner = front.chosen[i];
  const ExpandBox claimed = expand_claimed(&field, &front, corner);
  ExpandPlan plan;
  plan.kind = EXPAND_NOTHING;
  plan.vertices = 0;
  plan.target = EXPAND_NONE;
  if (expand_holds_cells(&field, &front, corner, claimed)) {
    ExpandAsker asker;
    asker.field = &field;
    asker.sizes = &size_field;
    asker.front = &front;
    asker.limits.join_reach = limits.x;
    asker.limits.least_tau = limits.y;
    asker.limits.least_angle = limits.z;
    asker.limits.off_surface = limits.w;
    asker.claimed = claimed;
    asker.corner = corner;
    asker.next = front.corners[corner].next;
    asker.previous = front.corners[corner].previous;
    asker.angle = front.corners[corner].angle;
    asker.length = expand_vertex(&front, corner)->size;
    asker.here = expand_position(&front, corner);
    asker.up = expand_normal(&front, corner);
    plan.kind = expand_ask(&asker, &plan);
    expand_settle(front.corners + corner, plan.kind);
  }
  expand_store(&plan, front.proposals + i);
  front.starts[i] = expand_needs(&front, corner, &plan);
}

// --- Additions. ----------------------------------------------------------------------------------

static uint3 expand_load_start(global const ExpandStart *start) {
  return (uint3)(start->vertex, start->triangle, start->corner);
}

/// Turns what the proposals need into where it begins, by one work-group.
kernel __attribute__((reqd_work_group_size(REDUCE_ITEMS, 1, 1))) void expand_number(ulong count,
                                                                                    FRONT_VIEW) {
  local uint3 item_sum[REDUCE_ITEMS];
  const ExpandFront front = TAKE_FRONT;
  const size_t item = get_local_id(0), run = (count + REDUCE_ITEMS - 1) / REDUCE_ITEMS;
  const size_t first = item * run, end = min((ulong)(first + run), count);
  uint3 sum = (uint3)(0);
  for (size_t i = first; i < end; ++i) sum += expand_load_start(front.starts + i);
  item_sum[item] = sum;
  barrier(CLK_LOCAL_MEM_FENCE);
  uint3 next =
      (uint3)(front.counts->vertices, front.counts->triangles, front.counts->corners);
  for (size_t i = 0; i < item; ++i) next += item_sum[i];
  for (size_t i = first; i < end; ++i) {
    const uint3 needs = expand_load_start(front.starts + i);
    front.starts[i].vertex = next.x;
    front.starts[i].triangle = next.y;
    front.starts[i].corner = next.z;
    next += needs;
  }
  barrier(CLK_GLOBAL_MEM_FENCE);  // the counts have been read
  if (item + 1 < REDUCE_ITEMS) return;
  front.counts->listed = front.counts->alive + (next.z - front.counts->corners);
  front.counts->vertices = next.x;
  front.counts->triangles = next.y;
  front.counts->corners = next.z;
}

static void expand_link(const ExpandFront *front, uint from, uint to) {
  front->corners[from].next = to;
  front->corners[to].previous = from;
  front->corners[from].state = front->corners[to].state = EXPAND_CHANGED;
}

static void expand_kill(const ExpandFront *front, uint corner) {
  front->corners[corner].state = EXPAND_DEAD;
  --front->vertices[front->corners[corner].vertex].corners;
}

static void expand_add_corner(const ExpandFront *front, uint corner, uint vertex) {
  const ExpandCorner added = {vertex, EXPAND_NONE, EXPAND_NONE, 0.0f,          0, EXPAND_NONE,
                              EXPAND_NONE, EXPAND_CHANGED, 0};
  front->corners[corner] = added;
  front->listed[front->counts->listed - front->counts->corners + corner] = corner;
}

/// The triangle of the edge from a corner to its next, with its tip at the corner `tip`: the
/// boundary runs past the tip instead. Where the tip is no neighbour it splits in two, and `spare`
/// is the second corner.
static void expand_fill_edge(const ExpandFront *front, uint corner, uint tip, uint spare,
                             global uint *triangle) {
  global ExpandCorner *corners = front->corners;
  const uint next = corners[corner].next, tip_vertex = corners[tip].vertex;
  triangle[0] = corners[corner].vertex;
  triangle[1] = tip_vertex;
  triangle[2] = corners[next].vertex;
  const bool follows = corners[next].next == tip, precedes = corners[corner].previous == tip;
  if (follows && precedes) {
    expand_kill(front, corner);
    expand_kill(front, next);
    expand_kill(front, tip);
  } else if (follows) {
    expand_link(front, corner, tip);
    expand_kill(front, next);
  } else if (precedes) {
    expand_link(front, tip, next);
    expand_kill(front, corner);
  } else {
    expand_add_corner(front, spare, tip_vertex);
    ++front->vertices[tip_vertex].corners;
    expand_link(front, corners[tip].previous, spare);
    expand_link(front, spare, next);
    expand_link(front, corner, tip);
  }
}

static void expand_add_vertex(const Field *field, const ExpandFront *front, uint vertex,
                              global const ExpandProposal *p, uint k, uint outside) {
  global ExpandVertex *added = front->vertices + vertex;
  const float3 position = vload3(0, p->position[k]);
  vstore3(position, 0, added->position);
  vstore3(vload3(0, p->normal[k]), 0, added->normal);
  added->size = p->size[k];
  added->corners = 1;
  const uint cell = expand_cell_index(field, expand_cell_at(field, position), outside);
  added->next_near = atomic_xchg(front->vertex_at + cell, vertex);
}

/// A fan of new vertices round the corner, from its next to its previous.
static void expand_add_fan(const Field *field, const ExpandFront *front, uint corner,
                           global const ExpandProposal *p, ExpandStart start,
                           global uint *triangle, uint outside) {
  const uint previous = front->corners[corner].previous;
  uint last = front->corners[corner].next;
  for (uint k = 0; k <= p->vertices; ++k) {
    const uint here = k < p->vertices ? start.corner + k : previous;
    if (k < p->vertices) {
      expand_add_vertex(field, front, start.vertex + k, p, k, outside);
      expand_add_corner(front, here, start.vertex + k);
    }
    triangle[3 * k] = front->corners[corner].vertex;
    triangle[3 * k + 1] = front->corners[here].vertex;
    triangle[3 * k + 2] = front->corners[last].vertex;
    expand_link(front, here, last);
    last = here;
  }
  expand_kill(front, corner);
}

/// A work-item a chosen corner.
kernel __attribute__((PLAIN_ELEMENT_GROUP)) void expand_add(ulong count, FIELD_VIEW, FRONT_VIEW,
                                                            uint outside) {
  const size_t i = get_global_id(0);
  if (i >= count) return;
  const Field field = TAKE_FIELD;
  const ExpandFront front = TAKE_FRONT;
  global const ExpandProposal *p = front.proposals + i;
  // Round a corner that may not hold its cells, others are at work.
  if (p->kind == EXPAND_NOTHING || p->kind == EXPAND_MORE_ROOM) return;
  const ExpandStart start = front.starts[i];
  const uint corner = front.chosen[i];
  const uint next = front.corners[corner].next, previous = front.corners[corner].previous;
  global uint *triangle = front.triangles + 3 * (size_t)start.triangle;
  if (p->kind == EXPAND_EAR)
    expand_fill_edge(&front, previous, next, EXPAND_NONE, triangle);
  else if (p->kind == EXPAND_JOIN_NEXT || p->kind == EXPAND_JOIN_BOTH)
    expand_fill_edge(&front, corner, p->target, start.corner, triangle);
  else if (p->kind == EXPAND_JOIN_PREVIOUS)
    expand_fill_edge(&front, previous, p->target, start.corner, triangle);
  else if (p->kind == EXPAND_FAN)
    expand_add_fan(&field, &front, corner, p, start, triangle, outside);
  if (p->kind == EXPAND_JOIN_BOTH)
    expand_fill_edge(&front, previous, p->target, EXPAND_NONE, triangle + 3);
}
