#include "drivers/replay/recording.hpp"

#include <utility>
#include <vector>

#include "drivers/decode/evt3_decoder.hpp"
#include "drivers/decode/text_event_decoder.hpp"

namespace pled::replay {
namespace {

/// No recording has larger images; a larger declared size is a fault of the file.
constexpr ImageSize kLargestImage{4096, 4096};

void add(Problems& problems, Severity severity, const std::string& file, std::string text) {
  problems.push_back({severity, file, 0, std::move(text)});
}

/// Size of the first image that can be read, or zero: a recording may have lost any
/// number of its first ones. `why` gets words for the last one that could not be.
[[nodiscard]] ImageSize first_image_size(FrameFileSource::Options options,
                                         std::string* why = nullptr) {
  auto source = FrameFileSource::open(std::move(options));
  if (!source.ok()) return {};
  while (true) {
    const auto frame = source.value()->acquire(Duration{});
    if (frame.ok()) return {frame.value().image.width, frame.value().image.height};
    const ErrorCode code = frame.error().code;
    if (code == ErrorCode::kCorrupt || code == ErrorCode::kTruncated) continue;
    if (why != nullptr) *why = source.value()->last_message();
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
  auto source = FrameFileSource::open(frame_options(frame_size_, slots));
  if (!source.ok()) {
    add(problems, Severity::kError, {}, open_failure(files_.frames, source.error()));
  }
  return source;
}

FrameFileSource::Options Recording::frame_options(ImageSize size, std::size_t slots) const {
  const auto format = layout_ == Layout::kEuroc ? FrameListFormat::kEuroc : FrameListFormat::kRpg;
  return {files_.frames, files_.frame_folder, format, size, slots, true};
}

void Recording::look_at_frames(Problems& problems) {
  if (files_.frames.empty()) return;
  FrameFileSource::Options any = frame_options(kLargestImage, 1);
  any.one_size = false;
  std::string why;
  frame_size_ = first_image_size(std::move(any), &why);
  if (frame_size_ == ImageSize{}) {
    add(problems, Severity::kWarning, files_.frames,
        "none of the images can be read (names begin at " + files_.frame_folder +
            "; PNG or JPEG, at most 4096x4096): the frames are treated as missing" +
            (why.empty() ? "" : "; the last: " + why));
    files_.frames.clear();
  }
}

bool Recording::set_frame_size(ImageSize size) {
  if (size != frame_size_ && first_image_size(frame_options(size, 1)) == ImageSize{}) return false;
  frame_size_ = size;
  return true;
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
  const ImageSize size =
      first_image_size({files_.masks, files_.root, FrameListFormat::kRpg, kLargestImage, 1});
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
