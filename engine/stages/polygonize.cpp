#include "stages/polygonize.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <span>
#include <string>
#include <utility>

#include "backend/in_steps.h"
#include "backend/ranges.h"
#include "stages/defects.h"
#include "stages/expand.h"
#include "stages/finish.h"
#include "stages/hard.h"
#include "stages/lattice.h"
#include "stages/mesh_parts.h"
#include "stages/pinches.h"
#include "stages/places.h"
#include "stages/remesh.h"
#include "stages/settle.h"
#include "stages/stitch.h"
#include "types/mesh_vertex.h"
#include "vasamesh/errors.h"

namespace vasamesh {

namespace {

constexpr double kLeastTriangles = 50;  // for each handle
constexpr int kFrontAttempts = 6;       // surfaces of mesh expanding
constexpr int kRemeshAttempts = 3;      // then, of the base surface remeshed whole
constexpr double kMostHard = 0.98;      // of the area: the front would have no room beside it
constexpr double kMostRedone = 0.2;     // of the area: beyond it, the whole is remeshed instead
constexpr std::size_t kWork = 3, kLeastWork = 25000;  // of settling: times a surface's triangles
constexpr int kAims = 3;                              // attempts at a number of triangles
constexpr double kCountTolerance = 0.1;               // of the triangles that are asked for
constexpr float kRemeshFactors[] = {0.5f, 0};
constexpr float kFactors[] = {0.7f, 0.5f, 0.35f, 0};  // of the edges in a place, failure by failure
constexpr float kPlace = 2.5f;                        // longest edges: a place's radius,
constexpr float kWidePlace = 4;  // voxel lengths: or one edge where that would be more than this
constexpr float kMargin = 1.2f;  // longest edges: the front's room

/// Of remeshing and finishing, for the report.
constexpr char kOnHost[] = "splits, collapses, flips, repairs, moves near other sheets";

SizeRule rule_of(const EdgeLengths& edges) {
  SizeRule rule;
  rule.rho = static_cast<float>(edges.edges_around > 0 ? 2 * std::numbers::pi / edges.edges_around
                                                       : edges.rho);
  rule.chord_error = static_cast<float>(edges.chord_error);
  rule.edge_min = static_cast<float>(edges.edge_min);
  rule.edge_max = static_cast<float>(edges.edge_max);
  rule.gradation = static_cast<float>(edges.gradation);
  return rule;
}

SizeRule scaled(SizeRule rule, float factor) {
  rule.rho *= factor;
  rule.chord_error *= factor * factor;
  rule.edge_min *= factor;
  rule.edge_max *= factor;
  return rule;
}

std::vector<CarefulPlace> where_base_stays(std::span<const CarefulPlace> places) {
  std::vector<CarefulPlace> kept;
  std::copy_if(places.begin(), places.end(), std::back_inserter(kept),
               [](const CarefulPlace& place) { return place.factor == 0; });
  return kept;
}

double area_of(Backend& backend, const TriangleMesh& mesh) {
  constexpr std::size_t kGrain = 8192;  // triangles a task takes
  const auto sum = [&](std::size_t begin, std::size_t end) {
    double area = 0;
    for (std::size_t t = begin; t < end; ++t) {
      const Vec3 a = vertex_at(mesh, mesh.triangles[3 * t]);
      area += 0.5 * double{norm(cross(vertex_at(mesh, mesh.triangles[3 * t + 1]) - a,
                                      vertex_at(mesh, mesh.triangles[3 * t + 2]) - a))};
    }
    return area;
  };
  return reduce_ranges(backend, mesh.triangle_count(), kGrain, 0.0, sum);
}

std::string refusal_of_count(double wanted, double possible, bool met) {
  return "this surface cannot have " + std::to_string(std::llround(wanted)) +
         " triangles: ask for about " + std::to_string(std::llround(possible)) +
         (possible > wanted ? " or more" : " or fewer") +
         (met ? "" : ", going by a prediction that may be off");
}

}  // namespace

CountRefused::CountRefused(double wanted, double possible, bool met)
    : Error(ErrorCode::usage, refusal_of_count(wanted, possible, met)), possible_(possible) {}

Polygonizer::Polygonizer(Scheduler& scheduler, const Lattice& lattice,
                         const std::array<int, 3>& size, const Scale& scale, TriangleMesh base,
                         const Parameters& parameters)
    : scheduler_(scheduler),
      backend_(scheduler.backend_for(Stage::mesh)),
      scale_(scale),
      stitch_(parameters.stitch),
      asked_(rule_of(parameters.edges)),
      rule_(asked_),
      wanted_triangles_(static_cast<double>(parameters.edges.triangles)),
      base_(std::move(base)),
      limit_(lattice.limit) {
  in_steps(backend_, base_.vertices.size(),
           [&](std::size_t i) { base_.vertices[i] *= scale_[i % 3]; });
  base_area_ = area_of(backend_, base_);
  scheduler_.begin("sizes", Stage::sizing, "trees of boxes, the growth of sizes");
  sizing().on_host(View<const std::uint8_t>(lattice.state.view()));
  backend_.run(2, [&](std::size_t half) {  // each half has work of one thread alone
    if (half == 0) {
      base_tree_ = build_tree_in_order(backend_, base_);
    } else {
      solid_ = marching_cubes_of(backend_, lattice, scale);
      solid_tree_ = build_triangle_tree(backend_, solid_.common);
    }
  });
  field_ = make_field(sizing(), lattice, size, scale);
  const float ample = wanted_triangles_ > 0 ? kLargestRadius : ample_radius(rule_);
  sizes_ = make_sizes(sizing(), field_, base_, rule_, ample);
  if (wanted_triangles_ > 0) aim();
  report_.predicted_triangles = sizes_.predicted_triangles;
}

/// Scales the lengths until the prediction is right: it goes with their inverse square.
void Polygonizer::aim() {
  constexpr int kSteps = 12;
  const double triangles = wanted_triangles_ / excess_;
  float factor = rule_.edge_max / asked_.edge_max;
  for (int step = 0; step < kSteps; ++step) {
    const double ratio = sizes_.predicted_triangles / triangles;
    if (std::fabs(ratio - 1) < 0.005) return;
    factor *= static_cast<float>(std::sqrt(ratio));
    factor = std::clamp(factor, static_cast<float>(EdgeLengths::kLeastEdge) / asked_.edge_min,
                        static_cast<float>(EdgeLengths::kLongestEdge) / asked_.edge_max);
    rule_ = scaled(asked_, factor);
    apply_rule(sizing(), field_, base_, rule_, {}, sizes_);
  }
  const double reached = sizes_.predicted_triangles;
  if (std::fabs(reached / triangles - 1) > kCountTolerance) refuse_count(reached * excess_);
}

void Polygonizer::refuse_count(double possible) const {
  throw CountRefused(wanted_triangles_, possible, false);
}

bool Polygonizer::is_worthwhile(const Topology& topology) const {
  return sizes_.predicted_triangles >= kLeastTriangles * static_cast<double>(topology.handles);
}

std::optional<TriangleMesh> Polygonizer::next() {
  while (plan_ != Plan::stop) {
    last_ = made();
    ++report_.attempts;
    report_.base_share = base_share();
    if (has_topology_) return in_voxels(last_);
    plan_after(find_defects(backend_, base_, base_tree_, last_, true));
  }
  return std::nullopt;
}

/// Of the area, where places keep the base surface as it is.
double Polygonizer::base_share() const {
  const std::vector<CarefulPlace> places = where_base_stays(places_);
  if (places.empty()) return 0;
  const std::vector<std::uint8_t> within = vertices_in(backend_, Places(places), base_);
  std::vector<std::uint8_t> stays(base_.triangle_count());
  in_steps(backend_, stays.size(), [&](std::size_t t) {
    const std::uint32_t* v = &base_.triangles[3 * t];
    stays[t] = within[v[0]] && within[v[1]] && within[v[2]];
  });
  return area_of(backend_, part_of(backend_, base_, stays)) / base_area_;
}

TriangleMesh Polygonizer::made() {
  switch (plan_) {
    case Plan::redo:
      return redone();
    case Plan::remesh:
      return remeshed();
    default:
      return expanded();
  }
}

Verdict Polygonizer::judge(const CheckReport& check) {
  if (!check.passed) {
    plan_after(find_defects(backend_, base_, base_tree_, last_, check.intersecting_pairs > 0));
    return Verdict::refuse;
  }
  if (astray_.empty() && (count_is_right(check.triangles) || !aim_again(check.triangles)))
    return Verdict::take;
  const bool best = !proven_ || astray_.size() < least_astray_;
  proven_ = true;
  if (best) least_astray_ = astray_.size();
  if (work_ == 0u)
    plan_ = Plan::stop;
  else if (!astray_.empty())
    plan_after(astray_);
  return best ? Verdict::keep : Verdict::refuse;
}

/// The longest edge that is asked for anywhere on the surface.
float Polygonizer::longest_edge() const {
  float longest = rule_.edge_min;
  for (const std::uint32_t cell : sizes_.samples.cell)
    longest = std::max(longest, sizes_.sizes.view()[cell]);
  return longest;
}

float Polygonizer::place_radius() const {
  const float edge = longest_edge();
  return std::min(kPlace * edge, std::max(kWidePlace, edge));
}

/// Places for the defects, each that no new place covers; its factor by how many old ones do.
void Polygonizer::note(const std::vector<Vec3>& defects, std::span<const float> factors) {
  first_fresh_ = places_.size();
  const float radius = place_radius();
  for (CarefulPlace& place : places_at(defects, radius, 1)) {
    const auto failures = static_cast<std::size_t>(
        std::count_if(places_.begin(), places_.begin() + static_cast<std::ptrdiff_t>(first_fresh_),
                      [&](const CarefulPlace& old) {
                        return squared_norm(place.centre - old.centre) < 0.25f * (radius * radius);
                      }));
    place.factor = factors[std::min(failures, factors.size() - 1)];
    places_.push_back(place);
  }
}

/// Whether the fresh places are some, and a small part of the surface.
bool Polygonizer::can_be_redone() const {
  const double radius = place_radius();
  const auto fresh = static_cast<double>(places_.size() - first_fresh_);
  return fresh > 0 && fresh * std::numbers::pi * radius * radius < kMostRedone * base_area_;
}

/// The next surface, after one with defects.
void Polygonizer::plan_after(const std::vector<Vec3>& defects) {
  ++failures_;
  if (plan_ != Plan::remesh) {
    note(defects, kFactors);
    plan_ = Plan::redo;
    if (failures_ < kFrontAttempts && can_be_redone()) return;
    if (proven_)
      plan_ = Plan::stop;
    else
      start_over(Plan::remesh);
    return;
  }
  note(defects, kRemeshFactors);
  if (defects.empty() || failures_ == kRemeshAttempts) plan_ = Plan::stop;
}

/// Forgets the places and what the attempts with them have added.
void Polygonizer::start_over(Plan plan) {
  plan_ = plan;
  failures_ = 0;
  work_.reset();
  places_.clear();
  apply_rule(sizing(), field_, base_, rule_, places_, sizes_);
  report_.rounds = 0;
  report_.front_triangles = report_.gaps = report_.gap_triangles = 0;
}

bool Polygonizer::count_is_right(std::int64_t triangles) const {
  return wanted_triangles_ == 0 ||
         std::fabs(static_cast<double>(triangles) / wanted_triangles_ - 1) <= kCountTolerance;
}

/// Aims once more at the number of triangles that is asked for. \return whether it may.
bool Polygonizer::aim_again(std::int64_t triangles) {
  if (++aims_ == kAims) return false;
  start_over(Plan::expand);
  excess_ = static_cast<double>(triangles) / sizes_.predicted_triangles;
  aim();
  return true;
}

void Polygonizer::check_count(std::int64_t triangles) const {
  if (!count_is_right(triangles)) refuse_count(static_cast<double>(triangles));
}

TriangleMesh Polygonizer::expanded() {
  const std::vector<std::uint8_t> hard = find_hard_regions(backend_, field_, sizes_, rule_, base_);
  const TriangleMesh part = part_of(backend_, base_, hard);
  report_.hard_share = area_of(backend_, part) / base_area_;
  if (report_.hard_share > kMostHard) {
    plan_ = Plan::remesh;
    return remeshed();
  }
  scheduler_.begin("remesh", Stage::relax, kOnHost);
  TriangleMesh patches;
  if (!part.triangles.empty())
    patches = remesh_patches(relaxing(), field_.view(), sizes_.view(field_), part);
  const std::optional<TriangleMesh> mesh = front_over(patches);
  if (!mesh) return remeshed_instead();
  scheduler_.begin("finish", Stage::relax, kOnHost);
  settled_ = false;
  return settled(finish(relaxing(), field_.view(), sizes_.view(field_), *mesh));
}

/// The last surface with the fresh places cut out, the base surface remeshed in their middle, and
/// the front in between.
TriangleMesh Polygonizer::redone() {
  scheduler_.begin("remesh", Stage::relax, kOnHost);
  apply_rule(sizing(), field_, base_, rule_, places_, sizes_);
  const std::span<const CarefulPlace> fresh = std::span(places_).subspan(first_fresh_);
  const float margin = kMargin * longest_edge();
  std::vector<std::uint8_t> within = vertices_in(backend_, Places(fresh), base_);
  const TriangleMesh part = part_of(backend_, base_, choose_triangles(backend_, base_, within));
  const std::vector<std::uint8_t> near = vertices_in(backend_, wider(fresh, margin), last_);
  std::vector<std::uint8_t> kept(last_.triangle_count());
  in_steps(backend_, kept.size(), [&](std::size_t t) {
    const std::uint32_t* v = &last_.triangles[3 * t];
    kept[t] = !near[v[0]] && !near[v[1]] && !near[v[2]];
  });
  const TriangleMesh patches = joined(part_of(backend_, last_, kept),
                                      remesh_patches(relaxing(), field_.view(), sizes_.view(field_),
                                                     part, where_base_stays(fresh)));
  const std::optional<TriangleMesh> mesh = front_over(patches);
  if (!mesh) return remeshed_instead();

  scheduler_.begin("finish", Stage::relax, kOnHost);
  std::vector<CarefulPlace> round = where_base_stays(places_);
  for (const CarefulPlace& place : fresh) {
    changed_.push_back({place.centre, place.radius + 2 * margin, 1});
    if (place.factor > 0) round.push_back(changed_.back());
  }
  return settled(finish(relaxing(), field_.view(), sizes_.view(field_), *mesh, round));
}

/// The front round the patches, its gaps stitched; none where it has run away, whose gaps are those
/// of no surface.
std::optional<TriangleMesh> Polygonizer::front_over(const TriangleMesh& patches) {
  scheduler_.begin("expand", Stage::expand, "the patches' boundary and the seeds");
  FrontResult front = expand(scheduler_.backend_for(Stage::expand), field_, sizes_, patches);
  report_.rounds += front.rounds;
  report_.front_triangles +=
      static_cast<std::int64_t>(front.mesh.triangle_count() - patches.triangle_count());
  if (front.over_budget) return std::nullopt;

  scheduler_.begin("stitch", Stage::stitch, "loops, bridges, the refinement of patches");
  Backend& stitching = scheduler_.backend_for(Stage::stitch);
  if (drop_repeated_edges(backend_, front.mesh))
    front.loops = find_gap_loops(stitching, front.mesh);
  const StitchReport stitched =
      stitch_gaps(stitching, field_.view(), sizes_.view(field_), stitch_, front.loops, front.mesh);
  report_.gaps += stitched.loops;
  report_.gap_triangles +=
      static_cast<std::int64_t>(front.mesh.triangle_count() - stitched.first_triangle);
  drop_repeated_edges(backend_, front.mesh);
  split_pinches(backend_, front.mesh);
  return std::move(front.mesh);
}

TriangleMesh Polygonizer::remeshed_instead() {
  start_over(Plan::remesh);
  return remeshed();
}

TriangleMesh Polygonizer::remeshed() {
  scheduler_.begin("remesh", Stage::relax, kOnHost);
  report_.hard_share = 1;
  settled_ = false;
  return settled(remesh(relaxing(), field_.view(), sizes_.view(field_), base_, places_));
}

/// The surface, settled in the bounds where it has changed since the last that was; as it is where
/// its topology is wrong, since it would fail its proof and is made again.
TriangleMesh Polygonizer::settled(TriangleMesh mesh) {
  scheduler_.begin("settle", Stage::mesh,
                   "few places, each mended by long, branching tasks with exact predicates");
  has_topology_ = has_topology_of(backend_, base_, mesh);
  if (!has_topology_) return mesh;
  if (!work_) work_ = kWork * mesh.triangle_count() + kLeastWork;
  const Bounds bounds = {base_, base_tree_, solid_, solid_tree_, limit_};
  const std::span<const CarefulPlace> within = settled_ ? changed_ : std::span<CarefulPlace>();
  Settled result = settle(backend_, field_.view(), sizes_.view(field_), bounds, place_radius(),
                          std::move(mesh), within, astray_, *work_);
  astray_ = std::move(result.far);
  report_.far_points = static_cast<std::int64_t>(astray_.size());
  settled_ = true;
  changed_.clear();
  return std::move(result.mesh);
}

TriangleMesh Polygonizer::in_voxels(TriangleMesh mesh) const {
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) mesh.vertices[i] /= scale_[i % 3];
  return mesh;
}

}  // namespace vasamesh
