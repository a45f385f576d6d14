#include "support/heap_counter.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdlib>

#include <malloc.h>

#include <doctest/doctest.h>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define PLED_COUNTS_ALLOCATIONS 0
#else
#define PLED_COUNTS_ALLOCATIONS 1
#endif

namespace {
std::size_t allocated = 0;
std::size_t live = 0;
std::size_t peak = 0;
}  // namespace

#if PLED_COUNTS_ALLOCATIONS
namespace {
void* counted(void* p) {
  if (p == nullptr) return p;
  ++allocated;
  live += malloc_usable_size(p);
  peak = std::max(peak, live);
  return p;
}
}  // namespace

// Every way to the heap goes through these in glibc, operator new and OpenCV's own included.
extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* old, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);
void __libc_free(void* p);

void* malloc(std::size_t size) { return counted(__libc_malloc(size)); }
void* calloc(std::size_t count, std::size_t size) { return counted(__libc_calloc(count, size)); }
void* realloc(void* old, std::size_t size) {
  if (old != nullptr) live -= malloc_usable_size(old);
  return counted(__libc_realloc(old, size));
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  return counted(__libc_memalign(alignment, size));
}
void* memalign(std::size_t alignment, std::size_t size) {
  return counted(__libc_memalign(alignment, size));
}
int posix_memalign(void** out, std::size_t alignment, std::size_t size) {
  *out = counted(__libc_memalign(alignment, size));
  return *out == nullptr ? ENOMEM : 0;
}
void free(void* p) {
  if (p != nullptr) live -= malloc_usable_size(p);
  __libc_free(p);
}
}
#endif

namespace pled::support {

bool heap_is_counted() {
  if (PLED_COUNTS_ALLOCATIONS == 0) {
    MESSAGE("skipped: the sanitizer owns the heap");
    return false;
  }
  const std::size_t start = allocated;
  void* volatile block = std::malloc(1);  // volatile: else the compiler leaves both out
  std::free(block);
  REQUIRE(allocated > start);
  return true;
}

std::size_t allocations() noexcept { return allocated; }
std::size_t live_bytes() noexcept { return live; }
std::size_t peak_bytes() noexcept { return peak; }
void forget_peak() noexcept { peak = live; }

}  // namespace pled::support
