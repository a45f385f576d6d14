#include "drivers/replay/frame_source.hpp"

#include <utility>

#include "drivers/decode/decimal.hpp"
#include "pled_vins/core/check.hpp"

namespace pled::replay {
namespace {

constexpr std::size_t kMaxPath = 4096;

[[nodiscard]] std::size_t pixels_of(ImageSize size) noexcept {
  return static_cast<std::size_t>(size.width_px) * static_cast<std::size_t>(size.height_px);
}

}  // namespace

FrameFileSource::FrameFileSource(FrameList list, Options options)
    : list_(std::move(list)),
      options_(std::move(options)),
      reader_(options_.max, options_.one_size),
      slots_(options_.slots, std::vector<std::uint8_t>(pixels_of(options_.max))) {
  PLED_CHECK(options_.slots >= 1);
  path_.reserve(kMaxPath);
}

Result<std::unique_ptr<FrameFileSource>> FrameFileSource::open(Options options) {
  auto list = FrameList::open(options.list_path, options.format);
  if (!list.ok()) return list.error();
  return std::unique_ptr<FrameFileSource>(
      new FrameFileSource(std::move(list).value(), std::move(options)));  // private constructor
}

Result<FrameView> FrameFileSource::acquire(Duration /*timeout*/) noexcept {
  if (held_ == slots_.size()) return ErrorCode::kTimeout;
  const auto entry = list_.next(message_);
  if (!entry.ok()) return entry.error();
  return decode(entry.value());
}

Result<FrameView> FrameFileSource::decode(const FrameList::Entry& entry) noexcept {
  const auto lost = [this, &entry](ErrorCode code, std::string_view why) -> Result<FrameView> {
    ++unreadable_;
    message_.set("%s: %.*s (%s line %lld); frame skipped", path_.c_str(),
                 static_cast<int>(why.size()), why.data(), options_.list_path.c_str(),
                 static_cast<long long>(entry.line));
    return Error{code, entry.line};
  };
  path_.clear();
  if (options_.image_folder.size() + entry.name.size() + 2 > kMaxPath) {
    return lost(ErrorCode::kCorrupt, "the path is too long");
  }
  path_.append(options_.image_folder).append("/").append(entry.name);
  std::vector<std::uint8_t>& slot = slots_[(first_held_ + held_) % slots_.size()];
  const auto size = reader_.read(path_.c_str(), slot);
  if (!size.ok()) {
    const bool truncated = size.error().code == ErrorCode::kTruncated;
    return lost(truncated ? ErrorCode::kTruncated : ErrorCode::kCorrupt, reader_.last_message());
  }
  if (size_ == ImageSize{}) size_ = size.value();
  if (size.value() != size_) {
    return lost(ErrorCode::kCorrupt, "its size is not that of the frames before");
  }
  ++held_;
  FrameView view;
  view.stamp_ns = entry.stamp_ns;
  view.t = {rounded_to_us(entry.stamp_ns)};
  view.image = {slot.data(), size_.width_px, size_.height_px, size_.width_px};
  return view;
}

void FrameFileSource::release() noexcept {
  PLED_CHECK(held_ > 0);
  first_held_ = (first_held_ + 1) % slots_.size();
  --held_;
}

}  // namespace pled::replay
