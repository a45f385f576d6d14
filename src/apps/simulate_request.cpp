#include "src/apps/simulate_request.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string_view>
#include <system_error>
#include <utility>

#include "pled_vins/core/check.hpp"
#include "pled_vins/sim/trajectory.hpp"

namespace pled::apps {
namespace {

namespace fs = std::filesystem;

template <typename... Values>
std::string format(const char* pattern, Values... values) {
  std::array<char, 256> text{};
  std::snprintf(text.data(), text.size(), pattern, values...);
  return text.data();
}

template <typename Value>
using Named = std::pair<std::string_view, Value>;

constexpr std::array kLevels{Named<sim::MovingLevel>{"none", sim::MovingLevel::kNone},
                             Named<sim::MovingLevel>{"low", sim::MovingLevel::kLow},
                             Named<sim::MovingLevel>{"mid", sim::MovingLevel::kMid},
                             Named<sim::MovingLevel>{"high", sim::MovingLevel::kHigh}};
constexpr std::array kLights{Named<sim::Daylight>{"day", sim::Daylight::kDay},
                             Named<sim::Daylight>{"dim", sim::Daylight::kDim},
                             Named<sim::Daylight>{"night", sim::Daylight::kNight}};
constexpr std::array kMotions{Named<sim::MotionKind>{"still", sim::MotionKind::kStill},
                              Named<sim::MotionKind>{"drone", sim::MotionKind::kDrone},
                              Named<sim::MotionKind>{"hand", sim::MotionKind::kHandheld},
                              Named<sim::MotionKind>{"car", sim::MotionKind::kCar}};

constexpr std::array kSurfaces{Named<sim::Surfaces>{"usual", sim::Surfaces::kUsual},
                               Named<sim::Surfaces>{"pebbles", sim::Surfaces::kPebbles},
                               Named<sim::Surfaces>{"stripes", sim::Surfaces::kStripes}};

template <typename List>
std::vector<std::string> names_of(const List& list) {
  std::vector<std::string> names;
  for (const auto& [name, value] : list) names.emplace_back(name);
  return names;
}

/// The command line lets no other name through.
template <typename List>
auto value_of(const List& list, std::string_view name) {
  const auto found = std::find_if(list.begin(), list.end(),
                                  [&](const auto& named) { return named.first == name; });
  PLED_CHECK(found != list.end());
  return found->second;
}

/// The option that sets a key of sim::check().
std::string option_of(std::string_view key) {
  constexpr std::pair<std::string_view, std::string_view> kOptions[] = {
      {"duration", "--duration"},
      {"speed", "--speed"},
      {"bus.time", "--bus"},
      {"bus.away", "--bus"},
      {"faults.camera_late", "--camera-late"},
      {"faults.imu_drift", "--imu-drift"},
      {"faults.imu_gap", "--imu-gap"},
      {"faults.dropped_frames", "--drop-frames"},
      {"faults.flicker", "--flicker"},
      {"faults.flash", "--flash"}};
  for (const auto& [known, option] : kOptions)
    if (known == key) return std::string(option);
  return std::string(key);
}

/// What contradicts itself, or would have no effect.
std::string contradiction(const SimulateRequest& r, const sim::SimulationOptions& o) {
  if (!r.path_file.empty() && (r.motion || r.speed_mps))
    return "--path says how the rig moves: leave out --motion and --speed";
  if (r.speed_mps && o.motion != sim::MotionKind::kCar)
    return "--speed is that of a car: add --motion car, or take --preset street or night";
  if (r.path_file.empty() && o.motion == sim::MotionKind::kCar &&
      o.world != sim::WorldKind::kStreet)
    return "--motion car needs a road: take --preset street or night";
  if (!r.bus.empty() && o.world == sim::WorldKind::kRoom)
    return "--bus needs a road: take --preset demo, car_park, street or night";
  if (!r.bus.empty() && !(r.bus[0] >= 0.0 && r.bus[0] < o.duration_s))
    return format("--bus must come in the recording: from 0 to %g s", o.duration_s);
  if (r.flash_at_s && !(*r.flash_at_s >= 0.0 && *r.flash_at_s < o.duration_s))
    return format("--flash must be in the recording: from 0 to %g s", o.duration_s);
  if (!r.imu_gap_s.empty()) {
    const double from_s = r.imu_gap_s[0], to_s = from_s + r.imu_gap_s[1];
    if (!(from_s < o.duration_s))
      return format("--imu-gap must begin in the recording: from 0 to %g s", o.duration_s);
    if (from_s <= 0.0 && to_s > o.duration_s) return "--imu-gap would leave no inertial sample";
  }
  return {};
}

std::string path_refusal(const SimulateRequest& r, sim::SimulationOptions& o) {
  const Result<std::unique_ptr<sim::Trajectory>> path = sim::make_trajectory(o);
  if (!path.ok()) {
    const Error error = path.error();
    switch (error.code) {
      case ErrorCode::kNotFound: return r.path_file + ": cannot be read, or is not there";
      case ErrorCode::kCorrupt:
        return r.path_file + format(":%lld: ", static_cast<long long>(error.detail)) +
               "is no line 't tx ty tz qx qy qz qw', with a later time than the one before and a "
               "quaternion of length 1";
      case ErrorCode::kUnsupported: return r.path_file + ": has fewer than 8 poses";
      case ErrorCode::kTooLarge: return r.path_file + ": is longer than an hour: cut a part of it";
      default: return r.path_file + ": " + std::string(to_string(error.code));
    }
  }
  const double longest_s = path.value()->longest_s();
  if (!r.duration_s) o.duration_s = std::min(longest_s, 600.0);
  if (o.duration_s > longest_s)
    return format("--duration %g is more than the path has: ", o.duration_s) + r.path_file +
           format(" is %.3f s long", longest_s);
  return {};
}

}  // namespace

std::vector<std::string> moving_names() { return names_of(kLevels); }
std::vector<std::string> light_names() { return names_of(kLights); }
std::vector<std::string> motion_names() { return names_of(kMotions); }
std::vector<std::string> surface_names() { return names_of(kSurfaces); }

RequestedOptions requested_options(const SimulateRequest& r) {
  const std::optional<sim::SimulationOptions> preset = sim::preset(r.preset);
  if (!preset) return {{}, "there is no preset " + r.preset};
  RequestedOptions out{*preset, {}};
  sim::SimulationOptions& o = out.options;
  o.seed = r.seed;
  if (r.duration_s) o.duration_s = *r.duration_s;
  if (r.moving) o.moving = value_of(kLevels, *r.moving);
  if (r.daylight) sim::set_daylight(o, value_of(kLights, *r.daylight));
  if (r.motion) o.motion = value_of(kMotions, *r.motion);
  if (r.speed_mps) o.speed_mps = *r.speed_mps;
  if (r.surfaces) o.surfaces = value_of(kSurfaces, *r.surfaces);
  if (r.bus.size() == 3) o.bus = {r.bus[0], r.bus[1], r.bus[2]};
  o.path_file = r.path_file;
  o.with_depth = r.depth;
  o.text_events = r.text_events;
  if (r.second_camera) o.event_camera = sim::camera_beside(o.camera);
  o.faults = r.faults;
  if (r.flash_at_s) o.faults.flash_at_s = *r.flash_at_s;
  if (r.imu_gap_s.size() == 2) {
    o.faults.imu_gap_at_s = r.imu_gap_s[0];
    o.faults.imu_gap_s = r.imu_gap_s[1];
  }
  if (const ConfigIssue issue = sim::check(o); issue.key != nullptr) {
    out.refusal = option_of(issue.key) + " " + issue.rule;
    return out;
  }
  if (!r.path_file.empty()) {
    out.refusal = path_refusal(r, o);
    out.misused = false;
  }
  if (out.refusal.empty()) {
    out.refusal = contradiction(r, o);
    out.misused = true;
  }
  return out;
}

std::string output_refusal(const SimulateRequest& r) {
  if (r.out.empty()) return "--out is empty: name a folder";
  std::error_code ignored;  // a folder that cannot be read is found out when writing
  if (!fs::exists(r.out, ignored)) return {};
  if (!fs::is_directory(r.out, ignored)) return r.out + " is not a folder: name one";
  if (fs::is_empty(r.out, ignored)) return {};
  // Only what simulate() made itself may be replaced.
  if (!fs::exists(fs::path(r.out) / "camchain.yaml", ignored))
    return r.out + " holds something else than a recording: name a new folder";
  if (!r.force) return r.out + " is there and not empty; --force replaces the recording in it";
  return {};
}

std::string failure_words(const SimulateRequest& r, Error error) {
  switch (error.code) {
    case ErrorCode::kUnsupported:
      return format("the motion meets a wall or leaves the world at %.2f s: ",
                    static_cast<double>(error.detail) * 1e-3) +
             "take a smaller path, a shorter --duration or another --preset";
    case ErrorCode::kTooLarge: return "not enough memory";
    default: break;
  }
  std::string words = "cannot write the recording to " + r.out + ": ";
  if (error.code == ErrorCode::kIoFailure && error.detail > 0)
    return words + std::strerror(static_cast<int>(error.detail));
  return words + std::string(to_string(error.code));
}

}  // namespace pled::apps
