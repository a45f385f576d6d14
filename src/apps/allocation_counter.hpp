#pragma once

#include <cstdint>
#include <optional>

namespace pled::apps {

/// Heap allocations of the whole process since it began (malloc, calloc, realloc and
/// the aligned forms, by whomever); nullopt where they cannot be counted (sanitizers
/// bring an allocator of their own, other C libraries have no hook).
[[nodiscard]] std::optional<std::uint64_t> allocation_count() noexcept;

}  // namespace pled::apps
