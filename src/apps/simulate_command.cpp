#include <cstdio>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "pled_vins/sim/simulator.hpp"
#include "src/apps/commands.hpp"
#include "src/apps/progress.hpp"
#include "src/apps/simulate_request.hpp"
#include "src/apps/text.hpp"

namespace pled::apps {
namespace {

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
           "  pled-vins simulate --out bus --preset car_park --bus 4 3 2\n"
           "  pled-vins simulate --out late --preset room --camera-late 0.03 --imu-gap 2.5 0.5\n"
           "  pled-vins simulate --out mine --preset room --path walk.tum";
  }

  void declare(CLI::App& app) override {
    const std::vector<std::string> presets(sim::kPresetNames.begin(), sim::kPresetNames.end());
    // The library would take -1 for the largest number.
    const CLI::Validator digits(
        [](const std::string& text) {
          const bool good = text.find_first_not_of("0123456789") == std::string::npos;
          return good ? std::string() : "must be a whole number from 0, not " + text;
        },
        "");
    app.add_option("--out", r_.out, "Folder to write")->required();
    app.add_option("--preset", r_.preset, "Ready-made options")
        ->check(CLI::IsMember(presets))
        ->capture_default_str();
    app.add_option("--seed", r_.seed, "Same seed, same bytes")
        ->check(digits)
        ->capture_default_str();
    app.add_option("--duration", r_.duration_s,
                   "Length, s (default: the preset's, with --path the path's)");
    app.add_option("--moving", r_.moving, "How much moves by itself (default: the preset's)")
        ->check(CLI::IsMember(moving_names()));
    app.add_option("--light", r_.daylight, "Light (default: the preset's)")
        ->check(CLI::IsMember(light_names()));
    app.add_option("--motion", r_.motion, "How the rig moves (default: the preset's)")
        ->check(CLI::IsMember(motion_names()));
    app.add_option("--speed", r_.speed_mps, "Of a car, m/s, 1 ... 20 (default: 5)");
    app.add_option("--bus", r_.bus,
                   "A bus drives across the view: when, for how long it stands there (0: drives "
                   "by), s, and how far away, m (from 2 m it fills the view)")
        ->expected(3);
    app.add_option("--surfaces", r_.surfaces,
                   "How everything looks: as what it is, in round spots where no straight edge is, "
                   "or striped all over (default: usual)")
        ->check(CLI::IsMember(surface_names()));
    app.add_option("--path", r_.path_file,
                   "TUM file to follow: world z up, body axes x right, y down, z forward; moved so "
                   "that its middle lies in the middle of the world");
    app.add_flag("--second-camera", r_.second_camera,
                 "Events from a camera of their own, 346x260, 4 cm beside the frames'; its "
                 "settings.yaml tells replay which camera is which");
    app.add_flag("--depth", r_.depth,
                 "Write depth pictures too, listed in depth.txt (16-bit PNG, mm along the optical "
                 "axis, 0: beyond 65.5 m)");
    app.add_flag("--text-events", r_.text_events, "Events as text, not as Prophesee RAW");
    app.add_option("--camera-late", r_.faults.camera_late_s,
                   "Stamp frames and events too late by this, s, -0.2 ... 0.2; the calibration is "
                   "not told");
    app.add_option("--imu-drift", r_.faults.imu_drift_ppm, "The IMU's clock runs fast, ppm");
    app.add_option("--imu-gap", r_.imu_gap_s, "No inertial samples: from, for how long, s")
        ->expected(2);
    app.add_option("--drop-frames", r_.faults.dropped_share, "Share of frames to lose, 0 ... 0.9");
    app.add_option("--flicker", r_.faults.flicker_hz, "Flickering light, Hz, 0 ... 500");
    app.add_option("--flash", r_.flash_at_s, "A flash at this time, s: a burst of events");
    app.add_flag("--force", r_.force, "Replace a recording that is there");
  }

  ExitCode run() override {
    const RequestedOptions requested = requested_options(r_);
    if (!requested.refusal.empty()) {
      print_error(requested.refusal);
      return requested.misused ? ExitCode::kMisused : ExitCode::kFailed;
    }
    if (const std::string refusal = output_refusal(r_); !refusal.empty()) {
      print_error(refusal);
      return r_.out.empty() ? ExitCode::kMisused : ExitCode::kFailed;
    }
    return write(requested.options);
  }

 private:
  ExitCode write(const sim::SimulationOptions& options) const {
    Progress progress = Progress::on_stderr(options.duration_s);
    const Result<sim::SimulationSummary> result = sim::simulate(
        options, r_.out, [&](double share) { progress.update(share * options.duration_s); });
    if (!result.ok()) {
      print_error(failure_words(r_, result.error()));
      return ExitCode::kFailed;
    }
    progress.finish();
    const sim::SimulationSummary& s = result.value();
    std::printf("%-10s %s\n%-10s %.3f s, %.2f m\n", "recording", r_.out.c_str(), "flight",
                s.duration_s, s.path_m);
    std::printf("%-10s %llu\n%-10s %llu\n%-10s %llu\n", "frames",
                static_cast<unsigned long long>(s.frames), "imu",
                static_cast<unsigned long long>(s.imu_samples), "events",
                static_cast<unsigned long long>(s.events));
    if (s.frames < 2)
      print_warning("the faults asked for left " + std::to_string(s.frames) +
                    " frames: nothing can start from it");
    return ExitCode::kDone;
  }

  SimulateRequest r_;
};

}  // namespace

std::unique_ptr<Command> make_simulate_command() { return std::make_unique<SimulateCommand>(); }

}  // namespace pled::apps
