#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "pled_vins/core/image_view.hpp"
#include "pled_vins/core/result.hpp"

namespace pled::sim {

/// Writes an 8-bit grey PNG, replacing the file. Error: kIoFailure.
[[nodiscard]] Result<void> write_png(const std::filesystem::path& path,
                                     ImageView<const std::uint8_t> image);

/// Writes a 16-bit grey PNG of width x height values, row-major. Error: kIoFailure.
[[nodiscard]] Result<void> write_png16(const std::filesystem::path& path,
                                       const std::vector<std::uint16_t>& values, int width_px,
                                       int height_px);

}  // namespace pled::sim
