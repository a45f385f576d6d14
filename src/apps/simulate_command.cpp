#include <cstdio>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include <CLI/CLI.hpp>

#include "pled_vins/sim/simulator.hpp"
#include "src/apps/commands.hpp"
#include "src/apps/progress.hpp"
#include "src/apps/text.hpp"

namespace pled::apps {
namespace {

namespace fs = std::filesystem;

const std::map<std::string, sim::MovingLevel> kLevels{{"none", sim::MovingLevel::kNone},
                                                      {"low", sim::MovingLevel::kLow},
                                                      {"mid", sim::MovingLevel::kMid},
                                                      {"high", sim::MovingLevel::kHigh}};
const std::map<std::string, sim::Daylight> kLights{
    {"day", sim::Daylight::kDay}, {"dim", sim::Daylight::kDim}, {"night", sim::Daylight::kNight}};
const std::map<std::string, sim::MotionKind> kMotions{{"still", sim::MotionKind::kStill},
                                                      {"drone", sim::MotionKind::kDrone},
                                                      {"hand", sim::MotionKind::kHandheld},
                                                      {"car", sim::MotionKind::kCar}};

class SimulateCommand final : public Command {
 public:
  std::string_view name() const noexcept override { return "simulate"; }
  std::string_view summary() const noexcept override {
    return "Make a recording from nothing: frames, events, IMU, truth and labels";
  }
  std::string_view examples() const noexcept override {
    return "  pled-vins simulate --out demo\n"
           "  pled-vins simulate --out busy --preset street --seed 7 --moving high --light night\n"
           "  pled-vins simulate --out two --preset room --second-camera --depth\n"
           "  pled-vins simulate --out late --preset room --camera-late 0.03 --imu-gap 2.5 0.5\n"
           "  pled-vins simulate --out mine --preset room --path walk.tum";
  }

  void declare(CLI::App& app) override {
    app.add_option("--out", out_, "Folder to write")->required();
    app.add_option("--preset", preset_, "Ready-made options")
        ->check(CLI::IsMember(
            std::vector<std::string>(sim::kPresetNames.begin(), sim::kPresetNames.end())))
        ->capture_default_str();
    app.add_option("--seed", seed_, "Same seed, same bytes")
        ->check(CLI::NonNegativeNumber)
        ->capture_default_str();
    app.add_option("--duration", duration_s_, "Length, s (default: the preset's)");
    app.add_option("--moving", moving_, "How much moves by itself (default: the preset's)")
        ->transform(CLI::CheckedTransformer(kLevels));
    app.add_option("--light", daylight_, "Light (default: the preset's)")
        ->transform(CLI::CheckedTransformer(kLights));
    app.add_option("--motion", motion_, "How the rig moves (default: the preset's)")
        ->transform(CLI::CheckedTransformer(kMotions));
    app.add_option("--speed", speed_mps_, "Of a car, m/s (default: 5)");
    app.add_option("--path", path_file_,
                   "TUM file to follow, body axes x right, y down, z forward; moved so that its "
                   "middle lies in the middle of the world");
    app.add_flag("--second-camera", second_camera_,
                 "Events from a camera of their own, 346x260, 4 cm beside the frames'");
    app.add_flag("--depth", depth_, "Write depth pictures too (16-bit PNG, mm)");
    app.add_flag("--text-events", text_events_, "Events as text, not as Prophesee RAW");
    app.add_option("--camera-late", faults_.camera_late_s,
                   "Stamp frames and events too late by this, s; the calibration is not told");
    app.add_option("--imu-drift", faults_.imu_drift_ppm, "The IMU's clock runs fast, ppm");
    app.add_option("--imu-gap", imu_gap_, "No inertial samples: from, for how long, s")
        ->expected(2);
    app.add_option("--drop-frames", faults_.dropped_share, "Share of frames to lose, 0 ... 0.9");
    app.add_option("--flicker", faults_.flicker_hz, "Flickering light, Hz");
    app.add_option("--flash", faults_.flash_at_s, "A flash at this time, s: a burst of events");
    app.add_flag("--force", force_, "Replace a recording that is there");
  }

  ExitCode run() override {
    std::optional<sim::SimulationOptions> options = sim::preset(preset_);
    if (!options) return misused("unknown preset " + preset_);
    options->seed = seed_;
    if (duration_s_) options->duration_s = *duration_s_;
    if (moving_) options->moving = *moving_;
    if (daylight_) sim::set_daylight(*options, *daylight_);
    if (motion_) options->motion = *motion_;
    if (speed_mps_) options->speed_mps = *speed_mps_;
    options->path_file = path_file_;
    options->with_depth = depth_;
    options->text_events = text_events_;
    if (second_camera_) options->event_camera = sim::camera_beside(options->camera);
    options->faults = faults_;
    if (imu_gap_.size() == 2) {
      options->faults.imu_gap_at_s = imu_gap_[0];
      options->faults.imu_gap_s = imu_gap_[1];
    }
    const ConfigIssue issue = sim::check(*options);
    if (issue.key != nullptr) return misused(std::string(issue.key) + " " + issue.rule);

    std::error_code ignored;  // a folder that cannot be read is found out when writing
    if (!force_ && fs::exists(out_, ignored) && !fs::is_empty(out_, ignored)) {
      print_error(out_ + " is there and not empty; --force replaces the recording in it");
      return ExitCode::kFailed;
    }
    return write(*options);
  }

 private:
  static ExitCode misused(const std::string& text) {
    print_error(text);
    return ExitCode::kMisused;
  }

  ExitCode write(const sim::SimulationOptions& options) const {
    Progress progress = Progress::on_stderr(options.duration_s);
    const Result<sim::SimulationSummary> result = sim::simulate(
        options, out_, [&](double share) { progress.update(share * options.duration_s); });
    if (!result.ok() && !path_file_.empty() && result.error().code != ErrorCode::kIoFailure &&
        result.error().code != ErrorCode::kTooLarge) {
      print_error("cannot follow the path in " + path_file_ + ": " +
                  std::string(to_string(result.error().code)) +
                  "; it must have at least 8 lines 't tx ty tz qx qy qz qw' with increasing times");
      return ExitCode::kFailed;
    }
    if (!result.ok()) {
      print_error("cannot write the recording to " + out_ + ": " +
                  std::string(to_string(result.error().code)));
      return ExitCode::kFailed;
    }
    progress.finish();
    const sim::SimulationSummary& s = result.value();
    std::printf("%-10s %s\n%-10s %.3f s, %.2f m\n", "recording", out_.c_str(), "flight",
                s.duration_s, s.path_m);
    std::printf("%-10s %llu\n%-10s %llu\n%-10s %llu\n", "frames",
                static_cast<unsigned long long>(s.frames), "imu",
                static_cast<unsigned long long>(s.imu_samples), "events",
                static_cast<unsigned long long>(s.events));
    return ExitCode::kDone;
  }

  std::string out_;
  std::string preset_ = "demo";
  std::string path_file_;
  std::uint64_t seed_ = 1;
  std::optional<double> duration_s_;
  std::optional<double> speed_mps_;
  std::optional<sim::MovingLevel> moving_;
  std::optional<sim::Daylight> daylight_;
  std::optional<sim::MotionKind> motion_;
  std::vector<double> imu_gap_;
  sim::FaultOptions faults_;
  bool second_camera_ = false;
  bool depth_ = false;
  bool text_events_ = false;
  bool force_ = false;
};

}  // namespace

std::unique_ptr<Command> make_simulate_command() { return std::make_unique<SimulateCommand>(); }

}  // namespace pled::apps
