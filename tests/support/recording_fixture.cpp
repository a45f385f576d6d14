#include "tests/support/recording_fixture.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <sstream>
#include <stdexcept>
#include <system_error>

#include <sys/wait.h>
#include <unistd.h>

#include "pled_vins/sim/simulator.hpp"

namespace pled::support {
namespace fs = std::filesystem;

namespace {

/// The folder of one test run, below the build, so that hard links are possible.
class RunFolder {
 public:
  RunFolder() : path_(fs::path(PLED_TEST_FOLDER) / std::to_string(::getpid())) {
    fs::create_directories(path_);
  }
  RunFolder(const RunFolder&) = delete;
  RunFolder& operator=(const RunFolder&) = delete;
  ~RunFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  /// A new folder in it.
  [[nodiscard]] fs::path next() {
    const fs::path folder = path_ / std::to_string(count_++);
    fs::create_directories(folder);
    return folder;
  }

 private:
  fs::path path_;
  int count_ = 0;
};

RunFolder& run_folder() {
  static RunFolder folder;
  return folder;
}

/// A room, seen in motion from the first frame. Events are coarse: they cost
/// most of a simulation's time, and here they only have to be there.
fs::path make_recording(RecordingCopy::Scene scene) {
  const fs::path folder = run_folder().next() / "recording";
  sim::SimulationOptions options = sim::preset("test").value();
  options.duration_s = 2.5;
  options.text_events = scene == RecordingCopy::Scene::kTextEvents;
  if (scene == RecordingCopy::Scene::kWithMovers) options.moving = sim::MovingLevel::kHigh;
  options.frames.blur_samples = 3;
  options.events.threshold = 0.6;
  options.events.max_step_s = 0.01;
  options.events.max_motion_px = 2.0;
  if (!sim::simulate(options, folder).ok())
    throw std::runtime_error("no recording could be made in " + folder.string());
  return folder;
}

const fs::path& shared_recording(RecordingCopy::Scene scene) {
  static std::map<RecordingCopy::Scene, fs::path> folders;
  fs::path& folder = folders[scene];
  if (folder.empty()) folder = make_recording(scene);
  return folder;
}

void link_tree(const fs::path& from, const fs::path& to) {
  fs::create_directories(to);
  for (const auto& entry : fs::recursive_directory_iterator(from)) {
    const fs::path target = to / fs::relative(entry.path(), from);
    if (entry.is_directory())
      fs::create_directories(target);
    else
      fs::create_hard_link(entry.path(), target);
  }
}

std::string quoted(const std::string& word) { return "'" + word + "'"; }

double number_or_nan(const std::string& word) {
  char* end = nullptr;
  const double value = std::strtod(word.c_str(), &end);
  const bool whole = !word.empty() && end == word.c_str() + word.size();
  return whole ? value : std::numeric_limits<double>::quiet_NaN();
}

/// `environment`: assignments as a shell takes them, before the program.
Outcome run_in(const std::string& environment, const std::vector<std::string>& arguments) {
  const fs::path folder = run_folder().next();
  std::string command = environment + " " + quoted(PLED_VINS_EXE);
  for (const std::string& argument : arguments) command += " " + quoted(argument);
  command += " >" + quoted((folder / "out").string()) + " 2>" + quoted((folder / "err").string());
  const int status = std::system(command.c_str());
  Outcome outcome;
  if (WIFEXITED(status)) outcome.code = WEXITSTATUS(status);
  outcome.out = bytes_of(folder / "out");
  outcome.err = bytes_of(folder / "err");
  fs::remove_all(folder);
  return outcome;
}

}  // namespace

std::string bytes_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

std::vector<std::string> lines_of(const fs::path& file) {
  std::ifstream stream(file);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

bool contains(std::string_view text, std::string_view part) {
  return text.find(part) != std::string_view::npos;
}

Outcome run_pled_vins(const std::vector<std::string>& arguments) { return run_in("", arguments); }

Outcome run_on_broken_disk(const std::vector<std::string>& arguments, const fs::path& file,
                           std::uintmax_t from) {
  // The address sanitizer wants to come first, and needs not.
  return run_in("PLED_BROKEN_FILE=" + quoted(fs::canonical(file).string()) + " PLED_BROKEN_FROM=" +
                    std::to_string(from) + " LD_PRELOAD=" + quoted(PLED_FAILING_READ) +
                    " ASAN_OPTIONS=\"$ASAN_OPTIONS:verify_asan_link_order=0\"",
                arguments);
}

RecordingCopy::RecordingCopy(Scene scene) {
  const fs::path& original = shared_recording(scene);
  root_ = run_folder().next();
  link_tree(original, path());
}

RecordingCopy::~RecordingCopy() {
  std::error_code ignored;
  fs::remove_all(root_, ignored);
}

void RecordingCopy::remove(const std::string& name) const { fs::remove(path() / name); }

void RecordingCopy::write(const std::string& name, std::string_view bytes) const {
  remove(name);  // breaks the link: the original stays as it is
  std::ofstream(path() / name, std::ios::binary) << bytes;
}

std::vector<std::string> RecordingCopy::lines(const std::string& name) const {
  return lines_of(path() / name);
}

void RecordingCopy::set_lines(const std::string& name,
                              const std::vector<std::string>& lines) const {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  write(name, text);
}

void RecordingCopy::replace(const std::string& name, const std::string& from,
                            const std::string& to) const {
  std::string text = bytes_of(path() / name);
  const std::size_t at = text.find(from);
  if (at == std::string::npos) throw std::runtime_error(name + " does not hold " + from);
  write(name, text.replace(at, from.size(), to));
}

Outcome RecordingCopy::replay(const std::vector<std::string>& more) const {
  std::vector<std::string> arguments{"replay",       path().string(), "--out",
                                     out().string(), "--force",       "--no-report"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return run_pled_vins(arguments);
}

std::vector<TumPose> read_tum(const fs::path& file) {
  std::vector<TumPose> poses;
  for (const std::string& line : lines_of(file)) {
    std::istringstream words(line);
    std::vector<std::string> fields{std::istream_iterator<std::string>(words), {}};
    fields.resize(8);
    TumPose pose;
    pose.stamp = fields[0];
    pose.t_s = number_or_nan(fields[0]);
    for (std::size_t k = 0; k < 3; ++k) pose.p[k] = number_or_nan(fields[1 + k]);
    for (std::size_t k = 0; k < 4; ++k) pose.q[k] = number_or_nan(fields[4 + k]);
    poses.push_back(pose);
  }
  return poses;
}

std::vector<std::string> csv_fields(const std::string& line) {
  std::vector<std::string> fields(1);
  for (const char c : line) {
    if (c == ',')
      fields.emplace_back();
    else
      fields.back() += c;
  }
  return fields;
}

double farthest_from_first_m(const std::vector<TumPose>& poses) {
  double farthest_m = 0.0;
  for (const TumPose& pose : poses) {
    const auto& p = pose.p;
    const auto& first = poses.front().p;
    const double distance_m = std::hypot(p[0] - first[0], p[1] - first[1], p[2] - first[2]);
    farthest_m = std::max(farthest_m, distance_m);
  }
  return farthest_m;
}

}  // namespace pled::support
