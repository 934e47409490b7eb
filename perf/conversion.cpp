#include "conversion.h"

#include "stages/normals.h"
#include "stages/poisson.h"
#include "stages/quality.h"
#include "stages/surface.h"
#include "stages/verify.h"
#include "tbb/backend.h"

namespace vasamesh {
namespace {

// Operations a point, cell, node or triangle; see docs/performance.md.
constexpr double kNormalOperations = 1000;  // 60 rows of the gradient, 10 neighbours, one Jacobi
constexpr double kSplatOperations = 6 * 6 * 6 * 4;
constexpr double kIterationOperations = 22;  // 7-point operator, two dot products, three updates
constexpr double kIterationBytes = 9 + 24 + 12;
constexpr double kSampleOperations = 90;  // 27 products of three weights
constexpr double kNodeOperations = 12;    // the spline at half steps, an axis at a time
constexpr double kVertexOperations = 12;
constexpr double kTriangleOperations = 60;
constexpr double kPointBytes = 10 * 4;

Context make_tbb_context(int threads) {
  Context context;
  context.backends.push_back(make_tbb_backend(threads, nullptr));
  return context;
}

double bit_bytes(const BitVolume& object) {
  return 8.0 * static_cast<double>(object.view().word_count());
}

double cell_count(const Octree& octree) {
  double cells = 0;
  for (const OctreeLevel& level : octree.levels)
    cells += static_cast<double>(level.bricks.count * kBrickCells);
  return cells;
}

}  // namespace

Conversion::Conversion(const Phantom& phantom, int threads)
    : phantom_(phantom),
      context_(make_tbb_context(threads)),
      scheduler_(context_),
      backend_(scheduler_.host()),
      scale_(make_scale(phantom.geometry)) {}

void Conversion::pack() { object_ = pack_volume(backend_, phantom_.view()); }
void Conversion::examine() {
  solid_ =
      examine_solid(backend_, object_.view(), phantom_.geometry.size, parameters_.connectivity);
}
void Conversion::extract() { points_ = extract_points(backend_, object_, scale_); }
void Conversion::estimate() { estimate_normals(backend_, object_, scale_, parameters_, points_); }
void Conversion::build_tree() { octree_ = build_octree(backend_, points_, scale_, parameters_); }
void Conversion::assemble() { assemble_poisson(backend_, points_, scale_, parameters_, octree_); }
void Conversion::solve() {
  levels_.clear();
  solve_poisson(scheduler_, parameters_, octree_, levels_);
}
void Conversion::subtract() { subtract_isovalue(backend_, points_, scale_, octree_); }
void Conversion::label() {
  lattice_ = build_lattice(backend_, object_, points_, scale_, octree_, parameters_);
}
void Conversion::relabel_nodes() { relabelled_ = relabel(scheduler_, scale_, lattice_, nullptr); }
void Conversion::make_surface() {
  mesh_ = extract_base_surface(backend_, lattice_);
  place_in_space(backend_, phantom_.geometry, parameters_.space, mesh_);
}
void Conversion::check() {
  const SolidMatch wanted{&solid_, phantom_.geometry, parameters_.space};
  check_surface(backend_, mesh_, &wanted);
}
void Conversion::measure() { measure_quality(backend_, mesh_); }

Floor Conversion::pack_floor() const {
  return {static_cast<double>(phantom_.voxels.size()) + bit_bytes(object_), 0};
}
Floor Conversion::examine_floor() const { return {bit_bytes(object_), 0}; }
Floor Conversion::extract_floor() const {
  return {bit_bytes(object_) + static_cast<double>(points_.count) * kPointBytes +
              4.0 * static_cast<double>(points_.voxel_start.size()),
          0};
}
Floor Conversion::estimate_floor() const {
  const auto count = static_cast<double>(points_.count);
  return {count * kPointBytes, count * kNormalOperations};
}
Floor Conversion::build_tree_floor() const {
  // One flag a cell, and 54 indices a brick.
  const double cells = cell_count(octree_);
  return {cells * (1 + 54 * 4.0 / kBrickCells), 0};
}
Floor Conversion::assemble_floor() const {
  const auto count = static_cast<double>(points_.count + points_.thin_count);
  return {4 * cell_count(octree_) + count * 7 * 4, count * kSplatOperations};
}
double Conversion::solved_cells() const {
  double cells = 0;
  for (const LevelReport& level : levels_)
    cells += static_cast<double>(level.nodes) * level.iterations;
  return cells;
}
Floor Conversion::solve_floor() const {
  return {solved_cells() * kIterationBytes, solved_cells() * kIterationOperations};
}
Floor Conversion::subtract_floor() const {
  const auto count = static_cast<double>(points_.count);
  return {8 * cell_count(octree_) + count * 6 * 4, count * 2 * kSampleOperations};
}
Floor Conversion::label_floor() const {
  const auto nodes = static_cast<double>(lattice_.values.size());
  return {nodes * 5 + 4 * cell_count(octree_), nodes * kNodeOperations};
}
Floor Conversion::relabel_floor() const {
  // Labels and values once in each pass, over all nodes.
  const double passes = 1 + relabelled_.repair_passes;
  return {static_cast<double>(lattice_.values.size()) * 5 * passes, 0};
}
double Conversion::mesh_bytes() const {
  return 4.0 * static_cast<double>(mesh_.vertices.size() + mesh_.triangles.size());
}
Floor Conversion::surface_floor() const {
  return {static_cast<double>(lattice_.values.size()) * 5 + mesh_bytes(),
          static_cast<double>(mesh_.vertex_count()) * kVertexOperations};
}
Floor Conversion::mesh_floor() const {
  return {mesh_bytes(), static_cast<double>(mesh_.triangle_count()) * kTriangleOperations};
}

}  // namespace vasamesh
