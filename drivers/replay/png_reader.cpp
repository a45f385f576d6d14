#include <csetjmp>

#include <png.h>

#include "drivers/replay/image_codec.hpp"

namespace pled::replay {
namespace {

/// State of one decode, reached from the library's callbacks. No destructors:
/// the library leaves by longjmp.
struct PngJob {
  ImageBytes* in = nullptr;
  const DecodeTarget* target = nullptr;
  Message* message = nullptr;
  std::size_t arena_used = 0;
  png_structp png = nullptr;
  png_infop info = nullptr;
  ImageSize size;
};

[[nodiscard]] PngJob& job_of(void* pointer) noexcept { return *static_cast<PngJob*>(pointer); }

void on_read(png_structp png, png_bytep out, std::size_t bytes) {
  PngJob& job = job_of(png_get_io_ptr(png));
  if (!job.in->read_exactly({reinterpret_cast<std::byte*>(out), bytes})) {
    png_error(png, "the file ends in the middle of the image");
  }
}

void on_error(png_structp png, png_const_charp text) {
  job_of(png_get_error_ptr(png)).message->set(text);
  png_longjmp(png, 1);
}

void on_warning(png_structp /*png*/, png_const_charp /*text*/) {}

/// Memory by moving a mark: an image's needs end with the image.
void* on_allocate(png_structp png, png_alloc_size_t bytes) {
  PngJob& job = job_of(png_get_mem_ptr(png));
  constexpr std::size_t kAlign = alignof(std::max_align_t);
  const std::span<std::byte> arena = job.target->arena;
  if (bytes > arena.size()) return nullptr;
  const std::size_t need = (bytes + kAlign - 1) / kAlign * kAlign;
  if (need > arena.size() - job.arena_used) return nullptr;
  void* const memory = arena.data() + job.arena_used;
  job.arena_used += need;
  return memory;
}

void on_free(png_structp /*png*/, void* /*memory*/) {}

/// Asks the library for 8 bits a sample, one (grey) or three (colour) a pixel.
void request_8_bit(PngJob& job) {
  png_set_scale_16(job.png);
  png_set_expand_gray_1_2_4_to_8(job.png);
  png_set_palette_to_rgb(job.png);
  png_set_strip_alpha(job.png);
}

void read_rows(PngJob& job, bool colour) {
  const auto width = static_cast<std::size_t>(job.size.width_px);
  const auto height = static_cast<std::size_t>(job.size.height_px);
  std::uint8_t* const pixels = job.target->pixels.data();
  if (!colour) {
    for (std::size_t y = 0; y < height; ++y) job.target->rows[y] = pixels + y * width;
    png_read_image(job.png, job.target->rows.data());
    return;
  }
  std::uint8_t* const row = job.target->row.data();
  for (std::size_t y = 0; y < height; ++y) {
    png_read_row(job.png, row, nullptr);
    for (std::size_t x = 0; x < width; ++x) {
      pixels[y * width + x] = luma(row[3 * x], row[3 * x + 1], row[3 * x + 2]);
    }
  }
}

ErrorCode run(PngJob& job) noexcept {
  if (setjmp(png_jmpbuf(job.png)) != 0) {
    return job.in->ended() ? ErrorCode::kTruncated : ErrorCode::kCorrupt;
  }
  png_set_read_fn(job.png, &job, on_read);
  png_read_info(job.png, job.info);
  const png_uint_32 width = png_get_image_width(job.png, job.info);
  const png_uint_32 height = png_get_image_height(job.png, job.info);
  if (!size_is_allowed(width, height, *job.target, *job.message)) return ErrorCode::kTooLarge;
  job.size = {static_cast<int>(width), static_cast<int>(height)};
  if (job.target->header_only) return ErrorCode::kNone;

  const bool colour = (png_get_color_type(job.png, job.info) & PNG_COLOR_MASK_COLOR) != 0;
  const bool interlaced = png_get_interlace_type(job.png, job.info) != PNG_INTERLACE_NONE;
  if (colour && interlaced) {
    job.message->set("an interlaced colour PNG: store it without interlacing");
    return ErrorCode::kUnsupported;
  }
  request_8_bit(job);
  if (interlaced) png_set_interlace_handling(job.png);
  png_read_update_info(job.png, job.info);
  read_rows(job, colour);
  png_read_end(job.png, nullptr);  // checks that the file is whole
  return ErrorCode::kNone;
}

}  // namespace

Result<ImageSize> decode_png(ImageBytes& in, const DecodeTarget& target,
                             Message& message) noexcept {
  PngJob job{.in = &in, .target = &target, .message = &message, .size = {}};
  job.png = png_create_read_struct_2(PNG_LIBPNG_VER_STRING, &job, on_error, on_warning, &job,
                                     on_allocate, on_free);
  if (job.png == nullptr) return ErrorCode::kIoFailure;
  job.info = png_create_info_struct(job.png);
  const ErrorCode code = job.info == nullptr ? ErrorCode::kIoFailure : run(job);
  png_destroy_read_struct(&job.png, &job.info, nullptr);
  if (code != ErrorCode::kNone) return code;
  return job.size;
}

}  // namespace pled::replay
