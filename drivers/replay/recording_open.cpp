#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include "drivers/replay/foreign_format.hpp"
#include "drivers/replay/raw_header.hpp"
#include "drivers/replay/recording.hpp"

namespace pled::replay {
namespace {

namespace fs = std::filesystem;

void add(Problems& problems, Severity severity, const std::string& file, std::string text) {
  problems.push_back({severity, file, 0, std::move(text)});
}

[[nodiscard]] bool is_file(const std::string& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

[[nodiscard]] bool is_folder(const std::string& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored);
}

/// The path when there is such a file with something in it; otherwise empty, with
/// a warning when the file is there and empty, or no file.
[[nodiscard]] std::string usable_file(const std::string& path, Problems& problems) {
  std::error_code error;
  if (!is_file(path)) {
    if (is_folder(path) || fs::exists(path, error)) {
      add(problems, Severity::kWarning, path,
          is_folder(path) ? "is a folder, not a file; it is treated as missing"
                          : "is no regular file; it is treated as missing");
    }
    return {};
  }
  if (fs::file_size(path, error) == 0 && !error) {
    add(problems, Severity::kWarning, path, "the file is empty; it is treated as missing");
    return {};
  }
  return path;
}

[[nodiscard]] std::string first_usable_file(std::initializer_list<std::string> paths,
                                            Problems& problems) {
  for (const std::string& path : paths) {
    if (std::string found = usable_file(path, problems); !found.empty()) return found;
  }
  return {};
}

/// The AEDAT files of a folder, by their names, sorted.
[[nodiscard]] std::vector<std::string> aedat_files(const std::string& folder) {
  std::vector<std::string> found;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string extension = entry->path().extension().string();
    const bool is_named = extension == ".aedat" || extension == ".aedat4" || extension == ".aedat2";
    if (is_named && is_file(entry->path().string())) found.push_back(entry->path().string());
  }
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace

Result<Recording> Recording::open(const std::string& path, Problems& problems) {
  Recording recording;
  RecordingFiles& files = recording.files_;
  files.root = path;
  if (!is_file(path) && !is_folder(path)) {
    add(problems, Severity::kError, path, "no such folder or file");
    return ErrorCode::kNotFound;
  }
  if (!recording.find_files(problems)) return ErrorCode::kUnsupported;
  if (files.events.empty() && files.imu.empty() && files.frames.empty()) {
    add(problems, Severity::kError, path,
        recording.layout_ == Layout::kFile || recording.layout_ == Layout::kAedat
            ? "holds no events"
            : "is no recording: none of events.raw, events.txt, images.txt, imu.txt, "
              "mav0/imu0/data.csv, mav0/cam0/data.csv, one .aedat or .aedat4 file is there with "
              "something in it");
    return ErrorCode::kNotFound;
  }
  recording.look_at_frames(problems);
  if (!recording.look_at_events(problems)) return ErrorCode::kUnsupported;
  return recording;
}

/// False when what is there cannot be read.
bool Recording::find_files(Problems& problems) {
  const std::string& path = files_.root;
  if (is_file(path)) return find_lone_file(problems);
  if (is_folder(path + "/mav0")) {
    find_euroc_files(path + "/mav0", problems);
  } else if (is_folder(path + "/imu0") || is_folder(path + "/cam0")) {
    find_euroc_files(path, problems);
  } else {
    return find_folder_files(problems);
  }
  return true;
}

/// An AEDAT file has its calibration beside it.
bool Recording::find_lone_file(Problems& problems) {
  layout_ = Layout::kFile;
  files_.events = usable_file(files_.root, problems);
  if (files_.events.empty()) return true;
  const auto head = read_head(files_.events.c_str());
  if (!head.ok() || !Container::is_container(head.value())) return true;
  const fs::path folder = fs::path(files_.root).parent_path();
  find_calibration(folder.empty() ? std::string(".") : folder.string(), problems);
  return take_container(files_.root, problems);
}

/// The files of the RPG layout, else one AEDAT file.
bool Recording::find_folder_files(Problems& problems) {
  find_rpg_files(problems);
  if (!files_.events.empty() || !files_.imu.empty() || !files_.frames.empty()) return true;
  const std::vector<std::string> found = aedat_files(files_.root);
  if (found.empty()) return true;
  if (found.size() == 1) return take_container(found.front(), problems);
  add(problems, Severity::kError, files_.root,
      "holds " + std::to_string(found.size()) + " AEDAT files (" + found[0] + ", " + found[1] +
          (found.size() > 2 ? ", ...): name the one that is meant"
                            : "): name the one that is meant"));
  return false;
}

bool Recording::take_container(const std::string& file, Problems& problems) {
  auto opened = Container::open(file, problems);
  if (!opened.ok()) return false;
  container_ = std::move(opened).value();
  layout_ = Layout::kAedat;
  event_format_ = EventFileFormat::kAedat;
  files_.events = container_->has_events() ? file : std::string();
  files_.imu = container_->has_imu() ? file : std::string();
  files_.frames = container_->has_frames() ? file : std::string();
  event_size_ = container_->event_size();
  return true;
}

void Recording::find_rpg_files(Problems& problems) {
  layout_ = Layout::kRpg;
  const std::string folder = files_.root + "/";
  files_.events = first_usable_file({folder + "events.raw", folder + "events.txt"}, problems);
  if (files_.events.empty() && is_file(folder + "events.raw.xz")) {
    add(problems, Severity::kWarning, folder + "events.raw.xz",
        "is compressed and was not read: unpack it first (xz -d)");
  }
  files_.imu = usable_file(folder + "imu.txt", problems);
  files_.frames = usable_file(folder + "images.txt", problems);
  files_.frame_folder = files_.root;
  files_.truth = usable_file(folder + "groundtruth.txt", problems);
  files_.masks = usable_file(folder + "masks.txt", problems);
  find_calibration(files_.root, problems);
}

void Recording::find_calibration(const std::string& folder, Problems& problems) {
  files_.calib = usable_file(folder + "/calib.txt", problems);
  files_.camchain = usable_file(folder + "/camchain.yaml", problems);
  files_.imu_yaml = usable_file(folder + "/imu.yaml", problems);
}

void Recording::find_euroc_files(const std::string& mav0, Problems& problems) {
  layout_ = Layout::kEuroc;
  files_.imu = usable_file(mav0 + "/imu0/data.csv", problems);
  files_.frames = usable_file(mav0 + "/cam0/data.csv", problems);
  files_.frame_folder = mav0 + "/cam0/data";
  files_.truth = first_usable_file({mav0 + "/state_groundtruth_estimate0/data.csv",
                                    mav0 + "/gt0/data.csv", mav0 + "/mocap0/data.csv"},
                                   problems);
  const std::string& root = files_.root;
  files_.camchain = first_usable_file({root + "/camchain.yaml", mav0 + "/camchain.yaml"}, problems);
  files_.imu_yaml = first_usable_file({root + "/imu.yaml", mav0 + "/imu.yaml"}, problems);
}

/// Tells the format of the event file and, from its header, the sensor's size. The frames
/// do not tell it: they may be another camera's. False when the format cannot be read.
bool Recording::look_at_events(Problems& problems) {
  if (files_.events.empty() || container_) return true;
  const auto head = read_head(files_.events.c_str());
  if (!head.ok()) {
    add(problems, Severity::kError, {}, open_failure(files_.events, head.error()));
    return false;
  }
  if (const std::string_view name = foreign_format(head.value()); !name.empty()) {
    add(problems, Severity::kError, files_.events,
        std::string("is not an event file that can be read: it is ").append(name));
    return false;
  }
  const auto header = parse_raw_header(head.value());
  if (!header.ok()) {
    problems.push_back({Severity::kError, files_.events, header.error().detail,
                        "the RAW header gives a sensor size that is none (1..2048 pixels a side)"});
    return false;
  }
  if (header.value().bytes > 0 || files_.events.ends_with(".raw"))
    return take_raw_header(header.value(), problems);
  event_format_ = EventFileFormat::kText;
  const std::string_view text{reinterpret_cast<const char*>(head.value().data()),
                              head.value().size()};
  if (text.starts_with(kUtf8Mark)) event_header_bytes_ = std::ssize(kUtf8Mark);
  return true;
}

/// False when the words behind the header are in a format that is not read.
bool Recording::take_raw_header(const RawHeader& header, Problems& problems) {
  if (header.format == RawFormat::kEvt2 || header.format == RawFormat::kEvt21) {
    add(problems, Severity::kError, files_.events,
        "the events are in EVT2; only EVT3 and text are read here: convert the file to EVT3");
    return false;
  }
  if (header.format == RawFormat::kUnknown) {
    add(problems, Severity::kWarning, files_.events,
        "the RAW header names no known format; the words are read as EVT3");
  }
  event_format_ = EventFileFormat::kEvt3;
  event_header_bytes_ = static_cast<std::int64_t>(header.bytes);
  if (header.width_px > 0 && header.height_px > 0)
    event_size_ = {header.width_px, header.height_px};
  std::error_code error;
  const std::uintmax_t words = fs::file_size(files_.events, error) - header.bytes;
  if (!error && words == 0)
    add(problems, Severity::kWarning, files_.events, "holds a header and not one event");
  if (!error && words % 2 != 0) {
    add(problems, Severity::kWarning, files_.events,
        "ends in the middle of a word: it was cut, and what followed is missing");
  }
  return true;
}

}  // namespace pled::replay
