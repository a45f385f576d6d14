#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/replay/line_reader.hpp"
#include "drivers/replay/message.hpp"
#include "pled_vins/core/result.hpp"

namespace pled::replay {

enum class FrameListFormat : std::uint8_t {
  kRpg,    ///< `t_s path`, the path relative to the recording's folder
  kEuroc,  ///< `t_ns,name`
};

/// The lines of images.txt, masks.txt or data.csv in the order of time. A stamp that
/// is not later than the last one is skipped and counted; so is one that leaps ahead:
/// later than that of the next line, which goes on from the last. Several that
/// lie more than two seconds off are given out as they are: whoever uses them must judge whether
/// they are wrong or the clock was set.
class FrameList {
 public:
  struct Entry {
    std::int64_t stamp_ns = 0;
    std::string_view name;  ///< valid until the next call
    std::int64_t line = 0;
  };

  /// Errors: as File::open.
  [[nodiscard]] static Result<FrameList> open(const std::string& path, FrameListFormat format);

  /// Errors: kEndOfStream, kIoFailure, kCorrupt (a line without stamp or name; counted,
  /// call again; detail: line). `message` gets words for what was skipped.
  [[nodiscard]] Result<Entry> next(Message& message) noexcept;

  [[nodiscard]] std::uint64_t malformed_lines() const noexcept { return malformed_lines_; }
  [[nodiscard]] std::uint64_t out_of_order() const noexcept { return out_of_order_; }
  /// Share of the file that was read.
  [[nodiscard]] double progress() const noexcept;

 private:
  /// A line, or why there is none.
  struct Line {
    std::int64_t stamp_ns = 0;
    std::string name;  ///< capacity reserved
    std::int64_t number = 0;
    Error error;  ///< kNone for a good line
  };

  FrameList(LineReader lines, std::string path, FrameListFormat format);

  void read(Line& line) noexcept;
  [[nodiscard]] bool is_out_of_order() const noexcept;
  [[nodiscard]] bool is_far() const noexcept;

  LineReader lines_;
  std::string path_;
  FrameListFormat format_;
  Line current_;
  Line ahead_;  ///< the line after current_
  bool has_ahead_ = false;
  bool has_stamp_ = false;
  std::int64_t last_stamp_ns_ = 0;
  std::uint64_t malformed_lines_ = 0;
  std::uint64_t out_of_order_ = 0;
};

/// The stamps that a replay of the list comes by, in nanoseconds; empty when the file
/// cannot be read. Allocates.
[[nodiscard]] std::vector<std::int64_t> listed_stamps(const std::string& path,
                                                      FrameListFormat format);

}  // namespace pled::replay
