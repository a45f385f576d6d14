#include "src/report/features_file.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "drivers/decode/decimal.hpp"

namespace pled::report {
namespace {

constexpr std::string_view kHeader =
    "t,id,kind,u0_px,v0_px,u1_px,v1_px,w_temporal,w_geometric,w,observations,used";
constexpr std::size_t kColumns = 12;
using Fields = std::array<std::string_view, kColumns>;

/// Cuts the line at its commas; how many fields it has.
std::size_t split(std::string_view line, Fields& fields) {
  std::size_t count = 0;
  while (true) {
    const std::size_t end = std::min(line.find(','), line.size());
    if (count < kColumns) fields[count] = line.substr(0, end);
    ++count;
    if (end == line.size()) return count;
    line.remove_prefix(end + 1);
  }
}

std::optional<Kind> kind_of(std::string_view word) {
  if (word == "image_point") return Kind::kImagePoint;
  if (word == "event_point") return Kind::kEventPoint;
  if (word == "line") return Kind::kLine;
  return std::nullopt;
}

bool read_number(std::string_view field, bool may_be_empty, double& out) {
  if (field.empty() && may_be_empty) return true;
  const auto value = parse_finite(field);
  if (value) out = *value;
  return value.has_value();
}

/// Fills the row; returns what is wrong, empty when nothing is.
std::string read_row(const Fields& f, FeatureRow& row) {
  const auto wrong = [](std::string_view field, const char* what) {
    return std::string("'").append(field).append("' is not ").append(what);
  };
  if (!parse_stamp_s(f[0], row.stamp_ns)) return wrong(f[0], "a time in seconds");
  const auto id = parse_scaled(f[1], 0);
  if (!id || *id < 0) return wrong(f[1], "an id");
  row.id = static_cast<std::uint64_t>(*id);
  const auto kind = kind_of(f[2]);
  if (!kind) return wrong(f[2], "image_point, event_point or line");
  row.kind = *kind;
  const bool is_line = row.kind == Kind::kLine;
  const std::array<std::pair<double*, bool>, 7> numbers{{{&row.begin_px[0], false},
                                                         {&row.begin_px[1], false},
                                                         {&row.end_px[0], !is_line},
                                                         {&row.end_px[1], !is_line},
                                                         {&row.w_temporal, true},
                                                         {&row.w_geometric, true},
                                                         {&row.w, true}}};
  for (std::size_t k = 0; k < numbers.size(); ++k)
    if (!read_number(f[3 + k], numbers[k].second, *numbers[k].first))
      return wrong(f[3 + k], "a finite number");
  const auto observations = parse_int(f[10]);
  if (!observations) return wrong(f[10], "a number of observations");
  row.observations = *observations;
  if (f[11] != "0" && f[11] != "1") return wrong(f[11], "0 or 1");
  row.used = f[11] == "1";
  return {};
}

}  // namespace

FeaturesFile::FeaturesFile(const std::filesystem::path& file) : name_(file.string()) {
  stream_.open(file, std::ios::binary);
  if (!stream_) {
    fail(std::string("cannot be read: ") + std::strerror(errno));
    return;
  }
  if (!read_line()) {
    if (!error_) fail("is empty: not even the header is there");
  } else if (text_ != kHeader) {
    fail("the first line is not '" + std::string(kHeader) + "'");
  }
}

bool FeaturesFile::read_line() {
  if (error_ || !std::getline(stream_, text_)) {
    if (!error_ && stream_.bad()) fail("reading failed");
    return false;
  }
  ++line_;
  if (stream_.eof()) {
    fail("the line has no end: the file was cut off here");
    return false;
  }
  if (text_.ends_with('\r')) text_.pop_back();
  return true;
}

std::optional<FeatureRow> FeaturesFile::next() {
  if (!read_line()) return std::nullopt;
  Fields fields;
  const std::size_t count = split(text_, fields);
  if (count != kColumns) {
    fail("has " + std::to_string(count) + " columns instead of " + std::to_string(kColumns));
    return std::nullopt;
  }
  FeatureRow row;
  if (std::string problem = read_row(fields, row); !problem.empty()) {
    fail(std::move(problem));
    return std::nullopt;
  }
  if (last_stamp_ns_ && row.stamp_ns < *last_stamp_ns_) {
    fail("the time goes back");
    return std::nullopt;
  }
  last_stamp_ns_ = row.stamp_ns;
  return row;
}

}  // namespace pled::report
