#pragma once

/// \file
/// Memory of a backend: a move-only owner (Buffer) and a cheap view (View). A pass takes views
/// alone. The host reaches the elements through Backend::on_host, or by an explicit copy.

#include <cstddef>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

namespace vasamesh {

/// `size` elements of T from element `offset` of a backend's allocation. `handle` is what the
/// backend's allocate() returned: the address of the allocation in the host's memory, of which a
/// device may hold a copy. Null with size 0.
template <class T>
struct View {
  void* handle = nullptr;
  std::size_t offset = 0;
  std::size_t size = 0;

  /// The elements' address in the host's memory; what is there is what the passes have left once
  /// Backend::on_host or settle has been called.
  T* data() const { return static_cast<T*>(handle) + offset; }
  T& operator[](std::size_t i) const { return data()[i]; }

  View subview(std::size_t first, std::size_t count) const {
    return {handle, offset + first, count};
  }
  operator View<const T>() const requires(!std::is_const_v<T>) { return {handle, offset, size}; }
};

/// What lies in the host's memory, for passes that only read it.
template <class T>
View<const T> view_of(const std::vector<T>& values) {
  return {const_cast<T*>(values.data()), 0, values.size()};
}

/// Where buffers come from. Counts what it gives out.
class Memory {
 public:
  virtual ~Memory() = default;
  /// \throws Error refused, when the bytes are not to be had or would exceed the limit.
  virtual void* allocate(std::size_t bytes) = 0;
  virtual void release(void* handle, std::size_t bytes) noexcept = 0;
};

/// An array of `size` elements in a backend's memory, uninitialised.
template <class T>
class Buffer {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  Buffer() = default;
  Buffer(Memory& memory, std::size_t size)
      : memory_(&memory),
        handle_(size ? memory.allocate(size * sizeof(T)) : nullptr),
        size_(size),
        capacity_(size) {}
  Buffer(Buffer&& other) noexcept { swap(other); }
  Buffer& operator=(Buffer&& other) noexcept {
    Buffer(std::move(other)).swap(*this);
    return *this;
  }
  ~Buffer() {
    if (handle_) memory_->release(handle_, capacity_ * sizeof(T));
  }

  /// Gives the buffer `size` elements of undefined value; keeps the memory where it is enough.
  void resize(Memory& memory, std::size_t size) {
    if (size > capacity_ || memory_ != &memory) *this = Buffer(memory, size);
    size_ = size;
  }

  std::size_t size() const { return size_; }
  View<T> view() { return {handle_, 0, size_}; }
  View<const T> view() const { return {handle_, 0, size_}; }

 private:
  void swap(Buffer& other) noexcept {
    std::swap(memory_, other.memory_);
    std::swap(handle_, other.handle_);
    std::swap(size_, other.size_);
    std::swap(capacity_, other.capacity_);
  }

  Memory* memory_ = nullptr;
  void* handle_ = nullptr;
  std::size_t size_ = 0;
  std::size_t capacity_ = 0;
};

}  // namespace vasamesh
