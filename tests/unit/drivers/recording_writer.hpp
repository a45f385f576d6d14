#pragma once

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <jpeglib.h>
#include <png.h>

/// Writes recordings, whole and damaged, for tests.
namespace pled::support {

/// A folder of its own that goes with the object.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "pled_test_XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) std::abort();
    path_ = name;
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] std::string operator/(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

/// Makes the folders above as well.
inline void write_file(const std::string& path, std::span<const std::byte> bytes) {
  std::filesystem::create_directories(std::filesystem::path(path).parent_path());
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
}
inline void write_file(const std::string& path, const std::string& text) {
  write_file(path, std::as_bytes(std::span{text}));
}

/// Keeps only the beginning of a file.
inline void truncate_file(const std::string& path, double part) {
  const auto size = static_cast<double>(std::filesystem::file_size(path));
  std::filesystem::resize_file(path, static_cast<std::uintmax_t>(size * part));
}

/// One byte of a file, inverted.
inline void damage_file(const std::string& path, std::streamoff offset) {
  std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
  file.seekg(offset);
  const auto byte = static_cast<char>(~file.get());
  file.seekp(offset);
  file.put(byte);
}

/// Samples of a test image: every pixel differs from its neighbours.
inline std::vector<std::uint8_t> pattern(int width, int height, int samples_per_pixel = 1) {
  std::vector<std::uint8_t> pixels;
  const int row = width * samples_per_pixel;
  for (int i = 0; i < row * height; ++i) {
    pixels.push_back(static_cast<std::uint8_t>((i % row) * 7 + (i / row) * 13));
  }
  return pixels;
}

struct PngKind {
  int colour = PNG_COLOR_TYPE_GRAY;
  int bits = 8;
  int interlace = PNG_INTERLACE_NONE;
};

/// `samples`: the rows as PNG wants them, one after the other.
inline void write_png(const std::string& path, int width, int height,
                      const std::vector<std::uint8_t>& samples, PngKind kind = {}) {
  std::filesystem::create_directories(std::filesystem::path(path).parent_path());
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "wb"),
                                                             std::fclose);
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_init_io(png, file.get());
  png_set_IHDR(png, info, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height),
               kind.bits, kind.colour, kind.interlace, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  if (kind.colour == PNG_COLOR_TYPE_PALETTE) {
    std::vector<png_color> palette(256);
    for (std::size_t i = 0; i < palette.size(); ++i) {
      const auto value = static_cast<png_byte>(255 - i);
      palette[i] = {value, value, value};
    }
    png_set_PLTE(png, info, palette.data(), 256);
  }
  png_write_info(png, info);
  const std::size_t stride = samples.size() / static_cast<std::size_t>(height);
  std::vector<std::uint8_t> copy = samples;
  std::vector<png_bytep> rows;
  for (std::size_t y = 0; y < static_cast<std::size_t>(height); ++y) {
    rows.push_back(copy.data() + y * stride);
  }
  png_write_image(png, rows.data());
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
}

inline void write_grey_png(const std::string& path, int width, int height) {
  write_png(path, width, height, pattern(width, height));
}

/// Grey (1 sample) or RGB (3 samples a pixel), quality 100.
inline void write_jpeg(const std::string& path, int width, int height,
                       const std::vector<std::uint8_t>& samples, int samples_per_pixel = 1) {
  std::filesystem::create_directories(std::filesystem::path(path).parent_path());
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "wb"),
                                                             std::fclose);
  jpeg_compress_struct jpeg{};
  jpeg_error_mgr errors{};
  jpeg.err = jpeg_std_error(&errors);
  jpeg_create_compress(&jpeg);
  jpeg_stdio_dest(&jpeg, file.get());
  jpeg.image_width = static_cast<JDIMENSION>(width);
  jpeg.image_height = static_cast<JDIMENSION>(height);
  jpeg.input_components = samples_per_pixel;
  jpeg.in_color_space = samples_per_pixel == 1 ? JCS_GRAYSCALE : JCS_RGB;
  jpeg_set_defaults(&jpeg);
  jpeg_set_quality(&jpeg, 100, TRUE);
  jpeg_start_compress(&jpeg, TRUE);
  std::vector<std::uint8_t> copy = samples;
  const auto stride = static_cast<std::size_t>(width * samples_per_pixel);
  while (jpeg.next_scanline < jpeg.image_height) {
    JSAMPROW row = copy.data() + jpeg.next_scanline * stride;
    jpeg_write_scanlines(&jpeg, &row, 1);
  }
  jpeg_finish_compress(&jpeg);
  jpeg_destroy_compress(&jpeg);
}

}  // namespace pled::support
