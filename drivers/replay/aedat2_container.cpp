#include <utility>

#include "drivers/decode/aedat2_event_decoder.hpp"
#include "drivers/replay/aedat_containers.hpp"
#include "drivers/replay/raw_file_source.hpp"

namespace pled::replay {
namespace {

class Aedat2Container final : public Container {
 public:
  Aedat2Container(std::string path, Aedat2Header header, Aedat2Census census)
      : path_(std::move(path)), header_(std::move(header)), census_(census) {}

  bool has_events() const noexcept override { return true; }
  bool has_imu() const noexcept override { return census_.imu; }
  bool has_frames() const noexcept override { return census_.frames; }
  ImageSize event_size() const noexcept override { return header_.size; }
  bool tells_frame_size() const noexcept override { return header_.size != ImageSize{}; }

  Result<EventReplay> open_events(ImageSize size) const override {
    auto source = RawFileSource::open(path_.c_str(), {header_.bytes, false});
    if (!source.ok()) return source.error();
    EventReplay replay;
    replay.source = std::move(source).value();
    replay.decoder = std::make_unique<Aedat2EventDecoder>(size.width_px, size.height_px);
    return replay;
  }

  Result<std::unique_ptr<RecordedImuSource>> open_imu() const override {
    auto file = Aedat2RecordFile::open(path_, header_);
    if (!file.ok()) return file.error();
    std::unique_ptr<RecordedImuSource> source =
        std::make_unique<Aedat2ImuSource>(std::move(file).value(), header_.imu);
    return source;
  }

  /// A read tells its pixel, and the chip how many there are: that is the size of all frames.
  Result<std::unique_ptr<RecordedFrameSource>> open_frames(
      const FrameSlots::Options& options) const override {
    const ImageSize size = tells_frame_size() ? header_.size : options.max;
    const bool known = tells_frame_size() || options.one_size;
    if (!known || size.width_px <= 0 || size.height_px <= 0) return ErrorCode::kInvalidArgument;
    if (options.one_size && size != options.max) return ErrorCode::kInvalidArgument;
    auto file = Aedat2RecordFile::open(path_, header_);
    if (!file.ok()) return file.error();
    std::unique_ptr<RecordedFrameSource> source =
        std::make_unique<Aedat2FrameSource>(std::move(file).value(), size, options.slots);
    return source;
  }

  Result<ContainerInfo> survey() const override {
    ContainerInfo info;
    info.triggers = census_.special;
    return info;
  }

 private:
  std::string path_;
  Aedat2Header header_;
  Aedat2Census census_;
};

}  // namespace

Result<std::shared_ptr<const Container>> open_aedat2(const std::string& path, Problems& problems) {
  const auto say = [&](Severity severity, std::string words) {
    problems.push_back({severity, path, 0, std::move(words)});
  };
  const auto header = read_aedat2_header(path.c_str());
  if (!header.ok()) {
    say(Severity::kError, "the AEDAT header cannot be read");
    return header.error();
  }
  if (!header.value().is_davis) {
    say(Severity::kError, "was recorded by " + header.value().chip +
                              "; of AEDAT 2.0 only the addresses of a DAVIS are read");
    return ErrorCode::kUnsupported;
  }
  if (header.value().chip.empty())
    say(Severity::kWarning, "the header does not tell the chip; it is read as that of a DAVIS");
  const auto census = take_census(path, header.value());
  if (!census.ok()) {
    say(Severity::kError, "reading failed");
    return census.error();
  }
  if (census.value().imu && !header.value().imu_is_known)
    say(Severity::kWarning,
        "the header does not tell the ranges of the IMU: 1000 deg/s and 8 g are assumed where "
        "they are missing");
  std::shared_ptr<const Container> made =
      std::make_shared<Aedat2Container>(path, header.value(), census.value());
  return made;
}

}  // namespace pled::replay
