#pragma once

/// \file
/// The backend contract: the data-parallel passes of the pipeline over flat arrays. The stages
/// (engine/stages) are written once above it; a backend (host/tbb, host/opencl) implements it.
///
/// One arithmetic for all backends: float32 and integers; +, -, *, /, square root, and fma only
/// where it is written; no contraction; sums in an order that depends on sizes alone; ties broken
/// by index. Two backends give the same bytes, unless one has another arithmetic and says so. A
/// pass gets views alone, keeps nothing, and writes only the views that are not const. It may
/// return before it is done; passes run in the order of their calls. Views of another backend's
/// memory are taken too, once that has settled.

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "backend/byte_account.h"
#include "types/bricks.h"
#include "types/buffer.h"
#include "types/fans.h"
#include "types/front.h"
#include "types/gaps.h"
#include "types/indicator_field.h"
#include "types/lattice.h"
#include "types/octree.h"
#include "types/point_cloud.h"
#include "types/sizes.h"
#include "types/triangle_boxes.h"
#include "types/vec3.h"
#include "types/volume.h"
#include "vasamesh/parameters.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// The stages that a backend may offer.
enum class Stage {
  points,
  normals,
  octree,
  poisson,
  lattice,
  surface,
  sizing,
  expand,
  stitch,
  relax,
  verify,
  mesh  ///< what only the host does
};

/// What a device was given to do, and what was copied to and from it.
struct Traffic {
  std::int64_t launches = 0;  ///< of kernels
  std::int64_t copies = 0;
  std::int64_t bytes = 0;  ///< copied
  double waited = 0;       ///< seconds in which the program waited for the device
};

class Backend : public Memory {
 public:
  virtual std::string name() const = 0;    ///< "tbb", "opencl"
  virtual std::string device() const = 0;  ///< what it runs on, for people
  virtual bool offers(Stage stage) const = 0;
  /// What of its arithmetic is not the contract's, as "contracts products"; empty: gives the bytes
  /// of all others.
  virtual std::string other_arithmetic() const { return {}; }
  virtual std::size_t memory() const { return 0; }  ///< of the device, bytes; 0: the host's
  virtual std::size_t bytes_held() const = 0;
  virtual std::size_t bytes_peak() const = 0;
  virtual Traffic traffic() const { return {}; }  ///< since it was opened
  /// 0: none. Of all backends that share an account; allocate() throws above it.
  virtual void set_byte_limit(std::size_t bytes) = 0;

  /// True: released buffers are kept for the next that are asked for (a Converter's, from one
  /// volume to the next), as many bytes as were ever held at once, none under a limit. False takes
  /// back one such wish; after the last what is kept is freed. Backends may ignore it.
  virtual void keep_memory(bool /*keep*/) {}

  // --- Stopping. ------------------------------------------------------------------------------

  /// What passes and run() call now and then, on each thread that works for them, on the caller's
  /// with at most some milliseconds of work between two calls; so do stages in loops of their own.
  /// What it throws ends the pass and leaves undefined the views that it writes. Empty: nothing.
  virtual void set_checkpoint(std::function<void()> checkpoint) {
    checkpoint_ = std::move(checkpoint);
  }
  void checkpoint() const {
    if (checkpoint_) checkpoint_();
  }

  // --- The host's sight of a backend's memory. ------------------------------------------------

  /// The elements of a view, as the passes called before have left them. Passes called after see
  /// what is written there; the span is stale once one of them has written the view.
  template <class T>
  std::span<T> on_host(View<T> view) {
    if (view.size) bring_to_host(view.handle, !std::is_const_v<T>);
    return {view.data(), view.size};
  }

  /// Waits for the passes called before, and brings what they have written to the host's memory,
  /// for work that is not this backend's; takes for granted that it may write there.
  virtual void settle() {}

  /// Waits for the passes called before.
  virtual void finish() {}

  // --- Copies. `bytes` from byte `offset` of an allocation. ---------------------------------

