#include "src/apps/text.hpp"

#include <array>
#include <cstdio>
#include <filesystem>

namespace pled::apps {
namespace {

void print_line(const char* kind, std::string_view text) {
  std::fprintf(stderr, "pled-vins: %s: %.*s\n", kind, static_cast<int>(text.size()), text.data());
}

}  // namespace

void print_error(std::string_view text) { print_line("error", text); }

void print_warning(std::string_view text) { print_line("warning", text); }

void print_note(std::string_view text) { print_line("note", text); }

std::string figure_text(const std::optional<double>& value) {
  if (!value) return "-";
  std::array<char, 32> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "%.3f", *value);
  return buffer.data();
}

std::string sequence_name(const std::string& recording) {
  std::filesystem::path path = std::filesystem::path(recording).lexically_normal();
  if (!path.has_filename()) path = path.parent_path();
  return path.filename().string();
}

}  // namespace pled::apps
