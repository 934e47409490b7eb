#pragma once

/// \file
/// Where the pixels of a volume come from: a part of a file, or the slices of a DICOM series.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "io/byte_stream.h"
#include "vasamesh/types.h"

namespace vasamesh {

enum class PixelType { int8, uint8, int16, uint16, int32, uint32, int64, uint64, float32, float64 };

/// Calls f(T{}) for the C++ type T of a pixel.
template <class F>
void visit_pixel_type(PixelType type, F&& f) {
  switch (type) {
    case PixelType::int8:
      return f(std::int8_t{});
    case PixelType::uint8:
      return f(std::uint8_t{});
    case PixelType::int16:
      return f(std::int16_t{});
    case PixelType::uint16:
      return f(std::uint16_t{});
    case PixelType::int32:
      return f(std::int32_t{});
    case PixelType::uint32:
      return f(std::uint32_t{});
    case PixelType::int64:
      return f(std::int64_t{});
    case PixelType::uint64:
      return f(std::uint64_t{});
    case PixelType::float32:
      return f(float{});
    case PixelType::float64:
      return f(double{});
  }
}

/// Bytes of one pixel.
std::size_t pixel_bytes(PixelType type);

/// Consecutive pixels in the machine's byte order; pixels[0] is pixel `first` of the volume.
struct PixelChunk {
  std::size_t first = 0, count = 0;
  PixelType type = PixelType::uint8;
  const void* pixels = nullptr;
};

/// Called for each chunk, by several threads at once, in no order.
using ChunkVisitor = std::function<void(const PixelChunk&)>;

/// The pixels of one volume; may be visited more than once.
class PixelSource {
 public:
  virtual ~PixelSource() = default;

  /// Visits every pixel once. \throws Error bad_input: truncated, corrupt; and what the visitor
  /// throws, which ends the reading.
  virtual void visit(const ChunkVisitor& visitor) const = 0;
};

/// A volume as its header describes it.
struct Volume {
  Geometry geometry;  ///< not yet checked
  std::unique_ptr<PixelSource> pixels;
};

/// The part of a file that holds the pixels of a volume.
struct PixelLayout {
  std::string file;
  std::int64_t file_offset = 0;  ///< where the encoded bytes begin
  Encoding encoding = Encoding::raw;
  std::int64_t skip = 0;  ///< decoded bytes before the first pixel
  PixelType type = PixelType::uint8;
  bool swap_bytes = false;          ///< the file's byte order is not the machine's
  double slope = 1, intercept = 0;  ///< value = slope * pixel + intercept, as float32 unless 1, 0
  std::int64_t count = 0;           ///< pixels
};

/// \param path  the file that errors name. \throws Error bad_input: more pixels than the file can
///        hold, before anything is allocated.
std::unique_ptr<PixelSource> make_file_pixels(const std::string& path, const PixelLayout& layout);

}  // namespace vasamesh
