#include "io/selection.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>

#include "io/bit_rows.h"
#include "io/io_error.h"
#include "io/value_survey.h"

namespace vasamesh {
namespace {

/// Marks pixels chunk by chunk and remembers what must become an error.
class Marker {
 public:
  Marker(const ReadOptions& options, BitRows& marks) : options_(options), marks_(marks) {}

  void operator()(const PixelChunk& chunk) {
    visit_pixel_type(chunk.type, [&]<class T>(T) {
      mark(static_cast<const T*>(chunk.pixels), chunk.count, chunk.first);
    });
  }

  bool clean() const { return selected_ && !several_ && !invalid_; }

 private:
  template <class T>
  void mark(const T* pixels, std::size_t count, std::size_t first) {
    if constexpr (std::is_floating_point_v<T>) find_invalid(pixels, count);
    if (options_.threshold) {
      mark_from(pixels, count, first, *options_.threshold);
    } else if (options_.label) {
      mark_label(pixels, count, first, *options_.label);
    } else {
      keep(pixels, count, first, [](T pixel) { return pixel != 0; });
      if (!options_.any_label) find_second_value(pixels, count);
    }
  }

  template <class T, class Keep>
  void keep(const T* pixels, std::size_t count, std::size_t first, const Keep& is_object) {
    if (marks_.set(first, count, [=](std::size_t i) { return is_object(pixels[i]); }))
      selected_ = true;
  }

  template <class T>
  void mark_from(const T* pixels, std::size_t count, std::size_t first, double threshold) {
    if constexpr (std::is_floating_point_v<T>) {
      keep(pixels, count, first, [=](T pixel) { return static_cast<double>(pixel) >= threshold; });
    } else if (threshold >= std::ldexp(1.0, std::numeric_limits<T>::digits)) {
      keep(pixels, count, first, [](T) { return false; });
    } else if (threshold <= static_cast<double>(std::numeric_limits<T>::min())) {
      keep(pixels, count, first, [](T) { return true; });
    } else {
      const T least = static_cast<T>(std::ceil(threshold));
      keep(pixels, count, first, [=](T pixel) { return pixel >= least; });
    }
  }

  template <class T>
  void mark_label(const T* pixels, std::size_t count, std::size_t first, std::int64_t label) {
    bool representable = true;
    if constexpr (std::is_integral_v<T>) representable = std::in_range<T>(label);
    const T wanted = representable ? static_cast<T>(label) : T{0};
    keep(pixels, count, first, [=](T pixel) { return representable && pixel == wanted; });
  }

  // The first chunk with a nonzero pixel says what the object's value is.
  template <class T>
  void find_second_value(const T* pixels, std::size_t count) {
    const T* end = pixels + count;
    const T* first = std::find_if(pixels, end, [](T pixel) { return pixel != 0; });
    if (first == end) return;
    const T sole = agree_on(*first);
    std::uint8_t other = 0;
    for (const T* pixel = first; pixel != end; ++pixel)
      other |= (*pixel != 0) & (*pixel != sole) ? 1 : 0;
    if (other) several_ = true;
  }

  template <class T>
  T agree_on(T value) {
    std::uint64_t bits = 0, agreed = 0;
    std::memcpy(&bits, &value, sizeof(T));
    if (!sole_bits_.compare_exchange_strong(agreed, bits)) std::memcpy(&value, &agreed, sizeof(T));
    return value;
  }

  template <class T>
  void find_invalid(const T* pixels, std::size_t count) {
    const T most =
        options_.threshold ? std::numeric_limits<T>::infinity() : std::numeric_limits<T>::max();
    bool found = false;
    for (std::size_t i = 0; i < count; ++i) found |= !(std::abs(pixels[i]) <= most);
    if (found) invalid_ = true;
  }

  const ReadOptions& options_;
  BitRows& marks_;
  std::atomic<bool> selected_{false}, several_{false}, invalid_{false};
  std::atomic<std::uint64_t> sole_bits_{0};  // bits of the object's value; 0 while unknown
};

void check_options(const ReadOptions& options) {
  if (options.label.has_value() + options.any_label + options.threshold.has_value() > 1) {
    throw Error(ErrorCode::usage, "--label and --threshold: give only one of them");
  }
  if (options.threshold && !std::isfinite(*options.threshold)) {
    throw Error(ErrorCode::usage, "--threshold: not a finite number; give one");
  }
}

[[noreturn]] void throw_several(const std::string& path, const ValueSurvey& survey) {
  if (survey.is_label_map()) {
    throw_bad_input(path, "it holds " + survey.labels_text(),
                    "choose one with --label N, all with --label any, or a grey level with "
                    "--threshold T");
  }
  throw_bad_input(path, "it holds grey levels, " + survey.range_text(),
                  "choose the object with --threshold T or --label N");
}

[[noreturn]] void throw_nothing(const std::string& path, const ValueSurvey& survey,
                                const ReadOptions& options) {
  const bool blank = survey.minimum == 0 && survey.maximum == 0;
  const std::string held = survey.is_label_map() ? survey.labels_text() : survey.range_text();
  if (options.label && !blank) {
    throw_bad_input(path, fmt::format("label {} is absent, it holds {}", *options.label, held),
                    "choose one that is there");
  }
  if (options.threshold) {
    throw_bad_input(path,
                    fmt::format("no voxel reaches the threshold {}, it holds {}",
                                *options.threshold, survey.range_text()),
                    "choose a lower one");
  }
  throw_bad_input(path, "nothing in the foreground, every voxel is 0",
                  "give a segmentation with an object");
}

[[noreturn]] void throw_unusable(const std::string& path, const PixelSource& pixels,
                                 const ReadOptions& options) {
  const ValueSurvey survey = survey_values(pixels);
  if (survey.nan) throw_bad_input(path, "it holds NaN", "replace NaN by background");
  if (survey.infinite && !options.threshold) {
    throw_bad_input(path, "it holds infinite values", "choose the object with --threshold T");
  }
  const bool chosen = options.label || options.any_label || options.threshold;
  if (!chosen && survey.values.size() > 1) throw_several(path, survey);
  throw_nothing(path, survey, options);
}

}  // namespace

std::vector<std::uint8_t> select_object(const std::string& path, const PixelSource& pixels,
                                        const std::array<std::int64_t, 3>& size,
                                        const ReadOptions& options) {
  check_options(options);
  BitRows marks(static_cast<std::size_t>(size[0]), static_cast<std::size_t>(size[1] * size[2]));
  Marker marker(options, marks);
  pixels.visit([&](const PixelChunk& chunk) { marker(chunk); });
  if (!marker.clean()) throw_unusable(path, pixels, options);
  return marks.take();
}

}  // namespace vasamesh
