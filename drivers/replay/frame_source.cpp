#include "drivers/replay/frame_source.hpp"

#include <utility>

#include "drivers/decode/decimal.hpp"
#include "pled_vins/core/check.hpp"

namespace pled::replay {
namespace {

constexpr int kNanoDigits = 9;
constexpr std::size_t kMaxPath = 4096;

[[nodiscard]] std::size_t pixels_of(ImageSize size) noexcept {
  return static_cast<std::size_t>(size.width_px) * static_cast<std::size_t>(size.height_px);
}

}  // namespace

FrameFileSource::FrameFileSource(LineReader lines, Options options)
    : lines_(std::move(lines)),
      options_(std::move(options)),
      reader_(options_.max),
      slots_(options_.slots, std::vector<std::uint8_t>(pixels_of(options_.max))) {
  PLED_CHECK(options_.slots >= 1);
  path_.reserve(kMaxPath);
}

Result<std::unique_ptr<FrameFileSource>> FrameFileSource::open(Options options) {
  auto lines = LineReader::open(options.list_path.c_str());
  if (!lines.ok()) return lines.error();
  return std::unique_ptr<FrameFileSource>(
      new FrameFileSource(std::move(lines).value(), std::move(options)));  // private constructor
}

Result<FrameView> FrameFileSource::acquire(Duration /*timeout*/) noexcept {
  if (held_ == slots_.size()) return ErrorCode::kTimeout;
  while (true) {
    const auto entry = next_entry();
    if (!entry.ok()) return entry.error();
    if (has_stamp_ && entry.value().stamp_ns <= last_stamp_ns_) {
      ++faults_.out_of_order;
      message_.set("%s line %lld: the stamp is not later than the one before; frame skipped",
                   options_.list_path.c_str(), static_cast<long long>(lines_.line_number()));
      continue;
    }
    has_stamp_ = true;
    last_stamp_ns_ = entry.value().stamp_ns;
    return decode(entry.value());
  }
}

Result<FrameFileSource::Entry> FrameFileSource::next_entry() noexcept {
  const auto line = lines_.next();
  if (!line.ok() && line.error().code != ErrorCode::kTooLarge) return line.error();
  if (line.ok()) {
    const bool euroc = options_.format == FrameListFormat::kEuroc;
    std::string_view rest = line.value();
    const auto stamp_ns = parse_scaled(next_field(rest), euroc ? 0 : kNanoDigits);
    const std::string_view name = next_field(rest);
    if (stamp_ns && !name.empty() && next_field(rest).empty()) return Entry{*stamp_ns, name};
  }
  ++faults_.malformed_lines;
  message_.set("%s line %lld: not a stamp and a file name; the line was skipped",
               options_.list_path.c_str(), static_cast<long long>(lines_.line_number()));
  return Error{ErrorCode::kCorrupt, lines_.line_number()};
}

Result<FrameView> FrameFileSource::decode(const Entry& entry) noexcept {
  const auto lost = [this](ErrorCode code, std::string_view why) -> Result<FrameView> {
    ++faults_.unreadable;
    message_.set("%s: %.*s (%s line %lld); frame skipped", path_.c_str(),
                 static_cast<int>(why.size()), why.data(), options_.list_path.c_str(),
                 static_cast<long long>(lines_.line_number()));
    return Error{code, lines_.line_number()};
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

double FrameFileSource::progress() const noexcept {
  if (lines_.size() <= 0) return 1.0;
  return static_cast<double>(lines_.position()) / static_cast<double>(lines_.size());
}

}  // namespace pled::replay
