#include "src/report/run_data.hpp"

#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <memory>
#include <utility>
#include <variant>

#include "drivers/replay/recording.hpp"
#include "pled_vins/evaluation/evaluate.hpp"
#include "src/report/feature_digest.hpp"
#include "src/report/moments_part.hpp"
#include "src/report/path_part.hpp"
#include "src/report/rates.hpp"

namespace pled::report {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMoments = 16;
constexpr double kFrameGapFactor = 1.5;
constexpr double kPoseGapFactor = 2.5;
constexpr double kImuGapFactor = 4.0;  // as `pled-vins info` counts them
constexpr std::int64_t kShortestImuGap_ns = 25'000'000;

std::optional<std::string> text_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) return std::nullopt;
  return std::string(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
}

/// One run on its way from files to figures.
class Loader {
 public:
  Loader(fs::path folder, std::string recording, std::size_t picture_bytes)
      : folder_(std::move(folder)),
        recording_path_(std::move(recording)),
        picture_bytes_(picture_bytes) {}

  RunData load() {
    if (read_report() && read_path() && (open_recording(), read_features())) {
      find_span();
      add_path();
      add_features();
      add_streams();
      run_.data["notes"] = run_.notes;
    }
    return std::move(run_);
  }

 private:
  bool fail(std::string text) {
    run_.error = std::move(text);
    return false;
  }
  void note(std::string text) { run_.notes.push_back(std::move(text)); }

  bool read_report();
  bool read_path();
  void open_recording();
  bool read_features();
  void find_span();
  void add_path();
  void add_features();
  void add_streams();
  [[nodiscard]] std::optional<Trajectory> read_truth();
  [[nodiscard]] Json imu_rates();

  fs::path folder_;
  std::string recording_path_;
  std::size_t picture_bytes_;
  RunData run_;
  Trajectory trajectory_;
  std::optional<replay::Recording> recording_;
  std::optional<FeatureDigest> features_;
  PlayedSpan span_;
};

bool Loader::read_report() {
  const fs::path file = folder_ / "report.json";
  const std::optional<std::string> text = text_of(file);
  if (!text)
    return fail(file.string() + ": cannot be read: " + std::strerror(errno) +
                "; is this a folder that 'pled-vins replay --out' wrote?");
  Json report;
  try {
    report = Json::parse(*text);
  } catch (const Json::parse_error& error) {
    return fail(file.string() + ": is not JSON: " + error.what());
  }
  if (!report.is_object()) return fail(file.string() + ": holds no report of a replay");
  const Json named = report.value("recording", Json());
  if (recording_path_.empty() && named.is_string()) recording_path_ = named.get<std::string>();
  const fs::path whole = fs::absolute(folder_).lexically_normal();
  run_.data["name"] = (whole.has_filename() ? whole : whole.parent_path()).filename().string();
  run_.data["folder"] = folder_.string();
  run_.data["report"] = std::move(report);
  const auto config = text_of(folder_ / "config.yaml");
  if (!config) note("config.yaml is not there: the settings of the run are unknown");
  run_.data["config"] = config ? Json(*config) : Json(nullptr);
  return true;
}

bool Loader::read_path() {
  auto read = read_trajectory(folder_ / "trajectory.tum");
  if (const auto* error = std::get_if<FileError>(&read)) return fail(error->message());
  trajectory_ = std::get<Trajectory>(std::move(read));
  return true;
}

void Loader::open_recording() {
  replay::Problems problems;
  auto opened = replay::Recording::open(recording_path_, problems);
  if (opened.ok()) {
    recording_ = std::move(opened).value();
    return;
  }
  const std::string why = problems.empty() ? "cannot be opened" : problems.back().text;
  note("without pictures, truth and sensor rates: the recording '" + recording_path_ + "': " + why);
}

bool Loader::read_features() {
  const fs::path file = folder_ / "features.csv";
  std::error_code ignored;
  if (!fs::exists(file, ignored)) {
    note("without features and weights: there is no " + file.string());
    return true;
  }
  auto digest = digest_features(file, recording_ ? &*recording_ : nullptr, kMoments);
  if (const auto* error = std::get_if<FileError>(&digest)) return fail(error->message());
  features_ = std::get<FeatureDigest>(std::move(digest));
  return true;
}

/// From the first processed frame to the last; without features.csv what the
/// trajectory and the report tell.
void Loader::find_span() {
  if (features_ && !features_->frames.empty()) {
    span_ = {features_->frames.front().stamp_ns, features_->frames.back().stamp_ns};
  } else if (!trajectory_.empty()) {
    span_ = {trajectory_.front().stamp_ns, trajectory_.back().stamp_ns};
    const Json started = run_.data["report"].value("initialised_at_s", Json());
    constexpr double kLongest_s = 1e6;  // of a report that was written over by something else
    if (started.is_number() && std::abs(started.get<double>()) < kLongest_s)
      span_.first_ns -= static_cast<std::int64_t>(started.get<double>() * 1e9);
  }
  run_.data["first_stamp_s"] = rounded(static_cast<double>(span_.first_ns) * 1e-9, 6);
  run_.data["length_s"] = since_s(span_.last_ns, span_.first_ns);
}

