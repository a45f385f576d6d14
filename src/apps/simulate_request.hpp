#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "pled_vins/core/result.hpp"
#include "pled_vins/sim/options.hpp"

namespace pled::apps {

[[nodiscard]] std::vector<std::string> moving_names();
[[nodiscard]] std::vector<std::string> light_names();
[[nodiscard]] std::vector<std::string> motion_names();
[[nodiscard]] std::vector<std::string> surface_names();

/// What `pled-vins simulate` was asked for, as it was typed.
struct SimulateRequest {
  std::string out;
  std::string preset = "demo";
  std::uint64_t seed = 1;
  std::optional<double> duration_s;
  std::optional<std::string> moving;    ///< one of moving_names()
  std::optional<std::string> daylight;  ///< one of light_names()
  std::optional<std::string> motion;    ///< one of motion_names()
  std::optional<double> speed_mps;
  std::optional<std::string> surfaces;  ///< one of surface_names()
  std::vector<double> bus;              ///< empty, or when, how long, how far away
  std::string path_file;
  bool second_camera = false;
  bool depth = false;
  bool text_events = false;
  sim::FaultOptions faults;
  std::optional<double> flash_at_s;
  std::vector<double> imu_gap_s;  ///< empty, or from and for how long
  bool force = false;
};

/// Options, or words on why there are none.
struct RequestedOptions {
  sim::SimulationOptions options;
  std::string refusal;  ///< names the option and the fix; empty when there is none
  bool misused = true;  ///< the refusal is about the command line, not about a file
};

/// The options for `simulate()`. Reads the path's file for its length.
[[nodiscard]] RequestedOptions requested_options(const SimulateRequest& request);

/// Why nothing may be written to `request.out`; empty when it may.
[[nodiscard]] std::string output_refusal(const SimulateRequest& request);

/// Why simulate() ended with `error`.
[[nodiscard]] std::string failure_words(const SimulateRequest& request, Error error);

}  // namespace pled::apps
