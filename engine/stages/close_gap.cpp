#include "stages/close_gap.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace vasamesh {

namespace {

constexpr std::size_t kAnnularAttempts = 5;
constexpr std::size_t kMostStarred = 16;  // corners of a gap that a vertex may close
constexpr int kAxisSteps = 4;             // along a gap's axis, as far as its corners are
constexpr int kNewtonSteps = 6;
constexpr std::size_t kBatchEntries = 1u << 20;  // of the tables of a batch, or one gap's

}  // namespace

/// What is tried for a gap, in this order.
struct GapCloser::Attempt {
  float least_cosine, middle_cosine, reach;  // as in GapRules
  bool star;                                 // a vertex in the middle instead of chords
};

constexpr GapCloser::Attempt GapCloser::kAttempts[] = {
    {0.5f, 0.5f, 0.35f, false}, {0.25f, 0.25f, 0.35f, false}, {0.25f, 0.25f, 0.35f, true},
    {0.0f, 0.1f, 0.35f, false}, {0.0f, 0.1f, 0.5f, true},     {0.0f, 0.1f, 0.5f, false},
    {-0.3f, 0.1f, 0.5f, false}, {0.0f, 0.1f, 2.0f, false},    {-0.3f, 0.0f, 2.0f, true},
    {-0.3f, 0.0f, 2.0f, false}, {-0.7f, -0.3f, 2.0f, true},   {-0.7f, -0.3f, 2.0f, false},
    {-1.0f, -1.0f, 2.0f, false}};

void GapCloser::run(std::span<const GapToClose> gaps) {
  std::size_t start = 0, entries = 0;
  for (std::size_t g = 0; g < gaps.size(); ++g) {
    const std::size_t own = gaps[g].loop.size() * gaps[g].loop.size();
    if (g > start && entries + own > kBatchEntries) {
      close_batch(gaps.subspan(start, g - start));
      start = g;
      entries = 0;
    }
    entries += own;
  }
  close_batch(gaps.subspan(start));
}

/// False for one triangle that has its other side in the surface already.
bool GapCloser::is_possible(const GapToClose& gap) const {
  return gap.loop.size() > 3 || rim_.across(gap.loop[0], gap.loop[1]) != gap.loop[2];
}

void GapCloser::close_batch(std::span<const GapToClose> gaps) {
  std::vector<const GapToClose*> open;
  for (const GapToClose& gap : gaps) {
    *gap.closing = {};
    if (is_possible(gap)) open.push_back(&gap);
  }
  std::size_t loaded = 0;
  for (std::size_t a = 0; a < std::size(kAttempts) && !open.empty(); ++a) {
    if (a == kAnnularAttempts)
      std::erase_if(open, [](const GapToClose* gap) { return gap->annular; });
    if (open.size() != loaded) load(open);
    loaded = open.size();
    const Attempt& attempt = kAttempts[a];
    const GapRules rules{field_, attempt.least_cosine, attempt.middle_cosine, attempt.reach};
    if (attempt.star)
      close_by_stars(rules, open);
    else
      triangulate(rules, open);
    std::erase_if(open, [a](const GapToClose* gap) {
      gap->closing->relaxed = gap->closing->kind != GapClosing::open && a > 0;
      return gap->closing->kind != GapClosing::open;
    });
  }
}

void GapCloser::load(std::span<const GapToClose* const> gaps) {
  std::vector<std::uint32_t> first{0}, chord_first{0};
  for (const GapToClose* gap : gaps) {
    const auto n = static_cast<std::uint32_t>(gap->loop.size());
    first.push_back(first.back() + n);
    chord_first.push_back(chord_first.back() + n * n);
  }
  first_.resize(backend_, first.size());
  chord_first_.resize(backend_, first.size());
  backend_.upload<std::uint32_t>(first_.view(), first);
  backend_.upload<std::uint32_t>(chord_first_.view(), chord_first);
  points_.resize(backend_, first.back());
  normals_.resize(backend_, first.back());
  across_.resize(backend_, mode_ == StitchMode::paper ? first.back() : 0);
  chords_.resize(backend_, chord_first.back());
  closed_.resize(backend_, gaps.size());
  triangles_.resize(backend_, 3 * (first.back() - 2 * gaps.size()));
  for (Buffer<Vec3>* vectors : {&points_, &normals_, &across_}) backend_.on_host(vectors->view());
  backend_.on_host(chords_.view());
  const auto starts =
      parts_of_gaps(gaps.size(), [&](std::size_t g) { return gaps[g]->loop.size(); });
  backend_.run(starts.size() - 1, [&](std::size_t part) {
    for (std::size_t g = starts[part]; g < starts[part + 1]; ++g) load_gap(*gaps[g], g);
  });
}

