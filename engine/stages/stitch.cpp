#include "stages/stitch.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "stages/bridge.h"
#include "stages/gap_rim.h"
#include "stages/gap_rules.h"
#include "stages/refine_patch.h"

namespace vasamesh {

namespace {

// What is tried for a gap, in this order.
struct Attempt {
  float least_cosine, middle_cosine, reach;  // as in GapRules
  bool star;                                 // a vertex in the middle instead of chords
};
constexpr Attempt kAttempts[] = {{0.5f, 0.5f, 0.35f, false},  {0.25f, 0.25f, 0.35f, false},
                                 {0.25f, 0.25f, 0.35f, true}, {0.0f, 0.1f, 0.35f, false},
                                 {0.0f, 0.1f, 0.5f, true},    {0.0f, 0.1f, 0.5f, false},
                                 {-0.3f, 0.1f, 0.5f, false}};
constexpr std::size_t kAnnularAttempts = 5;  // for a loop that may go round a tube: none caps it
constexpr Attempt kBridgeRules{0.25f, 0.25f, 0.35f, false};
constexpr std::size_t kMostCorners = 512;  // of a gap
constexpr std::size_t kMostStarred = 16;   // corners of a gap that a vertex in its middle may close
constexpr int kMostRounds = 16;            // of triangulation, while gaps want the same edges
constexpr std::size_t kTaskCost = 200000;  // what a task takes, in the units of gap_cost
constexpr float kAxisSteps = 4;            // along a gap's axis, as far as its corners are
constexpr int kNewtonSteps = 6;

enum class Closing : std::uint8_t { pending, triangulated, starred, open };

/// About how many steps a gap of n corners takes.
std::size_t gap_cost(std::size_t n) { return n * n * n / 6 + 20 * n * n + 50 * n; }

/// A chord that another gap has.
struct Taken {
  std::uint32_t loop, a, b;  ///< a < b
};

/// A chord that a gap wants: the first in order gets it.
struct Claim {
  std::uint32_t a, b;      ///< a < b
  std::uint32_t repeated;  ///< 1 in the rounds after the first: what was given stays
  std::uint32_t loop;
  bool operator<(const Claim& c) const {
    return std::tie(a, b, repeated, loop) < std::tie(c.a, c.b, c.repeated, c.loop);
  }
};

/// Workspace of one task: one gap at a time, as the triangulation wants it.
struct GapWork {
  std::vector<Vec3> points, normals, across;
  std::vector<std::uint8_t> chords;
  GapTriangulator triangulator;
};

/// What one task adds to the mesh; vertices of its own count on from the mesh's.
struct Added {
  std::vector<Vec3> points;
  std::vector<std::uint32_t> triangles;
};

class Stitcher {
 public:
  Stitcher(Backend& backend, const FieldView& field, const SizeView& sizes, StitchMode mode,
           const GapLoops& loops, TriangleMesh& mesh)
      : backend_(backend),
        field_(field),
        sizes_(sizes),
        mode_(mode),
        mesh_(mesh),
        rim_(backend, field, mesh, loops) {
    report_.loops = static_cast<std::int64_t>(loops.count());
    report_.first_vertex = mesh.vertex_count();
    report_.first_triangle = mesh.triangle_count();
    BridgedLoops bridged = bridge_loops(backend, mesh, rules(kBridgeRules), loops, rim_);
    report_.bridges = bridged.bridges;
    report_.splits = bridged.splits;
    loops_ = std::move(bridged.loops);
    annular_ = std::move(bridged.annular);
    mesh.triangles.insert(mesh.triangles.end(), bridged.triangles.begin(), bridged.triangles.end());
  }

  StitchReport run() {
    prepare();
    std::vector<std::uint32_t> pending = by_size();
    for (int round = 0; !pending.empty(); ++round) {
      triangulate(pending);
      pending = commit(round + 1 == kMostRounds);
      report_.repeated += static_cast<std::int64_t>(pending.size());
    }
    append_patches();
    for (std::size_t l = 0; l < loops_.count(); ++l) {
      report_.relaxed += relaxed_[l];
      report_.starred += closing_[l] == Closing::starred;
      if (closing_[l] == Closing::open)
        report_.open.push_back({{loops_[l].begin(), loops_[l].end()}, failure_[l]});
    }
    return std::move(report_);
  }

 private:
  GapRules rules(const Attempt& attempt) const {
    return {field_, attempt.least_cosine, attempt.middle_cosine, attempt.reach};
  }

