/// \file
/// The front of mesh expanding (engine/types/front.h), its cells (engine/stages/expand_grid.h), and
/// the rules that a triangle must keep (engine/stages/expand_checks.h).

#define EXPAND_NONE 0xffffffffu

enum { EXPAND_DEAD, EXPAND_CHANGED, EXPAND_ACTIVE, EXPAND_FROZEN };
enum { EXPAND_NOTHING, EXPAND_MORE_ROOM, EXPAND_EAR, EXPAND_FAN, EXPAND_JOIN_NEXT,
       EXPAND_JOIN_PREVIOUS, EXPAND_JOIN_BOTH };

typedef struct {
  float position[3], normal[3];
  float size;
  uint corners, next_near;
} ExpandVertex;

typedef struct {
  uint vertex, previous, next;
  float angle;
  uint key, cell, next_near;
  uchar state, wide;
} ExpandCorner;

typedef struct {
  float position[EXPAND_MOST_VERTICES][3], normal[EXPAND_MOST_VERTICES][3];
  float size[EXPAND_MOST_VERTICES];
  uint target;
  uchar kind, vertices;
} ExpandProposal;

typedef struct {
  uint vertex, triangle, corner;
} ExpandStart;

typedef struct {
  uint vertices, triangles, corners, listed, alive, chosen;
} ExpandCounts;

/// A claim is two numbers, the lower first.
typedef struct {
  uint corner, key;
} ExpandClaim;

typedef struct {
  global ExpandCounts *counts;
  global ExpandVertex *vertices;
  global ExpandCorner *corners;
  global uint *triangles, *listed, *alive, *chosen;
  global ExpandProposal *proposals;
  global ExpandStart *starts;
  global ExpandClaim *claims;
  global uint *edge_at, *vertex_at;
} ExpandFront;

/// A kernel's arguments that are a front, and the front of them.
#define FRONT_VIEW                                                                            \
  VIEW(ExpandCounts, counts), VIEW(ExpandVertex, vertices), VIEW(ExpandCorner, corners),      \
      VIEW(uint, triangles), VIEW(uint, listed), VIEW(uint, alive), VIEW(uint, chosen),       \
      VIEW(ExpandProposal, proposals), VIEW(ExpandStart, starts), VIEW(ExpandClaim, claims),  \
      VIEW(uint, edge_at), VIEW(uint, vertex_at)
#define TAKE_FRONT                                                                            \
  {counts + counts_first,       vertices + vertices_first,   corners + corners_first,         \
   triangles + triangles_first, listed + listed_first,       alive + alive_first,             \
   chosen + chosen_first,       proposals + proposals_first, starts + starts_first,           \
   claims + claims_first,       edge_at + edge_at_first,     vertex_at + vertex_at_first}

