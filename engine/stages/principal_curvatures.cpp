#include "stages/principal_curvatures.h"

#include <array>
#include <cmath>

#include "backend/ranges.h"
#include "stages/adjacency.h"
#include "types/mesh_vertex.h"

namespace vasamesh {

namespace {

constexpr std::size_t kGrain = 16384;  // triangles or vertices a task takes

struct Triangle {
  std::array<std::uint32_t, 3> v;
  std::array<Vec3, 3> edge;  ///< edge i lies across from corner i
};

Triangle triangle_of(const TriangleMesh& mesh, std::size_t t) {
  Triangle found;
  for (std::size_t i = 0; i < 3; ++i) found.v[i] = mesh.triangles[3 * t + i];
  for (std::size_t i = 0; i < 3; ++i)
    found.edge[i] = vertex_at(mesh, found.v[(i + 2) % 3]) - vertex_at(mesh, found.v[(i + 1) % 3]);
  return found;
}

/// The part of the triangle that is nearest to each corner (Voronoi's), as Meyer et al. have it:
/// where an angle is obtuse, half of the area goes to its corner and a quarter to each other.
std::array<float, 3> corner_areas(const Triangle& t) {
  const float twice = norm(cross(t.edge[0], t.edge[1]));
  if (!(twice > 0)) return {0, 0, 0};
  std::array<float, 3> cotangent, areas;
  for (std::size_t i = 0; i < 3; ++i)
    cotangent[i] = -dot(t.edge[(i + 1) % 3], t.edge[(i + 2) % 3]) / twice;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    if (cotangent[i] < 0) {
      areas[i] = 0.25f * twice;
      areas[j] = areas[k] = 0.125f * twice;
      return areas;
    }
    areas[i] =
        0.125f * (squared_norm(t.edge[j]) * cotangent[j] + squared_norm(t.edge[k]) * cotangent[k]);
  }
  return areas;
}

/// Two unit vectors in the plane of a unit normal.
struct Frame {
  Vec3 u, v, normal;
};

Frame frame_of(const Vec3& normal) {
  const Vec3 u = any_tangent(normal);
  return {u, cross(normal, u), normal};
}

/// The frame turned the shortest way so that its normal is `to`.
Frame turned(const Frame& frame, const Vec3& to) {
  const float cosine = dot(frame.normal, to);
  if (cosine <= -0.9999f) return {-frame.u, -frame.v, to};
  const Vec3 across = to - cosine * frame.normal;
  const Vec3 step = (1 / (1 + cosine)) * (frame.normal + to);
  return {frame.u - dot(frame.u, across) * step, frame.v - dot(frame.v, across) * step, to};
}

/// A symmetric tensor of a tangent plane, in some frame of it: uu, uv, vv.
struct Tensor {
  double uu = 0, uv = 0, vv = 0;
};

/// A triangle's tensor and the frame that it stands in; no area, no tensor.
struct FaceTensor {
  Frame frame;
  Tensor tensor;
  std::array<float, 3> areas{0, 0, 0};
};

/// The tensor of the least sum over the edges of |tensor edge - difference of normals|^2.
Tensor fit(const std::array<std::array<double, 2>, 3>& edges,
           const std::array<std::array<double, 2>, 3>& turns) {
  double a = 0, b = 0, c = 0, p = 0, q = 0, r = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& [eu, ev] = edges[i];
    const auto& [nu, nv] = turns[i];
    a += eu * eu, b += eu * ev, c += ev * ev;
    p += nu * eu, q += nu * ev + nv * eu, r += nv * ev;
  }
  // (a b 0; b a + c b; 0 b c) (uu uv vv) = (p q r); its determinant is (a + c) (a c - b b).
  const double determinant = (a + c) * (a * c - b * b);
  if (!(determinant > 0)) return {};
  const double uv = (a * c * q - b * c * p - a * b * r) / determinant;
  return {(p - b * uv) / a, uv, (r - b * uv) / c};
}

