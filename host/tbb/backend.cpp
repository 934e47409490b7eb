#include "tbb/backend.h"

#include <tbb/global_control.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <fstream>
#include <new>
#include <string>
#include <thread>
#include <vector>

#include "tbb/tbb_backend.h"
#include "vasamesh/errors.h"

namespace vasamesh {

namespace {

constexpr std::size_t kAlignment = 64;
/// The bytes of the block that serves a request: rounded up by a quarter at most, so that kept
/// blocks fit the buffers of the next volume.
std::size_t block_size(std::size_t bytes) {
  const std::size_t step = std::max<std::size_t>(std::bit_floor(bytes) / 4, kAlignment);
  return (bytes + step - 1) / step * step;
}

constexpr std::size_t kBlock = 16384;                     // elements a task of the primitives takes
constexpr std::size_t kCopyBytes = std::size_t{1} << 20;  // that a task of a copy takes

/// How many an arena of one's own has: oneTBB starts no more than the process allows.
int arena_threads(int asked) {
  if (asked <= 0) return tbb::task_arena::automatic;
  const std::size_t allowed =
      tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  return static_cast<int>(std::min<std::size_t>(capped_threads(asked), allowed));
}

}  // namespace

int processor_count() { return std::max(1, static_cast<int>(std::thread::hardware_concurrency())); }

std::string processor_name() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    const std::size_t colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "CPU";
}

int capped_threads(int asked) {
  constexpr int kPerProcessor = 4;
  return std::min(asked, kPerProcessor * processor_count());
}

std::shared_ptr<Backend> make_tbb_backend(int threads, void* task_arena,
                                          std::shared_ptr<ByteAccount> total) {
  return std::make_shared<TbbBackend>(threads, task_arena, std::move(total));
}

TbbBackend::TbbBackend(int threads, void* task_arena, std::shared_ptr<ByteAccount> total)
    : arena_(static_cast<tbb::task_arena*>(task_arena)), account_(std::move(total)) {
  if (arena_) return;
  own_arena_ = std::make_unique<tbb::task_arena>(arena_threads(threads));
  arena_ = own_arena_.get();
}

std::string TbbBackend::device() const {
  return "CPU, " + std::to_string(arena_->max_concurrency()) + " threads";
}

void* TbbBackend::allocate(std::size_t bytes) {
  account_.take(bytes);
  const std::size_t size = block_size(bytes);
  if (void* memory = take_block(size)) return memory;
  give_back_kept();
  if (void* memory = take_block(size)) return memory;
  account_.give(bytes);
  throw Error(ErrorCode::refused, "out of memory: " + std::to_string(bytes) +
                                      " bytes could not be had: convert a part of the volume");
}

void TbbBackend::release(void* handle, std::size_t bytes) noexcept {
  account_.give(bytes);
  if (!keep_block(handle, block_size(bytes)))
    ::operator delete(handle, std::align_val_t(kAlignment));
}

void TbbBackend::set_byte_limit(std::size_t bytes) {
  account_.set_limit(bytes);
  {
    const std::scoped_lock lock(kept_mutex_);
    limited_ = bytes > 0;
  }
  if (bytes > 0) give_back_kept();
}

bool TbbBackend::keep_block(void* block, std::size_t size) noexcept {
  const std::size_t most = account_.peak() + account_.peak() / 4 + kAlignment;  // of whole blocks
  const std::scoped_lock lock(kept_mutex_);
  if (keepers_ == 0 || limited_ || kept_bytes_ + size > most) return false;
  try {
    kept_[size].push_back(block);
  } catch (const std::bad_alloc&) {
    return false;
  }
  kept_bytes_ += size;
  return true;
}

void* TbbBackend::take_block(std::size_t size) {
  {
    const std::scoped_lock lock(kept_mutex_);
    if (const auto found = kept_.find(size); found != kept_.end() && !found->second.empty()) {
      void* block = found->second.back();
      found->second.pop_back();
      kept_bytes_ -= size;
      return block;
    }
  }
  return ::operator new(size, std::align_val_t(kAlignment), std::nothrow);
}