  virtual void write(void* handle, std::size_t offset, const void* from, std::size_t bytes) = 0;
  virtual void read(const void* handle, std::size_t offset, void* to, std::size_t bytes) = 0;

  template <class T>
  void upload(View<T> to, std::span<const T> from) {
    if (!from.empty()) write(to.handle, to.offset * sizeof(T), from.data(), from.size_bytes());
  }
  template <class T>
  void download(View<const T> from, std::span<T> to) {
    if (!to.empty()) read(from.handle, from.offset * sizeof(T), to.data(), to.size_bytes());
  }

  // --- Host work of stages that have no kernels. ----------------------------------------------

  /// task(i) for i in 0 .. tasks - 1 on the backend's workers, in any order and at the same time;
  /// returns when all are done, with the exception of one of them if any threw. Tasks write
  /// places of their own, so that no result depends on the order; make them coarse (tens of
  /// microseconds), their number by sizes alone.
  virtual void run(std::size_t tasks, const std::function<void(std::size_t)>& task) = 0;

  // --- Primitives. ---------------------------------------------------------------------------

  virtual void fill(View<float> values, float value) = 0;
  virtual void fill(View<std::uint8_t> values, std::uint8_t value) = 0;
  virtual void fill(View<std::uint32_t> values, std::uint32_t value) = 0;

  /// sums[i] = values[0] + ... + values[i - 1]; sums has one entry more than values. May be the
  /// same memory. \return the total. \throws Error refused when it passes 32 bits.
  virtual std::uint32_t exclusive_scan(View<const std::uint32_t> values,
                                       View<std::uint32_t> sums) = 0;

  /// Pairwise sum: values padded by zeros to a power of two n, then v[i] + v[i + n/2] for the
  /// lower half, and so on down to one. 0 for no values.
  virtual float reduce_sum(View<const float> values) = 0;

  // --- Points (engine/stages/points.h). --------------------------------------------------------

  /// Packs the caller's bytes or bits into the padded volume; every word is written.
  virtual void volume_pack(const VolumeView& volume, const std::array<int, 3>& size,
                           int words_per_row, View<std::uint64_t> words) = 0;

  /// thin = object minus its opening by a 3 x 3 x 3 cube; refine = thin dilated by the cube.
  virtual void points_thin_mask(const BitView& object, View<std::uint64_t> thin,
                                View<std::uint64_t> refine) = 0;

  /// Which octants of each of the volume's bricks (raster order, size / 8 along each axis) hold
  /// outer boundary voxels: background with an object 6-neighbour. Bit dx + 2 dy + 4 dz.
  virtual void points_mark_bricks(const BitView& object, View<std::uint8_t> octants) = 0;

  /// How many points each voxel of each brick gives (counts: 512 a brick), and how many of each
  /// brick's points come from refined voxels (refined: one a brick).
  virtual void points_count(const BitView& object, const BitView& refine, const BrickView& bricks,
                            View<std::uint32_t> counts, View<std::uint32_t> refined) = 0;

  /// Writes position, area and thickness of the points; voxel_start is the scan of the counts.
  virtual void points_emit(const BitView& object, const BitView& thin, const BitView& refine,
                           const BrickView& bricks, View<const std::uint32_t> voxel_start,
                           const Scale& scale, const PointOutput& points) = 0;

  // --- Normals (engine/stages/normals.h). ------------------------------------------------------

  /// Outward unit gradient of the occupancy smoothed by a Gaussian of `sigma` voxel lengths
  /// (make_gradient_table); where it vanishes or points against the point's faces, that of half the
  /// sigma; and where that does so too, the area vector's direction.
  virtual void normals_gradient(const BitView& object, const PointView& points, const Scale& scale,
                                float sigma, std::array<View<float>, 3> normals) = 0;

