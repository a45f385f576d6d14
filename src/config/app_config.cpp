#include "pled_vins/config/app_config.hpp"

#include <map>
#include <type_traits>
#include <vector>

#include "pled_vins/config/nearest.hpp"
#include "pled_vins/config/schema.hpp"
#include "src/config/yaml_reader.hpp"

namespace pled {
namespace {

namespace fs = std::filesystem;

/// Fills an AppConfig from one parsed file, key by key along the schema.
class ConfigReader {
 public:
  explicit ConfigReader(const yaml::Document& document) : document_(document) {}

  AppConfig read() {
    const YAML::Node& root = document_.root();
    if (root.IsNull()) return config_;  // an empty file changes no default
    if (!root.IsMap()) document_.fail(root, {}, "must hold `key: value` lines");
    read_map(root, {});
    check_rules();
    config_.sensors_named =
        lines_.contains("sensors.event_camera") || lines_.contains("sensors.frame_camera");
    return config_;
  }

 private:
  void read_map(const YAML::Node& map, const std::string& prefix) {
    for (const auto& entry : map) {
      // `a.b: 1` and `a: {b: 1}` are the same key: one list for the whole file.
      const std::string key = prefix + document_.text(entry.first, prefix + "?");
      if (!lines_.try_emplace(key, entry.first.Mark().line + 1).second)
        document_.fail(entry.first, key, "stands here a second time");
      read_entry(key, entry.first, entry.second);
    }
  }

  void read_entry(const std::string& key, const YAML::Node& name, const YAML::Node& value) {
    const std::string prefix = key + ".";
    bool is_section = false;
    for (const ConfigKey& known : config_schema()) {
      if (known.key == key) {
        if (value.IsNull()) document_.fail(name, key, "has no value");
        return read_value(known, value);
      }
      is_section = is_section || known.key.starts_with(prefix);
    }
    if (!is_section) fail_unknown(key, name);
    if (value.IsNull()) return;  // a section whose keys are all left out
    if (!value.IsMap()) document_.fail(value, key, "is a group: its keys go below it, indented");
    read_map(value, prefix);
  }

  void read_value(const ConfigKey& known, const YAML::Node& value) {
    const std::string key(known.key);
    const yaml::Range range{known.low, known.high, known.unit};
    const auto read = [&](auto* member) {
      using T = std::remove_pointer_t<decltype(member)>;
      if constexpr (std::is_same_v<T, double>) {
        *member = document_.number_in(value, key, range);
      } else if constexpr (std::is_same_v<T, int>) {
        *member = document_.whole_number(value, key);
        document_.check_range(value, *member, key, range);
      } else if constexpr (std::is_same_v<T, bool>) {
        *member = document_.flag(value, key);
      } else if constexpr (std::is_enum_v<T>) {
        read_choice(value, key, *member);
      } else {
        *member = document_.text(value, key);
      }
    };
    std::visit(read, known.field(config_));
  }

  template <typename Enum>
  void read_choice(const YAML::Node& value, const std::string& key, Enum& choice) const {
    const std::string name = document_.text(value, key);
    for (const auto& [known, word] : names_of(choice)) {
      if (name != word) continue;
      choice = known;
      return;
    }
    document_.fail(value, key, "must be " + choices<Enum>() + ", not '" + name + "'");
  }

  [[noreturn]] void fail_unknown(const std::string& key, const YAML::Node& name) const {
    std::vector<std::string_view> candidates;
    for (const ConfigKey& known : config_schema()) {
      const std::size_t dot = known.key.find('.');
      if (dot != std::string_view::npos && key.find('.') == std::string::npos)
        candidates.push_back(known.key.substr(0, dot));  // perhaps a section was meant
      candidates.push_back(known.key);
    }
    document_.fail(name, key,
                   "unknown key; the nearest is '" + std::string(nearest(key, candidates)) + "'");
  }

  /// Rules between values, which the struct's own check() knows.
  void check_rules() const {
    for (const ConfigIssue issue :
         {check(config_.frontend), check(config_.events), check(config_.lines),
          check(config_.reliability), check(config_.motion_cue), check(config_.backend),
          room_for_points()}) {
      if (issue.key == nullptr) continue;
      const auto line = lines_.find(issue.key);
      throw yaml::Failure{
          {document_.name(), line == lines_.end() ? 0 : line->second, issue.key, issue.rule}};
    }
    for (const auto& [key, value] :
         {std::pair{"sensors.event_camera", &config_.sensors.event_camera},
          std::pair{"sensors.frame_camera", &config_.sensors.frame_camera}})
      if (value->empty())
        throw yaml::Failure{{document_.name(), lines_.at(key), key, "must name a camera"}};
  }

  /// Image and event points share one pool.
  [[nodiscard]] ConfigIssue room_for_points() const {
    if (config_.frontend.max_points + config_.events.max_points <=
        static_cast<int>(limits::kMaxPoints))
      return {};
    return {"events.max_points", "and frontend.max_points must not be more than 150 together"};
  }

  const yaml::Document& document_;
  AppConfig config_;
  std::map<std::string, int> lines_;  ///< of every key in the file, for check_rules()
};

std::variant<AppConfig, ConfigError> read_document(const yaml::Document& document) {
  AppConfig config = ConfigReader(document).read();
  const fs::path folder = fs::path(document.name()).parent_path();
  for (std::string* path : {&config.calibration.camchain, &config.calibration.imu})
    if (!path->empty()) *path = (folder / *path).string();  // an absolute path stays as it is
  return config;
}

}  // namespace

std::variant<AppConfig, ConfigError> load_config(const fs::path& file) {
  try {
    return read_document(yaml::Document::from_file(file));
  } catch (const yaml::Failure& failure) {
    return failure.error;
  } catch (const std::exception& error) {  // from yaml-cpp or the file system
    return ConfigError{file.string(), 0, {}, error.what()};
  }
}

std::variant<AppConfig, ConfigError> parse_config(std::string_view text, const std::string& name) {
  try {
    return read_document(yaml::Document::from_text(std::string(text), name));
  } catch (const yaml::Failure& failure) {
    return failure.error;
  } catch (const std::exception& error) {
    return ConfigError{name, 0, {}, error.what()};
  }
}

}  // namespace pled
