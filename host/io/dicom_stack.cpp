#include "io/dicom_stack.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "io/io_error.h"
#include "median.h"

namespace vasamesh {
namespace {

constexpr double kStepTolerance = 0.1;    // of the usual step
constexpr double kLeastStep = 1e-3;       // of the largest step; below, slices lie in one place
constexpr double kPlaneTolerance = 1e-3;  // of directions, and of the spacing
constexpr double kUnitTolerance = 0.02;   // of the length of directions, which may be rounded
constexpr char kPlaceIt[] =
    "export the series with positions, or write it as NIfTI or NRRD with the right spacing";

struct Plane {
  std::size_t file_index = 0, frame_index = 0;
  const DicomFile* file = nullptr;
  const DicomFrame* frame = nullptr;
  double depth = 0;  ///< of the position, along the normal of the first plane

  const Vec3d& position() const { return *frame->position; }
  std::string name() const {
    return file->frame_count == 1 ? "this slice" : fmt::format("its frame {}", frame_index + 1);
  }
};

double length_of(const Vec3d& a) { return std::sqrt(dot(a, a)); }

[[noreturn]] void throw_plane(const Plane& plane, const std::string& reason,
                              const std::string& remedy) {
  throw_bad_input(plane.file->path, plane.name() + " " + reason, remedy);
}

void check_file(const DicomFile& file) {
  if (file.has_float_pixels)
    throw_bad_input(file.path, "its voxels are DICOM's floating-point numbers",
                    "write it with integers, or as NIfTI or NRRD");
  if (file.columns < 1 || file.rows < 1 || file.bits_allocated < 1)
    throw_bad_input(file.path, "it does not state the size of its pixels (Rows, Columns, bits)",
                    "get a whole copy of the series");
  if (file.frames.empty())
    throw_bad_input(file.path,
                    fmt::format("the positions of its {} frames are missing (functional groups)",
                                file.frame_count),
                    kPlaceIt);
  if (static_cast<std::int64_t>(file.frames.size()) != file.frame_count)
    throw_bad_input(file.path,
                    fmt::format("it holds {} frames and describes {} (functional groups)",
                                file.frame_count, file.frames.size()),
                    "export it again");
}

void check_spacing(const Plane& plane) {
  const auto& spacing = plane.frame->spacing;
  if (!spacing && plane.file->has_imager_spacing)
    throw_bad_input(
        plane.file->path,
        "it has no PixelSpacing (0028,0030), only ImagerPixelSpacing, which is that "
        "at the detector",
        "add PixelSpacing, or write the series as NIfTI or NRRD with the right spacing");
  if (!spacing)
    throw_bad_input(plane.file->path, "it has no PixelSpacing (0028,0030)",
                    "add it, or write the series as NIfTI or NRRD with the right spacing");
  if ((*spacing)[0] > 0 && (*spacing)[1] > 0) return;
  throw_bad_input(plane.file->path,
                  fmt::format("its PixelSpacing (0028,0030) is {:.6g} x {:.6g} mm", (*spacing)[1],
                              (*spacing)[0]),
                  "correct it, or write the series as NIfTI or NRRD with the right spacing");
}

void check_orientation(const Plane& plane) {
  if (!plane.frame->orientation) return;
  const auto& [row, column] = *plane.frame->orientation;
  const double a = length_of(row), b = length_of(column);
  if (std::abs(a - 1) <= kUnitTolerance && std::abs(b - 1) <= kUnitTolerance &&
      std::abs(dot(row, column)) <= kPlaneTolerance * a * b)
    return;
  throw_plane(plane, "has an ImageOrientationPatient that is not two perpendicular unit vectors",
              "correct it, or resample the volume on orthogonal axes");
}

void check_rescaling(const Plane& plane) {
  if (plane.frame->rescaling == plane.file->frames.front().rescaling) return;
  throw_plane(plane, "is rescaled in another way than the first",
              "write the series with one rescaling, or as NIfTI or NRRD");
}

/// All frames, in the order of the files.
std::vector<Plane> planes_of(const std::vector<DicomFile>& files) {
  std::vector<Plane> planes;
  for (std::size_t i = 0; i < files.size(); ++i) {
    check_file(files[i]);
    for (std::size_t k = 0; k < files[i].frames.size(); ++k)
      planes.push_back({i, k, &files[i], &files[i].frames[k]});
  }
  for (const Plane& plane : planes) {
    check_spacing(plane);
    check_orientation(plane);
    check_rescaling(plane);
  }
  return planes;
}

void check_segments(const std::vector<Plane>& planes) {
  std::set<std::int64_t> segments;
  for (const Plane& plane : planes) segments.insert(plane.frame->segment);
  if (segments.size() == 1) return;
  throw_bad_input(planes.front().file->path, fmt::format("it holds {} segments", segments.size()),
                  "export one segment alone, or a label map as NIfTI or NRRD");
}

void check_placed(const Plane& plane) {
  if (!plane.frame->position)
    throw_plane(plane, "has no position (ImagePositionPatient (0020,0032))", kPlaceIt);
  if (!plane.frame->orientation)
    throw_plane(plane, "has no orientation (ImageOrientationPatient (0020,0037))", kPlaceIt);
}

void check_same_plane(const Plane& first, const Plane& plane) {
  bool same = first.file->columns == plane.file->columns && first.file->rows == plane.file->rows;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const Vec3d turn = (*first.frame->orientation)[axis] - (*plane.frame->orientation)[axis];
    const double spacing = (*first.frame->spacing)[axis];
    same &= length_of(turn) < kPlaneTolerance;
    same &= std::abs(spacing - (*plane.frame->spacing)[axis]) < kPlaneTolerance * spacing;
  }
  if (same) return;
  throw_plane(plane, "differs in size, spacing or orientation from the first, " + first.file->path,
              "keep one series of parallel slices in the folder");
}

/// Between slices that do not lie in one place; 0 where all do.
double usual_step(const std::vector<Plane>& planes) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < planes.size(); ++i)
    steps.push_back(planes[i].depth - planes[i - 1].depth);
  const double largest = *std::max_element(steps.begin(), steps.end());
  std::erase_if(steps, [&](double step) { return step <= kLeastStep * largest; });
  return steps.empty() ? 0 : median(steps);
}

