#include "drivers/replay/aedat2_sources.hpp"

#include <utility>

namespace pled::replay {

Result<Aedat2RecordFile> Aedat2RecordFile::open(const std::string& path,
                                                const Aedat2Header& header) {
  auto file = File::open(path.c_str());
  if (!file.ok()) return file.error();
  PLED_TRY(file.value().seek(header.bytes));
  Aedat2RecordFile out;
  out.file_ = std::move(file).value();
  out.path_ = path;
  out.buffer_ = std::make_unique<std::byte[]>(kBufferBytes);
  out.position_ = header.bytes;
  return out;
}

Result<Aedat2Record> Aedat2RecordFile::next() noexcept {
  while (true) {
    if (const auto record = records_.next(rest_)) return *record;
    if (ended_) return ErrorCode::kEndOfStream;
    const auto got = file_.read({buffer_.get(), kBufferBytes});
    if (!got.ok()) return got.error();
    rest_ = {buffer_.get(), got.value()};
    position_ += static_cast<std::int64_t>(got.value());
    ended_ = got.value() < kBufferBytes;
  }
}

double Aedat2RecordFile::progress() const noexcept {
  if (file_.size() <= 0) return 1.0;
  return static_cast<double>(position_) / static_cast<double>(file_.size());
}

Result<Aedat2Census> take_census(const std::string& path, const Aedat2Header& header) {
  auto file = Aedat2RecordFile::open(path, header);
  if (!file.ok()) return file.error();
  Aedat2Census census;
  while (true) {
    const auto record = file.value().next();
    if (!record.ok() && record.error().code == ErrorCode::kEndOfStream) return census;
    if (!record.ok()) return record.error();
    switch (record.value().kind()) {
      case Aedat2Kind::kImu: census.imu = true; break;
      case Aedat2Kind::kReset:
      case Aedat2Kind::kSignal: census.frames = true; break;
      case Aedat2Kind::kSpecial: ++census.special; break;
      case Aedat2Kind::kEvent:
      case Aedat2Kind::kUnknown: break;
    }
  }
}

Aedat2ImuSource::Aedat2ImuSource(Aedat2RecordFile file, Aedat2ImuScale scale)
    : file_(std::move(file)), collector_(scale) {}

Result<ImuSample> Aedat2ImuSource::read(Duration /*timeout*/) noexcept {
  while (true) {
    const auto record = file_.next();
    if (!record.ok()) {
      if (record.error().code == ErrorCode::kEndOfStream) collector_.finish();
      if (collector_.malformed() > told_) return bad(last_us_);
      return record.error();
    }
    last_us_ = record.value().t_us;
    // A faulty word never ends a sample.
    const auto sample = collector_.take(record.value());
    if (sample) return *sample;
    if (collector_.malformed() > told_) return bad(last_us_);
  }
}

Error Aedat2ImuSource::bad(std::int64_t t_us) noexcept {
  told_ = collector_.malformed();
  message_.set("%s: inertial words at t = %.6f s are no whole sample; they were skipped",
               file_.path().c_str(), static_cast<double>(t_us) * 1e-6);
  return {ErrorCode::kBadNumber, 0};
}

Aedat2FrameSource::Aedat2FrameSource(Aedat2RecordFile file, ImageSize size, std::size_t slots)
    : file_(std::move(file)),
      size_(size),
      samples_(static_cast<std::size_t>(size.width_px) * static_cast<std::size_t>(size.height_px) *
               2),
      collector_(size.width_px, size.height_px, samples_),
      slots_({size, slots, true}) {}

Result<FrameView> Aedat2FrameSource::acquire(Duration /*timeout*/) noexcept {
  if (slots_.full()) return ErrorCode::kTimeout;
  while (true) {
    const auto record = file_.next();
    if (!record.ok()) return record.error();
    const bool is_whole = collector_.take(record.value());
    const double t_s = static_cast<double>(record.value().t_us) * 1e-6;
    if (collector_.incomplete() > told_) {
      told_ = collector_.incomplete();
      slots_.count_unreadable();
      message_.set("%s: the frame before t = %.6f s lacks reads of pixels; frame skipped",
                   file_.path().c_str(), t_s);
      return ErrorCode::kCorrupt;
    }
    if (!is_whole) continue;
    if (!slots_.takes_stamp(collector_.t_us())) {
      message_.set(
          "%s: the stamp of the frame at t = %.6f s is not later than the last; "
          "frame skipped",
          file_.path().c_str(), t_s);
      continue;
    }
    collector_.render(slots_.next_slot());
    return slots_.push(collector_.t_us(), size_);
  }
}

}  // namespace pled::replay
