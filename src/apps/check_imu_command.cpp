#include <cmath>
#include <cstddef>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include <CLI/CLI.hpp>

#include "drivers/replay/recording.hpp"
#include "pled_vins/config/calibration.hpp"
#include "pled_vins/imu/truth_check.hpp"
#include "src/apps/commands.hpp"
#include "src/apps/derived_truth.hpp"
#include "src/apps/problems.hpp"
#include "src/apps/text.hpp"

namespace pled::apps {
namespace {

/// Mean e^T P^-1 e per degree of freedom is 1 when P is right. These bounds do not show that: a
/// reference's noise is known to a factor only, so they are a check of plausibility. Above: errors
/// 1.7 times those expected (vibration, scale and axis errors of an IMU, which P leaves out).
/// Below: a third, where the errors of a smoothed reference cancel between the two ends.
constexpr double kMinNeesPerDof = 0.1;
constexpr double kMaxNeesPerDof = 3.0;

/// Of the reference systems that write velocity and biases; Ours: a motion-capture
/// or laser-tracker truth after smoothing, one axis.
constexpr TruthUncertainty kStatedUncertainty{
    .position_m = 1e-3, .attitude_rad = 1e-3, .velocity_mps = 1e-2};

NavState to_state(const replay::TruthState& truth) {
  NavState state;
  state.t = truth.t;
  state.p_wb = Eigen::Vector3d::Map(truth.p_world_body_m.data());
  state.q_wb = Eigen::Quaterniond(truth.q_world_body_xyzw.data()).normalized();
  if (!truth.has_motion) return state;
  state.v_wb = Eigen::Vector3d::Map(truth.v_world_body_mps.data());
  state.bg = Eigen::Vector3d::Map(truth.gyro_bias_radps.data());
  state.ba = Eigen::Vector3d::Map(truth.accel_bias_mps2.data());
  return state;
}

/// Of the mean over `intervals` of a normalised error with 9 degrees of freedom, per degree of
/// freedom, when P is right and the intervals are independent: 95 % of chi^2 (Wilson and
/// Hilferty). side: -1 or 1.
double bound_95(std::size_t intervals, double side) {
  const double a = 2.0 / (9.0 * 9.0 * static_cast<double>(intervals));
  return std::pow(1.0 - a + side * 1.959964 * std::sqrt(a), 3.0);
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
           "  pled-vins check-imu mav0 --config my.yaml\n"
           "P of the normalised error e^T P^-1 e holds the IMU's noise and the truth's. The\n"
           "truth's is measured while the body stands at its start; where it never does, it is\n"
           "the default of 1 mm, 1 mrad, 1 cm/s; where the truth is poses alone (a simulator's),\n"
           "they are taken as exact. Exit 1 when a normalised error is implausible.";
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
    sigma_option(app, "--position-sigma", stated_.position_m, "m");
    sigma_option(app, "--attitude-sigma", stated_.attitude_rad, "rad");
    sigma_option(app, "--velocity-sigma", stated_.velocity_mps, "m/s");
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
    if (!has_motion_ && !derive(imu, noise, truth)) return ExitCode::kFailed;
    return check_all(truth, imu, noise);
  }

 private:
  void sigma_option(CLI::App& app, const char* name, double& sigma, const char* unit) {
    app.add_option_function<double>(
           name,
           [this, &sigma](const double& value) {
             sigma = value;
             is_stated_ = true;
           },
           std::string("Of one axis of the truth, ") + unit +
               " (default: as measured while it stands still)")
        ->check(CLI::NonNegativeNumber);
  }

  /// Velocity and biases for a truth of poses alone.
  bool derive(const std::vector<ImuSample>& imu, const ImuNoise& noise,
              std::vector<NavState>& truth) {
    std::optional<DerivedTruth> derived = derive_motion(truth, imu, noise);
    if (!derived) {
      print_error(
          "the truth has no velocity and biases, and fewer than 100 poses a second or less than "
          "1.5 s of them, so they cannot be derived: name a EuRoC csv that has them with --truth");
      return false;
    }
    truth = std::move(derived->states);
    derived_ = derived->uncertainty;
    print_note(
        "the truth has no velocity and biases: its poses are taken as exact, the velocity is their "
        "central difference, and each bias is measured in the second before its interval");
    return true;
  }

