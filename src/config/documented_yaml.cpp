#include <type_traits>

#include "pled_vins/config/schema.hpp"
#include "src/config/number_text.hpp"

namespace pled {
namespace {

/// A double-quoted YAML scalar.
std::string quoted(const std::string& value) {
  std::string out = "\"";
  for (const char c : value) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + "\"";
}

std::string value_text(const ConfigField& field) {
  return std::visit(
      [](const auto* value) -> std::string {
        using T = std::remove_const_t<std::remove_pointer_t<decltype(value)>>;
        if constexpr (std::is_same_v<T, bool>)
          return *value ? "true" : "false";
        else if constexpr (std::is_same_v<T, std::string>)
          return quoted(*value);
        else if constexpr (std::is_enum_v<T>)
          return std::string(name_of(*value));
        else
          return number_text(*value);
      },
      field);
}

std::string type_text(const ConfigKey& key, const ConfigField& field) {
  const auto text = [&key](const auto* member) -> std::string {
    using T = std::remove_const_t<std::remove_pointer_t<decltype(member)>>;
    if constexpr (std::is_same_v<T, bool>) {
      return "true or false";
    } else if constexpr (std::is_same_v<T, std::string>) {
      return "text";
    } else if constexpr (std::is_enum_v<T>) {
      return choices<T>();
    } else {
      std::string out = std::is_same_v<T, int> ? "whole number" : "number";
      if (!key.unit.empty()) out += ", " + std::string(key.unit);
      return out + ", " + number_text(key.low) + " ... " + number_text(key.high);
    }
  };
  return std::visit(text, field);
}

}  // namespace

std::string to_documented_yaml(const AppConfig& config) {
  AppConfig copy = config;  // the schema hands out addresses of what it may change
  AppConfig defaults;
  std::string out =
      "# Settings of pled-vins. A key that is left out keeps the default named here;\n"
      "# a key that is not listed here is an error.\n";
  std::string_view section;
  for (const ConfigKey& key : config_schema()) {
    const std::size_t dot = key.key.find('.');
    const bool bare = dot == std::string_view::npos;
    const std::string indent = bare ? "" : "  ";
    const std::string_view key_section = bare ? std::string_view{} : key.key.substr(0, dot);
    if (bare || key_section != section) out += "\n";
    if (!bare && key_section != section) out += std::string(key_section) + ":\n";
    section = key_section;
    const ConfigField field = key.field(copy);
    out += indent + "# " + std::string(key.doc) + "\n";
    out += indent + "# (" + type_text(key, field) + ", default " + value_text(key.field(defaults)) +
           ")\n";
    out += indent + std::string(bare ? key.key : key.key.substr(dot + 1)) + ": " +
           value_text(field) + "\n";
  }
  return out;
}

}  // namespace pled
