#include "src/apps/text.hpp"

#include <cstdio>

namespace pled::apps {
namespace {

void print_line(const char* kind, std::string_view text) {
  std::fprintf(stderr, "pled-vins: %s: %.*s\n", kind, static_cast<int>(text.size()), text.data());
}

}  // namespace

void print_error(std::string_view text) { print_line("error", text); }

void print_warning(std::string_view text) { print_line("warning", text); }

void print_note(std::string_view text) { print_line("note", text); }

}  // namespace pled::apps
