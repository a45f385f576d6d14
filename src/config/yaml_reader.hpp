#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <yaml-cpp/yaml.h>

#include "pled_vins/config/config_error.hpp"

/// The only folder that sees yaml-cpp. Inside it faults travel as exceptions; the
/// public functions catch them.
namespace pled::yaml {

/// Thrown inside this folder, caught at its edge.
struct Failure {
  ConfigError error;
};

/// What a number may be, ends included.
struct Range {
  double low = 0.0;
  double high = 0.0;
  std::string_view unit;
};

/// One parsed file, and the words to complain about it.
class Document {
 public:
  /// Throws Failure when the file cannot be read or is no YAML.
  [[nodiscard]] static Document from_file(const std::filesystem::path& file);
  [[nodiscard]] static Document from_text(std::string text, std::string name);

  [[nodiscard]] const YAML::Node& root() const noexcept { return root_; }
  [[nodiscard]] const std::string& name() const noexcept { return name_; }

  /// Throws Failure at the line of `node`.
  [[noreturn]] void fail(const YAML::Node& node, std::string key, std::string text) const;
  /// Throws Failure for the whole file.
  [[noreturn]] void fail(std::string key, std::string text) const;

  /// Scalars of one type; `key` is for the message.
  [[nodiscard]] double number(const YAML::Node& node, const std::string& key) const;
  /// Throws Failure when `value`, read from `node`, lies outside `range`.
  void check_range(const YAML::Node& node, double value, const std::string& key,
                   const Range& range) const;
  /// Throws Failure when a key of the map stands in it twice; `prefix` goes before its name.
  void refuse_repeats(const YAML::Node& map, const std::string& prefix) const;
  /// A number that lies in `range`.
  [[nodiscard]] double number_in(const YAML::Node& node, const std::string& key,
                                 const Range& range) const;
  [[nodiscard]] int whole_number(const YAML::Node& node, const std::string& key) const;
  [[nodiscard]] bool flag(const YAML::Node& node, const std::string& key) const;
  [[nodiscard]] std::string text(const YAML::Node& node, const std::string& key) const;
  /// A list of numbers.
  [[nodiscard]] std::vector<double> numbers(const YAML::Node& node, const std::string& key) const;
  /// The entry `name` of a map. Throws Failure when there is none.
  [[nodiscard]] YAML::Node required(const YAML::Node& map, const std::string& name,
                                    const std::string& key) const;

 private:
  YAML::Node root_;
  std::string name_;
};

/// The whole file, at most 1 MiB. Throws Failure.
[[nodiscard]] std::string read_text_file(const std::filesystem::path& file);

/// What `text` says as a finite number or a whole number; false when it is none.
[[nodiscard]] bool parse(std::string_view text, double& value);
[[nodiscard]] bool parse(std::string_view text, int& value);

}  // namespace pled::yaml
