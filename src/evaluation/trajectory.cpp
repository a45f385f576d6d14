#include "pled_vins/evaluation/trajectory.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <optional>
#include <span>
#include <utility>

namespace pled {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kPoseColumns = 8;
constexpr double kMinQuaternionNorm = 1e-6;

/// Hands out the lines of a text file that say something.
class LineReader {
 public:
  explicit LineReader(const fs::path& file) : name_(file.string()) {
    std::error_code error;
    if (!fs::exists(file, error)) {
      problem_ = "there is no such file";
    } else if (fs::is_directory(file, error)) {
      problem_ = "is a folder, not a file";
    } else {
      stream_.open(file, std::ios::binary);
      if (!stream_) problem_ = std::string("cannot be read: ") + std::strerror(errno);
    }
  }

  /// The next line that is neither empty nor a comment; false at the end.
  bool next(std::string_view& line) {
    while (problem_.empty() && std::getline(stream_, text_)) {
      ++number_;
      line = text_;
      if (number_ == 1 && line.starts_with("\xEF\xBB\xBF")) line.remove_prefix(3);  // UTF-8 mark
      while (!line.empty() && kBlank.find(line.back()) != std::string_view::npos)
        line.remove_suffix(1);
      const std::size_t first = line.find_first_not_of(kBlank);
      if (first == std::string_view::npos || line[first] == '#') continue;
      line.remove_prefix(first);
      return true;
    }
    if (stream_.bad()) problem_ = "reading failed";
    return false;
  }

  [[nodiscard]] bool ok() const { return problem_.empty(); }
  [[nodiscard]] FileError failure() const { return {name_, 0, problem_}; }
  [[nodiscard]] FileError at_line(std::string text) const {
    return {name_, number_, std::move(text)};
  }

 private:
  static constexpr std::string_view kBlank = " \t\r\n";

  std::string name_;
  std::ifstream stream_;
  std::string text_;
  std::string problem_;
  std::int64_t number_ = 0;
};

/// The columns of a line, at most `out.size()` of them; returns how many there are.
std::size_t split(std::string_view line, bool csv, std::span<std::string_view> out) {
  const std::string_view separators = csv ? std::string_view(",") : std::string_view(" \t");
  std::size_t count = 0;
  while (true) {
    if (!csv) line.remove_prefix(std::min(line.find_first_not_of(separators), line.size()));
    if (line.empty()) break;
    const std::size_t end = std::min(line.find_first_of(separators), line.size());
    std::string_view word = line.substr(0, end);
    while (!word.empty() && (word.front() == ' ' || word.front() == '\t')) word.remove_prefix(1);
    while (!word.empty() && (word.back() == ' ' || word.back() == '\t')) word.remove_suffix(1);
    if (count < out.size()) out[count] = word;
    ++count;
    if (end == line.size()) break;
    line.remove_prefix(end + 1);
  }
  return count;
}

bool parse_number(std::string_view text, double& value) {
  if (text.starts_with('+')) text.remove_prefix(1);
  double parsed = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), parsed);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(parsed))
    return false;
  value = parsed;
  return true;
}

bool parse_stamp(std::string_view text, bool csv, std::int64_t& ns) {
  if (!csv) return parse_stamp_s(text, ns);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), ns);
  return error == std::errc{} && end == text.data() + text.size();
}

std::string quoted(std::string_view text) { return std::string("'").append(text).append("'"); }

