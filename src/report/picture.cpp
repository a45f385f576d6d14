#include "src/report/picture.hpp"

#include <algorithm>

#include <png.h>

#include "src/report/base64.hpp"

namespace pled::report {
namespace {

int height_for(ImageView<const std::uint8_t> image, int width_px) {
  return std::max(1, image.height * width_px / image.width);
}

/// First pixel of a cell when `size` pixels become `cells`.
int edge(int cell, int size, int cells) { return cell * size / cells; }

std::uint8_t mean(ImageView<const std::uint8_t> image, int x0, int x1, int y0, int y1) {
  unsigned sum = 0;
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) sum += image.at(y, x);
  const auto count = static_cast<unsigned>((x1 - x0) * (y1 - y0));
  return static_cast<std::uint8_t>((sum + count / 2) / count);
}

/// 64 grey levels: the eye does not miss the others, and the noise in them is most of
/// what a PNG of a photograph weighs.
Picture coarser(Picture picture) {
  for (std::uint8_t& pixel : picture.pixels)
    pixel = static_cast<std::uint8_t>((pixel & 0xFCU) | (pixel >> 6U));
  return picture;
}

}  // namespace

Picture shrunk(ImageView<const std::uint8_t> image, int width_px) {
  const int width = std::min(width_px, image.width);
  Picture out(width, height_for(image, width));
  for (int y = 0; y < out.height_px; ++y) {
    const int y0 = edge(y, image.height, out.height_px);
    const int y1 = std::max(y0 + 1, edge(y + 1, image.height, out.height_px));
    for (int x = 0; x < width; ++x) {
      const int x0 = edge(x, image.width, width);
      out.at(y, x) = mean(image, x0, std::max(x0 + 1, edge(x + 1, image.width, width)), y0, y1);
    }
  }
  return out;
}

Picture thinned(ImageView<const std::uint8_t> image, int width_px) {
  const int width = std::min(width_px, image.width);
  Picture out(width, height_for(image, width));
  for (int y = 0; y < out.height_px; ++y)
    for (int x = 0; x < width; ++x)
      out.at(y, x) = image.at(edge(y, image.height, out.height_px), edge(x, image.width, width));
  return out;
}

std::string png_base64(const Picture& picture) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(picture.width_px);
  header.height = static_cast<png_uint_32>(picture.height_px);
  header.format = PNG_FORMAT_GRAY;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(header);
  std::string bytes(size, '\0');
  const int written = png_image_write_to_memory(&header, bytes.data(), &size, 0,
                                                picture.pixels.data(), picture.width_px, nullptr);
  if (written == 0) return {};
  bytes.resize(size);
  return base64(bytes);
}

std::string png_base64_within(const Picture& picture, std::size_t max_bytes) {
  constexpr int kSmallest_px = 64;
  std::string text = png_base64(picture);
  Picture smaller = coarser(picture);
  while (text.size() > max_bytes && !text.empty()) {
    text = png_base64(smaller);
    const int width = smaller.width_px * 4 / 5;
    if (width < kSmallest_px) break;
    smaller = coarser(shrunk(picture.view(), width));
  }
  return text;
}

}  // namespace pled::report
