#include "drivers/replay/truth_reader.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <utility>

#include "drivers/decode/decimal.hpp"

namespace pled::replay {
namespace {

constexpr int kNanoDigits = 9;

[[nodiscard]] bool parse_all(std::string_view& line, std::span<double> out) noexcept {
  return std::all_of(out.begin(), out.end(), [&line](double& value) {
    const auto parsed = parse_finite(next_field(line));
    if (parsed) value = *parsed;
    return parsed.has_value();
  });
}

[[nodiscard]] bool normalise(std::array<double, 4>& q) noexcept {
  constexpr double kTolerance = 0.1;  // a quaternion printed with three digits passes
  const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  if (!(std::abs(length - 1.0) < kTolerance)) return false;
  for (double& value : q) value /= length;
  return true;
}

[[nodiscard]] std::optional<TruthState> parse_line(std::string_view line,
                                                   TruthFormat format) noexcept {
  const bool euroc = format == TruthFormat::kEuroc;
  const auto t_ns = parse_scaled(next_field(line), euroc ? 0 : kNanoDigits);
  TruthState state;
  if (!t_ns || !parse_all(line, state.p_world_body_m)) return std::nullopt;
  std::array<double, 4> q{};
  if (!parse_all(line, q)) return std::nullopt;
  if (euroc) std::rotate(q.begin(), q.begin() + 1, q.end());  // w first in the file
  if (!normalise(q)) return std::nullopt;
  state.stamp_ns = *t_ns;
  state.t = {rounded_to_us(*t_ns)};
  state.q_world_body_xyzw = q;
  if (euroc && !line.empty()) {
    state.has_motion = parse_all(line, state.v_world_body_mps) &&
                       parse_all(line, state.gyro_bias_radps) &&
                       parse_all(line, state.accel_bias_mps2);
    if (!state.has_motion) return std::nullopt;
  }
  if (!next_field(line).empty()) return std::nullopt;
  return state;
}

}  // namespace

TruthReader::TruthReader(LineReader lines, std::string path, TruthFormat format)
    : lines_(std::move(lines)), path_(std::move(path)), format_(format) {}

Result<TruthReader> TruthReader::open(const std::string& path, TruthFormat format) {
  auto lines = LineReader::open(path.c_str());
  if (!lines.ok()) return lines.error();
  return TruthReader{std::move(lines).value(), path, format};
}

Result<TruthState> TruthReader::next() noexcept {
  const auto line = lines_.next();
  if (!line.ok() && line.error().code != ErrorCode::kTooLarge) return line.error();
  if (line.ok()) {
    if (const auto state = parse_line(line.value(), format_)) return *state;
  }
  ++malformed_;
  message_.set(
      "%s line %lld: not `%s` with finite numbers and a unit quaternion; skipped", path_.c_str(),
      static_cast<long long>(lines_.line_number()),
      format_ == TruthFormat::kEuroc ? "t_ns,px,py,pz,qw,qx,qy,qz,..." : "t px py pz qx qy qz qw");
  return Error{ErrorCode::kBadNumber, lines_.line_number()};
}

}  // namespace pled::replay