void GapCloser::load_gap(const GapToClose& gap, std::size_t g) {
  const auto& loop = gap.loop;
  const std::size_t n = loop.size(), first = first_.view()[g];
  std::uint8_t* chords = &chords_.view()[chord_first_.view()[g]];
  for (std::size_t i = 0; i < n; ++i) {
    points_.view()[first + i] = vertex_at(mesh_, loop[i]);
    normals_.view()[first + i] = rim_.normal(loop[i]);
    if (mode_ == StitchMode::paper)
      across_.view()[first + i] = normal_across(loop[i], loop[(i + 1) % n]);
    for (std::size_t j = i; j < n; ++j)
      chords[n * i + j] = chords[n * j + i] =
          j > i + 1 && j - i + 1 < n && loop[i] != loop[j] && !rim_.has_edge(loop[i], loop[j]);
  }
  for (const TakenChord& chord : gap.taken)
    chords[n * chord.i + chord.j] = chords[n * chord.j + chord.i] = 0;
}

Vec3 GapCloser::normal_across(std::uint32_t a, std::uint32_t b) const {
  const std::uint32_t c = rim_.across(a, b);
  if (c == GapRim::kNoVertex) return {};
  const Vec3 at = vertex_at(mesh_, a);
  return normalised(cross(vertex_at(mesh_, c) - at, vertex_at(mesh_, b) - at));
}

GapView GapCloser::view() const {
  return {first_.view(),   chord_first_.view(), points_.view(),
          normals_.view(), across_.view(),      chords_.view()};
}

void GapCloser::triangulate(const GapRules& rules, std::span<const GapToClose* const> gaps) {
  backend_.stitch_triangulate(rules, mode_, view(), closed_.view(), triangles_.view());
  const auto closed = backend_.on_host(std::as_const(closed_).view());
  const auto triangles = backend_.on_host(std::as_const(triangles_).view());
  const std::uint16_t* from = triangles.data();
  for (std::size_t g = 0; g < gaps.size(); ++g) {
    const std::size_t corners = 3 * (gaps[g]->loop.size() - 2);
    if (closed[g]) {
      gaps[g]->closing->kind = GapClosing::triangulated;
      std::copy_n(from, corners, gaps[g]->triangles);
    }
    from += corners;
  }
}

void GapCloser::close_by_stars(const GapRules& rules, std::span<const GapToClose* const> gaps) {
  const GapView all = view();
  backend_.on_host(all.points);
  backend_.on_host(all.normals);
  const auto starts =
      parts_of_gaps(gaps.size(), [&](std::size_t g) { return gaps[g]->loop.size(); });
  backend_.run(starts.size() - 1, [&](std::size_t part) {
    for (std::size_t g = starts[part]; g < starts[part + 1]; ++g)
      if (close_by_star(rules, gap_polygon(all, g), gaps[g]->closing->middle))
        gaps[g]->closing->kind = GapClosing::starred;
  });
}

bool GapCloser::close_by_star(const GapRules& rules, const GapPolygon& polygon,
                              Vec3& middle) const {
  const std::size_t n = polygon.points.size();
  Vec3 normal;
  if (n > kMostStarred || !find_middle(polygon.points, middle, normal)) return false;
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t j = (i + 1) % n;
    const Vec3 points[3] = {polygon.points[i], polygon.points[j], middle};
    const Vec3 normals[3] = {polygon.normals[i], polygon.normals[j], normal};
    if (!triangle_follows_surface(rules, points, normals)) return false;
  }
  return true;
}

/// Where the gap's axis (through the mean of its corners, along the vector of its area) meets the
/// surface: over a vessel's end, too, that is its tip.
bool GapCloser::find_middle(std::span<const Vec3> points, Vec3& middle, Vec3& normal) const {
  const std::size_t n = points.size();
  Vec3 mean, axis;
  for (const Vec3& p : points) mean = mean + p;
  mean = (1.0f / static_cast<float>(n)) * mean;
  float reach = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 to = points[i] - mean;
    axis = axis + cross(to, points[(i + 1) % n] - mean);
    reach = std::max(reach, norm(to));
  }
  FieldSample sample = sample_field(field_, mean);
  const bool inside = sample.value > 0;
  const float length = (inside ? reach : -reach) / static_cast<float>(kAxisSteps);
  const Vec3 step = length * normalised(axis);
  middle = mean;
  for (int i = 0; i < 2 * kAxisSteps && sample.known && (sample.value > 0) == inside; ++i) {
    middle = middle + step;
    sample = sample_field(field_, middle);
  }
  if (!sample.known || (sample.value > 0) == inside) return false;
  sample = project_to_surface(field_, reach, kNewtonSteps, middle);
  normal = normalised(-sample.gradient);
  return sample.known;
}

}  // namespace vasamesh
