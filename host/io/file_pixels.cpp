/// \file
/// Pixels streamed out of a file: one thread reads and decompresses, the others visit.

#include <tbb/parallel_pipeline.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <memory>
#include <vector>

#include "io/io_error.h"
#include "io/pixel_source.h"
#include "tbb/task_order.h"

namespace vasamesh {
namespace {

constexpr std::size_t kChunkPixels = std::size_t{1} << 17;
constexpr std::size_t kChunksInFlight = 8;

struct Chunk {
  std::size_t first = 0, count = 0;
  std::unique_ptr<unsigned char[]> bytes;
};

void swap_bytes(const Chunk& chunk, std::size_t width) {
  for (std::size_t i = 0; i < chunk.count; ++i) {
    std::reverse(&chunk.bytes[i * width], &chunk.bytes[i * width] + width);
  }
}

template <class T>
void rescale(const unsigned char* bytes, std::size_t count, double slope, double intercept,
             float* values) {
  for (std::size_t i = 0; i < count; ++i) {
    T pixel;
    std::memcpy(&pixel, bytes + i * sizeof(T), sizeof(T));
    values[i] = static_cast<float>(slope * static_cast<double>(pixel) + intercept);
  }
}

std::vector<float> rescaled(const Chunk& chunk, const PixelLayout& layout) {
  std::vector<float> values(chunk.count);
  const auto run = [&]<class T>(T) {
    rescale<T>(chunk.bytes.get(), chunk.count, layout.slope, layout.intercept, values.data());
  };
  visit_pixel_type(layout.type, run);
  return values;
}

class FilePixels final : public PixelSource {
 public:
  FilePixels(std::string path, PixelLayout layout)
      : path_(std::move(path)), layout_(std::move(layout)) {}

  void visit(const ChunkVisitor& visitor) const override {
    ByteStream stream(layout_.file, layout_.file_offset, layout_.encoding);
    stream.skip(layout_.skip);
    visit_chunks(stream, visitor);
    check_end(stream);
  }

 private:
  void visit_chunks(ByteStream& stream, const ChunkVisitor& visitor) const {
    std::size_t next = 0;
    const auto read = [&](tbb::flow_control& flow) {
      auto chunk = read_chunk(stream, next);
      if (!chunk) flow.stop();
      return chunk;
    };
    const auto use = [&](const std::shared_ptr<Chunk>& chunk) { visit_chunk(*chunk, visitor); };
    TaskOrder order;
    tbb::parallel_pipeline(kChunksInFlight,
                           tbb::make_filter<void, std::shared_ptr<Chunk>>(
                               tbb::filter_mode::serial_in_order, order.in_turn(read)) &
                               tbb::make_filter<std::shared_ptr<Chunk>, void>(
                                   tbb::filter_mode::parallel, order.around(use)));
  }

  std::shared_ptr<Chunk> read_chunk(ByteStream& stream, std::size_t& next) const {
    const std::size_t left = static_cast<std::size_t>(layout_.count) - next;
    if (left == 0) return nullptr;
    auto chunk = std::make_shared<Chunk>();
    chunk->first = next;
    chunk->count = std::min(left, kChunkPixels);
    const std::size_t bytes = chunk->count * pixel_bytes(layout_.type);
    chunk->bytes = std::make_unique_for_overwrite<unsigned char[]>(bytes);
    if (stream.read(chunk->bytes.get(), bytes) != bytes) {
      throw_bad_input(path_, "truncated: it holds fewer voxels than its header says",
                      "get a whole copy of the file");
    }
    next += chunk->count;
    return chunk;
  }

  void visit_chunk(Chunk& chunk, const ChunkVisitor& visitor) const {
    if (layout_.swap_bytes) swap_bytes(chunk, pixel_bytes(layout_.type));
    if (layout_.slope == 1 && layout_.intercept == 0) {
      visitor({chunk.first, chunk.count, layout_.type, chunk.bytes.get()});
    } else {
      const std::vector<float> values = rescaled(chunk, layout_);
      visitor({chunk.first, chunk.count, PixelType::float32, values.data()});
    }
  }

  // A few bytes of padding are nobody's fault; a surplus of as much again is a wrong header.
  void check_end(ByteStream& stream) const {
    const std::int64_t expected =
        layout_.count * static_cast<std::int64_t>(pixel_bytes(layout_.type));
    const std::int64_t padding = std::max<std::int64_t>(4096, expected / 64);
    if (stream.finish() > padding) {
      throw_bad_input(path_, "it holds more voxels than its header says",
                      "write the volume again with the right sizes");
    }
  }

  std::string path_;
  PixelLayout layout_;
};

}  // namespace

std::size_t pixel_bytes(PixelType type) {
  std::size_t bytes = 0;
  visit_pixel_type(type, [&]<class T>(T) { bytes = sizeof(T); });
  return bytes;
}

std::unique_ptr<PixelSource> make_file_pixels(const std::string& path, const PixelLayout& layout) {
  const std::int64_t bytes = file_size(layout.file) - layout.file_offset;
  const std::int64_t held = decoded_bound(std::max<std::int64_t>(bytes, 0), layout.encoding);
  const auto width = static_cast<std::int64_t>(pixel_bytes(layout.type));
  if (layout.skip > held || layout.count > (held - layout.skip) / width) {
    throw_bad_input(path,
                    "its header asks for " + std::to_string(layout.count) +
                        " voxels, more than a file of this size can hold",
                    "get a whole copy of the file");
  }
  return std::make_unique<FilePixels>(path, layout);
}

}  // namespace vasamesh
