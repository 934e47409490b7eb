/// \file
/// Vectors of three (engine/types/vec3.h), and the indicator function as the mesh stages see it:
/// value, gradient, Newton projection (engine/types/indicator_field.h). The files that come after
/// use both.

static float vec_dot(float3 a, float3 b) { return (a.x * b.x + a.y * b.y) + a.z * b.z; }

static float3 vec_cross(float3 a, float3 b) {
  return (float3)(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

/// The zero vector where the norm is zero.
static float3 vec_normalised(float3 a) {
  const float length = sqrt(vec_dot(a, a));
  return length > 0 ? (1.0f / length) * a : (float3)(0.0f);
}

typedef struct {
  int3 grid;
  float3 inverse_step;
  global const int *brick_at;
  global const float *coefficients;
} Field;

/// A kernel's arguments that are a field, and the field of them.
#define FIELD_VIEW \
  int4 grid, float4 inverse_step, VIEW(const int, brick_at), VIEW(const float, coefficients)
#define TAKE_FIELD \
  {grid.xyz, inverse_step.xyz, brick_at + brick_at_first, coefficients + coefficients_first}

typedef struct {
  float value;
  float3 gradient;
  bool known;
} FieldSample;

static void field_weights(float t, float *value, float *slope) {
  value[0] = 0.5f * ((0.5f - t) * (0.5f - t));
  value[1] = 0.75f - t * t;
  value[2] = 0.5f * ((0.5f + t) * (0.5f + t));
  slope[0] = t - 0.5f;
  slope[1] = -2.0f * t;
  slope[2] = t + 0.5f;
}

/// Finds the bricks that hold the 27 nodes round a node, at most two along each axis: entry
/// i + 2 j + 4 k counts from brick `low`. \return false where one is not there.
static bool field_bricks(const Field *field, int3 node, int3 low, int *bricks) {
  const int3 last = ((node + 1) >> 3) - low;
  for (int k = 0; k <= last.z; ++k)
    for (int j = 0; j <= last.y; ++j)
      for (int i = 0; i <= last.x; ++i) {
        const size_t cell =
            ((size_t)(low.z + k) * field->grid.y + (low.y + j)) * field->grid.x + (low.x + i);
        bricks[i + 2 * j + 4 * k] = field->brick_at[cell];
        if (bricks[i + 2 * j + 4 * k] < 0) return false;
      }
  return true;
}

/// The coefficient of a node: `side` says which of the bricks along x and y, `place` where in them.
static float field_coefficient(const Field *field, const int *bricks, int3 low, int side, int place,
                               int z) {
  const size_t brick = bricks[side + 4 * ((z >> 3) - low.z)];
  return field->coefficients[brick * BRICK_CELLS + place + 64 * (z & 7)];
}

static FieldSample field_sample(const Field *field, float3 p) {
  FieldSample sample = {0.0f, (float3)(0.0f), false};
  const float3 at = p * field->inverse_step;
  const float3 end = convert_float3(8 * field->grid - 2);
  if (!(at.x >= 1 && at.x < end.x && at.y >= 1 && at.y < end.y && at.z >= 1 && at.z < end.z))
    return sample;
  const int3 node = convert_int3(at + 0.5f), low = (node - 1) >> 3;
  const float3 t = at - convert_float3(node);
  int bricks[8];
  if (!field_bricks(field, node, low, bricks)) return sample;
  float wx[3], wy[3], wz[3], sx[3], sy[3], sz[3];
  field_weights(t.x, wx, sx);
  field_weights(t.y, wy, sy);
  field_weights(t.z, wz, sz);
  float4 plane = (float4)(0.0f), plane_x = plane, plane_y = plane;  // lanes go along z
  for (int j = 0; j < 3; ++j) {
    float4 row = (float4)(0.0f), row_x = row;
    for (int i = 0; i < 3; ++i) {
      const int x = node.x + i - 1, y = node.y + j - 1;
      const int side = ((x >> 3) - low.x) + 2 * ((y >> 3) - low.y), place = (x & 7) + 8 * (y & 7);
      const float4 c = (float4)(field_coefficient(field, bricks, low, side, place, node.z - 1),
                                field_coefficient(field, bricks, low, side, place, node.z),
                                field_coefficient(field, bricks, low, side, place, node.z + 1),
                                0.0f);
      row += wx[i] * c;
      row_x += sx[i] * c;
    }
    plane += wy[j] * row;
    plane_x += wy[j] * row_x;
    plane_y += sy[j] * row;
  }
  const float plane_at[3] = {plane.x, plane.y, plane.z},
              plane_x_at[3] = {plane_x.x, plane_x.y, plane_x.z},
              plane_y_at[3] = {plane_y.x, plane_y.y, plane_y.z};
  for (int k = 0; k < 3; ++k) {
    sample.value += wz[k] * plane_at[k];
    sample.gradient.x += wz[k] * plane_x_at[k];
    sample.gradient.y += wz[k] * plane_y_at[k];
    sample.gradient.z += sz[k] * plane_at[k];
  }
  sample.gradient *= field->inverse_step;
  sample.known = true;
  return sample;
}

/// At most `steps` Newton steps onto the zero set, none longer than `reach` in all; `known` is false
/// where they do not come within 1 % of a voxel length.
static FieldSample field_project(const Field *field, float reach, int steps, float3 *place) {
  const float near = 0.01f, there = 0.001f;
  const FieldSample none = {0.0f, (float3)(0.0f), false};
  const float3 start = *place;
  FieldSample sample = field_sample(field, *place);
  for (int step = 0; step < steps && sample.known; ++step) {
    const float squared = vec_dot(sample.gradient, sample.gradient);
    if (!(squared > 0)) return none;
    if (sample.value * sample.value <= there * there * squared) return sample;
    *place = *place - (sample.value / squared) * sample.gradient;
    const float3 moved = *place - start;
    if (!(vec_dot(moved, moved) <= reach * reach)) return none;
    sample = field_sample(field, *place);
  }
  if (!sample.known) return none;
  const float squared = vec_dot(sample.gradient, sample.gradient);
  return sample.value * sample.value <= near * near * squared ? sample : none;
}

// --- Edge lengths asked for (engine/types/sizes.h). ----------------------------------------------

typedef struct {
  int3 grid;
  float3 inverse_step;
  float elsewhere;
  global const int *brick_at;
  global const float *sizes;
  ulong count;
} Sizes;

/// A kernel's arguments that are sizes, and the sizes of them.
#define SIZES_VIEW                                                                            \
  int4 size_grid, float4 size_step, VIEW(const int, size_brick_at), VIEW(const float, sizes), \
      ulong size_count
#define TAKE_SIZES                                                                            \
  {size_grid.xyz, size_step.xyz, size_step.w, size_brick_at + size_brick_at_first,            \
   sizes + sizes_first, size_count}

/// The size of the voxel that holds a point.
static float sizes_at(const Sizes *view, float3 p) {
  const float3 at = p * view->inverse_step, end = convert_float3(8 * view->grid);
  if (!(at.x >= 0 && at.x < end.x && at.y >= 0 && at.y < end.y && at.z >= 0 && at.z < end.z))
    return view->elsewhere;
  const int3 node = convert_int3(at), brick_at = node >> 3, cell = (node >> 1) & 3;
  const int brick =
      view->brick_at[((size_t)brick_at.z * view->grid.y + brick_at.y) * view->grid.x + brick_at.x];
  if (brick < 0) return view->elsewhere;
  const size_t entry = 64 * (size_t)brick + (cell.x + 4 * (cell.y + 4 * cell.z));
  return entry < view->count ? view->sizes[entry] : view->elsewhere;
}

kernel __attribute__((BRICK_GROUP)) void field_add(float factor, VIEW(const float, b),
                                                   VIEW(float, a)) {
  TAKE(b);
  TAKE(a);
  const size_t first = get_group_id(0) * BRICK_ROWS;
  for (int row = get_local_id(0); row < BRICK_ROWS; row += BRICK_ITEMS)
    vstore8(vload8(first + row, a) + factor * vload8(first + row, b), first + row, a);
}
