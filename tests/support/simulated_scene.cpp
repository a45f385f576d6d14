#include "tests/support/simulated_scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <deque>
#include <fstream>
#include <map>
#include <memory>
#include <stdexcept>
#include <system_error>
#include <variant>

#include <Eigen/Geometry>

#include "pled_vins/evaluation/align.hpp"
#include "pled_vins/sim/simulator.hpp"
#include "pled_vins/sim/trajectory.hpp"
#include "src/sim/bus.hpp"
#include "src/sim/renderer.hpp"
#include "tests/support/recording_fixture.hpp"

namespace pled::support {
namespace fs = std::filesystem;

namespace {

void write_path(const fs::path& file, const SimulatedScene::Path& path, double duration_s) {
  // Camera axes (x right, y down, z forward) of a rig that looks along +x.
  const Eigen::Quaterniond ahead(0.5, -0.5, 0.5, -0.5);
  std::ofstream out(file);
  out.precision(12);
  constexpr double kStep_s = 0.04;
  for (double t_s = 0.0; t_s < duration_s + kStep_s; t_s += kStep_s) {
    const Station at = path(t_s);
    const Eigen::Quaterniond q = Eigen::AngleAxisd(at.heading_rad, Eigen::Vector3d::UnitZ()) *
                                 Eigen::AngleAxisd(at.pitch_rad, Eigen::Vector3d::UnitY()) * ahead;
    out << t_s;
    for (const double value : {at.p_m.x(), at.p_m.y(), at.p_m.z(), q.x(), q.y(), q.z(), q.w()})
      out << ' ' << value;
    out << '\n';
  }
}

Trajectory trajectory_of(const fs::path& file) {
  std::variant<Trajectory, FileError> read = read_trajectory(file);
  if (const auto* error = std::get_if<FileError>(&read)) throw std::runtime_error(error->message());
  return std::get<Trajectory>(std::move(read));
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// A line of features.csv.
struct FeatureRow {
  std::array<std::array<double, 2>, 2> ends_px{};
  double w = 0.0;
};

/// Which pixels show the bus, at any time.
class BusView {
 public:
  explicit BusView(const sim::SimulationOptions& options)
      : options_(options),
        world_(sim::lay_out(options)),
        trajectory_(std::move(sim::make_trajectory(options).value())) {
    bus_ = world_.boxes.size();
    world_.boxes.push_back(sim::make_bus(options.bus, *trajectory_));
    // What a surface shows is of no matter here, so the smallest pictures will do.
    for (sim::Box& box : world_.boxes) box.texel_m = 1.0;
    sim::paint_boxes(world_, options.seed);
    renderer_.emplace(sim::Renderer::create(world_, options.camera).value());
  }

  void look(double t_s) {
    renderer_->render(trajectory_->at(t_s).T_world_body * options_.camera.T_body_cam, t_s, view_);
  }
  [[nodiscard]] bool shows(const std::array<double, 2>& px) const {
    const long x = std::clamp(std::lround(px[0]), 0L, long{renderer_->width()} - 1);
    const long y = std::clamp(std::lround(px[1]), 0L, long{renderer_->height()} - 1);
    return view_.surface[static_cast<std::size_t>(y * renderer_->width() + x)] / 6U == bus_;
  }
  [[nodiscard]] bool drives(double t_s) const {
    return world_.boxes[bus_].speed_mps(t_s) > sim::kMovingSpeedMps;
  }

 private:
  const sim::SimulationOptions& options_;
  sim::World world_;
  std::unique_ptr<sim::Trajectory> trajectory_;
  std::size_t bus_ = 0;
  std::optional<sim::Renderer> renderer_;
  sim::View view_;
};

std::map<double, std::vector<FeatureRow>> rows_by_time(const Played& played, bool of_lines) {
  std::map<double, std::vector<FeatureRow>> rows;
  for (const std::string& text : played.feature_rows) {
    const std::vector<std::string> f = csv_fields(text);
    if ((f[2] == "line") != of_lines || f[9].empty()) continue;
    FeatureRow row{{{{std::stod(f[3]), std::stod(f[4])}, {}}}, std::stod(f[9])};
    row.ends_px[1] = row.ends_px[0];
    if (of_lines) row.ends_px[1] = {std::stod(f[5]), std::stod(f[6])};
    rows[std::stod(f[0])].push_back(row);
  }
  return rows;
}

bool is_on(const BusView& bus, const FeatureRow& row) {
  const auto& [a, b] = row.ends_px;
  const int shown = int{bus.shows(a)} + int{bus.shows(b)} +
                    int{bus.shows({0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])})};
  return shown >= 2;
}

/// Time from `from_s` to the first median for which `holds`.
template <typename Holds>
std::optional<double> first_after(const std::map<double, double>& medians, double from_s,
                                  const Holds& holds) {
  for (auto it = medians.lower_bound(from_s); it != medians.end(); ++it)
    if (holds(it->second)) return it->first - from_s;
  return std::nullopt;
}

/// The instant between `from_s` and `to_s` when the bus begins or ends to count as moving.
double change_s(const BusView& bus, double from_s, double to_s) {
  const bool before = bus.drives(from_s);
  double t_s = from_s;
  while (t_s < to_s && bus.drives(t_s) == before) t_s += 1e-3;
  return t_s;
}

}  // namespace