  /// Outward unit eigenvector of the smallest eigenvalue of the covariance of the point's own voxel
  /// and its k nearest neighbours, with the tangent plane of the point's gradient added
  /// (engine/stages/normals.h), oriented by that gradient. A neighbour is a voxel's samples whose
  /// gradient agrees with the point's, at their mean, within kNeighbourReach voxels; ties by the
  /// index of the voxel's first sample. The gradient where that points against the point's faces.
  /// k is 3 to 64.
  virtual void normals_covariance(const PointView& points, const BrickView& bricks,
                                  View<const std::uint32_t> voxel_start, const Scale& scale, int k,
                                  std::array<View<const float>, 3> gradients,
                                  std::array<View<float>, 3> normals) = 0;

  // --- Indicator function (engine/stages/poisson.h). -------------------------------------------
  // Arrays of a level have 512 values a brick. A neighbour that is not there counts as zero.

  // A is the 7-point operator on unknown cells, and 0 elsewhere:
  // (A p)(c) = sum over the axes i of weights[i] * (2 p(c) - p(c - e_i) - p(c + e_i)), summed as
  // (wx * tx + wy * ty) + wz * tz with t = (2 p - p(c - e)) - p(c + e). A p is never stored: its
  // arithmetic, done twice an iteration, costs less than moving it.
  // Sums over a brick: lane x adds its 64 cells in order of y, then z; lanes are then added
  // pairwise, ((0+4)+(2+6)) + ((1+5)+(3+7)).

  /// r = p = b - A x on unknown cells and 0 elsewhere; of each brick, b_square = sum of b b over
  /// its unknown cells and r_square = sum of r r.
  virtual void poisson_residual(const LevelView& level, View<const std::uint8_t> unknown,
                                View<const float> b, View<const float> x, View<float> r,
                                View<float> p, View<float> b_square, View<float> r_square) = 0;

  /// energy[brick] = sum of p A p.
  virtual void poisson_energy(const LevelView& level, View<const std::uint8_t> unknown,
                              View<const float> p, View<float> energy) = 0;

  /// x += alpha p, r -= alpha A p; r_square[brick] = sum of r r.
  virtual void poisson_update_solution(const LevelView& level, View<const std::uint8_t> unknown,
                                       float alpha, View<const float> p, View<float> x,
                                       View<float> r, View<float> r_square) = 0;

  /// p = r + beta p.
  virtual void poisson_update_direction(const LevelView& level, float beta, View<const float> r,
                                        View<float> p) = 0;

  // --- Octree levels (engine/stages/octree.h, poisson.h). ---------------------------------------

  /// A cell is unknown (1) unless one of its six neighbours is in no brick; all cells of a level
  /// that is `whole` (the root, which ends in zeros) are.
  virtual void octree_mark_unknown(const LevelView& level, bool whole,
                                   View<std::uint8_t> unknown) = 0;

  /// The splatted vector field's divergence, eq. 3 and 4 of the paper with B-splines for the
  /// Gaussian: right_hand_side(c) = -volume * div V at c, V = sum over the points of
  /// -(area . normal) normal K, div by differences over the cell's faces. K is the tensor product
  /// of quadratic B-splines whose knots are kernel.at(the point's thickness) voxel lengths apart,
  /// and at least one cell.
  virtual void poisson_splat(const LevelView& level, const PointIndex& index,
                             const PointView& points, const Scale& scale, const Kernel& kernel,
                             View<float> right_hand_side) = 0;

  /// coarse = P^T fine, P the subdivision of quadratic B-splines (1 3 3 1) / 4 along each axis.
  /// `children` has 64 entries a coarse brick: the fine bricks 2 B - 1 .. 2 B + 2 along each axis.
  virtual void poisson_restrict(const LevelView& coarse, View<const std::int32_t> children,
                                View<const float> fine_values, View<float> coarse_values) = 0;

  /// fine = P coarse. `parents` has 27 entries a fine brick: the coarse bricks round its parent.
  virtual void poisson_prolong(const LevelView& fine, View<const std::int32_t> parents,
                               View<const float> coarse_values, View<float> fine_values) = 0;

