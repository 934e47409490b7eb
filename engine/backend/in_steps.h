#pragma once

/// \file
/// Long work of one thread in steps of some milliseconds at most, with a checkpoint of the backend
/// before each.

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "backend/backend.h"

namespace vasamesh {

inline constexpr std::size_t kStepTurns = std::size_t{1} << 16;  // of nanoseconds each
inline constexpr std::size_t kStepBytes = std::size_t{4} << 20;  // of memory not yet touched

/// visit(i) for i in 0 .. count - 1, in order.
template <class Visit>
void in_steps(const Backend& backend, std::size_t count, const Visit& visit) {
  for (std::size_t i = 0; i < count;) {
    backend.checkpoint();
    for (const std::size_t end = std::min(count, i + kStepTurns); i < end; ++i) visit(i);
  }
}

/// Appends `more`, which is not of `values` itself.
template <class T>
void append_in_steps(const Backend& backend, std::span<const T> more, std::vector<T>& values) {
  constexpr std::size_t kStep = kStepBytes / sizeof(T);
  const std::size_t size = values.size() + more.size();
  if (size > values.capacity()) {
    std::vector<T> larger;
    larger.reserve(std::max(size, values.empty() ? 0 : 2 * values.capacity()));
    append_in_steps<T>(backend, values, larger);
    values.swap(larger);
  }
  for (std::size_t i = 0; i < more.size(); i += kStep) {
    backend.checkpoint();
    const auto from = more.subspan(i, std::min(kStep, more.size() - i));
    values.insert(values.end(), from.begin(), from.end());
  }
}

/// values.resize(size, value)
template <class T>
void resize_in_steps(const Backend& backend, std::size_t size, std::vector<T>& values,
                     const T& value = {}) {
  constexpr std::size_t kStep = kStepBytes / sizeof(T);
  if (size > values.capacity()) {
    std::vector<T> larger;
    larger.reserve(size);
    append_in_steps<T>(backend, values, larger);
    values.swap(larger);
  }
  while (values.size() != size) {
    backend.checkpoint();
    values.resize(std::min(size, values.size() + kStep), value);
  }
}

template <class T>
std::vector<T> filled_in_steps(const Backend& backend, std::size_t size, const T& value = {}) {
  std::vector<T> values;
  resize_in_steps(backend, size, values, value);
  return values;
}

}  // namespace vasamesh
