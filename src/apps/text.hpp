#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace pled::apps {

/// One line on stderr: "pled-vins: error: TEXT".
void print_error(std::string_view text);
/// One line on stderr: "pled-vins: warning: TEXT".
void print_warning(std::string_view text);
/// One line on stderr: "pled-vins: note: TEXT".
void print_note(std::string_view text);

/// A figure of a table, three decimals; "-" when it is absent.
[[nodiscard]] std::string figure_text(const std::optional<double>& value);
/// What a recording is called: the last part of its path.
[[nodiscard]] std::string sequence_name(const std::string& recording);

}  // namespace pled::apps