  struct Model {
    const char* name;
    TruthUncertainty uncertainty;
  };
  [[nodiscard]] Model model(const std::vector<NavState>& truth, const std::vector<ImuSample>& imu,
                            double interval_s) const {
    if (is_stated_) return {"stated", stated_};
    if (!has_motion_) return {"derived", derived_};
    if (const auto measured = measure_standing_truth(truth, imu, interval_s))
      return {"standing", *measured};
    return {"default", stated_};
  }

  [[nodiscard]] ExitCode check_all(const std::vector<NavState>& truth,
                                   const std::vector<ImuSample>& imu, const ImuNoise& noise) const {
    std::printf(
        "interval_s  compared  skipped    nees  nees_p  nees_q  nees_v  "
        "nees_95       rms_p_m   rms_q_rad  rms_v_mps  model     plausible\n");
    bool compared = false;
    bool plausible = true;
    std::vector<std::pair<double, Model>> models;
    for (const double interval_s : intervals_s_) {
      const Model& m = models.emplace_back(interval_s, model(truth, imu, interval_s)).second;
      const PreintegrationCheck c =
          check_preintegration(truth, imu, interval_s, noise, m.uncertainty);
      bool inside = true;
      for (const double nees : {c.mean_nees_per_dof, c.position_nees_per_dof,
                                c.attitude_nees_per_dof, c.velocity_nees_per_dof})
        inside = inside && nees >= kMinNeesPerDof && nees <= kMaxNeesPerDof;
      compared = compared || c.compared > 0;
      plausible = plausible && (inside || c.compared == 0);
      std::printf(
          "%10.3f  %8zu  %7zu  %6.3f  %6.3f  %6.3f  %6.3f  %5.3f..%5.3f  %.6f  %.7f  %.6f   %-8s  "
          "%s\n",
          interval_s, c.compared, c.skipped, c.mean_nees_per_dof, c.position_nees_per_dof,
          c.attitude_nees_per_dof, c.velocity_nees_per_dof, bound_95(c.compared, -1.0),
          bound_95(c.compared, 1.0), c.position_rms_m, c.attitude_rms_rad, c.velocity_rms_mps,
          m.name, inside ? "yes" : "no");
    }
    std::printf(
        "nees_95: where nees (per degree of freedom) lies in 95 of 100 cases if P is right and "
        "the\n"
        "intervals are independent; plausible: nees and its three parts within %g and %g\n",
        kMinNeesPerDof, kMaxNeesPerDof);
    for (const auto& [interval_s, m] : models) print_model(interval_s, m);
    if (!compared) print_error("nothing was compared: truth and IMU do not overlap long enough");
    if (!plausible) print_error("a normalised error is outside its bounds");
    return compared && plausible ? ExitCode::kDone : ExitCode::kFailed;
  }

  static void print_model(double interval_s, const Model& m) {
    const TruthUncertainty& u = m.uncertainty;
    std::printf(
        "truth, %s, over %g s: %.3g m, %.3g rad, %.3g m/s, gyro bias %.3g rad/s, "
        "accelerometer bias %.3g m/s^2, tilt %.3g rad\n",
        m.name, interval_s, u.position_m, u.attitude_rad, u.velocity_mps, u.gyro_bias_radps,
        u.accel_bias_mps2, u.frame_tilt_rad);
  }

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
                  std::vector<NavState>& out) {
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
      has_motion_ = has_motion_ && state.value().has_motion;
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
  TruthUncertainty stated_ = kStatedUncertainty;
  TruthUncertainty derived_;
  bool is_stated_ = false;
  bool has_motion_ = true;
};

}  // namespace

std::unique_ptr<Command> make_check_imu_command() { return std::make_unique<CheckImuCommand>(); }

}  // namespace pled::apps
