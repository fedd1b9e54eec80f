// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <new>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace arap {

/// An uninitialized array of numbers, aligned to a cache line. Large arrays ask for huge pages: a solve streams through
/// the whole factor, and with pages of 4 KiB it waits for address translation.
template <class Number>
class AlignedBuffer {
 public:
  AlignedBuffer() = default;

  explicit AlignedBuffer(size_t size) : size_(size) {
    const size_t alignment = size * sizeof(Number) >= kHugePage ? kHugePage : kCacheLine;
    const size_t bytes = (std::max<size_t>(1, size * sizeof(Number)) + alignment - 1) / alignment * alignment;
    data_ = {static_cast<Number*>(::operator new (bytes, std::align_val_t{alignment})), Delete{alignment}};
#if defined(__linux__)
    // Advice only: the kernel may ignore it.
    if (alignment == kHugePage) static_cast<void>(madvise(data_.get(), bytes, MADV_HUGEPAGE));
#endif
  }

  [[nodiscard]] Number* data() { return data_.get(); }
  [[nodiscard]] const Number* data() const { return data_.get(); }
  [[nodiscard]] size_t size() const { return size_; }
  [[nodiscard]] Number& operator[](size_t i) { return data_[i]; }
  [[nodiscard]] const Number& operator[](size_t i) const { return data_[i]; }

 private:
  static constexpr size_t kCacheLine = 64;
  static constexpr size_t kHugePage = size_t{2} << 20;

  struct Delete {
    size_t alignment = kCacheLine;

    void operator()(Number* p) const { ::operator delete (p, std::align_val_t{alignment}); }
  };

  size_t size_ = 0;
  std::unique_ptr<Number[], Delete> data_;
};

}  // namespace arap
