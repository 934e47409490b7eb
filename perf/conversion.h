#pragma once

/// \file
/// A conversion of one phantom cut into its stages, each of which can be run and timed alone.

#include <cstdint>
#include <memory>

#include "measure/work.h"
#include "phantom/phantom.h"
#include "scheduler.h"
#include "stages/lattice.h"
#include "stages/octree.h"
#include "stages/points.h"
#include "stages/relabel.h"
#include "stages/topology_count.h"

namespace vasamesh {

/// State between stages. A stage needs the ones before it; it may run again, after `restore` where
/// kConversionStages names one.
class Conversion {
 public:
  Conversion(const Phantom& phantom, int threads);

  void pack();
  void examine();
  void extract();
  void estimate();
  void build_tree();
  void assemble();
  void solve();
  void subtract();
  void assemble_anew();  ///< from the points on: a solve uses up what it was given
  void solve_anew();
  void label();
  void relabel_nodes();
  void make_surface();
  void check();
  void measure();

  Work pack_floor() const;
  Work examine_floor() const;
  Work extract_floor() const;
  Work estimate_floor() const;
  Work build_tree_floor() const;
  Work assemble_floor() const;
  Work solve_floor() const;
  Work subtract_floor() const;
  Work label_floor() const;
  Work relabel_floor() const;
  Work surface_floor() const;
  Work mesh_floor() const;

 private:
  double voxel_count() const;
  double point_count() const;
  double node_count() const;

  const Phantom& phantom_;
  Context context_;
  Scheduler scheduler_;
  Backend& backend_;
  Parameters parameters_;
  Scale scale_;
  BitVolume object_;
  Solid solid_;
  PointCloud points_;
  Octree octree_;
  std::vector<LevelReport> levels_;
  Lattice lattice_;
  RelabelReport relabelled_;
  TriangleMesh mesh_;
};

/// The stages in order.
struct ConversionStage {
  const char* name;
  void (Conversion::*run)();
  void (Conversion::*restore)();  ///< run untimed before each repeat; may be null
  Work (Conversion::*floor)() const;
};
inline constexpr ConversionStage kConversionStages[] = {
    {"input_pack", &Conversion::pack, nullptr, &Conversion::pack_floor},
    {"input_examine", &Conversion::examine, nullptr, &Conversion::examine_floor},
    {"points", &Conversion::extract, nullptr, &Conversion::extract_floor},
    {"normals", &Conversion::estimate, nullptr, &Conversion::estimate_floor},
    {"octree_build", &Conversion::build_tree, nullptr, &Conversion::build_tree_floor},
    {"octree_assemble", &Conversion::assemble, nullptr, &Conversion::assemble_floor},
    {"poisson_solve", &Conversion::solve, &Conversion::assemble_anew, &Conversion::solve_floor},
    {"poisson_isovalue", &Conversion::subtract, &Conversion::solve_anew,
     &Conversion::subtract_floor},
    {"topology_label", &Conversion::label, nullptr, &Conversion::label_floor},
    {"topology_relabel", &Conversion::relabel_nodes, &Conversion::label,
     &Conversion::relabel_floor},
    {"surface", &Conversion::make_surface, nullptr, &Conversion::surface_floor},
    {"check_proof", &Conversion::check, nullptr, &Conversion::mesh_floor},
    {"check_quality", &Conversion::measure, nullptr, &Conversion::mesh_floor},
};

}  // namespace vasamesh
