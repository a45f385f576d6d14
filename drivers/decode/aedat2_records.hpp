#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace pled {

/// What a record of a DAVIS in AEDAT 2.0 stands for.
enum class Aedat2Kind : std::uint8_t { kEvent, kSpecial, kReset, kSignal, kImu, kUnknown };

/// One address with its time.
struct Aedat2Record {
  std::int64_t t_us = 0;  ///< unwrapped; may lie before that of earlier records
  std::uint32_t address = 0;

  /// Bit 31 clear: an event, bit 10 set: a special one. Bit 31 set: bits 11 and 10 tell the
  /// reset read, the signal read and the IMU.
  [[nodiscard]] constexpr Aedat2Kind kind() const noexcept {
    if (address >> 31 == 0)
      return (address >> 10 & 1U) != 0 ? Aedat2Kind::kSpecial : Aedat2Kind::kEvent;
    switch (address >> 10 & 3U) {
      case 0: return Aedat2Kind::kReset;
      case 1: return Aedat2Kind::kSignal;
      case 3: return Aedat2Kind::kImu;
      default: return Aedat2Kind::kUnknown;
    }
  }
  /// Pixel as stored, from the lower left corner. Events: x from the right.
  [[nodiscard]] constexpr std::uint32_t x() const noexcept { return address >> 12 & 0x3FFU; }
  [[nodiscard]] constexpr std::uint32_t y() const noexcept { return address >> 22 & 0x1FFU; }
  [[nodiscard]] constexpr bool on() const noexcept { return (address >> 11 & 1U) != 0; }
  /// Of a reset or signal read, 10 bits.
  [[nodiscard]] constexpr std::uint32_t sample() const noexcept { return address & 0x3FFU; }
  /// Of the IMU: which word, 0..7, and its value.
  [[nodiscard]] constexpr unsigned imu_code() const noexcept { return address >> 28 & 7U; }
  [[nodiscard]] constexpr std::int16_t imu_value() const noexcept {
    return static_cast<std::int16_t>(static_cast<std::uint16_t>(address >> 12 & 0xFFFFU));
  }
};

/// Bytes of AEDAT 2.0, big-endian pairs of address and 32-bit microseconds, to records with an
/// unwrapped time. Whoever reads a file from its beginning to look for one kind of record gets
/// the same times as who looks for another: the clock is that of all records.
///
/// Ours: a stamp within kMaxStep_us of the newest, before or behind (modulo 2^32), is taken at
/// once. Any other, and the first of all, waits for the next record and is given out when that
/// agrees with it; one that stays alone is malformed. When the stamps agree on a time that
/// lies back, the camera's clock was set anew: `restarts` counts it and time goes on from the
/// newest. A silence of up to 35 minutes is told from that.
class Aedat2Records {
 public:
  static constexpr std::size_t kRecordBytes = 8;
  static constexpr std::int64_t kMaxStep_us = 131'072;

  struct Faults {
    std::uint64_t malformed = 0;  ///< records without a time that can be believed, cut records
    std::uint64_t restarts = 0;
    std::uint64_t unconfirmed = 0;  ///< at the end of the stream
  };

  /// The next record, and its bytes taken from the front of `bytes`; nothing when these are
  /// used up. Up to one record may be left behind for the next call.
  [[nodiscard]] std::optional<Aedat2Record> next(std::span<const std::byte>& bytes) noexcept;
  /// A record is left that needs no more bytes.
  [[nodiscard]] bool has_next() const noexcept { return queued_.has_value(); }
  /// Bytes were lost: what was begun is no record.
  void resynchronise() noexcept { partial_bytes_ = 0; }
  /// No byte follows.
  void finish() noexcept;
  [[nodiscard]] const Faults& faults() const noexcept { return faults_; }

 private:
  struct Raw {
    std::uint32_t address = 0;
    std::uint32_t stamp = 0;
  };

  [[nodiscard]] std::optional<Aedat2Record> take(Raw raw) noexcept;
  [[nodiscard]] Aedat2Record timed(Raw raw) noexcept;
  void move_clock(std::uint32_t stamp) noexcept;

  std::array<std::byte, kRecordBytes> partial_{};
  std::size_t partial_bytes_ = 0;
  bool has_time_ = false;
  std::uint32_t newest_stamp_ = 0;  ///< as the file has it
  std::int64_t newest_us_ = 0;      ///< the same unwrapped
  std::optional<Raw> waiting_;
  std::optional<Aedat2Record> queued_;
  Faults faults_;
};

}  // namespace pled
