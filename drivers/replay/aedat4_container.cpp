#include <utility>

#include "drivers/decode/aedat4_event_decoder.hpp"
#include "drivers/decode/aedat4_packets.hpp"
#include "drivers/replay/aedat4_sources.hpp"
#include "drivers/replay/aedat_containers.hpp"

namespace pled::replay {
namespace {

constexpr const char* kEvents = "EVTS";
constexpr const char* kFrames = "FRME";
constexpr const char* kImu = "IMUS";
constexpr const char* kTriggers = "TRIG";

class Aedat4Container final : public Container {
 public:
  Aedat4Container(std::string path, Aedat4Header header)
      : path_(std::move(path)), header_(std::move(header)) {}

  bool has_events() const noexcept override { return header_.first(kEvents) != nullptr; }
  bool has_imu() const noexcept override { return header_.first(kImu) != nullptr; }
  bool has_frames() const noexcept override { return header_.first(kFrames) != nullptr; }
  ImageSize event_size() const noexcept override {
    const ImageSize told = has_events() ? header_.first(kEvents)->size : ImageSize{};
    return told.width_px > 0 && told.height_px > 0 ? told : ImageSize{};
  }
  bool tells_frame_size() const noexcept override { return true; }

  Result<EventReplay> open_events(ImageSize size) const override {
    auto reader = Aedat4Reader::open(path_, header_);
    if (!reader.ok()) return reader.error();
    EventReplay replay;
    replay.source =
        std::make_unique<Aedat4EventSource>(std::move(reader).value(), header_.first(kEvents)->id);
    replay.decoder = std::make_unique<Aedat4EventDecoder>(size.width_px, size.height_px);
    return replay;
  }

  Result<std::unique_ptr<RecordedImuSource>> open_imu() const override {
    auto reader = Aedat4Reader::open(path_, header_);
    if (!reader.ok()) return reader.error();
    std::unique_ptr<RecordedImuSource> source =
        std::make_unique<Aedat4ImuSource>(std::move(reader).value(), header_.first(kImu)->id);
    return source;
  }

  Result<std::unique_ptr<RecordedFrameSource>> open_frames(
      const FrameSlots::Options& options) const override {
    auto reader = Aedat4Reader::open(path_, header_);
    if (!reader.ok()) return reader.error();
    std::unique_ptr<RecordedFrameSource> source = std::make_unique<Aedat4FrameSource>(
        std::move(reader).value(), header_.first(kFrames)->id, options);
    return source;
  }

  Result<ContainerInfo> survey() const override;

 private:
  [[nodiscard]] bool is_trigger(std::int32_t id) const noexcept {
    for (const Aedat4Stream& stream : header_.streams)
      if (stream.id == id) return stream.type == kTriggers;
    return false;
  }

  std::string path_;
  Aedat4Header header_;
};

Result<ContainerInfo> Aedat4Container::survey() const {
  auto opened = Aedat4Reader::open(path_, header_);
  if (!opened.ok()) return opened.error();
  Aedat4Reader& reader = opened.value();
  ContainerInfo info;
  std::int64_t packets = 0;
  std::uint64_t malformed = 0;
  while (true) {
    const auto id = reader.next();
    if (!id.ok() && id.error().code != ErrorCode::kEndOfStream) return id.error();
    if (!id.ok()) break;
    ++packets;
    if (!is_trigger(id.value())) continue;
    const auto packet = reader.payload();
    const auto count = packet.ok() ? aedat4_trigger_count(packet.value()) : std::nullopt;
    info.triggers += count.value_or(0);
    if (!count) ++malformed;
  }
  if (reader.is_cut()) info.words.emplace_back(reader.last_message());
  if (malformed > 0)
    info.words.push_back(path_ + ": " + std::to_string(malformed) +
                         " packets of triggers cannot be read (skipped)");
  const std::int64_t listed = reader.listed_packets();
  if (listed < 0) {
    info.words.push_back(path_ +
                         ": the table of packets at the end is missing: the recording was not "
                         "closed, and its last data may be lost");
  } else if (listed != packets) {
    info.words.push_back(path_ + ": the table at the end lists " + std::to_string(listed) +
                         " packets, but " + std::to_string(packets) + " were found");
  }
  return info;
}

/// Words for a compression that cannot be read; empty for one that can.
[[nodiscard]] std::string compression_problem(std::int32_t number) {
  const auto compression = compression_of(number);
  if (!compression.ok()) return "is compressed in an unknown way (" + std::to_string(number) + ")";
  if (Decompressor::create(compression.value()).ok()) return {};
  const char* const name = compression.value() == Compression::kLz4 ? "LZ4" : "Zstandard";
  return std::string("is compressed with ") + name +
         ", which this build cannot unpack: install the package " +
         Decompressor::missing_package(compression.value()) + " and build again";
}

/// Says which streams are passed over.
void say_unread(const std::string& path, const Aedat4Header& header, Problems& problems) {
  for (const Aedat4Stream& stream : header.streams) {
    const bool known = stream.type == kEvents || stream.type == kFrames || stream.type == kImu ||
                       stream.type == kTriggers;
    if (known && header.first(stream.type) == &stream) continue;
    problems.push_back({Severity::kWarning, path, 0,
                        "stream " + std::to_string(stream.id) + " (" +
                            (stream.type.empty() ? "of no type" : stream.type) +
                            (known ? ") is not read: stream " +
                                         std::to_string(header.first(stream.type)->id) + " is"
                                   : ") is not read")});
  }
}

}  // namespace

Result<std::shared_ptr<const Container>> open_aedat4(const std::string& path, Problems& problems) {
  const auto fail = [&](Error error, std::string words) {
    problems.push_back({Severity::kError, path, 0, std::move(words)});
    return error;
  };
  const auto header = read_aedat4_header(path.c_str());
  if (!header.ok()) {
    const bool cut = header.error().code == ErrorCode::kTruncated;
    return fail(header.error(),
                cut ? "is cut within the AEDAT header" : "the AEDAT header cannot be read");
  }
  if (std::string words = compression_problem(header.value().compression); !words.empty())
    return fail({ErrorCode::kUnsupported, header.value().compression}, std::move(words));
  say_unread(path, header.value(), problems);
  std::shared_ptr<const Container> made = std::make_shared<Aedat4Container>(path, header.value());
  return made;
}

}  // namespace pled::replay