std::optional<Trajectory> Loader::read_truth() {
  if (!recording_ || !recording_->has(replay::Stream::kTruth)) return std::nullopt;
  auto read = read_trajectory(recording_->files().truth);
  if (const auto* error = std::get_if<FileError>(&read)) {
    note("without truth: " + error->message());
    return std::nullopt;
  }
  return std::get<Trajectory>(std::move(read));
}

void Loader::add_path() {
  const std::optional<Trajectory> truth = read_truth();
  Evaluation e;  // without truth: nothing is known, nothing is moved
  if (truth) e = evaluate(trajectory_, *truth, std::nullopt);
  run_.data["trajectory"] = path_of_estimate(trajectory_, e, span_.first_ns);
  run_.data["truth"] = truth ? path_of_truth(*truth, span_) : Json(nullptr);
  // The coverage is the replay's: it knows which part of the recording was played. The other
  // figures are told anew, from the files as they are; without truth they too are the replay's.
  Json replayed = run_.data["report"].value("accuracy", Json::object());
  if (!replayed.is_object()) {
    note("report.json: 'accuracy' is no object, it is left out");
    replayed = Json::object();
  }
  const auto figure = [&](const char* name, const std::optional<double>& value) {
    run_.data["accuracy"][name] = value ? Json(*value) : replayed.value(name, Json());
  };
  figure("ate_rmse_m", e.ate_rmse_m);
  figure("mpe_percent", e.mpe_percent);
  figure("rpe_trans_m", e.rpe_trans_m);
  figure("rpe_rot_deg", e.rpe_rot_deg);
  figure("coverage", std::nullopt);
}

Json histogram(const char* name, const Histogram& h) {
  if (h.empty()) return {{"name", name}, {"still", nullptr}, {"moving", nullptr}};
  return {{"name", name}, {"still", h.still}, {"moving", h.moving}};
}

void Loader::add_features() {
  if (!features_) {
    run_.data["features"] = nullptr;
    return;
  }
  // As many frames as the page has room for; the counts change slowly.
  constexpr std::size_t kMaxFrames = 2500;
  const std::size_t step = (features_->frames.size() + kMaxFrames - 1) / kMaxFrames;
  Json f = {{"labelled", features_->labelled}};
  for (const char* name : {"t_s", "image_points", "event_points", "lines", "used",
                           "event_points_used", "moving", "mean_w", "temporal_image",
                           "temporal_image_moving", "temporal_event", "temporal_event_moving"})
    f[name] = Json::array();
  for (std::size_t i = 0; i < features_->frames.size(); i += step) {
    const FrameStats& frame = features_->frames[i];
    f["t_s"].push_back(since_s(frame.stamp_ns, span_.first_ns));
    f["image_points"].push_back(frame.tracked[0]);
    f["event_points"].push_back(frame.tracked[1]);
    f["lines"].push_back(frame.tracked[2]);
    f["used"].push_back(frame.used);
    f["event_points_used"].push_back(frame.event_points_used);
    f["moving"].push_back(frame.moving);
    f["mean_w"].push_back(rounded(frame.mean_w, 3));
    f["temporal_image"].push_back(rounded(frame.image_points.still, 3));
    f["temporal_image_moving"].push_back(rounded(frame.image_points.moving, 3));
    f["temporal_event"].push_back(rounded(frame.event_points.still, 3));
    f["temporal_event_moving"].push_back(rounded(frame.event_points.moving, 3));
  }
  run_.data["features"] = std::move(f);
  run_.data["histograms"] = {histogram("w", features_->w),
                             histogram("w_temporal", features_->w_temporal),
                             histogram("w_geometric", features_->w_geometric)};
}

Json Loader::imu_rates() {
  replay::Problems ignored;
  auto opened = recording_->open_imu(ignored);
  if (!opened.ok()) return nullptr;
  std::vector<std::int64_t> stamps_ns;
  while (true) {
    const auto sample = opened.value()->read(Duration{});
    if (sample.ok()) stamps_ns.push_back(sample.value().t.us * 1000);
    if (!sample.ok() && sample.error().code != ErrorCode::kBadNumber) break;
  }
  return rates_of(stamps_ns, span_, kImuGapFactor, kShortestImuGap_ns);
}

void Loader::add_streams() {
  std::vector<std::int64_t> pose_stamps_ns;
  for (const StampedPose& pose : trajectory_) pose_stamps_ns.push_back(pose.stamp_ns);
  Json events;
  const std::vector<Moment> none;
  run_.data["moments"] =
      make_moments(features_ ? features_->moments : none, recording_ ? &*recording_ : nullptr,
                   span_, picture_bytes_, events, run_.notes);
  Json rates = Json::object();
  if (recording_) {
    rates["frames"] = rates_of(recording_->frame_stamps_ns(), span_, kFrameGapFactor, 0);
    if (recording_->has(replay::Stream::kImu)) rates["imu"] = imu_rates();
    if (recording_->has(replay::Stream::kEvents)) rates["events"] = events;
  }
  rates["poses"] = rates_of(pose_stamps_ns, span_, kPoseGapFactor, 0);
  run_.data["rates"] = std::move(rates);
}

}  // namespace

RunData load_run(const fs::path& folder, const std::string& recording, std::size_t picture_bytes) {
  return Loader(folder, recording, picture_bytes).load();
}

}  // namespace pled::report