  /// Where a loop's triangles are kept: n - 2 a loop, so that the places follow from the sizes.
  std::size_t place_of(std::size_t loop) const {
    return 3 * (std::size_t{loops_.first[loop]} - 2 * loop);
  }

  void prepare() {
    const std::size_t count = loops_.count();
    closing_.assign(count, Closing::pending);
    failure_.assign(count, GapFailure::no_triangulation);
    relaxed_.assign(count, 0);
    repeated_.assign(count, 0);
    middles_.assign(count, Vec3{});
    triangles_.resize(count == 0 ? 0 : place_of(count));
    shared_.assign(mesh_.vertex_count(), 0);
    for (std::uint32_t v : loops_.vertex)
      shared_[v] = static_cast<std::uint8_t>(std::min(shared_[v] + 1, 2));
  }

  /// All loops, the largest first, so that the long ones do not come last.
  std::vector<std::uint32_t> by_size() const {
    std::vector<std::uint32_t> order(loops_.count());
    for (std::uint32_t l = 0; l < order.size(); ++l) order[l] = l;
    std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
      return loops_.size(a) > loops_.size(b);
    });
    return order;
  }

  /// Parts of `gaps` of about equal cost: where each starts, and the end.
  std::vector<std::size_t> parts_of(const std::vector<std::uint32_t>& gaps) const {
    std::vector<std::size_t> starts{0};
    std::size_t cost = 0;
    for (std::size_t i = 0; i < gaps.size(); ++i) {
      cost += gap_cost(loops_.size(gaps[i]));
      if (cost < kTaskCost && i + 1 < gaps.size()) continue;
      starts.push_back(i + 1);
      cost = 0;
    }
    return starts;
  }

  void triangulate(const std::vector<std::uint32_t>& gaps) {
    const std::vector<std::size_t> starts = parts_of(gaps);
    backend_.run(starts.size() - 1, [&](std::size_t part) {
      GapWork work;
      for (std::size_t i = starts[part]; i < starts[part + 1]; ++i) close(gaps[i], work);
    });
  }

  /// Finds the triangles of one gap.
  void close(std::uint32_t l, GapWork& work) {
    const auto loop = loops_[l];
    closing_[l] = Closing::open;
    if (loop.size() > kMostCorners) {
      failure_[l] = GapFailure::too_long;
      return;
    }
    // One triangle that has its other side in the surface already.
    if (loop.size() == 3 && rim_.across(loop[0], loop[1]) == loop[2]) return;
    load(l, work);
    const std::span attempts(kAttempts, annular_[l] ? kAnnularAttempts : std::size(kAttempts));
    float reach = 0;
    for (const Attempt& attempt : attempts) {
      if (attempt.reach != reach) find_chords(l, rules(attempt), work);
      reach = attempt.reach;
      if (!(attempt.star ? close_by_star(l, rules(attempt), work)
                         : close_by_chords(l, rules(attempt), work)))
        continue;
      closing_[l] = attempt.star ? Closing::starred : Closing::triangulated;
      relaxed_[l] = &attempt != kAttempts;
      return;
    }
  }

  void load(std::uint32_t l, GapWork& work) const {
    const auto loop = loops_[l];
    const std::size_t n = loop.size();
    work.points.resize(n);
    work.normals.resize(n);
    work.across.resize(n);
    work.chords.resize(n * n);
    for (std::size_t i = 0; i < n; ++i) {
      work.points[i] = position(mesh_, loop[i]);
      work.normals[i] = rim_.normal(loop[i]);
      if (mode_ == StitchMode::paper) work.across[i] = normal_across(loop[i], loop[(i + 1) % n]);
    }
  }

