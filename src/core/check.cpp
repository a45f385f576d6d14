#include "pled_vins/core/check.hpp"

#include <cstdio>
#include <cstdlib>

namespace pled {

void check_failed(const char* condition, const char* file, int line) noexcept {
  std::fprintf(stderr, "pled-vins: broken invariant '%s' at %s:%d\n", condition, file, line);
  std::abort();
}

}  // namespace pled
