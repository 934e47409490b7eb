#include "stages/polygonize.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <span>
#include <string>
#include <utility>

#include "stages/approach.h"
#include "stages/curvature.h"
#include "stages/distance.h"
#include "stages/expand.h"
#include "stages/finish.h"
#include "stages/hard.h"
#include "stages/intersect.h"
#include "stages/lattice.h"
#include "stages/pinches.h"
#include "stages/remesh.h"
#include "stages/stitch.h"
#include "types/mesh_vertex.h"
#include "vasamesh/errors.h"

namespace vasamesh {

namespace {

constexpr int kFrontAttempts = 6;        // surfaces of mesh expanding
constexpr int kRemeshAttempts = 3;       // then, of the base surface remeshed whole
constexpr int kAims = 3;                 // attempts at a number of triangles
constexpr double kCountTolerance = 0.1;  // of the triangles that are asked for
constexpr float kRemeshFactors[] = {0.5f, 0};
constexpr float kFactors[] = {0.7f, 0.5f, 0.35f, 0};  // of the edges in a place, failure by failure
constexpr float kPlace = 2.5f, kMargin = 1.2f;  // edge_max: a place's radius, the front's room
constexpr float kFarShare = 0.9f;    // of the distance limit: how far from face centres is too far
constexpr float kStray = 0.4f;       // voxel lengths: of a vertex from the base surface, at most
constexpr float kNearShare = 0.82f;  // the same: how near the surface is brought to them
constexpr float kLeastEdge = 0.05f, kLongestEdge = 100;  // voxel lengths
constexpr std::uint32_t kNoVertex = 0xffffffffu;

SizeRule rule_of(const EdgeLengths& edges) {
  constexpr double kTwoPi = 6.283185307179586;
  SizeRule rule;
  rule.rho = static_cast<float>(edges.edges_around > 0 ? kTwoPi / edges.edges_around : edges.rho);
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

/// The chosen triangles of a mesh, and the vertices that they have.
TriangleMesh part_of(const TriangleMesh& mesh, const std::vector<std::uint8_t>& chosen) {
  TriangleMesh part;
  std::vector<std::uint32_t> renamed(mesh.vertex_count(), kNoVertex);
  for (std::size_t c = 0; c < mesh.triangles.size(); ++c) {
    if (!chosen[c / 3]) continue;
    const std::uint32_t v = mesh.triangles[c];
    if (renamed[v] == kNoVertex) {
      renamed[v] = static_cast<std::uint32_t>(part.vertex_count());
      const float* p = mesh.vertices.data() + 3 * std::size_t{v};
      part.vertices.insert(part.vertices.end(), p, p + 3);
    }
    part.triangles.push_back(renamed[v]);
  }
  return part;
}

TriangleMesh joined(TriangleMesh first, const TriangleMesh& second) {
  const auto shift = static_cast<std::uint32_t>(first.vertex_count());
  first.vertices.insert(first.vertices.end(), second.vertices.begin(), second.vertices.end());
  for (const std::uint32_t v : second.triangles) first.triangles.push_back(v + shift);
  return first;
}

/// One byte a vertex: whether it lies in one of the places, or up to `margin` beyond.
std::vector<std::uint8_t> vertices_within(Backend& backend, const TriangleMesh& mesh,
                                          std::span<const CarefulPlace> places, float margin) {
  constexpr std::size_t kBlock = 4096;
  std::vector<std::uint8_t> within(mesh.vertex_count());
  backend.run((within.size() + kBlock - 1) / kBlock, [&](std::size_t block) {
    const std::size_t end = std::min((block + 1) * kBlock, within.size());
    for (std::size_t v = block * kBlock; v < end; ++v) {
      const Vec3 p = vertex_at(mesh, static_cast<std::uint32_t>(v));
      within[v] = std::any_of(places.begin(), places.end(),
                              [&](const CarefulPlace& place) { return place.holds(p, margin); });
    }
  });
  return within;
}

std::vector<CarefulPlace> where_base_stays(std::span<const CarefulPlace> places) {
  std::vector<CarefulPlace> kept;
  std::copy_if(places.begin(), places.end(), std::back_inserter(kept),
               [](const CarefulPlace& place) { return place.factor == 0; });
  return kept;
}

/// The centres of the faces between object and background.
std::vector<Vec3> find_face_centres(const Lattice& lattice, const Scale& scale) {
  std::vector<Vec3> centres;
  const auto coords = lattice.bricks.coords.view();
  const auto state = lattice.state.view();
  for (std::size_t node = 0; node < state.size; ++node) {
    if (!(state[node] & kFaceCentre)) continue;
    const BrickCoord& brick = coords[node / kBrickCells];
    const int cell = static_cast<int>(node % kBrickCells);
    centres.push_back({0.5f * scale[0] * static_cast<float>(8 * brick.x + (cell & 7)),
                       0.5f * scale[1] * static_cast<float>(8 * brick.y + (cell >> 3 & 7)),
                       0.5f * scale[2] * static_cast<float>(8 * brick.z + (cell >> 6))});
  }
  return centres;
}

double area_of(const TriangleMesh& mesh) {
  double area = 0;
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    const Vec3 a = vertex_at(mesh, mesh.triangles[3 * t]);
    area += 0.5 * double{norm(cross(vertex_at(mesh, mesh.triangles[3 * t + 1]) - a,
                                    vertex_at(mesh, mesh.triangles[3 * t + 2]) - a))};
  }
  return area;
}

/// The first vertices of the edges that have not one triangle on each side.
std::vector<std::uint32_t> bad_edges(const TriangleMesh& mesh) {
  std::vector<std::uint64_t> edges;
  edges.reserve(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t)
    for (std::size_t i = 0; i < 3; ++i)
      edges.push_back(std::uint64_t{mesh.triangles[3 * t + i]} << 32 |
                      mesh.triangles[3 * t + (i + 1) % 3]);
  std::sort(edges.begin(), edges.end());
  std::vector<std::uint32_t> bad;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const std::uint64_t back = edges[i] << 32 | edges[i] >> 32;
    const auto [first, last] = std::equal_range(edges.begin(), edges.end(), back);
    if (last - first != 1 || (i > 0 && edges[i] == edges[i - 1]))
      bad.push_back(static_cast<std::uint32_t>(edges[i] >> 32));
  }
  return bad;
}

}  // namespace

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
      farthest_(kFarShare * distance_limit(scale)) {
  for (std::size_t i = 0; i < base_.vertices.size(); ++i) base_.vertices[i] *= scale_[i % 3];
  scheduler_.begin("sizes", Stage::sizing);
  Backend& sizing = scheduler_.backend_for(Stage::sizing);
  sizing.on_host(View<const std::uint8_t>(lattice.state.view()));
  base_tree_ = build_triangle_tree(backend_, base_);
  face_centres_ = find_face_centres(lattice, scale);
  field_ = make_field(sizing, lattice, size, scale);
  sizes_ = make_sizes(sizing, field_, base_, rule_);
  if (wanted_triangles_ > 0) aim(wanted_triangles_);
  report_.predicted_triangles = sizes_.predicted_triangles;
}