  /// values[i] = the spline at point i, for the points whose voxels lie in the level's bricks;
  /// the others keep what they have.
  virtual void poisson_sample_points(const LevelView& level, const PointIndex& index,
                                     const PointView& points, View<const float> coefficients,
                                     View<float> values) = 0;

  /// numerator = sum of weight B value, denominator = sum of weight B over the points, B the
  /// level's own quadratic B-spline round each cell.
  virtual void isovalue_splat(const LevelView& level, const PointIndex& index,
                              const PointView& points, View<const float> weights,
                              View<const float> values, View<float> numerator,
                              View<float> denominator) = 0;

  /// out(c) = tap * in(c - e) + (1 - 2 tap) * in(c) + tap * in(c + e), e along `axis`.
  virtual void isovalue_smooth(const LevelView& level, int axis, float tap, View<const float> in,
                               View<float> out) = 0;

  /// numerator = (numerator + small * fallback) / (denominator + small), small = 1e-4.
  virtual void isovalue_divide(float fallback, View<const float> denominator,
                               View<float> numerator) = 0;

  /// a += factor b.
  virtual void field_add(float factor, View<const float> b, View<float> a) = 0;

  // --- Cell lattice (engine/stages/lattice.h). ---------------------------------------------------
  // Nodes half a voxel apart in bricks of 8^3; LatticeBit of types/lattice.h names the bits.

  /// used[b] = 1 where a node of brick b lies within `radius` + 1 nodes (along each axis, 1 to 3)
  /// of the centre of a boundary face.
  virtual void lattice_mark(const BitView& object, const BrickView& bricks,
                            const std::array<int, 3>& radius, View<std::uint8_t> used) = 0;

  /// state = the solid's label (twice), whether the node may change, whether it is the centre of a
  /// boundary face.
  virtual void lattice_label(const BitView& object, int connectivity, const BrickView& bricks,
                             const std::array<int, 3>& radius, View<std::uint8_t> state) = 0;

  /// values = the spline at the nodes: from `refined` where it has the nodes' brick and the seven
  /// below, else from `regular`. `in_regular` has 27 entries a brick: the regular bricks round the
  /// one that holds it; `in_refined` likewise, at the brick itself.
  virtual void lattice_sample(const BrickView& bricks, View<const std::int32_t> in_regular,
                              View<const float> regular, View<const std::int32_t> in_refined,
                              View<const float> refined, View<float> values) = 0;

  /// How many nodes of each colour (the parities of x, y, z: bit 0, 1, 2) and brick may change and
  /// have a label that is not the value's sign: counts[colour * bricks.count + b]. None in bricks
  /// whose `active` is 0.
  virtual void relabel_count(const BrickView& bricks, View<const std::uint8_t> active,
                             View<const std::uint8_t> state, View<const float> values,
                             View<std::uint32_t> counts) = 0;
  /// Writes those nodes (512 b + cell), ordered by colour, brick, cell; starts: scan of counts.
  virtual void relabel_collect(const BrickView& bricks, View<const std::uint8_t> active,
                               View<const std::uint8_t> state, View<const float> values,
                               View<const std::uint32_t> starts, View<std::uint32_t> nodes) = 0;

  /// Flips the labels of the listed nodes (all of one colour, so that none sees another) that are
  /// simple and whose |value| is at least `threshold`, and lists those that it leaves, in the same
  /// order, in `left` (as large as `nodes`). \return how many are left; when they all are, `left`
  /// is undefined.
  virtual std::uint32_t relabel_sweep(const BrickView& bricks, View<const std::uint8_t> simple,
                                      View<const float> values, float threshold,
                                      View<const std::uint32_t> nodes, View<std::uint8_t> state,
                                      View<std::uint32_t> left) = 0;

  /// marks = `mark` at the listed nodes.
  virtual void relabel_mark(View<const std::uint32_t> nodes, std::uint8_t mark,
                            View<std::uint8_t> marks) = 0;

