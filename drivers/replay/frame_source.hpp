#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/replay/frame_list.hpp"
#include "drivers/replay/image_reader.hpp"
#include "drivers/replay/message.hpp"
#include "drivers/replay/recorded_source.hpp"

namespace pled::replay {

/// Images named by a list, decoded one by one to 8-bit grey into slots that are
/// allocated once. Serves label images (masks.txt) as well.
class FrameFileSource final : public RecordedFrameSource {
 public:
  struct Options {
    std::string list_path;     ///< images.txt, masks.txt or data.csv
    std::string image_folder;  ///< the names in the list begin here
    FrameListFormat format = FrameListFormat::kRpg;
    ImageSize max;          ///< larger images are refused
    std::size_t slots = 2;  ///< frames that may be held at once, >= 1
    bool one_size = false;  ///< smaller ones too: the size is known to be `max`, else the first's
  };

  /// Errors: File::open's for the list.
  [[nodiscard]] static Result<std::unique_ptr<FrameFileSource>> open(Options options);

  Result<void> start() noexcept override { return {}; }
  /// The next frame. A frame whose stamp is not later than the last one is
  /// skipped and counted; so is one whose stamp leaps ahead: later than that of the
  /// next line, which goes on from the last. Errors: kTruncated, kCorrupt (this frame is lost and
  /// counted, also when its file is missing, its line does not read or its size
  /// is another: last_message() says; call again), kTimeout (every
  /// slot is held), kEndOfStream, kIoFailure (final). Detail: line of the list.
  Result<FrameView> acquire(Duration timeout) noexcept override;
  void release() noexcept override;
  void stop() noexcept override {}

  [[nodiscard]] FrameFaults faults() const noexcept override {
    return {list_.malformed_lines(), list_.out_of_order(), unreadable_};
  }
  [[nodiscard]] std::string_view last_message() const noexcept override { return message_.text(); }
  [[nodiscard]] double progress() const noexcept override { return list_.progress(); }

 private:
  FrameFileSource(FrameList list, Options options);

  [[nodiscard]] Result<FrameView> decode(const FrameList::Entry& entry) noexcept;

  FrameList list_;
  Options options_;
  ImageReader reader_;
  std::vector<std::vector<std::uint8_t>> slots_;
  std::size_t first_held_ = 0;
  std::size_t held_ = 0;
  std::string path_;  ///< of the current image; capacity reserved
  ImageSize size_;    ///< of the first frame that could be read
  std::uint64_t unreadable_ = 0;
  Message message_;
};

}  // namespace pled::replay