/// Scales the lengths until the prediction is right: it goes with their inverse square.
void Polygonizer::aim(double triangles) {
  constexpr int kSteps = 12;
  float factor = rule_.edge_max / asked_.edge_max;
  for (int step = 0; step < kSteps; ++step) {
    const double ratio = sizes_.predicted_triangles / triangles;
    if (std::fabs(ratio - 1) < 0.005) return;
    factor *= static_cast<float>(std::sqrt(ratio));
    factor = std::clamp(factor, kLeastEdge / asked_.edge_min, kLongestEdge / asked_.edge_max);
    rule_ = scaled(asked_, factor);
    apply_rule(backend_, field_, base_, rule_, {}, sizes_);
  }
  const double reached = sizes_.predicted_triangles;
  if (std::fabs(reached / triangles - 1) <= kCountTolerance) return;
  throw Error(ErrorCode::usage, "this surface cannot have " +
                                    std::to_string(static_cast<std::int64_t>(triangles)) +
                                    " triangles: ask for about " +
                                    std::to_string(static_cast<std::int64_t>(reached)) +
                                    (reached > triangles ? " or more" : " or fewer"));
}

std::optional<TriangleMesh> Polygonizer::next() {
  switch (plan_) {
    case Plan::expand:
      last_ = expanded();
      break;
    case Plan::redo:
      last_ = redone();
      break;
    case Plan::remesh:
      last_ = remeshed();
      break;
    case Plan::stop:
      return std::nullopt;
  }
  ++report_.attempts;
  return in_voxels(last_);
}

