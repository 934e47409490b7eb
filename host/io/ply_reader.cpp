#include "io/ply_reader.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <sstream>
#include <string_view>
#include <vector>

#include "io/byte_stream.h"
#include "io/io_error.h"
#include "io/pixel_source.h"
#include "io/text_words.h"

namespace vasamesh {
namespace {

struct Property {
  std::string name;
  PixelType type = PixelType::float32;
  bool is_list = false;
  PixelType count_type = PixelType::uint8;  ///< of a list
};

struct Element {
  std::string name;
  std::int64_t count = 0;
  std::vector<Property> properties;
};

enum class PlyFormat { text, little, big };

struct PlyHeader {
  PlyFormat format = PlyFormat::text;
  std::vector<Element> elements;
  std::size_t end = 0;  ///< where the values begin
};

[[noreturn]] void throw_no_ply(const std::string& path) {
  throw_bad_input(path, "it cannot be read as a surface: its PLY header is not understood",
                  "write the surface again");
}

PixelType ply_type(const std::string& path, const std::string& name) {
  static const std::pair<const char*, PixelType> kTypes[] = {
      {"char", PixelType::int8},      {"int8", PixelType::int8},
      {"uchar", PixelType::uint8},    {"uint8", PixelType::uint8},
      {"short", PixelType::int16},    {"int16", PixelType::int16},
      {"ushort", PixelType::uint16},  {"uint16", PixelType::uint16},
      {"int", PixelType::int32},      {"int32", PixelType::int32},
      {"uint", PixelType::uint32},    {"uint32", PixelType::uint32},
      {"float", PixelType::float32},  {"float32", PixelType::float32},
      {"double", PixelType::float64}, {"float64", PixelType::float64}};
  for (const auto& [text, type] : kTypes) {
    if (name == text) return type;
  }
  throw_no_ply(path);
}

Property read_property(const std::string& path, std::istream& words) {
  Property property;
  std::string type, count_type;
  words >> type;
  property.is_list = type == "list";
  if (property.is_list) {
    words >> count_type >> type;
    property.count_type = ply_type(path, count_type);
  }
  property.type = ply_type(path, type);
  words >> property.name;
  return property;
}

PlyFormat read_format(const std::string& path, std::istream& words) {
  std::string name;
  words >> name;
  if (name == "ascii") return PlyFormat::text;
  if (name == "binary_little_endian") return PlyFormat::little;
  if (name == "binary_big_endian") return PlyFormat::big;
  throw_no_ply(path);
}

bool has_number(const Element& element, const char* name) {
  return std::any_of(
      element.properties.begin(), element.properties.end(),
      [&](const Property& property) { return property.name == name && !property.is_list; });
}

void check_elements(const std::string& path, const std::vector<Element>& elements) {
  for (const Element& element : elements) {
    if (element.name == "tristrips" && element.count > 0) {
      throw_bad_input(path, "its triangles are in strips (tristrips), which are not read",
                      "write it with faces");
    }
    if (element.name != "vertex") continue;
    for (const char* axis : {"x", "y", "z"}) {
      if (has_number(element, axis)) continue;
      throw_bad_input(path, std::string("its vertices have no ") + axis, "write the surface again");
    }
  }
}

PlyHeader read_header(const std::string& path, std::string_view text) {
  PlyHeader header;
  if (!text.starts_with("ply")) throw_no_ply(path);
  for (std::size_t begin = 0, end; (end = text.find('\n', begin)) != std::string::npos;
       begin = end + 1) {
    std::istringstream words(std::string(text.substr(begin, end - begin)));
    std::string keyword;
    words >> keyword;
    if (keyword == "format") header.format = read_format(path, words);
    if (keyword == "element") {
      Element element;
      words >> element.name >> element.count;
      if (!words || element.count < 0) throw_no_ply(path);
      header.elements.push_back(element);
    }
    if (keyword == "property") {
      if (header.elements.empty()) throw_no_ply(path);
      header.elements.back().properties.push_back(read_property(path, words));
    }
    header.end = end + 1;
    if (keyword == "end_header") return header;
  }
  throw_no_ply(path);
}

/// The values after the header, one after the other.
class PlyValues {
 public:
  PlyValues(const std::string& path, std::string_view rest, PlyFormat format)
      : path_(path), rest_(rest), format_(format) {}