  /// Marks nodes where the labels leave the solid's marching-cubes surface too far, by more than
  /// `limit` (voxel lengths): centres of boundary faces, and corners round which lie polygons of a
  /// marching cube, without the surface near; and relabelled nodes with a crossed edge whose
  /// crossing is far from every such centre and side of a polygon. marks: a byte a node, 0
  /// outside of the octants of bricks (bit dx + 2 dy + 4 dz) that are `active`. \return how many.
  virtual std::uint32_t lattice_mark_far(const BrickView& bricks, View<const std::uint8_t> active,
                                         const Scale& scale, float limit,
                                         View<const std::uint8_t> state, View<const float> values,
                                         View<std::uint8_t> marks) = 0;

  /// Marks, as stuck, voxel centres in active octants where what the labels keep is narrow: the
  /// label is the solid's, its flip would change the topology (simple[], as of relabel_sweep), and
  /// along two axes or more both neighbours have the other label, and for one of these
  /// (own / (own + below) + own / (own + above)) / 2 < `least.across`, of the absolute values: the
  /// width in voxels. Of nodes inside also where that is so along one axis, with `least.sheet`.
  /// \return how many.
  virtual std::uint32_t lattice_mark_narrow(const BrickView& bricks,
                                            View<const std::uint8_t> active,
                                            View<const std::uint8_t> simple,
                                            const LeastWidths& least,
                                            View<const std::uint8_t> state,
                                            View<const float> values, View<std::uint8_t> marks) = 0;

  /// Leads the values near marked nodes back to the solid's: value = (1 - d) value + d g,
  /// d = strength (1 - distance^2 / radius^2)^2 to the nearest mark, g from the occupancy round the
  /// node (its quadratic B-spline when `smooth`, else linear), kept on the side of the solid's
  /// label where a kStuckMark is within the radius: there the linear one serves solid nodes that
  /// the B-spline would lose. `radius` in nodes, at most 8. changed[b]: the octants of brick b
  /// (bits as above) with a node within the radius of a mark.
  virtual void lattice_blend(const BrickView& bricks, View<const std::uint8_t> marks, float radius,
                             float strength, bool smooth, View<const std::uint8_t> state,
                             View<float> values, View<std::uint8_t> changed) = 0;

  /// Gives each node whose value's sign is not its label, or whose value is zero, +-`least`.
  /// \return how many of the first kind may change their label.
  virtual std::uint32_t lattice_clamp(const BrickView& bricks, float least,
                                      View<const std::uint8_t> state, View<float> values) = 0;

  // --- Base surface (engine/stages/surface.h). ---------------------------------------------------

  /// Marching tetrahedra of the Freudenthal cut: which of its seven edges (to the node at each of
  /// the offsets 1..7, bits x, y, z; edge d is bit d - 1) each node owns that the labels cross, the
  /// first of its vertices within its brick, and how many vertices and triangles each brick gives.
  virtual void surface_count(const BrickView& bricks, View<const std::uint8_t> state,
                             View<std::uint8_t> crossed, View<std::uint16_t> node_start,
                             View<std::uint32_t> vertices, View<std::uint32_t> triangles) = 0;

  /// Vertices in padded voxel units, three floats each, between `margin` and 1 - margin along
  /// their edges; triangles counter-clockwise seen from outside in index space.
  virtual void surface_emit(const BrickView& bricks, View<const std::uint8_t> state,
                            View<const float> values, float margin,
                            View<const std::uint8_t> crossed, View<const std::uint16_t> node_start,
                            View<const std::uint32_t> vertex_start,
                            View<const std::uint32_t> triangle_start, View<float> vertices,
                            View<std::uint32_t> triangles) = 0;

  // --- Sizes (engine/stages/sizing.h). -----------------------------------------------------------

  /// Each position moves onto the field's zero set (project_to_surface), where its outward unit
  /// normal and its radius of curvature are taken (radius_of_curvature, which says what `ample`
  /// is). Where no zero set is found within half a voxel length the position stays, and normal and
  /// radius are zero.
  virtual void sizing_measure(const FieldView& field, float ample, View<Vec3> positions,
                              View<Vec3> normals, View<float> radii) = 0;