static float expand_least(float a, float b) { return b < a ? b : a; }
static float expand_most(float a, float b) { return a < b ? b : a; }
static float expand_clamp(float x, float low, float high) {
  return x < low ? low : high < x ? high : x;
}
static float expand_norm(float3 a) { return sqrt(vec_dot(a, a)); }
static bool expand_same(float3 a, float3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

static global const ExpandVertex *expand_vertex(const ExpandFront *front, uint corner) {
  return front->vertices + front->corners[corner].vertex;
}
static float3 expand_position(const ExpandFront *front, uint corner) {
  return vload3(0, expand_vertex(front, corner)->position);
}
static float3 expand_normal(const ExpandFront *front, uint corner) {
  return vload3(0, expand_vertex(front, corner)->normal);
}
static bool expand_in_loop_of_three(const ExpandFront *front, uint corner) {
  global const ExpandCorner *corners = front->corners;
  return corners[corners[corners[corner].next].next].next == corner;
}

// --- Angles (engine/types/angles.h). -----------------------------------------------------------

/// The angle of the vector (x, y) from the x axis, 0 to 2 pi.
static float expand_angle_of(float x, float y) {
  const float pi = EXPAND_PI;
  const float ax = x < 0 ? -x : x, ay = y < 0 ? -y : y;
  const float least = ax < ay ? ax : ay, most = ax < ay ? ay : ax;
  if (!(most > 0)) return y < 0 ? 2 * pi : 0.0f;
  const float t = least / most, s = t * t;
  float a =
      t * (0.99997726f +
           s * (-0.33262347f +
                s * (0.19354346f + s * (-0.11643287f + s * (0.05265332f + s * -0.01172120f)))));
  if (ay > ax) a = 0.5f * pi - a;
  if (x < 0) a = pi - a;
  return y < 0 ? 2 * pi + -a : a;
}

static float expand_angle_between(float3 p, float3 n, float3 from, float3 to) {
  float3 a = from - p, b = to - p;
  a = a - vec_dot(a, n) * n;
  b = b - vec_dot(b, n) * n;
  return expand_angle_of(vec_dot(a, b), vec_dot(n, vec_cross(a, b)));
}

/// Cosine and sine of a turn by at most 2.
static float2 expand_rotation(float angle) {
  const float s = angle * angle;
  return (float2)(
      1 - s * (0.5f - s * (1 / 24.0f - s * (1 / 720.0f - s * (1 / 40320.0f)))),
      angle * (1 - s * (1 / 6.0f - s * (1 / 120.0f - s * (1 / 5040.0f - s / 362880.0f)))));
}

// --- Cells. --------------------------------------------------------------------------------------

typedef struct {
  int3 low, high;  // both included
} ExpandBox;

static int expand_place_along(float at, int bricks) {
  const float most = (float)(8 * bricks - 1);
  return (int)(!(at > 0) ? 0.0f : at < most ? at : most) >> 2;
}

static int3 expand_cell_at(const Field *field, float3 p) {
  const float3 at = p * field->inverse_step;
  return (int3)(expand_place_along(at.x, field->grid.x), expand_place_along(at.y, field->grid.y),
                expand_place_along(at.z, field->grid.z));
}

static int expand_brick(const Field *field, int3 brick) {
  return field->brick_at[((size_t)brick.z * field->grid.y + brick.y) * field->grid.x + brick.x];
}

/// The index of a cell; `none` where there is no brick.
static uint expand_cell_index(const Field *field, int3 cell, uint none) {
  const int brick = expand_brick(field, cell >> 1);
  const int3 side = cell & 1;
  return brick < 0 ? none : 8 * (uint)brick + (uint)(side.x + 2 * side.y + 4 * side.z);
}

static ExpandBox expand_cells_round(const Field *field, float3 p, float reach) {
  const ExpandBox box = {
      expand_cell_at(field, (float3)(p.x - reach, p.y - reach, p.z - reach)),
      expand_cell_at(field, (float3)(p.x + reach, p.y + reach, p.z + reach))};
  return box;
}

static bool expand_box_holds(const ExpandBox *box, int3 cell) {
  return all(cell >= box->low) && all(cell <= box->high);
}

/// The box that a corner claims.
static ExpandBox expand_claimed(const Field *field, const ExpandFront *front, uint corner) {
  const float claim = front->corners[corner].wide ? EXPAND_WIDE_CLAIM : EXPAND_CLAIM;
  return expand_cells_round(field, expand_position(front, corner),
                            claim * expand_vertex(front, corner)->size);
}

/// A walk over the cells of a box that lie in bricks, brick by brick.
typedef struct {
  ExpandBox box;
  int3 brick;
  uint first;  // cell of the brick
  int side;    // the next of its eight cells
} ExpandCells;

static void expand_enter_brick(const Field *field, ExpandCells *walk) {
  const int brick = expand_brick(field, walk->brick);
  walk->first = 8 * (uint)brick;
  walk->side = brick < 0 ? 8 : 0;
}

static ExpandCells expand_cells(const Field *field, ExpandBox box) {
  ExpandCells walk;
  walk.box = box;
  walk.brick = box.low >> 1;
  expand_enter_brick(field, &walk);
  return walk;
}

/// The index of the next cell; EXPAND_NONE at the end.
static uint expand_next_cell(const Field *field, ExpandCells *walk) {
  const int3 first = walk->box.low >> 1, last = walk->box.high >> 1;
  for (;;) {
    while (walk->side < 8) {
      const int side = walk->side++;
      const int3 cell = 2 * walk->brick + (int3)(side & 1, side >> 1 & 1, side >> 2);
      if (expand_box_holds(&walk->box, cell)) return walk->first + (uint)side;
    }
    if (++walk->brick.x > last.x) {
      walk->brick.x = first.x;
      if (++walk->brick.y > last.y) {
        walk->brick.y = first.y;
        if (++walk->brick.z > last.z) {
          walk->brick.z = last.z;
          return EXPAND_NONE;
        }
      }
    }
    expand_enter_brick(field, walk);
  }
}

// --- Rules. --------------------------------------------------------------------------------------

typedef struct {
  float3 a, b, c;
} ExpandTriangle;

static float3 expand_unit_normal(const ExpandTriangle *t) {
  return vec_normalised(vec_cross(t->b - t->a, t->c - t->a));
}

static float3 expand_squared_edges(const ExpandTriangle *t) {
  const float3 ab = t->b - t->a, bc = t->c - t->b, ca = t->a - t->c;
  return (float3)(vec_dot(ab, ab), vec_dot(bc, bc), vec_dot(ca, ca));
}

static float expand_edge_ratio(const ExpandTriangle *t) {
  const float3 e = expand_squared_edges(t);
  const float least = expand_least(expand_least(e.x, e.y), e.z);
  const float most = expand_most(expand_most(e.x, e.y), e.z);
  return most > 0 ? sqrt(least / most) : 0.0f;
}

static float expand_longest_edge(const ExpandTriangle *t) {
  const float3 e = expand_squared_edges(t);
  return sqrt(expand_most(expand_most(e.x, e.y), e.z));
}

static bool expand_good_triangle(const ExpandTriangle *t, float3 na, float3 nb, float3 nc,
                                 float tau) {
  if (!(expand_edge_ratio(t) >= tau)) return false;
  const float3 n = expand_unit_normal(t);
  return vec_dot(n, na) > EXPAND_FACING && vec_dot(n, nb) > EXPAND_FACING &&
         vec_dot(n, nc) > EXPAND_FACING;
}

static bool expand_edge_on_surface(const Field *field, float3 a, float3 b, float off) {
  const FieldSample middle = field_sample(field, 0.5f * (a + b));
  if (!middle.known) return false;
  const float slope = expand_norm(middle.gradient), length = expand_norm(b - a);
  return fabs(middle.value) <= off * length * slope &&
         fabs(vec_dot(middle.gradient, b - a)) <= EXPAND_ALONG_GRADIENT * slope * length;
}

/// Takes off the part of an edge, parameters *from to *to, that is not on the inner side of the side
/// p -> q of a triangle with the normal n. \return false where nothing is.
static bool expand_cut(float3 start, float3 end, float3 p, float3 q, float3 n, float longest,
                       float *from, float *to) {
  const float3 inward = vec_normalised(vec_cross(n, q - p));
  const float before = vec_dot(start - p, inward) - EXPAND_SHRINK * longest;
  const float after = vec_dot(end - p, inward) - EXPAND_SHRINK * longest;
  if (before < 0 && after < 0) return false;
  if (before < 0) *from = expand_most(*from, before / (before - after));
  if (after < 0) *to = expand_least(*to, before / (before - after));
  return true;
}

static bool expand_edge_crosses(float3 start, float3 end, float3 normal, const ExpandTriangle *t) {
  const float3 n = expand_unit_normal(t);
  if (!(vec_dot(n, normal) > EXPAND_SAME_SHEET)) return false;
  const float longest = expand_longest_edge(t);
  const float start_height = vec_dot(start - t->a, n), end_height = vec_dot(end - t->a, n);
  if (expand_least(fabs(start_height), fabs(end_height)) > EXPAND_SHEET_OFFSET * longest)
    return false;
  float from = 0, to = 1;
  return expand_cut(start, end, t->a, t->b, n, longest, &from, &to) &&
         expand_cut(start, end, t->b, t->c, n, longest, &from, &to) &&
         expand_cut(start, end, t->c, t->a, n, longest, &from, &to) && from < to;
}

static float expand_squared_distance(float3 p, float3 a, float3 b) {
  const float3 along = b - a;
  const float length = vec_dot(along, along);
  const float at =
      length > 0 ? expand_clamp(vec_dot(p - a, along) / length, 0.0f, 1.0f) : 0.0f;
  const float3 off = p - a - at * along;
  return vec_dot(off, off);
}

// --- Places (engine/stages/expand_place.h). ------------------------------------------------------

/// Goes `length` along the surface from p in a tangent direction, and turns the direction with it.
static bool expand_walk(const Field *field, float length, float3 *p, float3 *direction) {
  const float3 start = *p;
  *p = *p + length * *direction;
  const FieldSample at = field_project(field, EXPAND_PLACE_REACH * length, EXPAND_PLACE_STEPS, p);
  if (!at.known) return false;
  const float3 normal = vec_normalised(at.gradient), gone = *p - start;
  *direction = vec_normalised(gone - vec_dot(gone, normal) * normal);
  return true;
}

static bool expand_place_on_surface(const Field *field, float3 from, float3 direction,
                                    float length, float3 *place, float3 *normal) {
  float3 p = from, along = direction;
  if (!expand_walk(field, length, &p, &along)) {
    p = from;
    along = direction;
    if (!expand_walk(field, 0.5f * length, &p, &along) ||
        !expand_walk(field, 0.5f * length, &p, &along))
      return false;
  }
  *place = from + (length / expand_most(expand_norm(p - from), 0.5f * length)) * (p - from);
  const FieldSample at =
      field_project(field, EXPAND_PLACE_REACH * length, EXPAND_PLACE_STEPS, place);
  if (!at.known) return false;
  *normal = -vec_normalised(at.gradient);
  return true;
}
