#pragma once

#include <string_view>

namespace pled::apps {

/// One line on stderr: "pled-vins: error: TEXT".
void print_error(std::string_view text);
/// One line on stderr: "pled-vins: warning: TEXT".
void print_warning(std::string_view text);
/// One line on stderr: "pled-vins: note: TEXT".
void print_note(std::string_view text);

}  // namespace pled::apps