Station flight_at(double t_s) {
  return {{0.5 * std::sin(0.9 * t_s), 0.9 * std::sin(1.3 * t_s), 0.2 * std::sin(1.7 * t_s)},
          0.25 * std::sin(1.1 * t_s),
          0.06 * std::sin(1.5 * t_s)};
}

Station flight_until(double stop_s, double t_s) {
  // The flight's own time runs at 1 - (10 x^3 - 15 x^4 + 6 x^5) over the two seconds.
  const double x = std::clamp(0.5 * (t_s - stop_s + 1.0), 0.0, 1.0);
  const double slowed = 2.0 * (x - x * x * x * x * (2.5 - 3.0 * x + x * x));
  return flight_at(std::min(t_s, stop_s - 1.0) + slowed);
}

double Played::worst_error_m(double from_s, double aligned_from_s) const {
  std::vector<Eigen::Vector3d> estimate, truth;
  std::size_t before = 0;  // aligned, not judged
  for (const PositionError& error : evaluation.position_errors) {
    const double t_s = static_cast<double>(error.stamp_ns) * 1e-9;
    if (t_s < aligned_from_s) continue;
    estimate.push_back(error.estimate_m);
    truth.push_back(error.truth_m);
    before += t_s < from_s ? 1 : 0;
  }
  if (estimate.size() == before) return std::nan("");
  const Pose T_truth_estimate = align_rigid(estimate, truth);
  double worst_m = 0.0;
  for (std::size_t k = before; k < estimate.size(); ++k)
    worst_m = std::max(worst_m, (T_truth_estimate * estimate[k] - truth[k]).norm());
  return worst_m;
}

std::string Played::cost() const {
  return std::to_string(report["cpu_ms_per_frame"].get<double>()) + " ms a frame, at most " +
         std::to_string(1e-3 * report["stages"]["frame"]["max_us"].get<double>()) + ", " +
         std::to_string(report["features_per_frame"]["lines"].get<double>()) + " lines";
}

SimulatedScene::SimulatedScene(const std::string& name, sim::SimulationOptions options,
                               const Path& path)
    : folder_(fs::path(PLED_TEST_FOLDER) / ("scene-" + name)), options_(std::move(options)) {
  fs::remove_all(folder_);
  fs::create_directories(folder_);
  options_.frames.blur_samples = 3;
  options_.events.threshold = 0.4;
  options_.events.max_step_s = 0.01;
  options_.events.max_motion_px = 2.0;
  if (path) {
    options_.path_file = (folder_ / "path.tum").string();
    write_path(options_.path_file, path, options_.duration_s);
  }
  if (!sim::simulate(options_, folder_ / "recording").ok())
    throw std::runtime_error("no recording could be made in " + folder_.string());
}

SimulatedScene::~SimulatedScene() {
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

Played SimulatedScene::play(const std::string& settings) const {
  const fs::path recording = folder_ / "recording", out = folder_ / "out";
  std::vector<std::string> words{"replay",     recording.string(), "--out",
                                 out.string(), "--force",          "--no-report"};
  if (!settings.empty()) {
    std::ofstream(folder_ / "settings.yaml") << settings;
    words.insert(words.end(), {"--config", (folder_ / "settings.yaml").string()});
  }
  if (const Outcome o = run_pled_vins(words); o.code != 0) throw std::runtime_error(o.err);
  Played played{nlohmann::json::parse(bytes_of(out / "report.json")), {}, {}};
  played.evaluation = evaluate(trajectory_of(out / "trajectory.tum"),
                               trajectory_of(recording / "groundtruth.txt"), std::nullopt);
  played.feature_rows = lines_of(out / "features.csv");
  played.feature_rows.erase(played.feature_rows.begin());
  return played;
}

Recovery recovery(const SimulatedScene& scene, const Played& played, bool of_lines) {
  const sim::BusOptions& timing = scene.options().bus;
  constexpr std::size_t kFewest = 3, kFrames = 3;
  BusView bus(scene.options());
  std::map<double, double> medians;
  std::deque<std::vector<double>> last;
  for (const auto& [t_s, rows] : rows_by_time(played, of_lines)) {
    bus.look(t_s);
    std::vector<double> weights;
    for (const FeatureRow& row : rows)
      if (is_on(bus, row)) weights.push_back(row.w);
    last.push_back(std::move(weights));
    if (last.size() > kFrames) last.pop_front();
    std::vector<double> all;
    for (const std::vector<double>& some : last) all.insert(all.end(), some.begin(), some.end());
    if (all.size() >= kFewest) medians[t_s] = median(std::move(all));
  }
  const double off_s = timing.at_s + timing.stand_s;
  const double stopped_s = change_s(bus, timing.at_s - 1.0, timing.at_s);
  const double started_s = change_s(bus, off_s, off_s + 1.0);
  const double braking_s = stopped_s - 0.7;
  std::vector<double> driving, parked;
  for (auto it = medians.begin(); it != medians.lower_bound(braking_s); ++it)
    driving.push_back(it->second);
  for (auto it = medians.lower_bound(off_s - 0.5); it != medians.lower_bound(off_s); ++it)
    parked.push_back(it->second);
  Recovery result;
  if (!driving.empty()) result.driving_weight = median(std::move(driving));
  if (!parked.empty()) result.parked_weight = median(std::move(parked));
  result.believed_s = first_after(medians, stopped_s, [](double w) { return w > 0.5; });
  result.disbelieved_s = first_after(medians, started_s, [](double w) { return w < 0.5; });
  return result;
}

}  // namespace pled::support
