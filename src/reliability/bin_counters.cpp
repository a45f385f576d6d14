#include "pled_vins/reliability/bin_counters.hpp"

#include <cstring>

#include "pled_vins/core/check.hpp"

namespace pled {
namespace {

constexpr int kBins = static_cast<int>(limits::kTimeBins);
static_assert(kBins == 8, "the counts of a pixel are the bytes of one 64-bit integer");
constexpr unsigned kBitsPerCount = 8;
/// The newest bin is the highest byte, so that a shift to the right lets bins grow old and fall
/// out.
constexpr unsigned kNewestShift = (kBins - 1) * kBitsPerCount;
constexpr std::uint64_t kFull = 0xFF;
/// Within this many bins the sweep visits every row. A stamp that is visited at least every 2^14
/// bins, and every jump of 2^14 bins or more clearing all, stays less than 2^15 bins old: 16 bits
/// tell its age without doubt.
constexpr std::uint32_t kSweepBins = 1U << 14;

/// Before the first bin: older than any, and still far from the ends of the type.
constexpr BinNumber kNoBin = -(BinNumber{1} << 62);

std::uint64_t counts_of(const BinCell& cell) noexcept {
  std::uint64_t counts;
  std::memcpy(&counts, cell.bytes.data(), sizeof counts);
  return counts;
}

std::uint16_t stamp_of(const BinCell& cell) noexcept {
  std::uint16_t stamp;
  std::memcpy(&stamp, cell.bytes.data() + sizeof(std::uint64_t), sizeof stamp);
  return stamp;
}

void write(BinCell& cell, std::uint64_t counts, std::uint16_t stamp) noexcept {
  std::memcpy(cell.bytes.data(), &counts, sizeof counts);
  std::memcpy(cell.bytes.data() + sizeof counts, &stamp, sizeof stamp);
}

constexpr std::uint16_t low_bits(BinNumber bin) noexcept { return static_cast<std::uint16_t>(bin); }

constexpr std::uint16_t difference(std::uint16_t newer, std::uint16_t older) noexcept {
  return static_cast<std::uint16_t>(newer - older);
}

/// The counts seen from `age` bins later.
constexpr std::uint64_t aged(std::uint64_t counts, unsigned age) noexcept {
  return age < kBins ? counts >> (age * kBitsPerCount) : 0;
}

}  // namespace

BinCounters::BinCounters(int width_px, int height_px, std::span<BinCell> cells) noexcept
    : cells_(cells),
      columns_(static_cast<std::uint32_t>(width_px)),
      rows_(static_cast<std::uint32_t>(height_px)) {
  PLED_CHECK(width_px > 0 && height_px > 0);
  PLED_CHECK(cells.size() >= cells_needed(width_px, height_px));
  cells_ = cells.first(cells_needed(width_px, height_px));
  clear();
}

void BinCounters::clear() noexcept {
  newest_ = kNoBin;  // from which the first bin is so far that the sweep writes every cell
  sweep_row_ = 0;
  sweep_progress_ = 0;
  losses_ = {};
}

void BinCounters::advance_to(BinNumber bin) noexcept {
  if (bin <= newest_) return;
  const BinNumber passed = bin - newest_;
  newest_ = bin;
  sweep(passed);
}

void BinCounters::sweep(BinNumber passed) noexcept {
  if (passed >= kSweepBins) {
    for (BinCell& cell : cells_) write(cell, 0, low_bits(newest_));
    return;
  }
  const std::uint16_t now = low_bits(newest_);
  std::uint64_t progress = sweep_progress_ + static_cast<std::uint64_t>(passed) * rows_;
  for (; progress >= kSweepBins; progress -= kSweepBins) {
    for (BinCell& cell : cells_.subspan(std::size_t{sweep_row_} * columns_, columns_)) {
      if (difference(now, stamp_of(cell)) >= kBins) write(cell, 0, now);
    }
    sweep_row_ = sweep_row_ + 1 == rows_ ? 0 : sweep_row_ + 1;
  }
  sweep_progress_ = static_cast<std::uint32_t>(progress);
}

void BinCounters::add(std::span<const WarpedPixel> events, BinNumber bin) noexcept {
  advance_to(bin);
  if (bin == newest_) {
    add_newest(events);
  } else if (newest_ - bin < kBins) {
    add_late(events, bin);
  } else {
    losses_.late += events.size();
  }
}

/// No pixel has a stamp beyond the newest bin, so every pixel is as old as that bin or older.
void BinCounters::add_newest(std::span<const WarpedPixel> events) noexcept {
  constexpr std::uint64_t kNewestFull = kFull << kNewestShift;
  const std::uint16_t now = low_bits(newest_);
  const std::uint32_t columns = columns_;
  const std::uint32_t rows = rows_;
  BinCell* const cells = cells_.data();
  for (const WarpedPixel& event : events) {
    // What lies left or above is negative, as unsigned: huge.
    const auto x = static_cast<std::uint32_t>(event.x_px);
    const auto y = static_cast<std::uint32_t>(event.y_px);
    if (x >= columns || y >= rows) {
      ++losses_.outside;
      continue;
    }
    BinCell& cell = cells[std::size_t{y} * columns + x];
    const std::uint64_t counts = aged(counts_of(cell), difference(now, stamp_of(cell)));
    if (counts >= kNewestFull) {
      ++losses_.saturated;
      continue;
    }
    write(cell, counts + (std::uint64_t{1} << kNewestShift), now);
  }
}

/// The same for a bin that is not the newest: a pixel may have gone on already.
void BinCounters::add_late(std::span<const WarpedPixel> events, BinNumber bin) noexcept {
  for (const WarpedPixel& event : events) {
    if (!contains(event.x_px, event.y_px)) {
      ++losses_.outside;
      continue;
    }
    BinCell& cell = cells_[index(event.x_px, event.y_px)];
    std::uint64_t counts = counts_of(cell);
    std::uint16_t stamp = stamp_of(cell);
    // Both are within 2^15 bins of each other: the sign tells which is newer.
    const auto ahead = static_cast<std::int16_t>(difference(low_bits(bin), stamp));
    if (ahead > 0) {
      counts = aged(counts, static_cast<unsigned>(ahead));
      stamp = low_bits(bin);
    }
    const unsigned age = ahead > 0 ? 0U : static_cast<unsigned>(-ahead);
    const unsigned shift = kNewestShift - age * kBitsPerCount;
    if (((counts >> shift) & kFull) == kFull) {
      ++losses_.saturated;
      continue;
    }
    write(cell, counts + (std::uint64_t{1} << shift), stamp);
  }
}

BinCounts BinCounters::counts_at(int x_px, int y_px, BinNumber last) const noexcept {
  BinCounts out{};
  if (newest_ == kNoBin || !contains(x_px, y_px)) return out;
  const BinCell& cell = cells_[index(x_px, y_px)];
  std::uint64_t counts = counts_of(cell);
  const BinNumber behind = difference(low_bits(newest_), stamp_of(cell));
  const BinNumber age = last - (newest_ - behind);  // of the pixel's newest bin, seen from `last`
  if (age >= kBins || age <= -kBins) return out;
  const auto bits = static_cast<unsigned>(age < 0 ? -age : age) * kBitsPerCount;
  counts = age < 0 ? counts << bits : counts >> bits;
  for (std::size_t k = 0; k < out.size(); ++k)
    out[k] = static_cast<std::uint8_t>(counts >> (k * kBitsPerCount));
  return out;
}

bool BinCounters::contains(int x_px, int y_px) const noexcept {
  return static_cast<std::uint32_t>(x_px) < columns_ && static_cast<std::uint32_t>(y_px) < rows_;
}

std::size_t BinCounters::index(int x_px, int y_px) const noexcept {
  return static_cast<std::size_t>(y_px) * columns_ + static_cast<std::size_t>(x_px);
}

}  // namespace pled
