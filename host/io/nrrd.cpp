/// \file
/// NRRD (teem.sourceforge.net/nrrd/format.html), and 3D Slicer's .seg.nrrd of one layer.

#include <itkNrrdImageIO.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdio>
#include <map>
#include <utility>

#include "io/io_error.h"
#include "io/itk_header.h"
#include "io/length_unit.h"
#include "io/text_header.h"
#include "io/volume_formats.h"
#include "lower_case.h"

namespace vasamesh {
namespace {

TextHeader read_header(const std::string& path) {
  char magic[4] = {};
  ByteStream(path, 0, Encoding::raw).read(magic, sizeof(magic));
  if (std::string(magic, 4) != "NRRD") {
    throw_bad_input(path, "it is no NRRD file", "check its format");
  }
  const auto is_last = [](const std::string&, const std::string& line) { return line.empty(); };
  TextHeader header = read_text_header(path, {":", ":=", is_last});  // "key:=value": anybody's
  std::map<std::string, std::string> fields;  // whose names are alike in both cases
  for (auto& [name, value] : header.fields) fields.emplace(lower_case(name), std::move(value));
  header.fields = std::move(fields);
  return header;
}

Encoding data_encoding(const std::string& path, const TextHeader& header) {
  const std::string encoding = header.get_lower("encoding");
  if (encoding == "raw") return Encoding::raw;
  if (encoding == "gzip" || encoding == "gz") return Encoding::deflate;
  throw_bad_input(path, "its encoding is \"" + encoding + "\"",
                  "write it with the encoding raw or gzip");
}

std::int64_t decoded_bytes(const PixelLayout& layout) {
  return ByteStream(layout.file, layout.file_offset, layout.encoding).finish();
}

// Lines to skip come first, then bytes; -1 byte means that the voxels are the last bytes,
// decoded.
void apply_skips(const std::string& path, const TextHeader& header, PixelLayout& layout) {
  const auto value = [&](const char* key) {
    const std::vector<double> numbers = header.numbers(key);
    return numbers.empty() ? 0 : numbers[0];
  };
  const double lines = value("line skip") + value("lineskip");
  const double bytes = value("byte skip") + value("byteskip");
  const auto held = layout.count * static_cast<std::int64_t>(pixel_bytes(layout.type));
  if (lines != 0 || bytes < -1 || bytes > 1e15) {
    throw_bad_input(path, "it skips lines before its voxels", "write it as one .nrrd file");
  }
  if (bytes == -1 && layout.encoding == Encoding::deflate) {
    layout.skip = std::max<std::int64_t>(decoded_bytes(layout) - held, 0);
  } else if (bytes == -1) {
    layout.file_offset = std::max(layout.file_offset, file_size(layout.file) - held);
  } else if (layout.encoding == Encoding::raw) {
    layout.file_offset += static_cast<std::int64_t>(bytes);
  } else {
    layout.skip = static_cast<std::int64_t>(bytes);
  }
}

// ITK does not say why it refuses such a header.
void check_endian(const std::string& path, const TextHeader& header) {
  const std::string type = header.get_lower("type");
  if (type.ends_with("char") || type.starts_with("int8") || type.starts_with("uint8")) return;
  if (!header.get("endian").empty()) return;
  throw_bad_input(path, "it does not say the byte order of its voxels",
                  "add the line \"endian: little\" or \"endian: big\" to its header");
}

PixelLayout data_layout(const std::string& path, const TextHeader& header) {
  PixelLayout layout;
  const std::string name = header.get("data file", header.get("datafile"));
  if (name.starts_with("LIST") || name.find('%') != std::string::npos) {
    throw_bad_input(path, "its voxels are in several files", "write it as one .nrrd file");
  }
  layout.file = name.empty() ? path : beside(path, name);
  file_size(layout.file);  // is it there?
  layout.file_offset = name.empty() ? header.end : 0;
  layout.encoding = data_encoding(path, header);
  const bool big = header.get_lower("endian") == "big";
  layout.swap_bytes = big != (std::endian::native == std::endian::big);
  return layout;
}

/// The vectors of three numbers among what the field has, "none" for one.
std::vector<std::array<double, 3>> vectors(const std::string& field) {
  std::vector<std::array<double, 3>> all;
  for (std::size_t at = field.find('('); at != std::string::npos; at = field.find('(', at + 1)) {
    std::array<double, 3> v{};
    if (std::sscanf(field.c_str() + at, "( %lf , %lf , %lf )", &v[0], &v[1], &v[2]) == 3)
      all.push_back(v);
  }
  return all;
}

// ITK 5.2 turns x round, where (x, -y, z) is LPS.
void place_las(const TextHeader& header, Geometry& geometry) {
  const std::string space = header.get_lower("space");
  if (space != "left-anterior-superior" && space != "las") return;
  const auto steps = vectors(header.get("space directions"));
  const auto origin = vectors(header.get("space origin"));
  for (std::size_t row = 0; row < 3; ++row) {
    const double sign = row == 1 ? -1 : 1;
    if (origin.size() == 1) geometry.origin[row] = sign * origin[0][row];
    for (std::size_t axis = 0; axis < 3 && steps.size() == 3; ++axis) {
      const auto& [x, y, z] = steps[axis];
      geometry.direction[3 * row + axis] = sign * steps[axis][row] / std::hypot(x, y, z);
    }
  }
}

/// The texts in quotes among what the field has.
std::vector<std::string> quoted(const std::string& field) {
  std::vector<std::string> all;
  std::size_t open = field.find('"'), close = 0;
  for (; open != std::string::npos; open = field.find('"', close + 1)) {
    close = field.find('"', open + 1);
    if (close == std::string::npos) break;
    all.push_back(field.substr(open + 1, close - open - 1));
  }
  return all;
}

/// The unit that ITK leaves out: of the space, else of the axes, whose fourth may be time.
double length_unit(const std::string& path, const TextHeader& header) {
  std::vector<std::string> names = quoted(header.get("space units"));
  if (names.empty()) names = quoted(header.get("units"));
  if (names.empty()) return 1;
  names.resize(std::min<std::size_t>(names.size(), 3));
  const double unit = unit_in_mm(path, names[0], "space units");
  for (const std::string& name : names) {
    if (unit_in_mm(path, name, "space units") == unit) continue;
    throw_bad_input(path,
                    "its axes have different units, \"" + names[0] + "\" and \"" + name + "\"",
                    "give all lengths in its header in one unit, as mm");
  }
  return unit;
}

}  // namespace

std::string nrrd_voxel_file(const std::string& path) {
  return data_layout(path, read_header(path)).file;
}

Volume open_nrrd(const std::string& path) {
  const TextHeader header = read_header(path);
  for (const double spacing : header.numbers("spacings")) check_raw_spacing(path, spacing);
  for (const double size : header.numbers("sizes")) check_raw_size(path, size);
  PixelLayout layout = data_layout(path, header);
  check_endian(path, header);

  auto io = itk::NrrdImageIO::New();
  read_itk_header(path, *io);
  Volume volume;
  layout.type = itk_pixel_type(path, *io);
  volume.geometry = itk_geometry(path, *io);
  place_las(header, volume.geometry);
  take_lengths_in(length_unit(path, header), volume.geometry);
  layout.count = voxel_count(path, volume.geometry);
  apply_skips(path, header, layout);
  volume.pixels = make_file_pixels(path, layout);
  return volume;
}

}  // namespace vasamesh
