#include "drivers/decode/decimal.hpp"

#include <cstdint>
#include <limits>

#include <doctest/doctest.h>

using namespace pled;

TEST_SUITE("drivers.decimal") {
  TEST_CASE("a scaled number is the decimal shifted, without rounding through a double") {
    CHECK(parse_scaled("1403715273.262143135", 9) == 1403715273262143135);
    CHECK(parse_scaled("0.003811000", 6) == 3811);
    CHECK(parse_scaled("12", 6) == 12'000'000);
    CHECK(parse_scaled("-0.5", 3) == -500);
    CHECK(parse_scaled("+.25", 2) == 25);
    CHECK(parse_scaled("7.", 0) == 7);
    CHECK(parse_scaled("000000000000000000000000000012.5", 1) == 125);
    CHECK(parse_scaled("0.00000000000000000000000000001", 6) == 0);
  }

  TEST_CASE("digits beyond the scale are rounded, half away from zero") {
    CHECK(parse_scaled("0.0000005", 6) == 1);
    CHECK(parse_scaled("0.00000049999999999999999999999999", 6) == 0);
    CHECK(parse_scaled("-0.0000005", 6) == -1);
    CHECK(parse_scaled("1.0000000005", 9) == 1000000001);
    CHECK(parse_scaled("1403715273.2621431355", 9) == 1403715273262143136);
    CHECK(parse_scaled("1403715273.26214313549999", 9) == 1403715273262143135);
  }

  TEST_CASE("an exponent moves the point") {
    CHECK(parse_scaled("1.5e-3", 6) == 1500);
    CHECK(parse_scaled("1.403715273262143135E+9", 9) == 1403715273262143135);
    CHECK(parse_scaled("1403715273262143135e-9", 9) == 1403715273262143135);
    CHECK(parse_scaled("5e-7", 6) == 1);
    CHECK(parse_scaled("1e-300", 9) == 0);
    CHECK(parse_scaled("0e300", 9) == 0);
  }

  TEST_CASE("what does not fit 64 bits is refused, the largest number is not") {
    CHECK(parse_scaled("9223372036854775807", 0) == std::numeric_limits<std::int64_t>::max());
    CHECK_FALSE(parse_scaled("9223372036854775808", 0));
    CHECK_FALSE(parse_scaled("18446744073709551616", 0));
    CHECK_FALSE(parse_scaled("1e19", 0));
    CHECK_FALSE(parse_scaled("1e300", 0));
    CHECK_FALSE(parse_scaled("9223372036.854775808", 9));
  }

  TEST_CASE("text that is no number is refused") {
    for (const char* text : {"", "-", "+", ".", "e5", "1e", "1e+", "nan", "inf", "-inf", "1.2.3",
                             "12x", "0x10", "1e5.0", "--1", "1 "}) {
      CAPTURE(text);
      CHECK_FALSE(parse_scaled(text, 6));
      CHECK_FALSE(parse_finite(text));
    }
    CHECK_FALSE(parse_finite("1e999"));
    CHECK_FALSE(parse_int("1.0"));
    CHECK_FALSE(parse_int("99999999999"));
    CHECK(parse_int("-3") == -3);
    CHECK(parse_finite("+2.5e1") == 25.0);
  }

  TEST_CASE("nanoseconds round to the nearest microsecond on both sides of zero") {
    CHECK(rounded_to_us(1499) == 1);
    CHECK(rounded_to_us(1500) == 2);
    CHECK(rounded_to_us(-1499) == -1);
    CHECK(rounded_to_us(-1500) == -2);
    CHECK(rounded_to_us(std::numeric_limits<std::int64_t>::max()) == 9223372036854776);
  }

  TEST_CASE("fields part at blanks and commas") {
    std::string_view line = " 1,2 ,\t3,,4";
    CHECK(next_field(line) == "1");
    CHECK(next_field(line) == "2");
    CHECK(next_field(line) == "3");
    CHECK(next_field(line) == "4");
    CHECK(next_field(line).empty());
    CHECK(is_blank_or_comment("  # x"));
    CHECK(is_blank_or_comment(" \t\r"));
    CHECK_FALSE(is_blank_or_comment("1 # x"));
  }
}