Verdict Polygonizer::judge(const CheckReport& check) {
  if (!check.passed) {
    plan_after(defects(check));
    return Verdict::refuse;
  }
  const std::vector<Vec3> far = astray();
  if (far.empty() && count_is_right(check.triangles)) return Verdict::take;
  const bool best = !proven_ || far.size() < least_astray_;
  proven_ = true;
  if (best) least_astray_ = far.size();
  if (!far.empty()) plan_after(far);
  return best ? Verdict::keep : Verdict::refuse;
}

/// Places for the defects, each that no new place covers; its factor by how many old ones do.
void Polygonizer::note(const std::vector<Vec3>& defects, std::span<const float> factors) {
  first_fresh_ = places_.size();
  const float radius = kPlace * rule_.edge_max;
  const auto covers = [&](const CarefulPlace& place, const Vec3& p) {
    return squared_norm(p - place.centre) < 0.25f * (radius * radius);
  };
  for (const Vec3& p : defects) {
    const auto first_new = places_.begin() + static_cast<std::ptrdiff_t>(first_fresh_);
    if (std::any_of(first_new, places_.end(), [&](const auto& q) { return covers(q, p); }))
      continue;
    const auto failures = static_cast<std::size_t>(
        std::count_if(places_.begin(), first_new, [&](const auto& q) { return covers(q, p); }));
    places_.push_back({p, radius, factors[std::min(failures, factors.size() - 1)]});
  }
}

