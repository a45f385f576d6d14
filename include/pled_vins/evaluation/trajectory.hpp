#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "pled_vins/geometry/pose.hpp"

namespace pled {

/// Where the body was at an instant: T_world_body.
struct StampedPose {
  std::int64_t stamp_ns = 0;
  Pose pose;
};

/// Strictly increasing in time.
using Trajectory = std::vector<StampedPose>;

/// What is wrong with a text file, and where.
struct FileError {
  std::string file;
  std::int64_t line = 0;  ///< from 1; 0 when the fault has no line
  std::string text;

  /// "FILE:LINE: TEXT".
  [[nodiscard]] std::string message() const;
};

/// A trajectory in TUM form (`t_s tx ty tz qx qy qz qw`) or as a EuRoC csv
/// (`t_ns,px,py,pz,qw,qx,qy,qz,...`); lines that begin with # and empty lines are
/// skipped, quaternions normalised. Errors: missing file, too few or too many
/// columns, a value that is not a finite number, a zero quaternion, a stamp that
/// does not increase. An empty file is an empty trajectory.
[[nodiscard]] std::variant<Trajectory, FileError> read_trajectory(
    const std::filesystem::path& file);

/// Stamps of a list of frames, and how many of its lines were passed over.
struct FrameStamps {
  std::vector<std::int64_t> ns;  ///< strictly increasing
  std::size_t passed_over = 0;   ///< no time, no path, or a time not after the one before
};

/// First column of an images.txt (`t_s path`) or of a EuRoC data.csv
/// (`t_ns,path`), in nanoseconds, as the file has them. Lines that a replay would pass over are
/// passed over here too.
[[nodiscard]] std::variant<FrameStamps, FileError> read_frame_stamps(
    const std::filesystem::path& file);

/// Seconds in decimal notation to nanoseconds, exactly; digits below a nanosecond
/// are rounded. False, leaving `ns` untouched, when it is not such a number or does
/// not fit.
[[nodiscard]] bool parse_stamp_s(std::string_view text, std::int64_t& ns) noexcept;

}  // namespace pled