  // --- Mesh expanding (engine/stages/expand_rounds.h, expand_steps.h). ---------------------------
  // One round: who may propose (choose, claim), what (propose), and all that at once (add).

  /// Begins a round, whose number is higher than that of all before and below kRoundsEnd: writes
  /// the list without the dead to front.alive, measures the corners on it that have changed, all of
  /// them when `wake`, gives each its key, and lists their edges in the cells anew. front.chosen
  /// are the active corners that go before their neighbours (goes_first), ascending. Counts both
  /// lists.
  virtual void expand_choose(const FieldView& field, std::uint32_t round, bool wake,
                             const FrontView& front) = 0;

  /// The chosen corners claim the cells round them (claimed_cells).
  virtual void expand_claim(const FieldView& field, const FrontView& front) = 0;

  /// What each chosen corner proposes (propose): nothing where another holds a cell that it claims.
  /// Else, where it finds nothing, it is frozen, and where it needs more room, it is wide, or
  /// frozen if it was wide.
  virtual void expand_propose(const FieldView& field, const SizeView& sizes,
                              const FrontLimits& limits, const FrontView& front) = 0;

  /// Adds what is proposed (add_proposal), numbered in the order of the chosen corners behind what
  /// there is, and the new corners to the list. Counts it all.
  virtual void expand_add(const FieldView& field, const FrontView& front) = 0;

  // --- Gaps (engine/stages/triangulate_gap.h). ---------------------------------------------------

  /// Triangulates each gap by itself (GapTriangulator): closed[g] = 1 where a triangulation obeys
  /// the rules, else 0; its n - 2 triangles, three corners of the gap each, go to triangles[3 t],
  /// t = first[g] - 2 g and on. Those of gaps that stay open are undefined.
  virtual void stitch_triangulate(const GapRules& rules, StitchMode mode, const GapView& gaps,
                                  View<std::uint8_t> closed, View<std::uint16_t> triangles) = 0;

  // --- Relaxation (engine/stages/fan_moves.h). --------------------------------------------------

  /// Smooths the vertices of each part, level by level, `passes` times (smooth_vertex). All lie on
  /// the field.
  virtual void relax_smooth(const FieldView& field, const SizeView& sizes, const PlaceView& places,
                            const FanView& fans, int passes, View<SurfacePoint> points) = 0;

  /// Moves those vertices towards equal edges (find_more_equal), likewise, and onto the surface if
  /// `onto` says so; else across their normals alone. None is on a border.
  virtual void relax_equalise(const FieldView& field, const SizeView& sizes,
                              const PlaceView& places, const FanView& fans, int passes, bool onto,
                              View<SurfacePoint> points) = 0;

  /// gaps = how far the surface lies outside of the triangles round each fan's vertex (mean_gap).
  /// None is on a border.
  virtual void relax_gaps(const FieldView& field, const FanView& fans,
                          View<const SurfacePoint> points, View<float> gaps) = 0;

  // --- Proof (engine/stages/candidate_pairs.h). -------------------------------------------------

  /// Pairs of triangles that may intersect (PairSearch): counts[leaf] = those of a leaf's triangles
  /// with its own and later leaves'.
  virtual void verify_count_pairs(const MeshView& mesh, const TreeView& tree,
                                  View<std::uint32_t> counts) = 0;

  /// Writes them, two triangles each, from pairs[2 * starts[leaf]] on; starts: scan of the counts.
  virtual void verify_collect_pairs(const MeshView& mesh, const TreeView& tree,
                                    View<const std::uint32_t> starts,
                                    View<std::uint32_t> pairs) = 0;

 private:
  /// on_host() for a whole allocation, which the host may write when `writes`.
  virtual void bring_to_host(void* /*handle*/, bool /*writes*/) {}

  std::function<void()> checkpoint_;
};

}  // namespace vasamesh
