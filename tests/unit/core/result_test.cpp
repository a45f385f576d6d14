#include "pled_vins/core/result.hpp"

#include <array>
#include <cstddef>
#include <memory>
#include <utility>

#include <doctest/doctest.h>

namespace pled {
namespace {

constexpr std::array kAllCodes{
    ErrorCode::kNone,           ErrorCode::kTimeout,     ErrorCode::kEndOfStream,
    ErrorCode::kDisconnected,   ErrorCode::kNotFound,    ErrorCode::kPermission,
    ErrorCode::kIoFailure,      ErrorCode::kTruncated,   ErrorCode::kCorrupt,
    ErrorCode::kBadNumber,      ErrorCode::kUnsupported, ErrorCode::kTooLarge,
    ErrorCode::kInvalidArgument};

Result<void> step(ErrorCode code, int& calls) {
  ++calls;
  if (code != ErrorCode::kNone) return Error{code, 17};
  return {};
}

Result<int> two_steps(ErrorCode first, ErrorCode second, int& calls) {
  PLED_TRY(step(first, calls));
  PLED_TRY(step(second, calls));
  return calls;
}

TEST_SUITE("core.result") {
  TEST_CASE("a value is ok and comes back as it went in") {
    Result<int> result = 42;
    REQUIRE(result.ok());
    CHECK(result.value() == 42);
    result.value() = 43;
    CHECK(result.value() == 43);
  }

  TEST_CASE("an error is not ok and keeps its code and its integer") {
    const Result<int> result = Error{ErrorCode::kTruncated, 512};
    CHECK_FALSE(result.ok());
    CHECK(result.error().code == ErrorCode::kTruncated);
    CHECK(result.error().detail == 512);
  }

  TEST_CASE("a bare code is an error whose integer is zero") {
    const Result<int> value_less = ErrorCode::kTimeout;
    const Result<void> nothing = ErrorCode::kTimeout;
    CHECK_FALSE(value_less.ok());
    CHECK_FALSE(nothing.ok());
    CHECK(value_less.error().detail == 0);
    CHECK(nothing.error().code == ErrorCode::kTimeout);
  }

  TEST_CASE("a default result without a value is success") { CHECK(Result<void>{}.ok()); }

  TEST_CASE("a value that cannot be copied is moved out") {
    Result<std::unique_ptr<int>> result = std::make_unique<int>(5);
    REQUIRE(result.ok());
    const std::unique_ptr<int> owned = std::move(result).value();
    REQUIRE(owned != nullptr);
    CHECK(*owned == 5);
  }

  TEST_CASE("PLED_TRY leaves at the first error and hands it on whole") {
    int calls = 0;
    const Result<int> first = two_steps(ErrorCode::kCorrupt, ErrorCode::kNone, calls);
    CHECK(calls == 1);
    CHECK(first.error().code == ErrorCode::kCorrupt);
    CHECK(first.error().detail == 17);

    calls = 0;
    const Result<int> second = two_steps(ErrorCode::kNone, ErrorCode::kTimeout, calls);
    CHECK(calls == 2);
    CHECK(second.error().code == ErrorCode::kTimeout);

    calls = 0;
    const Result<int> neither = two_steps(ErrorCode::kNone, ErrorCode::kNone, calls);
    REQUIRE(neither.ok());
    CHECK(neither.value() == 2);
  }

  TEST_CASE("every error code has words of its own") {
    for (std::size_t i = 0; i < kAllCodes.size(); ++i) {
      CAPTURE(i);
      CHECK(to_string(kAllCodes[i]) != "unknown");
      for (std::size_t k = 0; k < i; ++k) CHECK(to_string(kAllCodes[i]) != to_string(kAllCodes[k]));
    }
    const auto past_the_last = static_cast<ErrorCode>(kAllCodes.size());
    CHECK(to_string(past_the_last) == "unknown");  // kAllCodes misses none
  }
}

}  // namespace
}  // namespace pled
