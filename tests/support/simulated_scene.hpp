#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "pled_vins/evaluation/evaluate.hpp"
#include "pled_vins/sim/options.hpp"

namespace pled::support {

/// Where a rig is at an instant: a camera's axes, level but for the pitch, heading from +x to +y.
struct Station {
  Eigen::Vector3d p_m = Eigen::Vector3d::Zero();
  double heading_rad = 0.0;
  double pitch_rad = 0.0;
};

/// A gentle flight of about a metre with turns, in which an estimator finds all that it needs.
[[nodiscard]] Station flight_at(double t_s);
/// The same until `stop_s`, where it has come to rest within the two seconds about it.
[[nodiscard]] Station flight_until(double stop_s, double t_s);

/// What a run of `replay` found of a simulated recording.
struct Played {
  nlohmann::json report;
  Evaluation evaluation;                  ///< against the exact truth
  std::vector<std::string> feature_rows;  ///< of features.csv, without its head

  /// Worst distance to the truth of the poses from `from_s` of the recording on, laid on it by the
  /// rigid alignment of just these: what went wrong before is not counted. NaN without any.
  [[nodiscard]] double worst_error_m(double from_s) const { return worst_error_m(from_s, from_s); }
  /// The same of the poses from `from_s` on, laid on the truth by those from `aligned_from_s` on.
  [[nodiscard]] double worst_error_m(double from_s, double aligned_from_s) const;
  /// Mean and worst of a frame, and the lines followed, for a message.
  [[nodiscard]] std::string cost() const;
};

/// A recording made for one case, in a folder that goes with the object. Events and frames are
/// coarser than by default, for they cost most of a simulation's time.
class SimulatedScene {
 public:
  using Path = std::function<Station(double t_s)>;

  /// @param name  of its folder
  /// @param path  followed instead of the motion of `options`
  SimulatedScene(const std::string& name, sim::SimulationOptions options, const Path& path = {});
  SimulatedScene(const SimulatedScene&) = delete;
  SimulatedScene& operator=(const SimulatedScene&) = delete;
  ~SimulatedScene();

  /// `pled-vins replay` of it; `settings`, when not empty, are its --config.
  [[nodiscard]] Played play(const std::string& settings = {}) const;
  [[nodiscard]] const sim::SimulationOptions& options() const noexcept { return options_; }

 private:
  std::filesystem::path folder_;
  sim::SimulationOptions options_;
};

/// How long the features on the scene's bus took to be weighed anew after it stopped and after it
/// drove off: from the label's change until their median weight over the last three frames was on
/// the other side of 0.5. Absent: never, or never as many as three of them.
struct Recovery {
  std::optional<double> believed_s;     ///< after it stopped
  std::optional<double> disbelieved_s;  ///< after it drove off
  double driving_weight = 0.0;          ///< median before it stopped, its last braking left out
  double parked_weight = 0.0;           ///< median over the last half second of standing
};
/// Of image and event points, or of lines. `played` must be of `scene`.
[[nodiscard]] Recovery recovery(const SimulatedScene& scene, const Played& played, bool of_lines);

}  // namespace pled::support