void TbbBackend::keep_memory(bool keep) {
  bool last = false;
  {
    const std::scoped_lock lock(kept_mutex_);
    keepers_ += keep ? 1 : -1;
    last = keepers_ == 0;
  }
  if (last) give_back_kept();
}

void TbbBackend::give_back_kept() {
  const std::scoped_lock lock(kept_mutex_);
  for (auto& [size, blocks] : kept_)
    for (void* block : blocks) ::operator delete(block, std::align_val_t(kAlignment));
  kept_.clear();
  kept_bytes_ = 0;
}

void TbbBackend::copy(void* to, const void* from, std::size_t bytes) {
  for_each((bytes + kCopyBytes - 1) / kCopyBytes, 1, [=](std::size_t block) {
    const std::size_t first = block * kCopyBytes;
    std::memcpy(static_cast<std::byte*>(to) + first, static_cast<const std::byte*>(from) + first,
                std::min(kCopyBytes, bytes - first));
  });
}

void TbbBackend::write(void* handle, std::size_t offset, const void* from, std::size_t bytes) {
  copy(static_cast<std::byte*>(handle) + offset, from, bytes);
}

void TbbBackend::read(const void* handle, std::size_t offset, void* to, std::size_t bytes) {
  copy(to, static_cast<const std::byte*>(handle) + offset, bytes);
}

void TbbBackend::run(std::size_t tasks, const std::function<void(std::size_t)>& task) {
  for_each(tasks, 1, task);
}

template <class T>
void TbbBackend::fill_blocks(View<T> values, T value) {
  for_each((values.size + kBlock - 1) / kBlock, 1, [=](std::size_t block) {
    const std::size_t first = block * kBlock;
    std::fill_n(values.data() + first, std::min(kBlock, values.size - first), value);
  });
}

void TbbBackend::fill(View<float> values, float value) { fill_blocks(values, value); }

void TbbBackend::fill(View<std::uint8_t> values, std::uint8_t value) { fill_blocks(values, value); }

void TbbBackend::fill(View<std::uint32_t> values, std::uint32_t value) {
  fill_blocks(values, value);
}

std::uint32_t TbbBackend::exclusive_scan(View<const std::uint32_t> values,
                                         View<std::uint32_t> sums) {
  const std::size_t blocks = (values.size + kBlock - 1) / kBlock;
  std::vector<std::uint64_t> block_sum(blocks + 1, 0);
  for_each(blocks, 1, [&](std::size_t block) {
    const std::size_t end = std::min((block + 1) * kBlock, values.size);
    std::uint64_t sum = 0;
    for (std::size_t i = block * kBlock; i < end; ++i) sum += values[i];
    block_sum[block + 1] = sum;
  });
  for (std::size_t i = 0; i < blocks; ++i) block_sum[i + 1] += block_sum[i];
  if (block_sum[blocks] > 0xffffffffu)
    throw Error(ErrorCode::refused, "more than 2^32 elements: convert a part of the volume");
  for_each(blocks, 1, [&](std::size_t block) {
    const std::size_t end = std::min((block + 1) * kBlock, values.size);
    auto sum = static_cast<std::uint32_t>(block_sum[block]);
    for (std::size_t i = block * kBlock; i < end; ++i) {
      const std::uint32_t value = values[i];
      sums[i] = sum;
      sum += value;
    }
  });
  const auto total = static_cast<std::uint32_t>(block_sum[blocks]);
  sums[values.size] = total;
  return total;
}

float TbbBackend::reduce_sum(View<const float> values) {
  if (values.size == 0) return 0;
  std::size_t n = 1;
  while (n < values.size) n *= 2;
  std::vector<float> sums(n, 0.0f);
  std::copy_n(values.data(), values.size, sums.begin());
  for (n /= 2; n > 0; n /= 2)
    for (std::size_t i = 0; i < n; ++i) sums[i] += sums[i + n];
  return sums[0];
}

}  // namespace vasamesh
