#include <csetjmp>
#include <cstdio>

#include <jpeglib.h>

#include "drivers/replay/image_codec.hpp"

namespace pled::replay {
namespace {

/// State of one decode, reached from the library's callbacks through client_data.
/// No destructors: on_error leaves by longjmp.
struct JpegJob {
  ImageBytes* in = nullptr;
  const DecodeTarget* target = nullptr;
  Message* message = nullptr;
  std::span<const std::byte> held;  ///< lent to the library
  bool truncated = false;
  bool corrupt = false;
  std::jmp_buf leave{};
  jpeg_decompress_struct jpeg{};
  jpeg_error_mgr errors{};
  jpeg_source_mgr source{};
  ImageSize size;
};

template <typename Common>
[[nodiscard]] JpegJob& job_of(Common* jpeg) noexcept {
  return *static_cast<JpegJob*>(jpeg->client_data);
}

void say(j_common_ptr jpeg) {
  std::array<char, JMSG_LENGTH_MAX> text{};
  jpeg->err->format_message(jpeg, text.data());
  job_of(jpeg).message->set(text.data());
}

[[noreturn]] void on_error(j_common_ptr jpeg) {
  say(jpeg);
  std::longjmp(job_of(jpeg).leave, 1);
}

/// Warnings (negative levels) mean that data were made up to go on.
void on_message(j_common_ptr jpeg, int level) {
  if (level >= 0) return;
  say(jpeg);
  job_of(jpeg).corrupt = true;
}

void on_start(j_decompress_ptr /*jpeg*/) {}

boolean on_fill(j_decompress_ptr jpeg) {
  static constexpr std::array<JOCTET, 2> kEndOfImage{0xFF, JPEG_EOI};
  JpegJob& job = job_of(jpeg);
  job.in->consume(job.held.size());
  job.held = job.in->peek();
  if (job.held.empty()) {
    job.truncated = true;
    job.source.next_input_byte = kEndOfImage.data();
    job.source.bytes_in_buffer = kEndOfImage.size();
  } else {
    job.source.next_input_byte = reinterpret_cast<const JOCTET*>(job.held.data());
    job.source.bytes_in_buffer = job.held.size();
  }
  return TRUE;
}

void on_skip(j_decompress_ptr jpeg, long bytes) {
  if (bytes <= 0) return;
  JpegJob& job = job_of(jpeg);
  auto left = static_cast<std::size_t>(bytes);
  while (left > job.source.bytes_in_buffer) {
    left -= job.source.bytes_in_buffer;
    on_fill(jpeg);
    if (job.truncated) return;
  }
  job.source.next_input_byte += left;
  job.source.bytes_in_buffer -= left;
}

void on_finish(j_decompress_ptr /*jpeg*/) {}

void connect(JpegJob& job) {
  job.jpeg.err = jpeg_std_error(&job.errors);
  job.errors.error_exit = on_error;
  job.errors.emit_message = on_message;
  job.jpeg.client_data = &job;
}

void connect_source(JpegJob& job) {
  job.source.init_source = on_start;
  job.source.fill_input_buffer = on_fill;
  job.source.skip_input_data = on_skip;
  job.source.resync_to_restart = jpeg_resync_to_restart;
  job.source.term_source = on_finish;
  job.jpeg.src = &job.source;
}

ErrorCode run(JpegJob& job) noexcept {
  if (setjmp(job.leave) != 0) return job.truncated ? ErrorCode::kTruncated : ErrorCode::kCorrupt;
  jpeg_create_decompress(&job.jpeg);
  connect_source(job);
  jpeg_read_header(&job.jpeg, TRUE);
  if (!size_is_allowed(job.jpeg.image_width, job.jpeg.image_height, *job.target, *job.message)) {
    return ErrorCode::kTooLarge;
  }
  job.size = {static_cast<int>(job.jpeg.image_width), static_cast<int>(job.jpeg.image_height)};
  if (job.target->header_only) return ErrorCode::kNone;
  job.jpeg.out_color_space = JCS_GRAYSCALE;  // the Y of YCbCr: BT.601 luma
  job.jpeg.dct_method = JDCT_ISLOW;          // integers: the same pixels everywhere
  jpeg_start_decompress(&job.jpeg);
  const auto width = static_cast<std::size_t>(job.size.width_px);
  while (job.jpeg.output_scanline < job.jpeg.output_height) {
    JSAMPROW row = job.target->pixels.data() + job.jpeg.output_scanline * width;
    jpeg_read_scanlines(&job.jpeg, &row, 1);
  }
  jpeg_finish_decompress(&job.jpeg);
  if (job.truncated) {
    job.message->set("the file ends in the middle of the image");
    return ErrorCode::kTruncated;
  }
  return job.corrupt ? ErrorCode::kCorrupt : ErrorCode::kNone;
}

}  // namespace

Result<ImageSize> decode_jpeg(ImageBytes& in, const DecodeTarget& target,
                              Message& message) noexcept {
  JpegJob job;
  job.in = &in;
  job.target = &target;
  job.message = &message;
  connect(job);
  const ErrorCode code = run(job);
  jpeg_destroy_decompress(&job.jpeg);
  if (code != ErrorCode::kNone) return code;
  return job.size;
}

}  // namespace pled::replay
