#include <cstdio>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <CLI/CLI.hpp>

#include "drivers/replay/recording.hpp"
#include "pled_vins/config/calibration.hpp"
#include "pled_vins/imu/truth_check.hpp"
#include "src/apps/commands.hpp"
#include "src/apps/problems.hpp"
#include "src/apps/text.hpp"

namespace pled::apps {
namespace {

/// Of the reference systems that write velocity and biases; Ours: a motion-capture
/// or laser-tracker truth after smoothing, one axis.
constexpr TruthUncertainty kDefaultUncertainty{
    .position_m = 1e-3, .attitude_rad = 1e-3, .velocity_mps = 1e-2};

NavState to_state(const replay::TruthState& truth) {
  NavState state;
  state.t = truth.t;
  state.p_wb = Eigen::Vector3d::Map(truth.p_world_body_m.data());
  state.q_wb = Eigen::Quaterniond(truth.q_world_body_xyzw.data());
  state.v_wb = Eigen::Vector3d::Map(truth.v_world_body_mps.data());
  state.bg = Eigen::Vector3d::Map(truth.gyro_bias_radps.data());
  state.ba = Eigen::Vector3d::Map(truth.accel_bias_mps2.data());
  return state;
}

/// Integrates the IMU of a recording between true states and compares.
class CheckImuCommand final : public Command {
 public:
  std::string_view name() const noexcept override { return "check-imu"; }
  std::string_view summary() const noexcept override {
    return "Integrate the IMU of a recording between true states and print the normalised error";
  }
  std::string_view examples() const noexcept override {
    return "  pled-vins check-imu mav0\n"
           "  pled-vins check-imu recording --truth truth_with_biases.csv --interval 0.1,0.5,1\n"
           "  pled-vins check-imu mav0 --config my.yaml";
  }

  void declare(CLI::App& app) override {
    app.add_option("RECORDING", recording_, "Recording with an IMU")->required();
    app.add_option("--truth", truth_file_,
                   "EuRoC csv with velocity and biases (default: the recording's own truth)");
    app.add_option("--interval", intervals_s_,
                   "Lengths of integration, seconds, with commas between")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->check(CLI::Range(0.005, 2.0))
        ->capture_default_str();
    app.add_option("--config", config_file_, "Settings file that names imu.yaml (`imu: PATH`)");
    app.add_option("--position-sigma", uncertainty_.position_m, "Of the truth, m")
        ->check(CLI::NonNegativeNumber)
        ->capture_default_str();
    app.add_option("--attitude-sigma", uncertainty_.attitude_rad, "Of the truth, rad")
        ->check(CLI::NonNegativeNumber)
        ->capture_default_str();
    app.add_option("--velocity-sigma", uncertainty_.velocity_mps, "Of the truth, m/s")
        ->check(CLI::NonNegativeNumber)
        ->capture_default_str();
  }

  ExitCode run() override {
    replay::Problems problems;
    const auto recording = replay::Recording::open(recording_, problems);
    ImuNoise noise;
    std::vector<NavState> truth;
    std::vector<ImuSample> imu;
    if (!recording.ok() || !read_imu(recording.value(), problems, imu) ||
        !read_truth(recording.value(), problems, truth)) {
      if (!print_problems(problems)) print_error("the recording could not be read");
      return ExitCode::kFailed;
    }
    if (!read_noise(noise)) return ExitCode::kFailed;
    std::printf(
        "interval_s  compared  skipped    nees  nees_p  nees_q  nees_v  "
        "rms_p_m   rms_q_rad  rms_v_mps\n");
    bool compared = false;
    for (const double interval_s : intervals_s_) {
      const PreintegrationCheck c =
          check_preintegration(truth, imu, interval_s, noise, uncertainty_);
      compared = compared || c.compared > 0;
      std::printf("%10.3f  %8zu  %7zu  %6.3f  %6.3f  %6.3f  %6.3f  %.6f  %.7f  %.6f\n", interval_s,
                  c.compared, c.skipped, c.mean_nees_per_dof, c.position_nees_per_dof,
                  c.attitude_nees_per_dof, c.velocity_nees_per_dof, c.position_rms_m,
                  c.attitude_rms_rad, c.velocity_rms_mps);
    }
    if (compared) return ExitCode::kDone;
    print_error("nothing was compared: truth and IMU do not overlap long enough");
    return ExitCode::kFailed;
  }

 private:
  static bool read_imu(const replay::Recording& recording, replay::Problems& problems,
                       std::vector<ImuSample>& out) {
    const auto source = recording.open_imu(problems);
    if (!source.ok() || !source.value()->start().ok()) return false;
    while (true) {
      const Result<ImuSample> sample = source.value()->read(Duration{});
      if (sample.ok() && (out.empty() || sample.value().t > out.back().t))
        out.push_back(sample.value());
      else if (!sample.ok() && sample.error().code != ErrorCode::kBadNumber)
        return sample.error().code == ErrorCode::kEndOfStream;
    }
  }

  bool read_truth(const replay::Recording& recording, replay::Problems& problems,
                  std::vector<NavState>& out) const {
    auto reader = truth_file_.empty()
                      ? recording.open_truth(problems)
                      : replay::TruthReader::open(truth_file_, replay::TruthFormat::kEuroc);
    if (!reader.ok()) {
      if (!truth_file_.empty()) problems.push_back(problem("cannot be read"));
      return false;
    }
    while (true) {
      const Result<replay::TruthState> state = reader.value().next();
      if (!state.ok() && state.error().code == ErrorCode::kBadNumber) continue;
      if (!state.ok()) break;
      if (!state.value().has_motion) {
        problems.push_back(
            problem("the truth has no velocity and biases: name a EuRoC csv that "
                    "has them with --truth"));
        return false;
      }
      if (out.empty() || state.value().t > out.back().t) out.push_back(to_state(state.value()));
    }
    if (out.empty()) problems.push_back(problem("the truth holds no states"));
    return !out.empty();
  }

  [[nodiscard]] replay::Problem problem(const char* text) const {
    return {replay::Severity::kError, truth_file_, 0, text};
  }

  bool read_noise(ImuNoise& noise) const {
    AppConfig config;
    if (!config_file_.empty()) {
      auto loaded = load_config(config_file_);
      if (const auto* error = std::get_if<ConfigError>(&loaded)) return refuse(*error);
      config = std::get<AppConfig>(std::move(loaded));
    }
    const auto found = load_recording_imu(recording_, config);
    if (const auto* error = std::get_if<ConfigError>(&found)) return refuse(*error);
    noise = std::get<ImuNoise>(found);
    return true;
  }

  static bool refuse(const ConfigError& error) {
    print_error(error.message());
    return false;
  }

  std::string recording_;
  std::string truth_file_;
  std::string config_file_;
  std::vector<double> intervals_s_{0.1, 0.5, 1.0};
  TruthUncertainty uncertainty_ = kDefaultUncertainty;
};

}  // namespace

std::unique_ptr<Command> make_check_imu_command() { return std::make_unique<CheckImuCommand>(); }

}  // namespace pled::apps