FaceTensor face_tensor(const TriangleMesh& mesh, std::size_t t, const std::vector<Vec3>& normals) {
  const Triangle triangle = triangle_of(mesh, t);
  FaceTensor found;
  found.areas = corner_areas(triangle);
  if (found.areas[0] + found.areas[1] + found.areas[2] <= 0) return found;
  const Vec3 normal = normalised(cross(triangle.edge[0], triangle.edge[1]));
  const Vec3 u = normalised(triangle.edge[0]);
  found.frame = {u, cross(normal, u), normal};
  std::array<std::array<double, 2>, 3> edges, turns;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 turn = normals[triangle.v[(i + 2) % 3]] - normals[triangle.v[(i + 1) % 3]];
    edges[i] = {dot(triangle.edge[i], found.frame.u), dot(triangle.edge[i], found.frame.v)};
    turns[i] = {dot(turn, found.frame.u), dot(turn, found.frame.v)};
  }
  found.tensor = fit(edges, turns);
  return found;
}

Tensor in_frame(const FaceTensor& face, const Frame& frame) {
  const Frame flat = turned(frame, face.frame.normal);
  const double uu = dot(flat.u, face.frame.u), uv = dot(flat.u, face.frame.v);
  const double vu = dot(flat.v, face.frame.u), vv = dot(flat.v, face.frame.v);
  const Tensor& t = face.tensor;
  return {uu * uu * t.uu + 2 * uu * uv * t.uv + uv * uv * t.vv,
          uu * vu * t.uu + (uu * vv + uv * vu) * t.uv + uv * vv * t.vv,
          vu * vu * t.uu + 2 * vu * vv * t.uv + vv * vv * t.vv};
}

/// Max: Weights for computing vertex normals from facet normals, 1999; exact on spheres.
std::vector<Vec3> vertex_normals(Backend& backend, const TriangleMesh& mesh,
                                 const VertexCorners& corners) {
  std::vector<Vec3> normals(mesh.vertex_count());
  for_each_index(backend, normals.size(), kGrain, [&](std::size_t v) {
    Vec3 sum;
    for (std::uint32_t i = corners.first[v]; i < corners.first[v + 1]; ++i) {
      const std::uint32_t c = corners.corner[i];
      const Triangle t = triangle_of(mesh, c / 3);
      const Vec3 &before = t.edge[(c + 1) % 3], &after = t.edge[(c + 2) % 3];
      const float weight = squared_norm(before) * squared_norm(after);
      if (weight > 0) sum = sum + (1 / weight) * cross(before, after);
    }
    normals[v] = normalised(sum);
  });
  return normals;
}

}  // namespace

PrincipalCurvatures principal_curvatures(Backend& backend, const TriangleMesh& mesh) {
  const VertexCorners corners = vertex_corners(backend, mesh);
  const std::vector<Vec3> normals = vertex_normals(backend, mesh, corners);
  std::vector<FaceTensor> faces(mesh.triangle_count());
  for_each_index(backend, faces.size(), kGrain,
                 [&](std::size_t t) { faces[t] = face_tensor(mesh, t, normals); });
  const std::size_t count = mesh.vertex_count();
  PrincipalCurvatures found{std::vector<float>(count, 0), std::vector<float>(count, 0),
                            std::vector<float>(count, 0)};
  for_each_index(backend, count, kGrain, [&](std::size_t v) {
    const Frame frame = frame_of(normals[v]);
    Tensor sum;
    double area = 0;
    for (std::uint32_t i = corners.first[v]; i < corners.first[v + 1]; ++i) {
      const std::uint32_t c = corners.corner[i];
      const double share = faces[c / 3].areas[c % 3];
      if (!(share > 0)) continue;
      const Tensor t = in_frame(faces[c / 3], frame);
      sum = {sum.uu + share * t.uu, sum.uv + share * t.uv, sum.vv + share * t.vv};
      area += share;
    }
    if (!(area > 0)) return;
    const double mean = 0.5 * (sum.uu + sum.vv) / area, half = 0.5 * (sum.uu - sum.vv) / area;
    const double spread = std::sqrt(half * half + sum.uv * sum.uv / (area * area));
    found.most[v] = static_cast<float>(mean + spread);
    found.least[v] = static_cast<float>(mean - spread);
    found.area[v] = static_cast<float>(area);
  });
  return found;
}

std::vector<float> PrincipalCurvatures::rms() const {
  std::vector<float> values(most.size());
  for (std::size_t v = 0; v < values.size(); ++v)
    values[v] = std::sqrt(0.5f * (most[v] * most[v] + least[v] * least[v]));
  return values;
}

}  // namespace vasamesh
