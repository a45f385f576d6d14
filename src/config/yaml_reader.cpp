#include "src/config/yaml_reader.hpp"

#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <set>
#include <utility>

#include "src/config/number_text.hpp"

namespace pled::yaml {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxBytes = std::size_t{1} << 20;

[[noreturn]] void fail_file(const fs::path& file, std::string text) {
  throw Failure{{file.string(), 0, {}, std::move(text)}};
}

std::string seen(const YAML::Node& node) {
  switch (node.Type()) {
    case YAML::NodeType::Undefined:
    case YAML::NodeType::Null: return "nothing";
    case YAML::NodeType::Scalar: return "'" + node.Scalar() + "'";
    case YAML::NodeType::Sequence: return "a list";
    case YAML::NodeType::Map: return "a group of keys";
  }
  return "nothing";
}

/// Quoted in the file: text, whatever it looks like.
bool is_plain_scalar(const YAML::Node& node) { return node.IsScalar() && node.Tag() != "!"; }

/// "[3, 10] px".
std::string text_of(const Range& range) {
  std::string out = "[";
  out.append(number_text(range.low)).append(", ").append(number_text(range.high)).append("]");
  return range.unit.empty() ? out : out.append(" ").append(range.unit);
}

template <typename T>
bool parse_with_from_chars(std::string_view text, T& value) {
  if (text.starts_with('+')) text.remove_prefix(1);
  T parsed{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), parsed);
  if (error != std::errc{} || end != text.data() + text.size()) return false;
  value = parsed;
  return true;
}

}  // namespace

std::string read_text_file(const fs::path& file) {
  std::error_code error;
  if (!fs::exists(file, error)) fail_file(file, "there is no such file");
  if (!fs::is_regular_file(file, error)) fail_file(file, "is not a file");
  std::ifstream stream(file, std::ios::binary);
  if (!stream) fail_file(file, std::string("cannot be read: ") + std::strerror(errno));
  std::string text(kMaxBytes + 1, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (stream.bad()) fail_file(file, "reading failed");
  text.resize(static_cast<std::size_t>(stream.gcount()));
  if (text.size() > kMaxBytes) fail_file(file, "is larger than 1 MiB: not a settings file");
  if (text.find('\0') != std::string::npos) fail_file(file, "is not a text file");
  return text;
}

Document Document::from_file(const fs::path& file) {
  return from_text(read_text_file(file), file.string());
}

Document Document::from_text(std::string text, std::string name) {
  // OpenCV begins its files with "%YAML:1.0", which is not YAML. Blanked out, so that
  // lines keep their numbers.
  constexpr std::string_view kOpenCvHeader = "%YAML:";
  if (text.starts_with(kOpenCvHeader)) text.replace(0, std::min(text.find('\n'), text.size()), "");
  Document document;
  document.name_ = std::move(name);
  try {
    const std::vector<YAML::Node> parts = YAML::LoadAll(text);
    if (!parts.empty()) document.root_ = parts.front();
    for (std::size_t i = 1; i < parts.size(); ++i)
      if (!parts[i].IsNull())
        document.fail(parts[i], {}, "belongs to a second document (after `---`): one is read");
  } catch (const YAML::Exception& error) {
    throw Failure{{document.name_, error.mark.line + 1, {}, "is not valid YAML: " + error.msg}};
  }
  return document;
}

void Document::fail(const YAML::Node& node, std::string key, std::string text) const {
  const int line = node.IsDefined() ? node.Mark().line + 1 : 0;
  throw Failure{{name_, std::max(line, 0), std::move(key), std::move(text)}};
}

void Document::fail(std::string key, std::string text) const {
  throw Failure{{name_, 0, std::move(key), std::move(text)}};
}

double Document::number(const YAML::Node& node, const std::string& key) const {
  double value = 0.0;
  if (!is_plain_scalar(node) || !parse(node.Scalar(), value))
    fail(node, key, "must be a number, not " + seen(node));
  return value;
}

double Document::number_in(const YAML::Node& node, const std::string& key,
                           const Range& range) const {
  const double value = number(node, key);
  check_range(node, value, key, range);
  return value;
}

void Document::check_range(const YAML::Node& node, double value, const std::string& key,
                           const Range& range) const {
  if (value >= range.low && value <= range.high) return;
  const std::string seen = node.IsScalar() ? node.Scalar() : number_text(value);
  fail(node, key, seen + " is out of range: must be in " + text_of(range));
}

void Document::refuse_repeats(const YAML::Node& map, const std::string& prefix) const {
  std::set<std::string> names;
  for (const auto& entry : map)
    if (entry.first.IsScalar() && !names.insert(entry.first.Scalar()).second)
      fail(entry.first, prefix + entry.first.Scalar(), "stands here a second time");
}

int Document::whole_number(const YAML::Node& node, const std::string& key) const {
  int value = 0;
  if (!is_plain_scalar(node) || !parse(node.Scalar(), value))
    fail(node, key, "must be a whole number, not " + seen(node));
  return value;
}

bool Document::flag(const YAML::Node& node, const std::string& key) const {
  if (is_plain_scalar(node) && node.Scalar() == "true") return true;
  if (is_plain_scalar(node) && node.Scalar() == "false") return false;
  fail(node, key, "must be true or false, not " + seen(node));
}

std::string Document::text(const YAML::Node& node, const std::string& key) const {
  if (!node.IsScalar()) fail(node, key, "must be text, not " + seen(node));
  return node.Scalar();
}

std::vector<double> Document::numbers(const YAML::Node& node, const std::string& key) const {
  if (!node.IsSequence()) fail(node, key, "must be a list of numbers, not " + seen(node));
  std::vector<double> values;
  for (const YAML::Node& item : node) values.push_back(number(item, key));
  return values;
}

YAML::Node Document::required(const YAML::Node& map, const std::string& name,
                              const std::string& key) const {
  if (!map.IsMap()) fail(map, key, "must be inside a group of keys, not " + seen(map));
  for (const auto& entry : map)
    if (entry.first.IsScalar() && entry.first.Scalar() == name) return entry.second;
  fail(map, key, "is missing");
}

bool parse(std::string_view text, double& value) {
  double parsed = 0.0;
  if (!parse_with_from_chars(text, parsed) || !std::isfinite(parsed)) return false;
  value = parsed;
  return true;
}

bool parse(std::string_view text, int& value) { return parse_with_from_chars(text, value); }

}  // namespace pled::yaml
