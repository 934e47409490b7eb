#include "io/obj_reader.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <string_view>
#include <vector>

#include "io/byte_stream.h"
#include "io/io_error.h"

namespace vasamesh {
namespace {

[[noreturn]] void throw_bad_line(const std::string& path, std::size_t line) {
  throw_bad_input(path, "line " + std::to_string(line) + " is not a vertex or face of a surface",
                  "write the surface again");
}

/// Takes the next word off the front of `text`; empty at the end.
std::string_view next_word(std::string_view& text) {
  const char* blanks = " \t\r";
  text.remove_prefix(std::min(text.find_first_not_of(blanks), text.size()));
  const std::string_view word = text.substr(0, text.find_first_of(blanks));
  text.remove_prefix(word.size());
  return word;
}

bool read_vertex(std::string_view text, std::vector<float>& vertices) {
  for (int axis = 0; axis < 3; ++axis) {
    const std::string_view word = next_word(text);
    double value = 0;  // one too small for a float is no error
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size()) return false;
    vertices.push_back(static_cast<float>(value));
  }
  return true;
}

/// Indices count from 1, or backwards from the last vertex so far.
bool read_corner(std::string_view word, std::size_t vertices, std::uint32_t& corner) {
  word = word.substr(0, word.find('/'));
  std::int64_t index = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), index);
  if (error != std::errc() || end != word.data() + word.size() || index == 0) return false;
  index = index > 0 ? index - 1 : static_cast<std::int64_t>(vertices) + index;
  if (index < 0 || index > UINT32_MAX) return false;
  corner = static_cast<std::uint32_t>(index);
  return true;
}

bool read_face(std::string_view text, TriangleMesh& mesh) {
  std::uint32_t first = 0, last = 0;
  for (int count = 0;; ++count) {
    const std::string_view word = next_word(text);
    if (word.empty()) return count >= 3;
    std::uint32_t corner = 0;
    if (!read_corner(word, mesh.vertex_count(), corner)) return false;
    if (count == 0) first = corner;
    if (count >= 2) mesh.triangles.insert(mesh.triangles.end(), {first, last, corner});
    last = corner;
  }
}

}  // namespace

TriangleMesh read_obj(const std::string& path) {
  std::string text(static_cast<std::size_t>(file_size(path)), '\0');
  text.resize(ByteStream(path, 0, Encoding::raw).read(text.data(), text.size()));
  TriangleMesh mesh;
  std::size_t begin = 0;
  for (std::size_t line = 1; begin < text.size(); ++line) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    std::string_view rest(text.data() + begin, end - begin);
    begin = end + 1;
    const std::string_view kind = next_word(rest);
    const bool good =
        kind == "v" ? read_vertex(rest, mesh.vertices) : kind != "f" || read_face(rest, mesh);
    if (!good) throw_bad_line(path, line);
  }
  return mesh;
}

}  // namespace vasamesh
