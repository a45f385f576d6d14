#include "drivers/decode/aedat2_records.hpp"

#include <algorithm>

namespace pled {
namespace {

[[nodiscard]] std::uint32_t big_endian(std::span<const std::byte> bytes) noexcept {
  std::uint32_t value = 0;
  for (const std::byte byte : bytes.first(4)) value = value << 8 | std::to_integer<unsigned>(byte);
  return value;
}

/// From one stamp to another by the shorter way round, microseconds.
[[nodiscard]] std::int64_t step_us(std::uint32_t from, std::uint32_t to) noexcept {
  return static_cast<std::int32_t>(to - from);
}

[[nodiscard]] bool is_near(std::uint32_t from, std::uint32_t to) noexcept {
  const std::int64_t step = step_us(from, to);
  return step <= Aedat2Records::kMaxStep_us && step >= -Aedat2Records::kMaxStep_us;
}

}  // namespace

std::optional<Aedat2Record> Aedat2Records::next(std::span<const std::byte>& bytes) noexcept {
  if (queued_) {
    const std::optional<Aedat2Record> record = queued_;
    queued_.reset();
    return record;
  }
  while (!bytes.empty()) {
    const std::size_t part = std::min(kRecordBytes - partial_bytes_, bytes.size());
    std::span<const std::byte> whole = bytes.first(part);
    bytes = bytes.subspan(part);
    if (part < kRecordBytes) {
      std::copy(whole.begin(), whole.end(), partial_.begin() + partial_bytes_);
      partial_bytes_ += part;
      if (partial_bytes_ < kRecordBytes) return std::nullopt;
      partial_bytes_ = 0;
      whole = partial_;
    }
    if (const auto record = take({big_endian(whole), big_endian(whole.subspan(4))})) return record;
  }
  return std::nullopt;
}

std::optional<Aedat2Record> Aedat2Records::take(Raw raw) noexcept {
  if (has_time_ && is_near(newest_stamp_, raw.stamp)) {
    if (waiting_) ++faults_.malformed;
    waiting_.reset();
    return timed(raw);
  }
  if (waiting_ && is_near(waiting_->stamp, raw.stamp)) {
    move_clock(waiting_->stamp);
    const Aedat2Record first = timed(*waiting_);
    waiting_.reset();
    queued_ = timed(raw);
    return first;
  }
  if (waiting_) ++faults_.malformed;
  waiting_ = raw;
  return std::nullopt;
}

void Aedat2Records::move_clock(std::uint32_t stamp) noexcept {
  if (!has_time_) newest_us_ = static_cast<std::int32_t>(stamp);
  if (has_time_ && step_us(newest_stamp_, stamp) > 0)
    newest_us_ += step_us(newest_stamp_, stamp);
  else if (has_time_)
    ++faults_.restarts;
  newest_stamp_ = stamp;
  has_time_ = true;
}

Aedat2Record Aedat2Records::timed(Raw raw) noexcept {
  const std::int64_t step = step_us(newest_stamp_, raw.stamp);
  Aedat2Record record{newest_us_ + step, raw.address};
  if (step > 0) {
    newest_stamp_ = raw.stamp;
    newest_us_ = record.t_us;
  }
  return record;
}

void Aedat2Records::finish() noexcept {
  if (partial_bytes_ != 0) ++faults_.malformed;
  if (waiting_) ++faults_.unconfirmed;
  partial_bytes_ = 0;
  waiting_.reset();
}

}  // namespace pled
