#include "io/stl_reader.h"

#include <algorithm>
#include <bit>
#include <cctype>
#include <cstdint>
#include <cstring>
#include <limits>
#include <numeric>
#include <optional>
#include <string_view>

#include "io/byte_stream.h"
#include "io/io_error.h"
#include "io/text_words.h"
#include "lower_case.h"

namespace vasamesh {
namespace {

static_assert(std::endian::native == std::endian::little, "binary STL is read as it lies");

constexpr std::size_t kHeader = 84, kRecord = 50;  // bytes
constexpr std::size_t kNormal = 12, kCorners = 36;

[[noreturn]] void throw_no_stl(const std::string& path) {
  throw_bad_input(path, "it cannot be read as a surface: truncated, corrupt or another format",
                  "write the surface again");
}

std::size_t count_in_header(std::string_view bytes) {
  std::uint32_t count = 0;
  if (bytes.size() >= kHeader) std::memcpy(&count, bytes.data() + 80, sizeof(count));
  return count;
}

/// "solid" begins a text, and some binary files: a text has no control characters but white space.
bool is_text(std::string_view bytes) {
  if (bytes.size() == kHeader + kRecord * count_in_header(bytes)) return false;
  const std::string_view head = bytes.substr(0, kHeader + kRecord);
  std::string_view words = without_mark(head);
  return lower_case(std::string(next_word(words))).starts_with("solid") &&
         std::all_of(head.begin(), head.end(),
                     [](unsigned char c) { return std::iscntrl(c) == 0 || std::isspace(c) != 0; });
}

TriangleMesh read_binary(const std::string& path, std::string_view bytes) {
  if (bytes.size() < kHeader) throw_no_stl(path);
  const std::size_t held = (bytes.size() - kHeader) / kRecord;
  const std::size_t count = count_in_header(bytes) == 0 ? held : count_in_header(bytes);
  if (count > held) {
    throw_bad_input(path, "truncated: it holds fewer triangles than it says",
                    "get a whole copy of the file");
  }
  TriangleMesh mesh;
  mesh.vertices.resize(9 * count);
  for (std::size_t t = 0; t < count; ++t)
    std::memcpy(&mesh.vertices[9 * t], &bytes[kHeader + kRecord * t + kNormal], kCorners);
  return mesh;
}

void skip_line(std::string_view& text) {
  text.remove_prefix(std::min(text.find_first_of("\r\n"), text.size()));
}

void read_vertex(const std::string& path, std::string_view& text, TriangleMesh& mesh) {
  for (int axis = 0; axis < 3; ++axis) {
    const std::optional<double> value = number_in(next_word(text));
    if (!value) throw_no_stl(path);
    mesh.vertices.push_back(static_cast<float>(*value));
  }
}

/// Facets are what stands in loops; their normals are not needed.
TriangleMesh read_text(const std::string& path, std::string_view text) {
  TriangleMesh mesh;
  bool ended = false;
  std::size_t begun = 0;  // coordinates before the loop
  for (std::string_view next; !(next = next_word(text)).empty();) {
    const std::string word = lower_case(std::string(next));
    if (word == "solid" || word == "endsolid") {
      ended = word == "endsolid";
      skip_line(text);
    }
    if (word == "vertex") read_vertex(path, text, mesh);
    if (word == "loop") begun = mesh.vertices.size();
    if (word == "endloop" && mesh.vertices.size() != begun + 9) throw_no_stl(path);
  }
  if (!ended || mesh.vertices.size() % 9 != 0) throw_no_stl(path);
  return mesh;
}

}  // namespace

TriangleMesh read_stl(const std::string& path) {
  const std::string bytes = whole_file(path);
  TriangleMesh mesh =
      is_text(bytes) ? read_text(path, without_mark(bytes)) : read_binary(path, bytes);
  if (mesh.vertex_count() > std::numeric_limits<std::uint32_t>::max()) {
    throw_bad_input(path, "it has more than 2^32 - 1 vertices", "cut the surface");
  }
  mesh.triangles.resize(mesh.vertex_count());
  std::iota(mesh.triangles.begin(), mesh.triangles.end(), std::uint32_t{0});
  return mesh;
}

}  // namespace vasamesh
