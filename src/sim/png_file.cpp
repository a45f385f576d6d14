#include "src/sim/png_file.hpp"

#include <bit>
#include <csetjmp>
#include <cstdio>
#include <memory>

#include <png.h>

namespace pled::sim {

static_assert(std::endian::native == std::endian::little, "png_set_swap below");

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

Result<void> write_png16(const std::filesystem::path& path,
                         const std::vector<std::uint16_t>& values, int width_px, int height_px) {
  // libpng's simplified writer takes 16 bits as linear light and marks the file so; readers of
  // depth want plain numbers, hence the full interface.
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "wb"),
                                                             std::fclose);
  if (!file) return ErrorCode::kIoFailure;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png != nullptr ? png_create_info_struct(png) : nullptr;
  if (info == nullptr || setjmp(png_jmpbuf(png)) != 0) {
    png_destroy_write_struct(&png, &info);
    return ErrorCode::kIoFailure;
  }
  png_init_io(png, file.get());
  png_set_compression_level(png, 1);
  png_set_IHDR(png, info, static_cast<png_uint_32>(width_px), static_cast<png_uint_32>(height_px),
               16, PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  png_set_swap(png);  // PNG is big-endian
  for (int y = 0; y < height_px; ++y)
    png_write_row(png, reinterpret_cast<png_const_bytep>(values.data() + y * width_px));
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return {};
}

}  // namespace pled::sim
