#include "drivers/replay/recording.hpp"

#include <filesystem>
#include <system_error>
#include <utility>
#include <vector>

#include "drivers/decode/evt3_decoder.hpp"
#include "drivers/decode/text_event_decoder.hpp"
#include "drivers/replay/raw_header.hpp"

namespace pled::replay {
namespace {

namespace fs = std::filesystem;

/// No recording has larger images; a larger declared size is a fault of the file.
constexpr ImageSize kLargestImage{4096, 4096};
/// Images looked at to learn their size, should the first ones be damaged.
constexpr int kImagesToTry = 16;

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
/// a warning when the file is there and empty.
[[nodiscard]] std::string usable_file(const std::string& path, Problems& problems) {
  if (!is_file(path)) return {};
  std::error_code error;
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

/// Size of the first image of a list that can be read, or zero.
[[nodiscard]] ImageSize first_image_size(const std::string& list, const std::string& folder,
                                         FrameListFormat format) {
  auto source = FrameFileSource::open({list, folder, format, kLargestImage, 1});
  if (!source.ok()) return {};
  for (int i = 0; i < kImagesToTry; ++i) {
    const auto frame = source.value()->acquire(Duration{});
    if (frame.ok()) return {frame.value().image.width, frame.value().image.height};
    if (frame.error().code == ErrorCode::kEndOfStream) break;
  }
  return {};
}

[[nodiscard]] const char* name_of(Stream stream) noexcept {
  switch (stream) {
    case Stream::kEvents: return "events.raw or events.txt";
    case Stream::kImu: return "imu.txt (or mav0/imu0/data.csv)";
    case Stream::kFrames: return "images.txt (or mav0/cam0/data.csv)";
    case Stream::kTruth: return "groundtruth.txt (or mav0/state_groundtruth_estimate0/data.csv)";
    case Stream::kMasks: return "masks.txt";
  }
  return "";
}

}  // namespace

std::string to_string(const Problem& problem) {
  std::string words = problem.severity == Severity::kError ? "error: " : "warning: ";
  if (!problem.file.empty()) {
    words.append(problem.file);
    if (problem.line > 0) words.append(1, ':').append(std::to_string(problem.line));
    words.append(": ");
  }
  words.append(problem.text);
  return words;
}

Result<Recording> Recording::open(const std::string& path, Problems& problems) {
  Recording recording;
  RecordingFiles& files = recording.files_;
  files.root = path;
  if (is_file(path)) {
    recording.layout_ = Layout::kFile;
    files.events = usable_file(path, problems);
  } else if (!is_folder(path)) {
    add(problems, Severity::kError, path, "no such folder or file");
    return ErrorCode::kNotFound;
  } else if (is_folder(path + "/mav0")) {
    recording.find_euroc_files(path + "/mav0", problems);
  } else if (is_folder(path + "/imu0") || is_folder(path + "/cam0")) {
    recording.find_euroc_files(path, problems);
  } else {
    recording.find_rpg_files(problems);
  }
  if (files.events.empty() && files.imu.empty() && files.frames.empty()) {
    add(problems, Severity::kError, path,
        recording.layout_ == Layout::kFile
            ? "holds no events"
            : "is no recording: none of events.raw, events.txt, images.txt, imu.txt, "
              "mav0/imu0/data.csv, mav0/cam0/data.csv is there with something in it");
    return ErrorCode::kNotFound;
  }
  recording.look_at_frames(problems);
  if (!recording.look_at_events(problems)) return ErrorCode::kUnsupported;
  return recording;
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
  files_.calib = usable_file(folder + "calib.txt", problems);
  files_.camchain = usable_file(folder + "camchain.yaml", problems);
  files_.imu_yaml = usable_file(folder + "imu.yaml", problems);
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

/// Tells the format of the event file and the sensor's size. False when the
/// format cannot be read.
bool Recording::look_at_events(Problems& problems) {
  if (files_.events.empty()) return true;
  event_size_ = frame_size_;
  auto lines = LineReader::open(files_.events.c_str());
  if (!lines.ok()) {
    add(problems, Severity::kError, files_.events, open_failure(files_.events, lines.error()));
    return false;
  }
  const auto header = read_raw_header(files_.events.c_str());
  if (!header.ok()) {
    problems.push_back({Severity::kError, files_.events, header.error().detail,
                        "the RAW header gives a sensor size that is none (1..2048 pixels a side)"});
    return false;
  }
  const bool named_raw = files_.events.ends_with(".raw");
  if (header.value().bytes == 0 && !named_raw) {
    event_format_ = EventFileFormat::kText;
    return true;
  }
  if (header.value().format == RawFormat::kEvt2 || header.value().format == RawFormat::kEvt21) {
    add(problems, Severity::kError, files_.events,
        "the events are in EVT2; only EVT3 and text are read here: convert the file to EVT3");
    return false;
  }
  if (header.value().format == RawFormat::kUnknown) {
    add(problems, Severity::kWarning, files_.events,
        "the RAW header names no known format; the words are read as EVT3");
  }
  event_format_ = EventFileFormat::kEvt3;
  event_header_bytes_ = static_cast<std::int64_t>(header.value().bytes);
  if (header.value().width_px > 0 && header.value().height_px > 0) {
    event_size_ = {header.value().width_px, header.value().height_px};
  }
  return true;
}

void Recording::look_at_frames(Problems& problems) {
  if (files_.frames.empty()) return;
  const auto format = layout_ == Layout::kEuroc ? FrameListFormat::kEuroc : FrameListFormat::kRpg;
  frame_size_ = first_image_size(files_.frames, files_.frame_folder, format);
  if (frame_size_ == ImageSize{}) {
    add(problems, Severity::kWarning, files_.frames,
        "none of the first images can be read (names begin at " + files_.frame_folder +
            "; PNG or JPEG, at most 4096x4096): the frames are treated as missing");
    files_.frames.clear();
  }
}

const std::string& Recording::path_of(Stream stream) const noexcept {
  switch (stream) {
    case Stream::kEvents: return files_.events;
    case Stream::kImu: return files_.imu;
    case Stream::kFrames: return files_.frames;
    case Stream::kTruth: return files_.truth;
    case Stream::kMasks: return files_.masks;
  }
  return files_.events;
}

bool Recording::has(Stream stream) const noexcept { return !path_of(stream).empty(); }

Result<void> Recording::require(Stream stream, Problems& problems) const {
  if (has(stream)) return {};
  add(problems, Severity::kError, files_.root,
      std::string("needs ") + name_of(stream) + ", which is missing or unusable");
  return ErrorCode::kNotFound;
}

Result<EventReplay> Recording::open_events(Problems& problems) const {
  PLED_TRY(require(Stream::kEvents, problems));
  if (event_size_ == ImageSize{}) {
    add(problems, Severity::kError, files_.events,
        "nothing says how large the sensor is: give its resolution in the calibration");
    return ErrorCode::kInvalidArgument;
  }
  const bool text = event_format_ == EventFileFormat::kText;
  auto source = RawFileSource::open(files_.events.c_str(), {event_header_bytes_, text});
  if (!source.ok()) {
    add(problems, Severity::kError, {}, open_failure(files_.events, source.error()));
    return source.error();
  }
  EventReplay replay;
  replay.source = std::move(source).value();
  if (text) {
    replay.decoder =
        std::make_unique<TextEventDecoder>(event_size_.width_px, event_size_.height_px);
  } else {
    replay.decoder = std::make_unique<Evt3Decoder>(event_size_.width_px, event_size_.height_px);
  }
  return replay;
}

Result<std::unique_ptr<ImuFileSource>> Recording::open_imu(Problems& problems) const {
  PLED_TRY(require(Stream::kImu, problems));
  auto source = ImuFileSource::open(
      files_.imu, layout_ == Layout::kEuroc ? ImuFormat::kEuroc : ImuFormat::kRpg);
  if (!source.ok()) {
    add(problems, Severity::kError, {}, open_failure(files_.imu, source.error()));
  }
  return source;
}

Result<std::unique_ptr<FrameFileSource>> Recording::open_frames(std::size_t slots,
                                                                Problems& problems) const {
  PLED_TRY(require(Stream::kFrames, problems));
  const auto format = layout_ == Layout::kEuroc ? FrameListFormat::kEuroc : FrameListFormat::kRpg;
  auto source =
      FrameFileSource::open({files_.frames, files_.frame_folder, format, frame_size_, slots});
  if (!source.ok()) {
    add(problems, Severity::kError, {}, open_failure(files_.frames, source.error()));
  }
  return source;
}

std::vector<std::int64_t> Recording::frame_stamps_ns() const {
  const auto format = layout_ == Layout::kEuroc ? FrameListFormat::kEuroc : FrameListFormat::kRpg;
  return has(Stream::kFrames) ? listed_stamps(files_.frames, format) : std::vector<std::int64_t>{};
}

Result<TruthReader> Recording::open_truth(Problems& problems) const {
  PLED_TRY(require(Stream::kTruth, problems));
  auto reader = TruthReader::open(
      files_.truth, layout_ == Layout::kEuroc ? TruthFormat::kEuroc : TruthFormat::kTum);
  if (!reader.ok()) {
    add(problems, Severity::kError, {}, open_failure(files_.truth, reader.error()));
  }
  return reader;
}

Result<std::unique_ptr<FrameFileSource>> Recording::open_masks(std::size_t slots,
                                                               Problems& problems) const {
  PLED_TRY(require(Stream::kMasks, problems));
  const ImageSize size = first_image_size(files_.masks, files_.root, FrameListFormat::kRpg);
  if (size == ImageSize{}) {
    add(problems, Severity::kError, files_.masks, "none of the first label images can be read");
    return ErrorCode::kNotFound;
  }
  auto source =
      FrameFileSource::open({files_.masks, files_.root, FrameListFormat::kRpg, size, slots});
  if (!source.ok()) {
    add(problems, Severity::kError, {}, open_failure(files_.masks, source.error()));
  }
  return source;
}

}  // namespace pled::replay
