#include "stages/predicates.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

namespace vasamesh {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

Kernel::Point_3 point(const float* p) { return {p[0], p[1], p[2]}; }

Kernel::Point_2 projected(const float* p, int axis) {
  return {p[(axis + 1) % 3], p[(axis + 2) % 3]};
}

}  // namespace

int orient3d(const float* a, const float* b, const float* c, const float* d) {
  return CGAL::orientation(point(a), point(b), point(c), point(d));
}

int orient2d(const float* a, const float* b, const float* c, int axis) {
  return CGAL::orientation(projected(a, axis), projected(b, axis), projected(c, axis));
}

bool collinear(const float* a, const float* b, const float* c) {
  return orient2d(a, b, c, 0) == 0 && orient2d(a, b, c, 1) == 0 && orient2d(a, b, c, 2) == 0;
}

}  // namespace vasamesh
