#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "drivers/decode/aedat2_records.hpp"
#include "pled_vins/hal/event_source.hpp"

namespace pled {

/// The events of a DAVIS in AEDAT 2.0; inertial words, samples of frames and special events
/// are passed over. The file counts pixels from the lower right corner; they are given from
/// the upper left. Time: see Aedat2Records; the time given out is held where an event's goes
/// back.
class Aedat2EventDecoder final : public EventDecoder {
 public:
  /// The size is the chip's own: pixels are counted from its edges. Sides: 1..1024, 1..512;
  /// larger ones are held there.
  Aedat2EventDecoder(int width_px, int height_px) noexcept;

  DecodeStep decode(std::span<const std::byte> bytes, std::span<Event> out) noexcept override;
  void resynchronise() noexcept override;
  void finish() noexcept override;
  [[nodiscard]] const DecoderFaults& faults() const noexcept override { return faults_; }

 private:
  [[nodiscard]] bool take(const Aedat2Record& record, Event& out) noexcept;
  void collect_faults() noexcept;

  std::uint32_t width_px_;
  std::uint32_t height_px_;
  Aedat2Records records_;
  bool has_time_ = false;
  std::int64_t last_us_ = 0;
  std::uint64_t unknown_ = 0;  ///< addresses of no kind
  std::uint64_t losses_ = 0;   ///< calls of resynchronise()
  DecoderFaults faults_;
};

}  // namespace pled
