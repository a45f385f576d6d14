#include "drivers/replay/imu_source.hpp"

#include <array>
#include <optional>
#include <utility>

#include "drivers/decode/decimal.hpp"

namespace pled::replay {
namespace {

constexpr int kNanoDigits = 9;

[[nodiscard]] std::optional<ImuSample> parse_line(std::string_view line,
                                                  ImuFormat format) noexcept {
  const bool euroc = format == ImuFormat::kEuroc;
  const auto t_ns = parse_scaled(next_field(line), euroc ? 0 : kNanoDigits);
  if (!t_ns) return std::nullopt;
  std::array<double, 6> values{};
  for (double& value : values) {
    const auto parsed = parse_finite(next_field(line));
    if (!parsed) return std::nullopt;
    value = *parsed;
  }
  if (!next_field(line).empty()) return std::nullopt;
  ImuSample sample;
  sample.t = {rounded_to_us(*t_ns)};
  const std::array first{values[0], values[1], values[2]};
  const std::array second{values[3], values[4], values[5]};
  sample.gyro_radps = euroc ? first : second;
  sample.accel_mps2 = euroc ? second : first;
  return sample;
}

}  // namespace

ImuFileSource::ImuFileSource(LineReader lines, std::string path, ImuFormat format)
    : lines_(std::move(lines)), path_(std::move(path)), format_(format) {}

Result<std::unique_ptr<ImuFileSource>> ImuFileSource::open(const std::string& path,
                                                           ImuFormat format) {
  auto lines = LineReader::open(path.c_str());
  if (!lines.ok()) return lines.error();
  return std::unique_ptr<ImuFileSource>(
      new ImuFileSource(std::move(lines).value(), path, format));  // private constructor
}

Result<ImuSample> ImuFileSource::read(Duration /*timeout*/) noexcept {
  const auto line = lines_.next();
  if (!line.ok() && line.error().code != ErrorCode::kTooLarge) return line.error();
  if (line.ok()) {
    if (const auto sample = parse_line(line.value(), format_)) return *sample;
  }
  ++malformed_;
  message_.set("%s line %lld: not `%s` with finite numbers; the line was skipped", path_.c_str(),
               static_cast<long long>(lines_.line_number()),
               format_ == ImuFormat::kEuroc ? "t_ns,gx,gy,gz,ax,ay,az" : "t ax ay az gx gy gz");
  return Error{ErrorCode::kBadNumber, lines_.line_number()};
}

double ImuFileSource::progress() const noexcept {
  if (lines_.size() <= 0) return 1.0;
  return static_cast<double>(lines_.position()) / static_cast<double>(lines_.size());
}

}  // namespace pled::replay
