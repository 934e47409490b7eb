#pragma once

/// \file
/// What the stages must do at least: each array that a step reads or makes moved once, and the
/// float32 operations of its formulas without the search for their operands.

#include <string>

#include "vasamesh/report.h"

namespace vasamesh {

struct Work {
  double bytes = 0, operations = 0;

  Work operator+(const Work& other) const {
    return {bytes + other.bytes, operations + other.operations};
  }
};

/// Steps, by how many they have of what they work on.
Work pack_work(double voxels);
Work examine_work(double voxels);
Work points_work(double voxels, double points);
Work normals_work(double points);
Work build_work(double cells);
Work assemble_work(double cells, double points);
Work solve_work(double cell_iterations);
Work isovalue_work(double cells, double points);
Work label_work(double cells, double nodes);
Work relabel_work(double nodes, double passes);
Work surface_work(double nodes, double vertices, double triangles);
Work examine_mesh_work(double vertices, double triangles);  ///< the proof, and the quality

/// A stage of a conversion to the base surface, by its name in the report; none for other names.
Work stage_work(const std::string& stage, const Report& report);

}  // namespace vasamesh
