#include "stages/places.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "backend/ranges.h"
#include "types/mesh_vertex.h"

namespace vasamesh {

namespace {

/// A cell's coordinate; 21 bits.
std::uint64_t cell_of(float x) {
  constexpr float kMost = 1 << 20;
  return static_cast<std::uint64_t>(
      std::clamp(std::floor(Places::kInverseSide * x), -kMost, kMost - 1) + kMost);
}

std::uint64_t key_of(std::uint64_t x, std::uint64_t y, std::uint64_t z) {
  return x | y << 21 | z << 42;
}

}  // namespace

Places::Places(std::span<const CarefulPlace> places) : places_(places.begin(), places.end()) {
  for (std::uint32_t i = 0; i < places_.size(); ++i) {
    const Vec3& c = places_[i].centre;
    const float reach = places_[i].radius + kMargin;
    for (std::uint64_t z = cell_of(c.z - reach); z <= cell_of(c.z + reach); ++z)
      for (std::uint64_t y = cell_of(c.y - reach); y <= cell_of(c.y + reach); ++y)
        for (std::uint64_t x = cell_of(c.x - reach); x <= cell_of(c.x + reach); ++x)
          cells_.push_back({key_of(x, y, z), i});
  }
  std::sort(cells_.begin(), cells_.end(), [](const PlaceCell& a, const PlaceCell& b) {
    return a.cell != b.cell ? a.cell < b.cell : a.place < b.place;
  });
}

Places::Places(const PlaceView& view)
    : places_(view.places.data(), view.places.data() + view.places.size),
      cells_(view.cells.data(), view.cells.data() + view.cells.size) {}

PlaceView Places::view() const { return {view_of(cells_), view_of(places_)}; }

template <class Visit>
void Places::for_each_near(const Vec3& p, const Visit& visit) const {
  if (places_.empty()) return;
  const std::uint64_t key = key_of(cell_of(p.x), cell_of(p.y), cell_of(p.z));
  const auto first = std::partition_point(cells_.begin(), cells_.end(),
                                          [&](const PlaceCell& c) { return c.cell < key; });
  for (auto it = first; it != cells_.end() && it->cell == key; ++it) visit(places_[it->place]);
}

bool Places::hold(const Vec3& p, float margin) const {
  bool held = false;
  for_each_near(p, [&](const CarefulPlace& place) { held = held || place.holds(p, margin); });
  return held;
}

float Places::factor_at(const Vec3& p) const {
  constexpr float kNone = 1e9f;
  float factor = kNone;
  for_each_near(p, [&](const CarefulPlace& place) {
    if (place.holds(p)) factor = std::min(factor, place.factor);
  });
  return factor < kNone ? factor : 1;
}

bool Places::any_fixed() const {
  return std::any_of(places_.begin(), places_.end(),
                     [](const CarefulPlace& place) { return place.factor == 0; });
}

Places wider(std::span<const CarefulPlace> places, float by) {
  std::vector<CarefulPlace> wide(places.begin(), places.end());
  for (CarefulPlace& place : wide) place.radius += by;
  return Places(wide);
}

std::vector<std::uint8_t> vertices_in(Backend& backend, const Places& places,
                                      const TriangleMesh& mesh) {
  constexpr std::size_t kGrain = 4096;
  std::vector<std::uint8_t> within(mesh.vertex_count());
  for_each_index(backend, within.size(), kGrain,
                 [&](std::size_t v) { within[v] = places.hold(vertex_at(mesh, v)); });
  return within;
}

namespace {

/// The centres of places in the cells of a grid, to find whether one is near a point.
class Centres {
 public:
  explicit Centres(float near) : near_(near), inverse_side_(0.99f / near) {}

  void add(const Vec3& p) { cells_[key_at(cell(p.x), cell(p.y), cell(p.z))].push_back(p); }

  bool any_near(const Vec3& p) const {
    for (std::int64_t z = -1; z <= 1; ++z)
      for (std::int64_t y = -1; y <= 1; ++y)
        for (std::int64_t x = -1; x <= 1; ++x) {
          const auto found = cells_.find(key_at(cell(p.x) + x, cell(p.y) + y, cell(p.z) + z));
          if (found != cells_.end() &&
              std::any_of(found->second.begin(), found->second.end(), [&](const Vec3& centre) {
                return squared_norm(p - centre) < near_ * near_;
              }))
            return true;
        }
    return false;
  }

 private:
  std::int64_t cell(float x) const {
    return static_cast<std::int64_t>(std::floor(inverse_side_ * x));
  }
  static std::uint64_t key_at(std::int64_t x, std::int64_t y, std::int64_t z) {
    constexpr std::int64_t kShift = 1 << 20;
    return key_of(static_cast<std::uint64_t>(x + kShift), static_cast<std::uint64_t>(y + kShift),
                  static_cast<std::uint64_t>(z + kShift));
  }

  float near_, inverse_side_;
  std::unordered_map<std::uint64_t, std::vector<Vec3>> cells_;
};

}  // namespace

void add_places(std::span<const Vec3> points, float radius, float factor,
                std::vector<CarefulPlace>& places) {
  if (points.empty()) return;
  Centres centres(0.5f * radius);
  for (const CarefulPlace& place : places) centres.add(place.centre);
  for (const Vec3& p : points) {
    if (centres.any_near(p)) continue;
    centres.add(p);
    places.push_back({p, radius, factor});
  }
}

std::vector<CarefulPlace> places_at(std::span<const Vec3> points, float radius, float factor) {
  std::vector<CarefulPlace> places;
  add_places(points, radius, factor, places);
  return places;
}

}  // namespace vasamesh
