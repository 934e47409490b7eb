/// \file
/// MetaImage (the MetaIO library's documentation of its tags).

#include <itkMetaImageIO.h>

#include <bit>

#include "io/io_error.h"
#include "io/itk_header.h"
#include "io/length_unit.h"
#include "io/text_header.h"
#include "io/volume_formats.h"

namespace vasamesh {
namespace {

bool is_true(const TextHeader& header, const char* key) {
  return header.get_lower(key).starts_with('t') || header.get(key) == "1";
}

// MetaIO has arrays of ten axes and trusts the header with them.
void check_fields(const std::string& path, const TextHeader& header) {
  const std::vector<double> dimensions = header.numbers("NDims");
  const std::vector<double> sizes = header.numbers("DimSize");
  if (dimensions.size() != 1 || !(dimensions[0] >= 2 && dimensions[0] <= 4) ||
      static_cast<double>(sizes.size()) != dimensions[0]) {
    throw_bad_input(path, "it is not a 3D volume", "give a 3D segmentation");
  }
  for (const double size : sizes) check_raw_size(path, size);
  for (const char* key : {"ElementSpacing", "ElementSize"}) {
    const std::vector<double> spacings = header.numbers(key);
    for (std::size_t i = 0; i < spacings.size() && i < 3; ++i) {
      check_raw_spacing(path, spacings[i]);
    }
  }
}

PixelLayout data_layout(const std::string& path, const TextHeader& header) {
  const std::string name = header.get("ElementDataFile");
  if (name == "LIST" || name.starts_with("LIST ") || name.find('%') != std::string::npos) {
    throw_bad_input(path, "its voxels are in several files", "write it as one .mha file");
  }
  if (name.empty()) {
    throw_bad_input(path, "its ElementDataFile names no file", "name the file of its voxels there");
  }
  if (header.get_lower("BinaryData", "true").starts_with('f')) {
    throw_bad_input(path, "its voxels are text", "write it as a binary .mha file");
  }
  PixelLayout layout;
  const bool local = name == "LOCAL" || name == "Local" || name == "local";
  layout.file = local ? path : beside(path, name);
  layout.file_offset = local ? header.end : 0;
  layout.encoding = is_true(header, "CompressedData") ? Encoding::deflate : Encoding::raw;
  const bool big =
      is_true(header, "BinaryDataByteOrderMSB") || is_true(header, "ElementByteOrderMSB");
  layout.swap_bytes = big != (std::endian::native == std::endian::big);
  return layout;
}

// HeaderSize skips bytes of the data file; -1 means that the voxels are its last bytes.
void apply_header_size(const TextHeader& header, PixelLayout& layout) {
  const std::vector<double> values = header.numbers("HeaderSize");
  if (values.empty() || values[0] == 0 || !(values[0] >= -1 && values[0] < 1e15)) return;
  const auto bytes = layout.count * static_cast<std::int64_t>(pixel_bytes(layout.type));
  layout.file_offset = values[0] > 0 ? layout.file_offset + static_cast<std::int64_t>(values[0])
                                     : std::max(layout.file_offset, file_size(layout.file) - bytes);
}

/// "?" is MetaIO's word for an unknown one.
double length_unit(const std::string& path, const TextHeader& header) {
  const std::string name = header.get("DistanceUnits");
  return name == "?" ? 1 : unit_in_mm(path, name, "DistanceUnits");
}

TextHeader read_header(const std::string& path) {
  const auto is_last = [](const std::string& key, const std::string&) {
    return key == "ElementDataFile";
  };
  return read_text_header(path, {"=:", "", is_last});  // MetaIO takes both
}

}  // namespace

std::string meta_voxel_file(const std::string& path) {
  return data_layout(path, read_header(path)).file;
}

Volume open_meta(const std::string& path) {
  const TextHeader header = read_header(path);
  check_fields(path, header);
  PixelLayout layout = data_layout(path, header);

  auto io = itk::MetaImageIO::New();
  read_itk_header(path, *io);
  Volume volume;
  volume.geometry = itk_geometry(path, *io);
  take_lengths_in(length_unit(path, header), volume.geometry);
  layout.type = itk_pixel_type(path, *io);
  layout.count = voxel_count(path, volume.geometry);
  apply_header_size(header, layout);
  volume.pixels = make_file_pixels(path, layout);
  return volume;
}

}  // namespace vasamesh
