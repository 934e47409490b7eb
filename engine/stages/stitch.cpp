#include "stages/stitch.h"

#include <algorithm>
#include <span>
#include <tuple>
#include <utility>

#include "stages/bridge.h"
#include "stages/close_gap.h"
#include "stages/gap_rim.h"
#include "stages/gap_rules.h"
#include "stages/refine_patch.h"
#include "types/angles.h"

namespace vasamesh {

namespace {

constexpr float kBridgeCosine = 0.25f;  // of the triangles of bridges, as in GapRules
// A loop that found no other to join and turns by less (radians) may go round a tube.
constexpr float kTubeTurning = 0.5f * kPi;
constexpr int kMostRounds = 16;  // of triangulation, while gaps want the same edges

/// A chord that a gap wants: the first in order gets it.
struct Claim {
  std::uint32_t a, b;      ///< a < b
  std::uint32_t repeated;  ///< 1 where it was triangulated again: what others have stays theirs
  std::uint32_t loop;
  TakenChord chord;  ///< its corners
  bool operator<(const Claim& c) const {
    return std::tie(a, b, repeated, loop, chord.i, chord.j) <
           std::tie(c.a, c.b, c.repeated, c.loop, c.chord.i, c.chord.j);
  }
};

/// A chord that a gap lost to another, or to another place of its own.
struct Lost {
  std::uint32_t loop;
  TakenChord chord;
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
        mesh_(mesh),
        rim_(backend, field, mesh, loops),
        closer_(backend, field, mesh, rim_, mode) {
    report_.loops = static_cast<std::int64_t>(loops.count());
    report_.first_vertex = mesh.vertex_count();
    report_.first_triangle = mesh.triangle_count();
    bridged_ = bridge_loops(backend, mesh, {field, kBridgeCosine, kBridgeCosine}, loops, rim_);
    report_.bridges = bridged_.bridges;
    report_.splits = bridged_.splits;
    mesh.triangles.insert(mesh.triangles.end(), bridged_.triangles.begin(),
                          bridged_.triangles.end());
  }

  StitchReport run() {
    const GapLoops& gaps = loops();
    closings_.resize(gaps.count());
    lost_count_.assign(gaps.count(), 0);
    triangles_.resize(place_of(gaps.count()));
    count_corners();
    std::vector<std::uint32_t> pending = by_size();
    for (int round = 1; !pending.empty(); ++round) {
      triangulate(pending);
      pending = settle_claims(round == kMostRounds);
      report_.repeated += static_cast<std::int64_t>(pending.size());
    }
    append_patches();
    fill_report();
    return std::move(report_);
  }

 private:
  const GapLoops& loops() const { return bridged_.loops; }

  /// Where a loop's triangles are kept: n - 2 a loop, so that the places follow from the sizes.
  std::size_t place_of(std::size_t loop) const { return 3 * (loops().first[loop] - 2 * loop); }

  void count_corners() {
    shared_.assign(mesh_.vertex_count(), 0);
    for (std::uint32_t v : loops().vertex)
      shared_[v] = static_cast<std::uint8_t>(std::min(shared_[v] + 1, 2));
  }

  /// All loops, the largest first, so that the long ones do not come last.
  std::vector<std::uint32_t> by_size() const {
    std::vector<std::uint32_t> order(loops().count());
    for (std::uint32_t l = 0; l < order.size(); ++l) order[l] = l;
    std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
      return loops().size(a) > loops().size(b);
    });
    return order;
  }

  std::vector<std::size_t> parts_of(const std::vector<std::uint32_t>& gaps) const {
    return parts_of_gaps(gaps.size(), [&](std::size_t i) { return loops().size(gaps[i]); });
  }

  /// Closes each of the gaps by itself.
  void triangulate(const std::vector<std::uint32_t>& gaps) {
    std::vector<GapToClose> to_close;
    for (const std::uint32_t l : gaps) {
      if (loops().size(l) > kMostGapCorners) continue;
      GapToClose& gap = to_close.emplace_back();
      gap.loop = loops()[l];
      gap.annular = bridged_.turning[l] < kTubeTurning;
      for (const Lost& lost : lost_)
        if (lost.loop == l) gap.taken.push_back(lost.chord);
      gap.closing = &closings_[l];
      gap.triangles = triangles_.data() + place_of(l);
    }
    closer_.run(to_close);
  }

