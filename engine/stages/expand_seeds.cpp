#include "stages/expand_seeds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "backend/ranges.h"
#include "stages/compass.h"
#include "stages/expand_checks.h"
#include "stages/expand_place.h"
#include "stages/expand_rules.h"

namespace vasamesh {

namespace {

constexpr float kApart = 10.0f;  // edge lengths between seeds
constexpr float kClear = 2.1f;   // edge lengths from a seed's centre to any vertex
constexpr float kSeedTau = 0.6f;
constexpr float kOffSurface = 0.2f;  // of an edge's length
constexpr std::size_t kGrain = 64;

/// Points that keep their distance, in coarse cells a distance wide.
class SparsePoints {
 public:
  SparsePoints(const FieldView& field, float apart) : apart_(apart) {
    std::size_t cells = 1;
    for (std::size_t i = 0; i < 3; ++i) {
      side_[i] = static_cast<int>(8 * field.grid[i] * field.step[i] / apart) + 1;
      cells *= static_cast<std::size_t>(side_[i]);
    }
    head_.assign(cells, kNoEntry);
  }

  /// Whether a point is nearer than `reach`, which is at most the cells' width.
  bool any_near(const Vec3& p, float reach) const {
    const int x = place(p.x, 0), y = place(p.y, 1), z = place(p.z, 2);
    for (int k = std::max(z - 1, 0); k <= std::min(z + 1, side_[2] - 1); ++k)
      for (int j = std::max(y - 1, 0); j <= std::min(y + 1, side_[1] - 1); ++j)
        for (int i = std::max(x - 1, 0); i <= std::min(x + 1, side_[0] - 1); ++i)
          for (std::uint32_t q = head_[index(i, j, k)]; q != kNoEntry; q = next_[q])
            if (squared_norm(points_[q] - p) < reach * reach) return true;
    return false;
  }

  void add(const Vec3& p) {
    std::uint32_t& head = head_[index(place(p.x, 0), place(p.y, 1), place(p.z, 2))];
    next_.push_back(head);
    head = static_cast<std::uint32_t>(points_.size());
    points_.push_back(p);
  }

 private:
  int place(float at, int axis) const {
    return std::clamp(static_cast<int>(at / apart_), 0, side_[static_cast<std::size_t>(axis)] - 1);
  }
  std::size_t index(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * side_[1] + y) * side_[0] + x;
  }

  float apart_;
  std::array<int, 3> side_;
  std::vector<std::uint32_t> head_, next_;
  std::vector<Vec3> points_;
};

struct Hexagon {
  bool good = false;
  std::array<Vec3, 6> position, normal;
};

Hexagon make_hexagon(const FieldView& field, const Vec3& p, const Vec3& normal, float edge) {
  const std::array<Vec3, 6> directions = hexagon_across(normal);
  Hexagon hexagon;
  for (std::size_t i = 0; i < 6; ++i) {
    if (!place_on_surface(field, p, directions[i], edge, hexagon.position[i], hexagon.normal[i]))
      return hexagon;
  }
  for (std::size_t i = 0; i < 6; ++i) {
    const std::size_t j = (i + 1) % 6;
    const Triangle t = {p, hexagon.position[i], hexagon.position[j]};
    if (edge_ratio(t) < kSeedTau ||
        !faces_outward(t, {normal, hexagon.normal[i], hexagon.normal[j]}) ||
        !edge_on_surface(field, t[0], t[1], kOffSurface) ||
        !edge_on_surface(field, t[1], t[2], kOffSurface))
      return hexagon;
  }
  hexagon.good = true;
  return hexagon;
}

void add_hexagon(const SizeView& sizes, const Vec3& p, const Vec3& normal, const Hexagon& hexagon,
                 Front& front) {
  const std::uint32_t centre = front.add_vertex(p, normal, size_at(sizes, p));
  const std::uint32_t first = front.counts().corners;
  for (std::uint32_t i = 0; i < 6; ++i) {
    const Vec3& q = hexagon.position[i];
    front.add_corner(front.add_vertex(q, hexagon.normal[i], size_at(sizes, q)));
    front.add_triangle(centre, centre + 1 + i, centre + 1 + (i + 1) % 6);
  }
  for (std::uint32_t i = 0; i < 6; ++i) front.link(first + i, first + (i + 1) % 6);
}

}  // namespace

FrontSeeds::FrontSeeds(const FieldView& field, const SizeView& sizes, const SurfaceSamples& samples)
    : field_(field), sizes_(sizes), samples_(samples) {
  for (std::uint32_t i = 0; i < samples.count(); ++i)
    if (samples.radius[i] > 0) open_.push_back(i);
}

/// Most have a vertex within the first reach, where there are few cells to look into.
bool FrontSeeds::is_covered(const FrontView& front, std::uint32_t sample) const {
  constexpr float kReaches[] = {0.7f, kClear};
  const Vec3 &p = samples_.position[sample], &normal = samples_.normal[sample];
  const float size = size_at(sizes_, p);
  return std::any_of(std::begin(kReaches), std::end(kReaches), [&](float reach) {
    return any_near(field_, front, p, reach * size, [&](const FrontVertex& v) {
      return dot(v.normal, normal) > -expand_rules::kSameSheet;
    });
  });
}

void FrontSeeds::drop_covered(Backend& backend, const FrontView& front) {
  std::vector<std::uint8_t> covered(open_.size());
  for_each_index(backend, open_.size(), kGrain,
                 [&](std::size_t i) { covered[i] = is_covered(front, open_[i]); });
  std::size_t kept = 0;
  for (std::size_t i = 0; i < open_.size(); ++i)
    if (!covered[i]) open_[kept++] = open_[i];
  open_.resize(kept);
}

std::size_t FrontSeeds::add(Backend& backend, Front& front) {
  front.bring_to_host();
  drop_covered(backend, front.view());
  SparsePoints taken(field_, kApart * sizes_.elsewhere);
  std::size_t count = 0;
  for (const std::uint32_t i : open_) {
    const Vec3 &p = samples_.position[i], &normal = samples_.normal[i];
    const float edge = size_at(sizes_, p);
    if (taken.any_near(p, kApart * edge)) continue;
    const Hexagon hexagon = make_hexagon(field_, p, normal, edge);
    if (!hexagon.good) continue;
    taken.add(p);
    add_hexagon(sizes_, p, normal, hexagon, front);
    ++count;
  }
  return count;
}

}  // namespace vasamesh
