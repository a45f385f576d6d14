#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/replay/container.hpp"
#include "drivers/replay/frame_source.hpp"
#include "drivers/replay/imu_source.hpp"
#include "drivers/replay/problem.hpp"
#include "drivers/replay/raw_header.hpp"
#include "drivers/replay/truth_reader.hpp"
#include "pled_vins/hal/event_source.hpp"

namespace pled::replay {

enum class Layout : std::uint8_t {
  kRpg,    ///< events.raw|events.txt, images.txt, imu.txt, groundtruth.txt, masks.txt
  kEuroc,  ///< mav0/{imu0,cam0,state_groundtruth_estimate0|gt0}/data.csv
  kFile,   ///< one event file alone
  kAedat,  ///< one AEDAT file with all streams, alone or in a folder with its calibration
};

enum class Stream : std::uint8_t { kEvents, kImu, kFrames, kTruth, kMasks };

enum class EventFileFormat : std::uint8_t { kNone, kEvt3, kText, kAedat };

/// Where everything lies. An empty path: not there (or an empty file). Streams of one
/// container have the same path.
struct RecordingFiles {
  std::string root;
  std::string events;
  std::string imu;
  std::string frames;        ///< the list
  std::string frame_folder;  ///< names in the list begin here
  std::string truth;
  std::string masks;     ///< the list; names begin at `root`
  std::string calib;     ///< calib.txt
  std::string camchain;  ///< Kalibr's camchain.yaml
  std::string imu_yaml;  ///< Kalibr's imu.yaml
};

/// A recording on disk: which streams it has, how large its sensors are, and a
/// source for each. For the set-up phase: allocates freely and explains failures
/// in `Problem`s. What it opens follows the rules of the hal.
class Recording {
 public:
  /// Looks at a folder in the RPG layout, a EuRoC folder (`mav0` or its parent),
  /// one AEDAT file or a folder that holds one beside its calibration, or one event file
  /// (.raw or text). Fails, with words in `problems`, when the path does not exist or holds
  /// no stream at all. Empty or odd files are warnings.
  [[nodiscard]] static Result<Recording> open(const std::string& path, Problems& problems);

  [[nodiscard]] Layout layout() const noexcept { return layout_; }
  [[nodiscard]] const RecordingFiles& files() const noexcept { return files_; }
  [[nodiscard]] bool has(Stream stream) const noexcept;
  [[nodiscard]] EventFileFormat event_format() const noexcept { return event_format_; }

  /// Says in words, as an error, that a needed stream is not there.
  [[nodiscard]] Result<void> require(Stream stream, Problems& problems) const;

  /// From the header of the RAW or AEDAT file, else zero: then the calibration of the event camera
  /// must say it through set_event_size().
  [[nodiscard]] ImageSize event_size() const noexcept { return event_size_; }
  void set_event_size(ImageSize size) noexcept { event_size_ = size; }
  /// Of the first readable image, or as set; zero without any.
  [[nodiscard]] ImageSize frame_size() const noexcept { return frame_size_; }
  /// What the calibration of the frame camera says: open_frames() then refuses images of
  /// another size one by one. False, and nothing changed, when no readable image has it.
  [[nodiscard]] bool set_frame_size(ImageSize size);

  /// Each opens its stream from the beginning, as often as wanted. The error has
  /// its words in `problems`; kNotFound when the stream is not there.
  [[nodiscard]] Result<EventReplay> open_events(Problems& problems) const;
  [[nodiscard]] Result<std::unique_ptr<RecordedImuSource>> open_imu(Problems& problems) const;
  /// `slots`: frames that may be held at once.
  [[nodiscard]] Result<std::unique_ptr<RecordedFrameSource>> open_frames(std::size_t slots,
                                                                         Problems& problems) const;
  /// Stamps of the frames as open_frames() goes through them, read or not; ns.
  [[nodiscard]] std::vector<std::int64_t> frame_stamps_ns() const;
  [[nodiscard]] Result<TruthReader> open_truth(Problems& problems) const;
  [[nodiscard]] Result<std::unique_ptr<FrameFileSource>> open_masks(std::size_t slots,
                                                                    Problems& problems) const;
  /// The file that holds all streams; nullptr for other layouts.
  [[nodiscard]] const Container* container() const noexcept { return container_.get(); }

 private:
  Recording() = default;

  [[nodiscard]] bool find_files(Problems& problems);
  [[nodiscard]] bool find_lone_file(Problems& problems);
  [[nodiscard]] bool find_folder_files(Problems& problems);
  void find_rpg_files(Problems& problems);
  void find_calibration(const std::string& folder, Problems& problems);
  [[nodiscard]] bool take_container(const std::string& file, Problems& problems);
  void find_euroc_files(const std::string& mav0, Problems& problems);
  [[nodiscard]] bool look_at_events(Problems& problems);
  [[nodiscard]] bool take_raw_header(const RawHeader& header, Problems& problems);
  void look_at_frames(Problems& problems);
  [[nodiscard]] Result<std::unique_ptr<RecordedFrameSource>> open_frames_of(
      ImageSize size, bool one_size, std::size_t slots) const;
  [[nodiscard]] const std::string& path_of(Stream stream) const noexcept;

  Layout layout_ = Layout::kRpg;
  RecordingFiles files_;
  EventFileFormat event_format_ = EventFileFormat::kNone;
  std::int64_t event_header_bytes_ = 0;
  ImageSize event_size_;
  ImageSize frame_size_;
  std::shared_ptr<const Container> container_;
};

}  // namespace pled::replay