  /// Gives each chord to the first gap that wants it, those of earlier rounds before the others.
  /// \return the gaps that lost one and must be triangulated again; after the last round they
  /// stay open instead.
  std::vector<std::uint32_t> settle_claims(bool last) {
    std::vector<Claim> claims;
    for (std::uint32_t l = 0; l < loops().count(); ++l)
      if (closings_[l].kind == GapClosing::triangulated) claim_chords(l, claims);
    std::sort(claims.begin(), claims.end());
    std::vector<std::uint32_t> losers;
    for (std::size_t i = 1; i < claims.size(); ++i) {
      if (claims[i].a != claims[i - 1].a || claims[i].b != claims[i - 1].b) continue;
      lost_.push_back({claims[i].loop, claims[i].chord});
      losers.push_back(claims[i].loop);
    }
    std::sort(losers.begin(), losers.end());
    losers.erase(std::unique(losers.begin(), losers.end()), losers.end());
    for (std::uint32_t l : losers) {
      ++lost_count_[l];
      closings_[l] = {};
    }
    if (last) losers.clear();
    return losers;
  }

  /// Chords from a vertex that lies on two gaps, or twice on one: only they can be wanted twice.
  void claim_chords(std::uint32_t l, std::vector<Claim>& claims) const {
    const auto loop = loops()[l];
    const std::size_t n = loop.size();
    // Triangles are (i, k, j), i < k < j, and each chord is the edge i - j of one of them.
    const std::uint16_t* t = triangles_.data() + place_of(l);
    for (const std::uint16_t* end = t + 3 * (n - 2); t != end; t += 3) {
      if (t[2] - t[0] + std::size_t{1} == n) continue;
      const std::uint32_t a = loop[t[0]], b = loop[t[2]];
      if (shared_[a] > 1 || shared_[b] > 1)
        claims.push_back({std::min(a, b), std::max(a, b), lost_count_[l], l, {t[0], t[2]}});
    }
  }

  /// Refines the patches and adds them to the mesh, in the order of the loops.
  void append_patches() {
    std::vector<std::uint32_t> closed;
    for (std::uint32_t l = 0; l < loops().count(); ++l)
      if (closings_[l].kind != GapClosing::open) closed.push_back(l);
    const std::vector<std::size_t> starts = parts_of(closed);
    std::vector<Added> added(starts.size() - 1);
    backend_.run(added.size(), [&](std::size_t part) {
      PatchRefiner refiner(field_, sizes_);
      Patch patch;
      for (std::size_t i = starts[part]; i < starts[part + 1]; ++i) {
        load_patch(closed[i], patch);
        refiner.run(patch);
        add_patch(loops()[closed[i]], patch, added[part]);
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
    const auto loop = loops()[l];
    const auto n = static_cast<std::uint32_t>(loop.size());
    patch.points.clear();
    patch.normals.clear();
    patch.triangles.clear();
    patch.rim = n;
    for (std::uint32_t v : loop) {
      patch.points.push_back(vertex_at(mesh_, v));
      patch.normals.push_back(rim_.normal(v));
    }
    if (closings_[l].kind == GapClosing::starred) {
      patch.points.push_back(closings_[l].middle);
      patch.normals.push_back(normalised(-sample_field(field_, closings_[l].middle).gradient));
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

  void fill_report() {
    for (std::size_t l = 0; l < loops().count(); ++l) {
      const GapClosing& closing = closings_[l];
      report_.relaxed += closing.relaxed;
      report_.starred += closing.kind == GapClosing::starred;
      if (closing.kind != GapClosing::open) continue;
      const GapFailure reason = loops().size(l) > kMostGapCorners ? GapFailure::too_long
                                : lost_count_[l] > 0              ? GapFailure::edge_taken
                                                                  : GapFailure::no_triangulation;
      report_.open.push_back({{loops()[l].begin(), loops()[l].end()}, reason});
    }
  }

  Backend& backend_;
  const FieldView field_;
  const SizeView sizes_;
  TriangleMesh& mesh_;
  GapRim rim_;
  BridgedLoops bridged_;
  GapCloser closer_;
  std::vector<GapClosing> closings_;       ///< a loop
  std::vector<std::uint32_t> lost_count_;  ///< a loop: rounds in which it lost an edge
  std::vector<std::uint16_t> triangles_;   ///< corners of the loops
  std::vector<std::uint8_t> shared_;       ///< a vertex: corners of loops there, at most 2
  std::vector<Lost> lost_;
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
