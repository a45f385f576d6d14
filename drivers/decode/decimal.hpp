#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace pled {

/// A decimal number times 10^scale, as an integer: exact, half rounded away from
/// zero, without passing through a double. Reads `12`, `-0.5`, `1.5e-3`.
/// Nothing when the text is no number (also `nan`, `inf`), has something after
/// it, or leaves the range of the result.
[[nodiscard]] std::optional<std::int64_t> parse_scaled(std::string_view text, int scale) noexcept;

/// A finite decimal number, correctly rounded and independent of the locale.
/// Nothing when the text is no number, is `nan` or `inf`, or has something after it.
[[nodiscard]] std::optional<double> parse_finite(std::string_view text) noexcept;

/// A whole number without fraction or exponent.
[[nodiscard]] std::optional<std::int32_t> parse_int(std::string_view text) noexcept;

/// Cuts the first field off `rest`. Fields are separated by spaces, tabs or
/// commas, any number of them. Empty when there is none left.
[[nodiscard]] std::string_view next_field(std::string_view& rest) noexcept;

/// The line without its end: a carriage return and trailing blanks are cut off.
[[nodiscard]] std::string_view trimmed_line(std::string_view line) noexcept;

/// True for a line that carries no data: blank, or beginning with '#'.
[[nodiscard]] bool is_blank_or_comment(std::string_view line) noexcept;

/// Nanoseconds to the nearest microsecond, half rounded away from zero.
[[nodiscard]] constexpr std::int64_t rounded_to_us(std::int64_t ns) noexcept {
  const std::int64_t whole = ns / 1000;
  const std::int64_t rest = ns % 1000;
  if (rest >= 500) return whole + 1;
  return rest <= -500 ? whole - 1 : whole;
}

}  // namespace pled