/// Along the normal, from each slice to the next.
void check_steps(const std::vector<Plane>& planes, double usual) {
  if (usual == 0)
    throw_bad_input(planes.front().file->path,
                    "its slices have no positions of their own: ImagePositionPatient is the same "
                    "in all",
                    kPlaceIt);
  for (std::size_t i = 1; i < planes.size(); ++i) {
    const double step = planes[i].depth - planes[i - 1].depth;
    if (std::abs(step - usual) <= kStepTolerance * usual) continue;
    if (step <= kLeastStep * usual)
      throw_plane(planes[i],
                  planes[i].file == planes[i - 1].file
                      ? "lies where " + planes[i - 1].name() + " lies"
                      : "lies where that of " + planes[i - 1].file->path + " lies",
                  "give one volume, with every slice once");
    throw_plane(planes[i],
                fmt::format("is {:.6g} mm from the one before, others {:.6g} mm", step, usual),
                planes[i].file->frame_count == 1 ? "give every slice once"
                                                 : "export every frame once, empty ones too");
  }
}

/// \throws Error bad_input where `offset`, without its part along `normal`, is too large.
void check_offset(const Plane& plane, const Vec3d& offset, const Vec3d& normal, double usual) {
  const double length = length_of(offset - dot(offset, normal) * normal);
  if (length <= kStepTolerance * usual) return;
  throw_plane(plane, fmt::format("is displaced by {:.6g} mm within its plane", length),
              "correct its position, or resample the volume on orthogonal axes");
}

