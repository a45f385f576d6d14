#include "drivers/replay/recording.hpp"

#include <utility>
#include <vector>

#include "drivers/decode/evt3_decoder.hpp"
#include "drivers/decode/text_event_decoder.hpp"
#include "drivers/replay/raw_file_source.hpp"

namespace pled::replay {
namespace {

/// No recording has larger images; a larger declared size is a fault of the file.
constexpr ImageSize kLargestImage{4096, 4096};

void add(Problems& problems, Severity severity, const std::string& file, std::string text) {
  problems.push_back({severity, file, 0, std::move(text)});
}

/// Size of the first image that a source can read, or zero: a recording may have lost any
/// number of its first ones. `why` gets words for the last one that could not be.
[[nodiscard]] ImageSize first_image_size(RecordedFrameSource& source, std::string* why = nullptr) {
  while (true) {
    const auto frame = source.acquire(Duration{});
    if (frame.ok()) return {frame.value().image.width, frame.value().image.height};
    const ErrorCode code = frame.error().code;
    if (code == ErrorCode::kCorrupt || code == ErrorCode::kTruncated) continue;
    if (why != nullptr) *why = source.last_message();
    return {};
  }
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

[[nodiscard]] const char* word_for(Stream stream) noexcept {
  switch (stream) {
    case Stream::kEvents: return "a stream of events";
    case Stream::kImu: return "a stream of inertial samples";
    case Stream::kFrames: return "a stream of frames";
    case Stream::kTruth: return "groundtruth.txt beside it";
    case Stream::kMasks: return "masks.txt beside it";
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
  const char* const name = container_ ? word_for(stream) : name_of(stream);
  add(problems, Severity::kError, files_.root,
      std::string("needs ") + name + ", which is missing or unusable");
  return ErrorCode::kNotFound;
}

Result<EventReplay> Recording::open_events(Problems& problems) const {
  PLED_TRY(require(Stream::kEvents, problems));
  if (event_size_ == ImageSize{}) {
    add(problems, Severity::kError, files_.events,
        "nothing says how large the sensor is: give its resolution in the calibration");
    return ErrorCode::kInvalidArgument;
  }
  if (container_) {
    auto replay = container_->open_events(event_size_);
    if (!replay.ok())
      add(problems, Severity::kError, {}, open_failure(files_.events, replay.error()));
    return replay;
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

Result<std::unique_ptr<RecordedImuSource>> Recording::open_imu(Problems& problems) const {
  PLED_TRY(require(Stream::kImu, problems));
  const auto open = [this]() -> Result<std::unique_ptr<RecordedImuSource>> {
    if (container_) return container_->open_imu();
    const auto format = layout_ == Layout::kEuroc ? ImuFormat::kEuroc : ImuFormat::kRpg;
    auto source = ImuFileSource::open(files_.imu, format);
    if (!source.ok()) return source.error();
    return std::unique_ptr<RecordedImuSource>(std::move(source).value());
  };
  auto source = open();
  if (!source.ok()) add(problems, Severity::kError, {}, open_failure(files_.imu, source.error()));
  return source;
}

Result<std::unique_ptr<RecordedFrameSource>> Recording::open_frames(std::size_t slots,
                                                                    Problems& problems) const {
  PLED_TRY(require(Stream::kFrames, problems));
  auto source = open_frames_of(frame_size_, true, slots);
  if (!source.ok())
    add(problems, Severity::kError, {}, open_failure(files_.frames, source.error()));
  return source;
}

/// Frames of this size, or with `one_size` false of the first one's, at most this large.
Result<std::unique_ptr<RecordedFrameSource>> Recording::open_frames_of(ImageSize size,
                                                                       bool one_size,
                                                                       std::size_t slots) const {
  if (container_) return container_->open_frames({size, slots, one_size});
  const auto format = layout_ == Layout::kEuroc ? FrameListFormat::kEuroc : FrameListFormat::kRpg;
  auto source =
      FrameFileSource::open({files_.frames, files_.frame_folder, format, size, slots, one_size});
  if (!source.ok()) return source.error();
  return std::unique_ptr<RecordedFrameSource>(std::move(source).value());
}

void Recording::look_at_frames(Problems& problems) {
  if (files_.frames.empty() || (container_ && !container_->tells_frame_size())) return;
  std::string why;
  auto source = open_frames_of(kLargestImage, false, 1);
  if (source.ok()) frame_size_ = first_image_size(*source.value(), &why);
  if (frame_size_ == ImageSize{}) {
    const std::string where = container_ ? std::string()
                                         : " (names begin at " + files_.frame_folder +
                                               "; PNG or JPEG, at most 4096x4096)";
    add(problems, Severity::kWarning, files_.frames,
        "none of the images can be read" + where + ": the frames are treated as missing" +
            (why.empty() ? "" : "; the last: " + why));
    files_.frames.clear();
  }
}

bool Recording::set_frame_size(ImageSize size) {
  if (size != frame_size_) {
    auto source = open_frames_of(size, true, 1);
    if (!source.ok() || first_image_size(*source.value()) == ImageSize{}) return false;
  }
  frame_size_ = size;
  return true;
}

std::vector<std::int64_t> Recording::frame_stamps_ns() const {
  std::vector<std::int64_t> stamps_ns;
  if (!has(Stream::kFrames)) return stamps_ns;
  const auto format = layout_ == Layout::kEuroc ? FrameListFormat::kEuroc : FrameListFormat::kRpg;
  if (!container_) return listed_stamps(files_.frames, format);
  auto source = open_frames_of(frame_size_, true, 1);
  while (source.ok()) {
    const auto frame = source.value()->acquire(Duration{});
    if (frame.ok()) {
      stamps_ns.push_back(frame.value().stamp_ns);
      source.value()->release();
    } else if (frame.error().code != ErrorCode::kCorrupt) {
      break;
    }
  }
  return stamps_ns;
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
  auto any =
      FrameFileSource::open({files_.masks, files_.root, FrameListFormat::kRpg, kLargestImage, 1});
  const ImageSize size = any.ok() ? first_image_size(*any.value()) : ImageSize{};
  if (size == ImageSize{}) {
    add(problems, Severity::kError, files_.masks, "none of the label images can be read");
    return ErrorCode::kNotFound;
  }
  auto source =
      FrameFileSource::open({files_.masks, files_.root, FrameListFormat::kRpg, size, slots, true});
  if (!source.ok()) {
    add(problems, Severity::kError, {}, open_failure(files_.masks, source.error()));
  }
  return source;
}

}  // namespace pled::replay
