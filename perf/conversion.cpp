#include "conversion.h"

#include "stages/normals.h"
#include "stages/poisson.h"
#include "stages/quality.h"
#include "stages/surface.h"
#include "stages/verify.h"
#include "tbb/backend.h"

namespace vasamesh {
namespace {

Context make_tbb_context(int threads) {
  Context context;
  context.backends.push_back(make_tbb_backend(threads, nullptr));
  return context;
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
void Conversion::assemble_anew() {
  build_tree();
  assemble();
}
void Conversion::solve_anew() {
  assemble_anew();
  solve();
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

Work Conversion::pack_floor() const { return pack_work(voxel_count()); }
Work Conversion::examine_floor() const { return examine_work(voxel_count()); }
Work Conversion::extract_floor() const { return points_work(voxel_count(), point_count()); }
Work Conversion::estimate_floor() const { return normals_work(point_count()); }
Work Conversion::build_tree_floor() const { return build_work(cell_count(octree_)); }
Work Conversion::assemble_floor() const {
  const double thin = static_cast<double>(points_.thin_count);
  return assemble_work(cell_count(octree_), point_count() + thin);
}
Work Conversion::solve_floor() const {
  double cell_iterations = 0;
  for (const LevelReport& level : levels_)
    cell_iterations += static_cast<double>(level.nodes) * level.iterations;
  return solve_work(cell_iterations);
}
Work Conversion::subtract_floor() const {
  return isovalue_work(cell_count(octree_), point_count());
}
Work Conversion::label_floor() const { return label_work(cell_count(octree_), node_count()); }
Work Conversion::relabel_floor() const {
  return relabel_work(node_count(), 1 + relabelled_.repair_passes);
}
Work Conversion::surface_floor() const {
  return surface_work(node_count(), static_cast<double>(mesh_.vertex_count()),
                      static_cast<double>(mesh_.triangle_count()));
}
Work Conversion::mesh_floor() const {
  return examine_mesh_work(static_cast<double>(mesh_.vertex_count()),
                           static_cast<double>(mesh_.triangle_count()));
}

double Conversion::voxel_count() const { return static_cast<double>(phantom_.voxels.size()); }
double Conversion::point_count() const { return static_cast<double>(points_.count); }
double Conversion::node_count() const { return static_cast<double>(lattice_.values.size()); }

}  // namespace vasamesh
