#include "io/obj_reader.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "io/byte_stream.h"
#include "io/io_error.h"
#include "io/text_words.h"

namespace vasamesh {
namespace {

[[noreturn]] void throw_bad_line(const std::string& path, std::size_t line) {
  throw_bad_input(path, "line " + std::to_string(line) + " is not a vertex or face of a surface",
                  "write the surface again");
}

/// Takes a line off the front of `text`, without blanks at its end.
std::string_view next_line(std::string_view& text) {
  const std::size_t end = std::min(text.find('\n'), text.size());
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return line.substr(0, line.find_last_not_of(" \t\r") + 1);
}

bool read_vertex(std::string_view text, std::vector<float>& vertices) {
  for (int axis = 0; axis < 3; ++axis) {
    const std::optional<double> value = number_in(next_word(text));
    if (!value) return false;
    vertices.push_back(static_cast<float>(*value));
  }
  return true;
}

/// Indices count from 1, or backwards from the last vertex so far.
bool read_corner(std::string_view word, std::size_t vertices, std::uint32_t& corner) {
  word = without_plus(word.substr(0, word.find('/')));
  std::int64_t index = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), index);
  if (error != std::errc() || end != word.data() + word.size() || index == 0) return false;
  index = index > 0 ? index - 1 : static_cast<std::int64_t>(vertices) + index;
  if (index < 0 || index > UINT32_MAX) return false;
  corner = static_cast<std::uint32_t>(index);
  return true;
}

bool read_face(std::string_view text, std::vector<std::uint32_t>& corners, FannedMesh& surface) {
  corners.clear();
  for (std::string_view word; !(word = next_word(text)).empty();) {
    corners.emplace_back();
    if (!read_corner(word, surface.mesh.vertex_count(), corners.back())) return false;
  }
  surface.append(corners);
  return corners.size() >= 3;
}

}  // namespace

FannedMesh read_obj(const std::string& path) {
  const std::string bytes = whole_file(path);
  std::string_view text = without_mark(bytes);
  FannedMesh surface;
  std::vector<std::uint32_t> corners;
  for (std::size_t line = 1; !text.empty(); ++line) {
    std::string_view rest = next_line(text);
    const std::string_view kind = next_word(rest);
    if (kind != "v" && kind != "f") continue;
    const std::size_t first = line;
    std::string joined;  // of lines that "\" joins
    for (; rest.ends_with('\\') && !text.empty(); ++line, rest = joined) {
      const std::string begun(rest.substr(0, rest.size() - 1));
      joined = begun + " " + std::string(next_line(text));
    }
    rest = rest.substr(0, rest.find('#'));
    const bool good =
        kind == "v" ? read_vertex(rest, surface.mesh.vertices) : read_face(rest, corners, surface);
    if (!good) throw_bad_line(path, first);
  }
  return surface;
}

}  // namespace vasamesh