  double next(PixelType type) {
    if (format_ == PlyFormat::text) return next_number();
    double value = 0;
    visit_pixel_type(type, [&]<class T>(T) { value = static_cast<double>(next_bytes<T>()); });
    return value;
  }

  /// The length of a list that can still follow.
  std::int64_t next_count(PixelType type) {
    const double count = next(type);
    if (!(count >= 0 && count <= static_cast<double>(rest_.size()))) throw_truncated();
    return static_cast<std::int64_t>(count);
  }

 private:
  [[noreturn]] void throw_truncated() const {
    throw_bad_input(path_, "truncated or corrupt", "get a whole copy of the file");
  }

  template <class T>
  T next_bytes() {
    if (rest_.size() < sizeof(T)) throw_truncated();
    std::array<char, sizeof(T)> bytes;
    std::memcpy(bytes.data(), rest_.data(), sizeof(T));
    rest_.remove_prefix(sizeof(T));
    const bool native_is_big = std::endian::native == std::endian::big;
    if ((format_ == PlyFormat::big) != native_is_big) std::reverse(bytes.begin(), bytes.end());
    return std::bit_cast<T>(bytes);
  }

  double next_number() {
    const std::optional<double> number = number_in(next_word(rest_));
    if (!number) throw_truncated();
    return *number;
  }

  const std::string& path_;
  std::string_view rest_;
  PlyFormat format_;
};

std::uint32_t corner_of(const std::string& path, double index) {
  if (!(index >= 0 && index < 4294967295.0 && index == std::floor(index))) {
    throw_bad_input(path, "a triangle's index is out of range", "write the surface again");
  }
  return static_cast<std::uint32_t>(index);
}

void read_corners(const std::string& path, PlyValues& values, const Property& property,
                  std::vector<std::uint32_t>& corners) {
  const std::int64_t count = values.next_count(property.count_type);
  corners.clear();
  for (std::int64_t i = 0; i < count; ++i)
    corners.push_back(corner_of(path, values.next(property.type)));
}

void read_vertex_property(PlyValues& values, const Property& property, float* vertex) {
  const auto value = static_cast<float>(values.next(property.type));
  if (property.name == "x") vertex[0] = value;
  if (property.name == "y") vertex[1] = value;
  if (property.name == "z") vertex[2] = value;
}

void skip_property(PlyValues& values, const Property& property) {
  const std::int64_t count = property.is_list ? values.next_count(property.count_type) : 1;
  for (std::int64_t i = 0; i < count; ++i) values.next(property.type);
}

void read_element(const std::string& path, PlyValues& values, const Element& element,
                  FannedMesh& surface) {
  TriangleMesh& mesh = surface.mesh;
  std::vector<std::uint32_t> corners;
  const bool is_vertex = element.name == "vertex", is_face = element.name == "face";
  if (element.properties.empty()) return;
  for (std::int64_t i = 0; i < element.count; ++i) {
    if (is_vertex) mesh.vertices.insert(mesh.vertices.end(), {0, 0, 0});
    for (const Property& property : element.properties) {
      const bool is_corners = property.is_list && property.name.starts_with("vertex_ind");
      if (is_face && is_corners) {
        read_corners(path, values, property, corners);
        surface.append(corners);
      } else if (is_vertex && !property.is_list) {
        read_vertex_property(values, property, &mesh.vertices[mesh.vertices.size() - 3]);
      } else {
        skip_property(values, property);
      }
    }
  }
}

}  // namespace

FannedMesh read_ply(const std::string& path) {
  const std::string bytes = whole_file(path);
  const std::string_view text = without_mark(bytes);
  const PlyHeader header = read_header(path, text);
  check_elements(path, header.elements);
  PlyValues values(path, text.substr(header.end), header.format);
  FannedMesh surface;
  for (const Element& element : header.elements) read_element(path, values, element, surface);
  return surface;
}

}  // namespace vasamesh