/// One line to a pose; the reason when it is none.
std::optional<std::string> parse_pose(std::string_view line, StampedPose& out) {
  const bool csv = line.find(',') != std::string_view::npos;
  std::array<std::string_view, kPoseColumns> words;
  const std::size_t count = split(line, csv, words);
  // A csv may go on with velocity and biases.
  if (count < kPoseColumns || (!csv && count > kPoseColumns))
    return "has " + std::to_string(count) + " columns instead of 8" +
           (csv ? " or more (t_ns,px,py,pz,qw,qx,qy,qz)" : " (t px py pz qx qy qz qw)");
  if (!parse_stamp(words[0], csv, out.stamp_ns))
    return quoted(words[0]) + " is not a time in " + (csv ? "nanoseconds" : "seconds");
  std::array<double, 7> v{};
  for (std::size_t i = 0; i < v.size(); ++i)
    if (!parse_number(words[i + 1], v[i])) return quoted(words[i + 1]) + " is not a finite number";
  out.pose.p = {v[0], v[1], v[2]};
  out.pose.q =
      csv ? Eigen::Quaterniond(v[3], v[4], v[5], v[6]) : Eigen::Quaterniond(v[6], v[3], v[4], v[5]);
  if (!(out.pose.q.norm() > kMinQuaternionNorm)) return "the quaternion is zero";
  out.pose.q.normalize();
  return std::nullopt;
}

constexpr const char* kNotLater = "the time is not later than the one before it";

}  // namespace

std::string FileError::message() const {
  std::string out = file;
  if (line > 0) out.append(":").append(std::to_string(line));
  return out.append(": ").append(text);
}

bool parse_stamp_s(std::string_view text, std::int64_t& ns) noexcept {
  constexpr std::int64_t kMax = std::numeric_limits<std::int64_t>::max();
  constexpr std::size_t kMaxText = 64;
  if (text.size() > kMaxText) return false;
  const bool negative = text.starts_with('-');
  if (negative || text.starts_with('+')) text.remove_prefix(1);
  int exponent = 0;
  if (const std::size_t e = text.find_first_of("eE"); e != std::string_view::npos) {
    std::string_view power = text.substr(e + 1);
    if (power.starts_with('+')) power.remove_prefix(1);
    const auto [end, error] = std::from_chars(power.data(), power.data() + power.size(), exponent);
    if (error != std::errc{} || end != power.data() + power.size()) return false;
    if (exponent < -99 || exponent > 99) return false;
    text = text.substr(0, e);
  }
  const std::size_t dot = std::min(text.find('.'), text.size());
  // Digits without the dot; the first `whole` of them count nanoseconds.
  std::array<char, kMaxText> digits{};
  std::size_t count = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (i == dot) continue;
    if (text[i] < '0' || text[i] > '9') return false;
    digits[count++] = text[i];
  }
  if (count == 0) return false;
  const int whole = static_cast<int>(dot) + exponent + 9;
  std::int64_t value = 0;
  for (int i = 0; i < whole; ++i) {
    const bool given = static_cast<std::size_t>(i) < count;
    const std::int64_t digit = given ? digits[static_cast<std::size_t>(i)] - '0' : 0;
    if (value > (kMax - digit) / 10) return false;
    value = value * 10 + digit;
  }
  if (whole >= 0 && static_cast<std::size_t>(whole) < count &&
      digits[static_cast<std::size_t>(whole)] >= '5' && value < kMax)
    ++value;
  ns = negative ? -value : value;
  return true;
}

std::variant<Trajectory, FileError> read_trajectory(const fs::path& file) {
  LineReader reader(file);
  Trajectory trajectory;
  std::string_view line;
  while (reader.next(line)) {
    StampedPose pose;
    if (auto problem = parse_pose(line, pose)) return reader.at_line(std::move(*problem));
    if (!trajectory.empty() && pose.stamp_ns <= trajectory.back().stamp_ns)
      return reader.at_line(kNotLater);
    trajectory.push_back(pose);
  }
  if (!reader.ok()) return reader.failure();
  return trajectory;
}

std::variant<FrameStamps, FileError> read_frame_stamps(const fs::path& file) {
  LineReader reader(file);
  FrameStamps stamps;
  std::string_view line;
  while (reader.next(line)) {
    const bool csv = line.find(',') != std::string_view::npos;
    std::array<std::string_view, 1> words;
    std::int64_t ns = 0;
    const bool reads = split(line, csv, words) >= 2 && parse_stamp(words[0], csv, ns);
    if (reads && (stamps.ns.empty() || ns > stamps.ns.back()))
      stamps.ns.push_back(ns);
    else
      ++stamps.passed_over;
  }
  if (!reader.ok()) return reader.failure();
  return stamps;
}

}  // namespace pled
