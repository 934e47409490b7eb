#include "reference/points_reference.h"

#include <algorithm>

namespace vasamesh::reference {

namespace {

using Cell = std::array<int, 3>;

/// A face of a voxel or subvoxel that it shares with an object voxel.
struct Face {
  std::array<double, 3> centre, area;
  int axis;
};

template <class Body>
void for_each_voxel(const DenseVolume& volume, const Body& body) {
  for (int z = 0; z < volume.size[2]; ++z)
    for (int y = 0; y < volume.size[1]; ++y)
      for (int x = 0; x < volume.size[0]; ++x) body(Cell{x, y, z});
}

bool object_at(const DenseVolume& volume, const Cell& c) { return volume.object(c[0], c[1], c[2]); }

/// How many of the cube of `reach` round a voxel are object.
int count_near(const DenseVolume& volume, const Cell& c, int reach) {
  int count = 0;
  for (int z = c[2] - reach; z <= c[2] + reach; ++z)
    for (int y = c[1] - reach; y <= c[1] + reach; ++y)
      for (int x = c[0] - reach; x <= c[0] + reach; ++x) count += volume.object(x, y, z);
  return count;
}

DenseVolume with_at_least(const DenseVolume& volume, int least) {
  DenseVolume result(volume.size);
  for_each_voxel(volume, [&](const Cell& c) {
    result.at(c[0], c[1], c[2]) = count_near(volume, c, 1) >= least;
  });
  return result;
}

/// The shared face of the box at `corner` on one side of an axis.
Face face_of(const std::array<double, 3>& corner, double size, int axis, int side,
             const Scale& scale) {
  Face face{corner, {0, 0, 0}, axis};
  for (double& c : face.centre) c += size / 2;
  face.centre[axis] = corner[axis] + size * side;
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  const double area = size * scale[u] * size * scale[v];
  face.area[axis] = side == 0 ? area : -area;  // the object is beyond the face
  return face;
}

Point merge(const std::vector<Face>& faces, const Cell& voxel, bool refined) {
  Point point{voxel, {0, 0, 0}, {0, 0, 0}, 0, refined};
  for (const Face& face : faces)
    for (int axis = 0; axis < 3; ++axis) {
      point.position[axis] += face.centre[axis] / static_cast<double>(faces.size());
      point.area[axis] += face.area[axis];
    }
  return point;
}

Cell beside(Cell voxel, int axis, int side) {
  voxel[axis] += side == 0 ? -1 : 1;
  return voxel;
}

std::vector<Point> subvoxel_points(const DenseVolume& object, const Cell& voxel,
                                   const Scale& scale) {
  std::vector<Point> points;
  for (int s = 0; s < 8; ++s) {
    std::vector<Face> faces;
    const Cell half{s & 1, s >> 1 & 1, s >> 2};
    const std::array<double, 3> corner{voxel[0] + half[0] / 2.0, voxel[1] + half[1] / 2.0,
                                       voxel[2] + half[2] / 2.0};
    for (int axis = 0; axis < 3; ++axis)
      if (object_at(object, beside(voxel, axis, half[axis])))
        faces.push_back(face_of(corner, 0.5, axis, half[axis], scale));
    if (!faces.empty()) points.push_back(merge(faces, voxel, true));
  }
  return points;
}

std::vector<Point> voxel_points(const DenseVolume& object, const Cell& voxel, const Scale& scale) {
  std::vector<Face> faces;
  for (int axis = 0; axis < 3; ++axis)
    for (int side = 0; side < 2; ++side)
      if (object_at(object, beside(voxel, axis, side)))
        faces.push_back(
            face_of({double(voxel[0]), double(voxel[1]), double(voxel[2])}, 1, axis, side, scale));
  const bool opposite =
      std::adjacent_find(faces.begin(), faces.end(), [](const Face& a, const Face& b) {
        return a.axis == b.axis;
      }) != faces.end();
  if (!opposite) return {merge(faces, voxel, false)};
  std::vector<Point> points;
  for (const Face& face : faces) points.push_back(merge({face}, voxel, false));
  return points;
}

/// Brick in raster order, then voxel in raster order.
std::array<int, 6> order_key(const Cell& v) {
  return {v[2] / 8, v[1] / 8, v[0] / 8, v[2], v[1], v[0]};
}

}  // namespace

DenseVolume padded(const DenseVolume& volume) {
  DenseVolume result({(volume.size[0] + 2 * kPad + 7) / 8 * 8,
                      (volume.size[1] + 2 * kPad + 7) / 8 * 8,
                      (volume.size[2] + 2 * kPad + 7) / 8 * 8});
  for_each_voxel(volume, [&](const Cell& c) {
    result.at(c[0] + kPad, c[1] + kPad, c[2] + kPad) = object_at(volume, c);
  });
  return result;
}

DenseVolume eroded(const DenseVolume& volume) { return with_at_least(volume, 27); }
DenseVolume dilated(const DenseVolume& volume) { return with_at_least(volume, 1); }

DenseVolume top_hat(const DenseVolume& volume) {
  const DenseVolume opened = dilated(eroded(volume));
  DenseVolume result(volume.size);
  for_each_voxel(volume, [&](const Cell& c) {
    result.at(c[0], c[1], c[2]) = object_at(volume, c) && !object_at(opened, c);
  });
  return result;
}

bool is_outer_boundary(const DenseVolume& volume, const Cell& voxel) {
  if (object_at(volume, voxel)) return false;
  for (int axis = 0; axis < 3; ++axis)
    for (int side = 0; side < 2; ++side)
      if (object_at(volume, beside(voxel, axis, side))) return true;
  return false;
}

std::vector<Point> extract_points(const DenseVolume& object, const Scale& scale) {
  const DenseVolume thin = top_hat(object), refine = dilated(thin);
  std::vector<Cell> boundary;
  for_each_voxel(object, [&](const Cell& c) {
    if (is_outer_boundary(object, c)) boundary.push_back(c);
  });
  std::sort(boundary.begin(), boundary.end(),
            [](const Cell& a, const Cell& b) { return order_key(a) < order_key(b); });
  std::vector<Point> all;
  for (const Cell& voxel : boundary) {
    const double thickness = 1 - static_cast<double>(count_near(thin, voxel, 2)) /
                                     static_cast<double>(count_near(object, voxel, 2));
    for (Point& point : object_at(refine, voxel) ? subvoxel_points(object, voxel, scale)
                                                 : voxel_points(object, voxel, scale)) {
      point.thickness = thickness;
      all.push_back(point);
    }
  }
  return all;
}

}  // namespace vasamesh::reference
