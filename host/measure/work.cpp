#include "measure/work.h"

#include <functional>
#include <map>

namespace vasamesh {

namespace {

// Operations a point, cell, node or triangle; see docs/performance.md.
constexpr double kNormalOperations = 1000;  // 60 rows of the gradient, 10 neighbours, one Jacobi
constexpr double kSplatOperations = 6 * 6 * 6 * 4;
constexpr double kIterationOperations = 35;  // 7-point operator twice, two sums, three updates
constexpr double kIterationBytes = 5 + 21 + 12;
constexpr double kSampleOperations = 90;  // 27 products of three weights
constexpr double kNodeOperations = 12;    // the spline at half steps, an axis at a time
constexpr double kVertexOperations = 12;
constexpr double kTriangleOperations = 60;

constexpr double kPointBytes = 10 * 4;
constexpr double kNodeBytes = 5;                     // a label and a value
constexpr double kBrickTableBytes = 54 * 4 / 512.0;  // of a cell: 54 indices a brick

double mesh_bytes(double vertices, double triangles) { return 12 * (vertices + triangles); }

/// Of passes whose operations depend on what they find: that the field is read, that triangles are
/// added, that a mesh is read and written.
Work values_work(double nodes) { return {nodes * kNodeBytes, 0}; }
Work added_work(std::int64_t triangles) {
  return {mesh_bytes(0, static_cast<double>(triangles)), 0};
}
Work remake_work(double vertices, double triangles) {
  return {2 * mesh_bytes(vertices, triangles), 0};
}

/// What a report counts, as the steps above want it.
struct Counts {
  explicit Counts(const Report& report)
      : points(static_cast<double>(report.points)),
        samples(static_cast<double>(report.points + report.thin_points)),
        nodes(static_cast<double>(report.relabel.lattice_nodes)),
        passes(1.0 + report.relabel.repair_passes),
        vertices(static_cast<double>(report.check.vertices)),
        triangles(static_cast<double>(report.check.triangles)) {
    for (const std::int64_t side : report.geometry.size) voxels *= static_cast<double>(side);
    for (const LevelReport& level : report.levels) {
      cells += static_cast<double>(level.nodes);
      cell_iterations += static_cast<double>(level.nodes) * level.iterations;
    }
  }
  double voxels = 1, points, samples, cells = 0, cell_iterations = 0, nodes, passes, vertices,
         triangles;
};

}  // namespace

Work pack_work(double voxels) { return {voxels + voxels / 8, 0}; }
Work examine_work(double voxels) { return {voxels / 8, 0}; }
Work points_work(double voxels, double points) { return {voxels / 8 + points * kPointBytes, 0}; }
Work normals_work(double points) { return {points * kPointBytes, points * kNormalOperations}; }
Work build_work(double cells) { return {cells * (1 + kBrickTableBytes), 0}; }
Work assemble_work(double cells, double points) {
  return {4 * cells + points * 7 * 4, points * kSplatOperations};
}
Work solve_work(double cell_iterations) {
  return {cell_iterations * kIterationBytes, cell_iterations * kIterationOperations};
}
Work isovalue_work(double cells, double points) {
  return {8 * cells + points * 6 * 4, points * 2 * kSampleOperations};
}
Work label_work(double cells, double nodes) {
  return {nodes * kNodeBytes + 4 * cells, nodes * kNodeOperations};
}
Work relabel_work(double nodes, double passes) { return {nodes * kNodeBytes * passes, 0}; }
Work surface_work(double nodes, double vertices, double triangles) {
  return {nodes * kNodeBytes + mesh_bytes(vertices, triangles), vertices * kVertexOperations};
}
Work examine_mesh_work(double vertices, double triangles) {
  return {mesh_bytes(vertices, triangles), triangles * kTriangleOperations};
}

Work stage_work(const std::string& stage, const Report& report) {
  const Counts n(report);
  const std::map<std::string, std::function<Work()>> stages = {
      {"input", [&] { return pack_work(n.voxels) + examine_work(n.voxels); }},
      {"points", [&] { return points_work(n.voxels, n.points); }},
      {"normals", [&] { return normals_work(n.points); }},
      {"octree", [&] { return build_work(n.cells) + assemble_work(n.cells, n.samples); }},
      {"poisson", [&] { return solve_work(n.cell_iterations) + isovalue_work(n.cells, n.points); }},
      {"topology", [&] { return label_work(n.cells, n.nodes) + relabel_work(n.nodes, n.passes); }},
      {"surface", [&] { return surface_work(n.nodes, n.vertices, n.triangles); }},
      {"sizes", [&] { return values_work(n.nodes); }},
      {"remesh",
       [&] {
         return remake_work(report.mesh.hard_share * n.vertices,
                            report.mesh.hard_share * n.triangles);
       }},
      {"expand", [&] { return values_work(n.nodes) + added_work(report.mesh.front_triangles); }},
      {"stitch", [&] { return added_work(report.mesh.gap_triangles); }},
      {"finish", [&] { return remake_work(n.vertices, n.triangles); }},
      {"settle", [&] { return remake_work(n.vertices, n.triangles); }},
      {"check", [&] { return examine_mesh_work(n.vertices, n.triangles); }},
      {"quality", [&] { return examine_mesh_work(n.vertices, n.triangles); }}};
  const auto found = stages.find(stage);
  return found == stages.end() ? Work() : found->second();
}

}  // namespace vasamesh