/// Slices may step sideways, each as the others: the geometry then shows as sheared. A step that is
/// unlike the others tells the slice; the line from first to last, whether small ones add up.
void check_sideways(const std::vector<Plane>& planes, const Vec3d& normal, double usual) {
  std::array<std::vector<double>, 3> steps;
  for (std::size_t i = 1; i < planes.size(); ++i) {
    const Vec3d step = planes[i].position() - planes[i - 1].position();
    steps[0].push_back(step.x);
    steps[1].push_back(step.y);
    steps[2].push_back(step.z);
  }
  const Vec3d typical{median(steps[0]), median(steps[1]), median(steps[2])};
  for (std::size_t i = 1; i < planes.size(); ++i)
    check_offset(planes[i], planes[i].position() - planes[i - 1].position() - typical, normal,
                 usual);
  const Plane &first = planes.front(), &last = planes.back();
  const Vec3d way = (1 / (last.depth - first.depth)) * (last.position() - first.position());
  for (const Plane& plane : planes)
    check_offset(plane, plane.position() - first.position() - (plane.depth - first.depth) * way,
                 normal, usual);
}

/// Size, spacing and direction of the plane itself; one slice is as thick as it says.
Geometry plane_geometry(const Plane& plane) {
  Geometry geometry;
  const auto& spacing = *plane.frame->spacing;
  const double thickness = plane.frame->thickness;
  geometry.size = {plane.file->columns, plane.file->rows, 1};
  geometry.spacing = {spacing[0], spacing[1],
                      thickness > 0 ? thickness : std::sqrt(spacing[0] * spacing[1])};
  const Vec3d position = plane.frame->position.value_or(Vec3d{});
  geometry.origin = {position.x, position.y, position.z};
  const auto axes = plane.frame->orientation.value_or(std::array<Vec3d, 2>{{{1, 0, 0}, {0, 1, 0}}});
  const Vec3d row = (1 / length_of(axes[0])) * axes[0];
  const Vec3d column = (1 / length_of(axes[1])) * axes[1];
  const Vec3d normal = cross(row, column);
  geometry.direction = {row.x,    column.x, normal.x, row.y,   column.y,
                        normal.y, row.z,    column.z, normal.z};
  return geometry;
}

Vec3d normal_of(const Geometry& geometry) {
  return {geometry.direction[2], geometry.direction[5], geometry.direction[8]};
}

/// Puts the planes in order along `normal`.
void sort_planes(std::vector<Plane>& planes, const Vec3d& normal) {
  for (Plane& plane : planes) plane.depth = dot(plane.position(), normal);
  std::stable_sort(planes.begin(), planes.end(),
                   [](const Plane& a, const Plane& b) { return a.depth < b.depth; });
}

/// \param planes  sorted, two at least.
Geometry stack_geometry(const std::vector<Plane>& planes) {
  Geometry geometry = plane_geometry(planes.front());
  const Vec3d way = planes.back().position() - planes.front().position();
  const Vec3d axis = (1 / length_of(way)) * way;
  geometry.size[2] = static_cast<std::int64_t>(planes.size());
  geometry.spacing[2] =
      (planes.back().depth - planes.front().depth) / static_cast<double>(planes.size() - 1);
  geometry.direction[2] = axis.x;
  geometry.direction[5] = axis.y;
  geometry.direction[8] = axis.z;
  return geometry;
}

}  // namespace

DicomStack dicom_stack(const std::vector<DicomFile>& files) {
  std::vector<Plane> planes = planes_of(files);
  check_segments(planes);
  if (planes.size() == 1) return {plane_geometry(planes.front()), {{0}}};
  for (const Plane& plane : planes) {
    check_placed(plane);
    check_same_plane(planes.front(), plane);
  }
  const Vec3d normal = normal_of(plane_geometry(planes.front()));
  sort_planes(planes, normal);
  const double usual = usual_step(planes);
  check_steps(planes, usual);
  check_sideways(planes, normal, usual);
  DicomStack stack{stack_geometry(planes), {}};
  for (const DicomFile& file : files) stack.slices.emplace_back(file.frames.size());
  for (std::size_t i = 0; i < planes.size(); ++i)
    stack.slices[planes[i].file_index][planes[i].frame_index] = i;
  return stack;
}

}  // namespace vasamesh