/// The next surface, after one with defects.
void Polygonizer::plan_after(const std::vector<Vec3>& defects) {
  ++failures_;
  if (plan_ != Plan::remesh) {
    note(defects, kFactors);
    plan_ = Plan::redo;
    if (!defects.empty() && failures_ < kFrontAttempts) return;
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
  places_.clear();
  apply_rule(backend_, field_, base_, rule_, places_, sizes_);
  report_.rounds = 0;
  report_.front_triangles = report_.gaps = report_.gap_triangles = 0;
}

/// Whether the number of triangles is what was asked for. If not, the next surface aims again.
bool Polygonizer::count_is_right(std::int64_t triangles) {
  if (wanted_triangles_ == 0) return true;
  const double ratio = static_cast<double>(triangles) / wanted_triangles_;
  if (std::fabs(ratio - 1) <= kCountTolerance || ++aims_ == kAims) return true;
  start_over(Plan::expand);
  aim(sizes_.predicted_triangles / ratio);
  return false;
}

TriangleMesh Polygonizer::expanded() {
  const std::vector<std::uint8_t> hard = find_hard_regions(backend_, field_, sizes_, rule_, base_);
  const TriangleMesh part = part_of(base_, hard);
  report_.hard_share = area_of(part) / area_of(base_);
  scheduler_.begin("remesh", Stage::mesh);
  TriangleMesh patches;
  if (!part.triangles.empty()) patches = remesh(backend_, field_.view(), sizes_.view(field_), part);
  const TriangleMesh mesh = front_over(patches);
  scheduler_.begin("finish", Stage::mesh);
  return approached(finish(backend_, field_.view(), sizes_.view(field_), mesh));
}

/// The last surface with the fresh places cut out, the base surface remeshed in their middle, and
/// the front in between.
TriangleMesh Polygonizer::redone() {
  scheduler_.begin("remesh", Stage::mesh);
  apply_rule(backend_, field_, base_, rule_, places_, sizes_);
  const std::span<const CarefulPlace> fresh = std::span(places_).subspan(first_fresh_);
  const float margin = kMargin * rule_.edge_max;
  std::vector<std::uint8_t> within = vertices_within(backend_, base_, fresh, 0);
  const TriangleMesh part = part_of(base_, choose_triangles(backend_, base_, within));
  const std::vector<std::uint8_t> near = vertices_within(backend_, last_, fresh, margin);
  std::vector<std::uint8_t> kept(last_.triangle_count());
  for (std::size_t t = 0; t < kept.size(); ++t) {
    const std::uint32_t* v = &last_.triangles[3 * t];
    kept[t] = !near[v[0]] && !near[v[1]] && !near[v[2]];
  }
  const TriangleMesh patches =
      joined(part_of(last_, kept),
             remesh(backend_, field_.view(), sizes_.view(field_), part, where_base_stays(fresh)));
  const TriangleMesh mesh = front_over(patches);

  scheduler_.begin("finish", Stage::mesh);
  std::vector<CarefulPlace> round = where_base_stays(places_);
  for (const CarefulPlace& place : fresh)
    if (place.factor > 0) round.push_back({place.centre, place.radius + 2 * margin, 1});
  return approached(finish(backend_, field_.view(), sizes_.view(field_), mesh, round));
}

/// The front round the patches, its gaps stitched.
TriangleMesh Polygonizer::front_over(const TriangleMesh& patches) {
  scheduler_.begin("expand", Stage::mesh);
  FrontResult front = expand(backend_, field_, sizes_, patches);
  report_.rounds += front.rounds;
  report_.front_triangles +=
      static_cast<std::int64_t>(front.mesh.triangle_count() - patches.triangle_count());

  scheduler_.begin("stitch", Stage::mesh);
  const StitchReport stitched =
      stitch_gaps(backend_, field_.view(), sizes_.view(field_), stitch_, front.loops, front.mesh);
  report_.gaps += stitched.loops;
  report_.gap_triangles +=
      static_cast<std::int64_t>(front.mesh.triangle_count() - stitched.first_triangle);
  split_pinches(front.mesh);
  return std::move(front.mesh);
}

TriangleMesh Polygonizer::remeshed() {
  scheduler_.begin("remesh", Stage::mesh);
  report_.hard_share = 1;
  return approached(remesh(backend_, field_.view(), sizes_.view(field_), base_, places_));
}

/// The surface, its vertices brought back to the base surface, and it to the face centres, where
/// they are too far.
TriangleMesh Polygonizer::approached(TriangleMesh mesh) {
  const FieldView field = field_.view();
  const SizeView sizes = sizes_.view(field_);
  mesh = bring_back(backend_, field, sizes, base_, base_tree_, kStray, std::move(mesh));
  return approach(backend_, field, sizes, face_centres_, kNearShare * distance_limit(scale_),
                  std::move(mesh));
}

/// The face centres that the last surface is too far from.
std::vector<Vec3> Polygonizer::astray() const {
  const std::vector<float> distances =
      distances_to(backend_, face_centres_, last_, build_triangle_tree(backend_, last_));
  std::vector<Vec3> found;
  for (std::size_t i = 0; i < distances.size(); ++i)
    if (distances[i] > farthest_) found.push_back(face_centres_[i]);
  return found;
}

/// Where the last surface is open, has an edge of several triangles or meets itself; where none of
/// these explains its topology, where its curvature is not the base surface's.
std::vector<Vec3> Polygonizer::defects(const CheckReport& check) const {
  std::vector<Vec3> found;
  for (const std::uint32_t v : bad_edges(last_)) found.push_back(vertex_at(last_, v));
  if (check.intersecting_pairs > 0) {
    const Intersections pairs =
        find_intersections(backend_, last_, build_triangle_tree(backend_, last_));
    for (const CarefulPlace& place : places_of(last_, pairs.pairs, 1, 1))
      found.push_back(place.centre);
  }
  return found.empty() ? curvature_differences(base_, last_) : found;
}

TriangleMesh Polygonizer::in_voxels(TriangleMesh mesh) const {
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) mesh.vertices[i] /= scale_[i % 3];
  return mesh;
}

}  // namespace vasamesh
