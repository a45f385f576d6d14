#include "drivers/replay/frame_list.hpp"

#include <cstdlib>
#include <utility>

#include "drivers/decode/decimal.hpp"

namespace pled::replay {
namespace {

constexpr int kNanoDigits = 9;
constexpr std::size_t kMaxName = 4096;
constexpr std::int64_t kFar_ns = 2'000'000'000;  ///< between stamps of one clock

}  // namespace

FrameList::FrameList(LineReader lines, std::string path, FrameListFormat format)
    : lines_(std::move(lines)), path_(std::move(path)), format_(format) {
  current_.name.reserve(kMaxName);
  ahead_.name.reserve(kMaxName);
}

Result<FrameList> FrameList::open(const std::string& path, FrameListFormat format) {
  auto lines = LineReader::open(path.c_str());
  if (!lines.ok()) return lines.error();
  return FrameList(std::move(lines).value(), path, format);
}

Result<FrameList::Entry> FrameList::next(Message& message) noexcept {
  while (true) {
    if (!has_ahead_) read(ahead_);
    has_ahead_ = true;
    std::swap(current_, ahead_);
    read(ahead_);
    const auto number = static_cast<long long>(current_.number);
    if (current_.error.code == ErrorCode::kCorrupt) {
      ++malformed_lines_;
      message.set("%s line %lld: not a stamp and a file name; the line was skipped", path_.c_str(),
                  number);
    }
    if (current_.error.code != ErrorCode::kNone) return current_.error;
    if (!is_out_of_order()) break;
    ++out_of_order_;
    message.set("%s line %lld: the stamp is not between those around it; frame skipped",
                path_.c_str(), number);
  }
  if (!is_far()) last_stamp_ns_ = current_.stamp_ns;
  has_stamp_ = true;
  return Entry{current_.stamp_ns, current_.name, current_.number};
}

bool FrameList::is_far() const noexcept {
  return has_stamp_ && std::llabs(current_.stamp_ns - last_stamp_ns_) > kFar_ns;
}

bool FrameList::is_out_of_order() const noexcept {
  const bool goes_on = ahead_.error.code == ErrorCode::kNone &&
                       (!has_stamp_ || (ahead_.stamp_ns > last_stamp_ns_ &&
                                        ahead_.stamp_ns - last_stamp_ns_ <= kFar_ns));
  if (goes_on && ahead_.stamp_ns < current_.stamp_ns) return true;
  if (is_far() && !goes_on) return false;
  return has_stamp_ && current_.stamp_ns <= last_stamp_ns_;
}

void FrameList::read(Line& line) noexcept {
  const auto text = lines_.next();
  line.number = lines_.line_number();
  if (!text.ok() && text.error().code != ErrorCode::kTooLarge) {
    line.error = text.error();
    return;
  }
  line.error = {ErrorCode::kCorrupt, line.number};
  if (!text.ok()) return;
  const bool euroc = format_ == FrameListFormat::kEuroc;
  std::string_view rest = text.value();
  const auto stamp_ns = parse_scaled(next_field(rest), euroc ? 0 : kNanoDigits);
  const std::string_view name = next_field(rest);
  if (!stamp_ns || name.empty() || name.size() > kMaxName || !next_field(rest).empty()) return;
  line.stamp_ns = *stamp_ns;
  line.name.assign(name);
  line.error = {};
}

double FrameList::progress() const noexcept {
  if (lines_.size() <= 0) return 1.0;
  return static_cast<double>(lines_.position()) / static_cast<double>(lines_.size());
}

std::vector<std::int64_t> listed_stamps(const std::string& path, FrameListFormat format) {
  std::vector<std::int64_t> stamps_ns;
  auto list = FrameList::open(path, format);
  if (!list.ok()) return stamps_ns;
  Message ignored;
  while (true) {
    const auto entry = list.value().next(ignored);
    if (entry.ok())
      stamps_ns.push_back(entry.value().stamp_ns);
    else if (entry.error().code != ErrorCode::kCorrupt)
      return stamps_ns;
  }
}

}  // namespace pled::replay
