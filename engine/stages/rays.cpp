#include "stages/rays.h"

#include "stages/predicates.h"

namespace vasamesh {

namespace {

const float* vertex(const TriangleMesh& mesh, std::uint32_t v) {
  return mesh.vertices.data() + 3 * std::size_t{v};
}

/// Sign of orient2d(a, b, p) along x, p moved by (e, e^2) in (y, z) for a vanishing e > 0.
int perturbed_side(const float* a, const float* b, const float* p) {
  if (const int side = orient2d(a, b, p, 0)) return side;
  if (a[2] != b[2]) return a[2] > b[2] ? 1 : -1;
  if (a[1] != b[1]) return b[1] > a[1] ? 1 : -1;
  return 0;
}

/// Where the line through p along x meets the plane of (a, b, c), which is not parallel to x.
double meeting_x(const float* a, const float* b, const float* c, const float* p) {
  const double uy = double{b[1]} - a[1], uz = double{b[2]} - a[2];
  const double vy = double{c[1]} - a[1], vz = double{c[2]} - a[2];
  const double py = double{p[1]} - a[1], pz = double{p[2]} - a[2];
  const double area = uy * vz - uz * vy;
  const double s = (py * vz - pz * vy) / area, t = (uy * pz - uz * py) / area;
  return a[0] + s * (double{b[0]} - a[0]) + t * (double{c[0]} - a[0]);
}

}  // namespace

int RayCaster::crossing_side(std::uint32_t triangle, const float* p) const {
  const std::uint32_t* t = mesh_.triangles.data() + 3 * std::size_t{triangle};
  const float *a = vertex(mesh_, t[0]), *b = vertex(mesh_, t[1]), *c = vertex(mesh_, t[2]);
  const int side = perturbed_side(a, b, p);
  if (side == 0 || perturbed_side(b, c, p) != side || perturbed_side(c, a, p) != side) return 0;
  return orient3d(a, b, c, p) == -side ? side : 0;
}

double RayCaster::crossing_x(std::uint32_t triangle, const float* p) const {
  const std::uint32_t* t = mesh_.triangles.data() + 3 * std::size_t{triangle};
  return meeting_x(vertex(mesh_, t[0]), vertex(mesh_, t[1]), vertex(mesh_, t[2]), p);
}

}  // namespace vasamesh
