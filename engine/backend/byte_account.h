#pragma once

/// \file
/// Bytes held against a limit, by one backend or by several together.

#include <atomic>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>

#include "vasamesh/errors.h"

namespace vasamesh {

/// Counts what its owner takes, and has it counted by `total` as well, whose limit holds for all
/// that share it. Any thread may take and give.
class ByteAccount {
 public:
  explicit ByteAccount(std::shared_ptr<ByteAccount> total = nullptr) : total_(std::move(total)) {}

  /// 0: none. With a total, its limit.
  void set_limit(std::size_t bytes) { total_ ? total_->set_limit(bytes) : void(limit_ = bytes); }

  /// \throws Error refused, and takes nothing, where that passes the limit.
  void take(std::size_t bytes) {
    if (total_) total_->take(bytes);
    const std::size_t held = held_ += bytes;
    if (limit_ && held > limit_) {
      held_ -= bytes;
      throw Error(ErrorCode::refused,
                  "the conversion needs more memory than --max-memory allows (" +
                      std::to_string(held) + " of " + std::to_string(limit_) +
                      " bytes): allow more, or convert a part of the volume");
    }
    std::size_t peak = peak_;
    while (held > peak && !peak_.compare_exchange_weak(peak, held)) {
    }
  }
  void give(std::size_t bytes) noexcept {
    held_ -= bytes;
    if (total_) total_->give(bytes);
  }

  std::size_t held() const { return held_; }
  std::size_t peak() const { return peak_; }

 private:
  std::shared_ptr<ByteAccount> total_;
  std::atomic<std::size_t> held_{0}, peak_{0};
  std::size_t limit_ = 0;
};

}  // namespace vasamesh
