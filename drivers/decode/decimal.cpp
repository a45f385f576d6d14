#include "drivers/decode/decimal.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <system_error>

namespace pled {
namespace {

constexpr int kMaxDigits = 19;  // 10^19 - 1 fits 64 bits without sign

constexpr auto kPowersOfTen = [] {
  std::array<std::uint64_t, 20> powers{};
  powers[0] = 1;
  for (std::size_t i = 1; i < powers.size(); ++i) powers[i] = powers[i - 1] * 10;
  return powers;
}();

[[nodiscard]] constexpr bool is_digit(char c) noexcept { return c >= '0' && c <= '9'; }

/// Significant digits of a number, value = mantissa * 10^exponent.
struct Decimal {
  std::uint64_t mantissa = 0;
  int exponent = 0;
  int digits = 0;         ///< significant digits in the mantissa
  bool round_up = false;  ///< the first digit that found no room was 5 or more
  bool any_digit = false;

  /// False when the number is longer than anything that could be meant.
  [[nodiscard]] bool take(char c, bool fraction) noexcept {
    constexpr int kMaxExponent = 1000;
    any_digit = true;
    if (digits < kMaxDigits) {
      mantissa = mantissa * 10 + static_cast<std::uint64_t>(c - '0');
      if (mantissa != 0) ++digits;
      if (fraction) --exponent;
    } else {
      if (digits == kMaxDigits) round_up = c >= '5';
      ++digits;
      if (!fraction) ++exponent;
    }
    return exponent > -kMaxExponent && exponent < kMaxExponent;
  }
};

/// mantissa * 10^(exponent + scale), rounded; nothing beyond 63 bits.
[[nodiscard]] std::optional<std::uint64_t> scaled(const Decimal& d, int scale) noexcept {
  constexpr std::uint64_t kMax =
      static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  const int power = d.exponent + scale;
  std::uint64_t value = d.mantissa;
  if (power > 0) {
    if (value == 0) return 0;
    if (power > kMaxDigits) return std::nullopt;
    const std::uint64_t factor = kPowersOfTen[static_cast<std::size_t>(power)];
    if (value > kMax / factor) return std::nullopt;
    value *= factor;
  } else if (power < 0) {
    if (power < -kMaxDigits) return 0;
    const std::uint64_t divisor = kPowersOfTen[static_cast<std::size_t>(-power)];
    const std::uint64_t rest = value % divisor;
    value /= divisor;
    if (rest >= divisor - rest) ++value;
  } else if (d.round_up) {
    if (value >= kMax) return std::nullopt;
    ++value;
  }
  if (value > kMax) return std::nullopt;
  return value;
}

}  // namespace

std::optional<std::int64_t> parse_scaled(std::string_view text, int scale) noexcept {
  std::size_t i = 0;
  const bool negative = !text.empty() && text[0] == '-';
  if (negative || (!text.empty() && text[0] == '+')) ++i;
  Decimal decimal;
  for (; i < text.size() && is_digit(text[i]); ++i) {
    if (!decimal.take(text[i], false)) return std::nullopt;
  }
  if (i < text.size() && text[i] == '.') {
    for (++i; i < text.size() && is_digit(text[i]); ++i) {
      if (!decimal.take(text[i], true)) return std::nullopt;
    }
  }
  if (!decimal.any_digit) return std::nullopt;
  if (i < text.size() && (text[i] == 'e' || text[i] == 'E')) {
    ++i;
    if (i + 1 < text.size() && text[i] == '+' && is_digit(text[i + 1])) ++i;
    int exponent = 0;
    const auto [end, error] = std::from_chars(text.data() + i, text.data() + text.size(), exponent);
    constexpr int kMaxExponent = 1000;
    if (error != std::errc{} || exponent > kMaxExponent || exponent < -kMaxExponent) {
      return std::nullopt;
    }
    decimal.exponent += exponent;
    i = static_cast<std::size_t>(end - text.data());
  }
  if (i != text.size()) return std::nullopt;
  const std::optional<std::uint64_t> magnitude = scaled(decimal, scale);
  if (!magnitude) return std::nullopt;
  const auto value = static_cast<std::int64_t>(*magnitude);
  return negative ? -value : value;
}

std::optional<double> parse_finite(std::string_view text) noexcept {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  if (!std::isfinite(value)) return std::nullopt;
  return value;
}

std::optional<std::int32_t> parse_int(std::string_view text) noexcept {
  std::int32_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::string_view next_field(std::string_view& rest) noexcept {
  const auto is_separator = [](char c) { return c == ' ' || c == '\t' || c == ','; };
  std::size_t begin = 0;
  while (begin < rest.size() && is_separator(rest[begin])) ++begin;
  std::size_t end = begin;
  while (end < rest.size() && !is_separator(rest[end])) ++end;
  const std::string_view field = rest.substr(begin, end - begin);
  rest.remove_prefix(end);
  return field;
}

std::string_view trimmed_line(std::string_view line) noexcept {
  while (!line.empty() && (line.back() == '\r' || line.back() == ' ' || line.back() == '\t')) {
    line.remove_suffix(1);
  }
  return line;
}

bool is_blank_or_comment(std::string_view line) noexcept {
  for (const char c : line) {
    if (c == '#') return true;
    if (c != ' ' && c != '\t' && c != '\r') return false;
  }
  return true;
}

}  // namespace pled
