#include <cstdio>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "drivers/replay/recording.hpp"
#include "drivers/replay/recording_info.hpp"
#include "pled_vins/config/calibration.hpp"
#include "src/apps/commands.hpp"
#include "src/apps/json_number.hpp"
#include "src/apps/problems.hpp"
#include "src/apps/progress.hpp"
#include "src/apps/recording_sizes.hpp"
#include "src/apps/settings.hpp"
#include "src/apps/text.hpp"

namespace pled::apps {
namespace {

using Json = nlohmann::ordered_json;

/// A value that means something only when the stream holds anything.
Json known(bool is_known, double value) { return is_known ? json_number(value) : Json(nullptr); }

Json size_or_null(int pixels) { return pixels > 0 ? Json(pixels) : Json(nullptr); }

Json to_json(const replay::RecordingInfo& info, const std::vector<std::string>& problems) {
  const replay::EventInfo& e = info.events;
  const replay::ImuInfo& i = info.imu;
  const replay::FrameInfo& f = info.frames;
  Json out;
  out["events"] = {{"count", e.count},
                   {"first_s", e.count > 0 ? json_seconds(e.first_s) : Json(nullptr)},
                   {"last_s", e.count > 0 ? json_seconds(e.last_s) : Json(nullptr)},
                   {"rate_hz", known(e.count > 1, e.rate_hz)},
                   {"width", size_or_null(e.width)},
                   {"height", size_or_null(e.height)}};
  out["imu"] = {{"count", i.count}, {"rate_hz", known(i.count > 1, i.rate_hz)}, {"gaps", i.gaps}};
  out["frames"] = {{"count", f.count},
                   {"first_s", f.count > 0 ? json_seconds(f.first_s) : Json(nullptr)},
                   {"last_s", f.count > 0 ? json_seconds(f.last_s) : Json(nullptr)},
                   {"rate_hz", known(f.count > 1, f.rate_hz)},
                   {"width", size_or_null(f.width)},
                   {"height", size_or_null(f.height)},
                   {"gaps", f.gaps}};
  out["masks"] = {{"count", info.masks.count}};
  if (info.triggers.present) out["triggers"] = {{"count", info.triggers.count}};
  out["problems"] = problems;
  return out;
}

void print_text(const replay::RecordingInfo& info, const std::vector<std::string>& problems) {
  const replay::EventInfo& e = info.events;
  const replay::ImuInfo& i = info.imu;
  const replay::FrameInfo& f = info.frames;
  if (e.count > 0)
    std::printf("events    %llu, %.6f ... %.6f s, %.0f Hz, %d x %d\n",
                static_cast<unsigned long long>(e.count), e.first_s, e.last_s, e.rate_hz, e.width,
                e.height);
  if (i.count > 0)
    std::printf("imu       %llu, %.6f ... %.6f s, %.1f Hz, %llu gaps\n",
                static_cast<unsigned long long>(i.count), i.first_s, i.last_s, i.rate_hz,
                static_cast<unsigned long long>(i.gaps));
  if (f.count > 0)
    std::printf("frames    %llu, %.6f ... %.6f s, %.2f Hz, %d x %d\n",
                static_cast<unsigned long long>(f.count), f.first_s, f.last_s, f.rate_hz, f.width,
                f.height);
  if (info.truth.count > 0)
    std::printf("truth     %llu, %.6f ... %.6f s\n",
                static_cast<unsigned long long>(info.truth.count), info.truth.first_s,
                info.truth.last_s);
  if (info.masks.present)
    std::printf("masks     %llu\n", static_cast<unsigned long long>(info.masks.count));
  if (info.triggers.count > 0)
    std::printf("triggers  %llu, not used\n", static_cast<unsigned long long>(info.triggers.count));
  if (problems.empty()) std::printf("problems  none\n");
  for (const std::string& problem : problems) std::printf("problem   %s\n", problem.c_str());
}

class InfoCommand final : public Command {
 public:
  std::string_view name() const noexcept override { return "info"; }
  std::string_view summary() const noexcept override {
    return "Say what a recording or an event file holds and what is wrong with it";
  }
  std::string_view examples() const noexcept override {
    return "  pled-vins info recording\n"
           "  pled-vins info recording/events.raw --json\n"
           "  pled-vins info recording --config my.yaml";
  }

  void declare(CLI::App& app) override {
    app.add_option("RECORDING", path_,
                   "Recording folder, EuRoC mav0 folder, AEDAT file or event file")
        ->required();
    app.add_option("--config", config_,
                   "Settings file (YAML): which camera gives the events, where the calibration is");
    app.add_flag("--json", json_, "Print JSON");
  }

  ExitCode run() override {
    const std::optional<AppConfig> config = settings_for(path_, config_);
    if (!config) return ExitCode::kFailed;
    replay::Problems problems;
    auto recording = replay::Recording::open(path_, problems);
    if (!recording.ok()) return failed(problems);
    std::vector<std::string> words;
    apply_calibration(*config, recording.value(), words);
    Progress progress = Progress::share_on_stderr();
    const auto info =
        replay::survey(recording.value(), problems, [&](double share) { progress.update(share); });
    progress.finish();
    if (!info.ok()) return failed(problems);
    for (const replay::Problem& problem : problems) words.push_back(to_string(problem));
    words.insert(words.end(), info.value().problems.begin(), info.value().problems.end());
    if (json_)
      std::printf(
          "%s\n",
          to_json(info.value(), words).dump(2, ' ', false, Json::error_handler_t::replace).c_str());
    else
      print_text(info.value(), words);
    return ExitCode::kDone;
  }

 private:
  /// The sizes of the cameras. A calibration that cannot be read or contradicts the data
  /// is one of the recording's problems.
  void apply_calibration(const AppConfig& config, replay::Recording& recording,
                         std::vector<std::string>& words) const {
    if (recording.files().camchain.empty() && config.calibration.camchain.empty()) {
      // Without a calibration nothing tells of a second camera: a DAVIS is both in one.
      if (recording.event_size() == replay::ImageSize{})
        recording.set_event_size(recording.frame_size());
      return;
    }
    const auto loaded = load_recording_cameras(path_, config);
    if (const auto* error = std::get_if<ConfigError>(&loaded)) {
      words.push_back(error->message());
      return;
    }
    const auto& calibration = std::get<LoadedCalibration>(loaded);
    words.insert(words.end(), calibration.notes.begin(), calibration.notes.end());
    std::string problem = apply_calibrated_sizes(recording, calibration.rig);
    if (!problem.empty()) words.push_back(problem);
    if (problem.empty() && sensor_class(recording, problem) == nullptr) words.push_back(problem);
  }

  static ExitCode failed(const replay::Problems& problems) {
    if (!print_problems(problems)) print_error("the recording could not be read");
    return ExitCode::kFailed;
  }

  std::string path_;
  std::string config_;
  bool json_ = false;
};

}  // namespace

std::unique_ptr<Command> make_info_command() { return std::make_unique<InfoCommand>(); }

}  // namespace pled::apps
