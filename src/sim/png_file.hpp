#pragma once

#include <cstdint>
#include <filesystem>

#include "pled_vins/core/image_view.hpp"
#include "pled_vins/core/result.hpp"

namespace pled::sim {

/// Writes an 8-bit grey PNG, replacing the file. Error: kIoFailure.
[[nodiscard]] Result<void> write_png(const std::filesystem::path& path,
                                     ImageView<const std::uint8_t> image);

}  // namespace pled::sim
