/// \file
/// The indicator function as the mesh stages see it: value, gradient, Newton projection
/// (engine/types/indicator_field.h), and the radius of curvature (eq. 5 of the paper;
/// engine/stages/sizing.h). Contract: engine/backend/backend.h.

typedef struct {
  int3 grid;
  float3 inverse_step;
  global const int *brick_at;
  global const float *coefficients;
} SizingField;

typedef struct {
  float value;
  float3 gradient;
  bool known;
} SizingSample;

static float sizing_dot(float3 a, float3 b) { return (a.x * b.x + a.y * b.y) + a.z * b.z; }

static float3 sizing_cross(float3 a, float3 b) {
  return (float3)(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

/// The zero vector where the norm is zero.
static float3 sizing_normalised(float3 a) {
  const float length = sqrt(sizing_dot(a, a));
  return length > 0 ? (1.0f / length) * a : (float3)(0.0f);
}

static void sizing_weights(float t, float *value, float *slope) {
  value[0] = 0.5f * ((0.5f - t) * (0.5f - t));
  value[1] = 0.75f - t * t;
  value[2] = 0.5f * ((0.5f + t) * (0.5f + t));
  slope[0] = t - 0.5f;
  slope[1] = -2.0f * t;
  slope[2] = t + 0.5f;
}

/// Finds the bricks that hold the 27 nodes round a node, at most two along each axis: entry
/// i + 2 j + 4 k counts from brick `low`. \return false where one is not there.
static bool sizing_bricks(const SizingField *field, int3 node, int3 low, int *bricks) {
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

static SizingSample sizing_sample(const SizingField *field, float3 p) {
  SizingSample sample = {0.0f, (float3)(0.0f), false};
  const float3 at = p * field->inverse_step;
  const float3 end = convert_float3(8 * field->grid - 2);
  if (!(at.x >= 1 && at.x < end.x && at.y >= 1 && at.y < end.y && at.z >= 1 && at.z < end.z))
    return sample;
  const int3 node = convert_int3(at + 0.5f), low = (node - 1) >> 3;
  const float3 t = at - convert_float3(node);
  int bricks[8];
  if (!sizing_bricks(field, node, low, bricks)) return sample;
  float wx[3], wy[3], wz[3], sx[3], sy[3], sz[3];
  sizing_weights(t.x, wx, sx);
  sizing_weights(t.y, wy, sy);
  sizing_weights(t.z, wz, sz);
  for (int k = 0; k < 3; ++k) {
    const int z = node.z + k - 1;
    float plane = 0, plane_x = 0, plane_y = 0;
    for (int j = 0; j < 3; ++j) {
      const int y = node.y + j - 1;
      const int side = 2 * ((y >> 3) - low.y) + 4 * ((z >> 3) - low.z);
      float row = 0, row_x = 0;
      for (int i = 0; i < 3; ++i) {
        const int x = node.x + i - 1;
        const float c = field->coefficients[(size_t)bricks[side + ((x >> 3) - low.x)] * BRICK_CELLS +
                                            (x & 7) + 8 * (y & 7) + 64 * (z & 7)];
        row += wx[i] * c;
        row_x += sx[i] * c;
      }
      plane += wy[j] * row;
      plane_x += wy[j] * row_x;
      plane_y += sy[j] * row;
    }
    sample.value += wz[k] * plane;
    sample.gradient.x += wz[k] * plane_x;
    sample.gradient.y += wz[k] * plane_y;
    sample.gradient.z += sz[k] * plane;
  }
  sample.gradient *= field->inverse_step;
  sample.known = true;
  return sample;
}

/// Newton steps onto the zero set, none longer than `reach` in all; `known` is false where they do
/// not come within 1 % of a voxel length.
static SizingSample sizing_project(const SizingField *field, float reach, float3 *place) {
  const float near = 0.01f, there = 0.001f;
  const SizingSample none = {0.0f, (float3)(0.0f), false};
  const float3 start = *place;
  SizingSample sample = sizing_sample(field, *place);
  for (int step = 0; step < SIZING_STEPS && sample.known; ++step) {
    const float squared = sizing_dot(sample.gradient, sample.gradient);
    if (!(squared > 0)) return none;
    if (sample.value * sample.value <= there * there * squared) return sample;
    *place = *place - (sample.value / squared) * sample.gradient;
    const float3 moved = *place - start;
    if (!(sizing_dot(moved, moved) <= reach * reach)) return none;
    sample = sizing_sample(field, *place);
  }
  if (!sample.known) return none;
  const float squared = sizing_dot(sample.gradient, sample.gradient);
  return sample.value * sample.value <= near * near * squared ? sample : none;
}

/// A walk over the surface: where it has come to, and the tangent along which it goes on.
typedef struct {
  float3 at, direction;
} SizingWalk;

/// Goes a step on. \return the square of d / (2 sin(theta / 2)) from p; 0 where no surface is
/// found, and the walk stays where it was.
static float sizing_walk_on(const SizingField *field, float3 p, float3 normal, float step,
                            SizingWalk *walk) {
  const float least = 1e-12f, largest = SIZING_LARGEST_RADIUS * SIZING_LARGEST_RADIUS;
  float3 q = walk->at + step * walk->direction;
  const SizingSample found = sizing_project(field, step, &q);
  if (!found.known) return 0.0f;
  const float3 there = -sizing_normalised(found.gradient), along = walk->direction;
  walk->at = q;
  walk->direction = sizing_normalised(along - sizing_dot(along, there) * there);
  const float turned = sizing_dot(normal - there, normal - there);
  const float squared = sizing_dot(q - p, q - p) / (turned < least ? least : turned);
  return largest < squared ? largest : squared;
}

/// A unit vector at right angles to a unit vector: along the cross product with the axis that it is
/// farthest from.
static float3 sizing_tangent(float3 n) {
  const float3 s = n * n;
  if (s.x <= s.y && s.x <= s.z) return sizing_normalised((float3)(0.0f, n.z, -n.y));
  if (s.y <= s.z) return sizing_normalised((float3)(-n.z, 0.0f, n.x));
  return sizing_normalised((float3)(n.y, -n.x, 0.0f));
}

/// The least of the radii in six directions, at the first ring where it is not beyond the ring.
static float sizing_radius(const SizingField *field, float3 p, float3 normal) {
  const float rings[4] = {1.0f, 1.0f, 2.0f, 3.0f};
  const float cosine[6] = {1.0f, 0.5f, -0.5f, -1.0f, -0.5f, 0.5f};
  const float sine[6] = {0.0f, 0.8660254f, 0.8660254f, 0.0f, -0.8660254f, -0.8660254f};
  const float3 u = sizing_tangent(normal), v = sizing_cross(normal, u);
  SizingWalk walks[6];
  for (int i = 0; i < 6; ++i) {
    walks[i].at = p;
    walks[i].direction = cosine[i] * u + sine[i] * v;
  }
  float least = 0, far = 0;
  for (int ring = 0; ring < 4; ++ring) {
    const float step = rings[ring];
    float here = SIZING_LARGEST_RADIUS * SIZING_LARGEST_RADIUS;
    for (int i = 0; i < 6; ++i) {
      float squared = sizing_walk_on(field, p, normal, step, &walks[i]);
      if (!(squared > 0) && far == 0)
        squared = sizing_walk_on(field, p, normal, 0.5f * step, &walks[i]);
      here = squared < here ? squared : here;
    }
    if (!(here > 0) && far > 0) break;
    least = here;
    far += step;
    if (least < far * far) break;
  }
  return sqrt(least);
}

/// A work-item a sample.
kernel __attribute__((ELEMENT_GROUP)) void sizing_measure(
    ulong count, int4 grid, float4 inverse_step, VIEW(const int, brick_at),
    VIEW(const float, coefficients), VIEW(float, positions), VIEW(float, normals),
    VIEW(float, radii)) {
  const size_t i = get_global_id(0);
  if (i >= count) return;
  const SizingField field = {grid.xyz, inverse_step.xyz, brick_at + brick_at_first,
                             coefficients + coefficients_first};
  // Views of vectors count vectors.
  positions += 3 * positions_first;
  normals += 3 * normals_first;
  TAKE(radii);
  float3 p = vload3(i, positions);
  const SizingSample at = sizing_project(&field, SIZING_REACH, &p);
  const float3 normal = at.known ? -sizing_normalised(at.gradient) : (float3)(0.0f);
  if (at.known) vstore3(p, i, positions);
  vstore3(normal, i, normals);
  radii[i] = at.known ? sizing_radius(&field, p, normal) : 0.0f;
}
