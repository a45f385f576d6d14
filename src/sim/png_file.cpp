#include "src/sim/png_file.hpp"

#include <png.h>

namespace pled::sim {

Result<void> write_png(const std::filesystem::path& path, ImageView<const std::uint8_t> image) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(image.width);
  header.height = static_cast<png_uint_32>(image.height);
  header.format = PNG_FORMAT_GRAY;
  header.flags = PNG_IMAGE_FLAG_FAST;
  const int written =
      png_image_write_to_file(&header, path.c_str(), 0, image.data, image.stride, nullptr);
  if (written == 0) return ErrorCode::kIoFailure;
  return {};
}

}  // namespace pled::sim