  void find_chords(std::uint32_t l, const GapRules& rules, GapWork& work) const {
    const auto loop = loops_[l];
    const std::size_t n = loop.size();
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = i + 2; j < n; ++j)
        work.chords[n * i + j] = work.chords[n * j + i] =
            j - i + 1 < n && is_free(loop[i], loop[j]) &&
            chord_follows_surface(rules, work.points[i], work.points[j]);
    for (const Taken& taken : taken_) {
      if (taken.loop != l) continue;
      for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < n; ++j)
          if (loop[i] == taken.a && loop[j] == taken.b)
            work.chords[n * i + j] = work.chords[n * j + i] = 0;
    }
  }

  bool is_free(std::uint32_t a, std::uint32_t b) const { return a != b && !rim_.has_edge(a, b); }

  Vec3 normal_across(std::uint32_t a, std::uint32_t b) const {
    const std::uint32_t c = rim_.across(a, b);
    if (c == GapRim::kNoVertex) return {};
    const Vec3 at = position(mesh_, a);
    return normalised(cross(position(mesh_, c) - at, position(mesh_, b) - at));
  }

  bool close_by_chords(std::uint32_t l, const GapRules& rules, GapWork& work) {
    const GapPolygon polygon{work.points, work.normals, work.across, work.chords};
    if (!work.triangulator.run(polygon, rules, mode_)) return false;
    const auto found = work.triangulator.triangles();
    std::copy(found.begin(), found.end(), triangles_.begin() + place_of(l));
    return true;
  }

  /// One vertex in the middle of the gap, joined to every edge.
  bool close_by_star(std::uint32_t l, const GapRules& rules, const GapWork& work) {
    const std::size_t n = work.points.size();
    if (n > kMostStarred) return false;
    Vec3 middle, normal;
    if (!find_middle(work, middle, normal)) return false;
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t j = (i + 1) % n;
      const Vec3 points[3] = {work.points[i], work.points[j], middle};
      const Vec3 normals[3] = {work.normals[i], work.normals[j], normal};
      if (!triangle_follows_surface(rules, points, normals)) return false;
    }
    middles_[l] = middle;
    return true;
  }

  /// Where the gap's axis (through the mean of its corners, along the vector of its area) meets
  /// the surface: over a vessel's end, too, that is its tip.
  bool find_middle(const GapWork& work, Vec3& middle, Vec3& normal) const {
    const std::size_t n = work.points.size();
    Vec3 mean, axis;
    for (const Vec3& p : work.points) mean = mean + p;
    mean = (1.0f / static_cast<float>(n)) * mean;
    float reach = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const Vec3 to = work.points[i] - mean;
      axis = axis + cross(to, work.points[(i + 1) % n] - mean);
      reach = std::max(reach, norm(to));
    }
    axis = normalised(axis);
    FieldSample sample = sample_field(field_, mean);
    const bool inside = sample.value > 0;
    const Vec3 step = ((inside ? 1.0f : -1.0f) * reach / kAxisSteps) * axis;
    middle = mean;
    for (int i = 0;
         i < 2 * static_cast<int>(kAxisSteps) && sample.known && (sample.value > 0) == inside;
         ++i) {
      middle = middle + step;
      sample = sample_field(field_, middle);
    }
    if (!sample.known || (sample.value > 0) == inside) return false;
    sample = project_to_surface(field_, reach, kNewtonSteps, middle);
    normal = normalised(-sample.gradient);
    return sample.known;
  }

  /// Gives each chord to the first gap that wants it. \return the gaps that must be triangulated
  /// again; none, and those open, when it is the last round.
  std::vector<std::uint32_t> commit(bool last) {
    std::vector<Claim> claims;
    for (std::uint32_t l = 0; l < loops_.count(); ++l)
      if (closing_[l] == Closing::triangulated) claim_chords(l, claims);
    std::sort(claims.begin(), claims.end());
    std::vector<std::uint32_t> losers;
    for (std::size_t i = 1; i < claims.size(); ++i) {
      if (claims[i].a != claims[i - 1].a || claims[i].b != claims[i - 1].b) continue;
      taken_.push_back({claims[i].loop, claims[i].a, claims[i].b});
      losers.push_back(claims[i].loop);
    }
    std::sort(losers.begin(), losers.end());
    losers.erase(std::unique(losers.begin(), losers.end()), losers.end());
    repeated_.assign(loops_.count(), 0);
    for (std::uint32_t l : losers) {
      closing_[l] = last ? Closing::open : Closing::pending;
      failure_[l] = GapFailure::edge_taken;
      repeated_[l] = 1;
    }
    if (last) losers.clear();
    return losers;
  }

  /// Chords between vertices that lie on two gaps, or twice on one: only they can be wanted twice.
  void claim_chords(std::uint32_t l, std::vector<Claim>& claims) const {
    const auto loop = loops_[l];
    const std::size_t n = loop.size();
    const std::uint16_t* t = triangles_.data() + place_of(l);
    for (std::size_t e = 0; e < 3 * (n - 2); ++e) {
      // Corners ascend in a triangle: its last edge leads back. A chord is the last edge of one
      // of its two triangles.
      if (e % 3 != 2 || t[e] - t[e - 2] + std::size_t{1} == n) continue;
      const std::uint32_t a = loop[t[e - 2]], b = loop[t[e]];
      if (shared_[a] > 1 && shared_[b] > 1)
        claims.push_back({std::min(a, b), std::max(a, b), repeated_[l], l});
    }
  }

  void append_patches() {
    std::vector<std::uint32_t> closed;
    for (std::uint32_t l = 0; l < loops_.count(); ++l)
      if (closing_[l] != Closing::open) closed.push_back(l);
    const std::vector<std::size_t> starts = parts_of(closed);
    std::vector<Added> added(starts.size() - 1);
    backend_.run(added.size(), [&](std::size_t part) {
      PatchRefiner refiner(field_, sizes_);
      Patch patch;
      for (std::size_t i = starts[part]; i < starts[part + 1]; ++i) {
        load_patch(closed[i], patch);
        refiner.run(patch);
        add_patch(loops_[closed[i]], patch, added[part]);
      }
    });
    const auto base = static_cast<std::uint32_t>(mesh_.vertex_count());
    for (const Added& part : added) {
      const auto shift = static_cast<std::uint32_t>(mesh_.vertex_count()) - base;
      for (const Vec3& p : part.points)
        mesh_.vertices.insert(mesh_.vertices.end(), {p.x, p.y, p.z});
      for (std::uint32_t v : part.triangles) mesh_.triangles.push_back(v < base ? v : v + shift);
    }
  }

  void load_patch(std::uint32_t l, Patch& patch) const {
    const auto loop = loops_[l];
    const auto n = static_cast<std::uint32_t>(loop.size());
    patch.points.clear();
    patch.normals.clear();
    patch.triangles.clear();
    for (std::uint32_t v : loop) {
      patch.points.push_back(position(mesh_, v));
      patch.normals.push_back(rim_.normal(v));
    }
    patch.rim = n;
    if (closing_[l] == Closing::starred) {
      const FieldSample sample = sample_field(field_, middles_[l]);
      patch.points.push_back(middles_[l]);
      patch.normals.push_back(normalised(-sample.gradient));
      for (std::uint32_t i = 0; i < n; ++i)
        patch.triangles.insert(patch.triangles.end(), {i, (i + 1) % n, n});
    } else {
      const auto first = triangles_.begin() + place_of(l);
      patch.triangles.assign(first, first + 3 * (n - 2));
    }
  }

  void add_patch(std::span<const std::uint32_t> loop, const Patch& patch, Added& added) const {
    const std::size_t n = loop.size();
    const std::size_t first = mesh_.vertex_count() + added.points.size();
    added.points.insert(added.points.end(), patch.points.begin() + n, patch.points.end());
    for (std::uint32_t v : patch.triangles)
      added.triangles.push_back(v < n ? loop[v] : static_cast<std::uint32_t>(first + (v - n)));
  }

  Backend& backend_;
  const FieldView field_;
  const SizeView sizes_;
  const StitchMode mode_;
  TriangleMesh& mesh_;
  GapRim rim_;
  GapLoops loops_;
  // A loop each:
  std::vector<Closing> closing_;
  std::vector<GapFailure> failure_;  ///< says something where the gap is open
  std::vector<std::uint8_t> annular_;
  std::vector<std::uint8_t> relaxed_;
  std::vector<std::uint8_t> repeated_;
  std::vector<Vec3> middles_;  ///< of starred gaps
  std::vector<std::uint16_t> triangles_;
  std::vector<std::uint8_t> shared_;  ///< a vertex: corners of loops there, at most 2
  std::vector<Taken> taken_;
  StitchReport report_;
};

}  // namespace

StitchReport stitch_gaps(Backend& backend, const FieldView& field, const SizeView& sizes,
                         StitchMode mode, const GapLoops& loops, TriangleMesh& mesh) {
  GapLoops gaps;
  gaps.first.push_back(0);
  for (std::size_t l = 0; l < loops.count(); ++l)
    if (loops.size(l) > 2) gaps.add(loops[l]);
  return Stitcher(backend, field, sizes, mode, gaps, mesh).run();
}

StitchReport stitch_gaps(Backend& backend, const FieldView& field, const SizeView& sizes,
                         StitchMode mode, TriangleMesh& mesh) {
  return stitch_gaps(backend, field, sizes, mode, find_gap_loops(backend, mesh), mesh);
}

}  // namespace vasamesh
