/// \file
/// Samples of the surface: the radius of curvature (eq. 5 of the paper; engine/stages/sizing.h).
/// Contract: engine/backend/backend.h.

/// A walk over the surface: where it has come to, and the tangent along which it goes on.
typedef struct {
  float3 at, direction;
} SizingWalk;

/// Goes a step on. \return the square of d / (2 sin(theta / 2)) from p; 0 where no surface is
/// found, and the walk stays where it was.
static float sizing_walk_on(const Field *field, float3 p, float3 normal, float step,
                            SizingWalk *walk) {
  const float least = 1e-12f, largest = SIZING_LARGEST_RADIUS * SIZING_LARGEST_RADIUS;
  float3 q = walk->at + step * walk->direction;
  const FieldSample found = field_project(field, step, SIZING_STEPS, &q);
  if (!found.known) return 0.0f;
  const float3 there = -vec_normalised(found.gradient), along = walk->direction;
  walk->at = q;
  walk->direction = vec_normalised(along - vec_dot(along, there) * there);
  const float turned = vec_dot(normal - there, normal - there);
  const float squared = vec_dot(q - p, q - p) / (turned < least ? least : turned);
  return largest < squared ? largest : squared;
}

/// A unit vector at right angles to a unit vector: along the cross product with the axis that it is
/// farthest from.
static float3 sizing_tangent(float3 n) {
  const float3 s = n * n;
  if (s.x <= s.y && s.x <= s.z) return vec_normalised((float3)(0.0f, n.z, -n.y));
  if (s.y <= s.z) return vec_normalised((float3)(-n.z, 0.0f, n.x));
  return vec_normalised((float3)(n.y, -n.x, 0.0f));
}

/// The least of the radii in six directions, at the first ring where it is not beyond the ring, or
/// ample.
static float sizing_radius(const Field *field, float3 p, float3 normal, float ample) {
  const float rings[4] = {1.0f, 1.0f, 2.0f, 3.0f};
  const float cosine[6] = {1.0f, 0.5f, -0.5f, -1.0f, -0.5f, 0.5f};
  const float sine[6] = {0.0f, 0.8660254f, 0.8660254f, 0.0f, -0.8660254f, -0.8660254f};
  const float3 u = sizing_tangent(normal), v = vec_cross(normal, u);
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
    if (least < far * far || least >= ample * ample) break;
  }
  return sqrt(least);
}

/// A work-item a sample.
kernel __attribute__((PLAIN_ELEMENT_GROUP)) void sizing_measure(
    ulong count, float ample, FIELD_VIEW, VIEW(float, positions), VIEW(float, normals),
    VIEW(float, radii)) {
  const size_t i = get_global_id(0);
  if (i >= count) return;
  const Field field = TAKE_FIELD;
  // Views of vectors count vectors.
  positions += 3 * positions_first;
  normals += 3 * normals_first;
  TAKE(radii);
  float3 p = vload3(i, positions);
  const FieldSample at = field_project(&field, SIZING_REACH, SIZING_STEPS, &p);
  const float3 normal = at.known ? -vec_normalised(at.gradient) : (float3)(0.0f);
  if (at.known) vstore3(p, i, positions);
  vstore3(normal, i, normals);
  radii[i] = at.known ? sizing_radius(&field, p, normal, ample) : 0.0f;
}
