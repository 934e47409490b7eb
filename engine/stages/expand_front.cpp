#include "stages/expand_front.h"

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "stages/expand_grid.h"

namespace vasamesh {

namespace {

/// Room for `size` elements, of which the first `used` are kept.
template <class T>
void grow(Backend& backend, std::size_t size, std::size_t used, Buffer<T>& buffer) {
  if (size <= buffer.size()) return;
  Buffer<T> larger(backend, std::max(size, 2 * buffer.size()));
  const auto from = backend.on_host(std::as_const(buffer).view().subview(0, used));
  std::copy(from.begin(), from.end(), backend.on_host(larger.view()).begin());
  buffer = std::move(larger);
}

template <class T>
View<T> first(Buffer<T>& buffer, std::size_t count) {
  return buffer.view().subview(0, count);
}

}  // namespace

Front::Front(Backend& backend, const FieldView& field)
    : backend_(backend),
      field_(field),
      shared_counts_(backend, 1),
      claims_(backend, cell_count(field) + 1),
      edge_at_(backend, cell_count(field) + 1),
      vertex_at_(backend, cell_count(field) + 1) {
  backend_.upload<std::uint64_t>(claims_.view(), std::vector<std::uint64_t>(claims_.size(), 0));
  backend_.fill(edge_at_.view(), kNoEntry);
  backend_.fill(vertex_at_.view(), kNoEntry);
}

FrontView Front::view() {
  if (counts_changed_) backend_.upload<FrontCounts>(shared_counts_.view(), {&counts_, 1});
  counts_changed_ = false;
  return {shared_counts_.view(),
          vertices_.view(),
          corners_.view(),
          triangles_.view(),
          first(listed_, most_listed_),
          alive_.view(),
          chosen_.view(),
          proposals_.view(),
          starts_.view(),
          claims_.view(),
          edge_at_.view(),
          vertex_at_.view()};
}

void Front::bring_to_host() {
  backend_.on_host(vertices_.view());
  backend_.on_host(corners_.view());
  for (Buffer<std::uint32_t>* each : {&triangles_, &listed_, &edge_at_, &vertex_at_})
    backend_.on_host(each->view());
}

void Front::reserve(std::size_t vertices, std::size_t triangles, std::size_t corners) {
  grow(backend_, counts_.vertices + vertices, counts_.vertices, vertices_);
  grow(backend_, 3 * (counts_.triangles + triangles), 3 * std::size_t{counts_.triangles},
       triangles_);
  grow(backend_, counts_.corners + corners, counts_.corners, corners_);
  grow(backend_, counts_.corners + corners, counts_.listed, listed_);
  grow(backend_, counts_.corners + corners, counts_.listed, alive_);
  grow(backend_, counts_.corners + corners, counts_.chosen, chosen_);
}

std::uint32_t Front::add_vertex(const Vec3& position, const Vec3& normal, float size) {
  reserve(1, 0, 0);
  const std::uint32_t v = counts_.vertices++;
  std::uint32_t& head = vertex_at_.view()[cell_index(field_, cell_at(field_, position))];
  vertices_.view()[v] = {position, normal, size, 0, head};
  head = v;
  counts_changed_ = true;
  return v;
}

std::uint32_t Front::add_corner(std::uint32_t vertex) {
  reserve(0, 0, 1);
  const std::uint32_t c = counts_.corners++;
  corners_.view()[c] = {.vertex = vertex};
  ++vertices_.view()[vertex].corners;
  listed_.view()[counts_.listed++] = c;
  most_listed_ = counts_.listed;
  counts_changed_ = true;
  return c;
}

void Front::add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  reserve(0, 1, 0);
  std::uint32_t* triangle = triangles_.view().data() + 3 * std::size_t{counts_.triangles++};
  triangle[0] = a;
  triangle[1] = b;
  triangle[2] = c;
  counts_changed_ = true;
}

void Front::link(std::uint32_t from, std::uint32_t to) {
  FrontCorner &a = corners_.view()[from], &b = corners_.view()[to];
  a.next = to;
  b.previous = from;
  a.state = b.state = CornerState::changed;
}

void Front::begin_round() {
  backend_.download<FrontCounts>(std::as_const(shared_counts_).view(), {&counts_, 1});
  std::swap(listed_, alive_);
  counts_.listed = counts_.alive;
  counts_changed_ = counts_.chosen == 0;  // no pass follows that counts the list
  const std::size_t chosen = counts_.chosen;
  most_listed_ = counts_.listed + kMostNewVertices * chosen;
  reserve(kMostNewVertices * chosen, kMostNewTriangles * chosen, kMostNewVertices * chosen);
  proposals_.resize(backend_, chosen);
  starts_.resize(backend_, chosen);
}

}  // namespace vasamesh
