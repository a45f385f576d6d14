#pragma once

#include <cstdint>
#include <optional>

#include "pled_vins/core/messages.hpp"
#include "pled_vins/hal/event_source.hpp"
#include "pled_vins/hal/frame_source.hpp"
#include "pled_vins/hal/imu_source.hpp"
#include "pled_vins/pipeline/event_feed.hpp"
#include "pled_vins/pipeline/health.hpp"
#include "pled_vins/pipeline/stamp_guard.hpp"
#include "pled_vins/pipeline/vio_pipeline.hpp"

namespace pled {

/// Where the data comes from; events are optional. Nothing is owned.
struct RunSources {
  FrameSource* frames = nullptr;
  ImuSource* imu = nullptr;
  EventSource* events = nullptr;
  EventDecoder* event_decoder = nullptr;
};

/// Which part of a recording is played, relative to its first frame.
struct RunSpan {
  Duration start;
  std::optional<Duration> length;
};

/// Told of each processed frame, in order.
class ResultSink {
 public:
  virtual ~ResultSink() = default;
  /// Once, when the first frame of the span has been read: what came before was only passed over.
  virtual void on_start() noexcept {}
  /// False ends the run (for example when the results cannot be written).
  virtual bool on_frame(const FrameResult& result) noexcept = 0;
};

/// How a run ended.
struct RunEnd {
  bool stopped_by_sink = false;
  std::optional<Error> imu_failure;
  std::optional<Error> event_failure;
  std::optional<Error> frame_failure;
  std::optional<std::int64_t> first_stamp_ns;  ///< of the frames in the span
  std::optional<std::int64_t> last_stamp_ns;
};

/// Plays sources through a pipeline on the calling thread, in timestamp order:
/// for each frame first the inertial samples and events up to it. The result
/// depends on the data alone, never on the clock.
class InlineRunner {
 public:
  InlineRunner(VioPipeline& pipeline, Health& health) noexcept
      : pipeline_(pipeline), health_(health) {}

  RunEnd run(const RunSources& sources, const RunSpan& span, ResultSink& sink) noexcept;

 private:
  enum class Next : std::uint8_t { kFrame, kSkip, kEnd };

  [[nodiscard]] Next next_frame(const RunSpan& span, FrameView& frame) noexcept;
  [[nodiscard]] bool stamp_holds(const FrameView& frame) noexcept;
  [[nodiscard]] bool stamp_holds(const ImuSample& sample, Timestamp until) noexcept;
  [[nodiscard]] Next after_failed_read(Error error) noexcept;
  [[nodiscard]] bool play(const FrameView& frame, ResultSink& sink) noexcept;
  void feed_imu(Timestamp until) noexcept;
  void feed_events(Timestamp until) noexcept;
  void collect_event_faults() noexcept;
  [[nodiscard]] bool read_imu(ImuSample& sample) noexcept;
  [[nodiscard]] std::optional<ImuSample> next_readable_imu() noexcept;

  VioPipeline& pipeline_;
  Health& health_;
  RunSources sources_;
  RunEnd end_;
  EventFeed event_feed_;
  StampGuard frame_guard_{5};  ///< a quarter of a second at 20 Hz
  StampGuard imu_guard_{20};
  std::optional<Timestamp> origin_;
  bool imu_ended_ = false;
  std::optional<ImuSample> imu_ahead_;  ///< read, but not handed out yet
  std::uint64_t imu_leaps_ = 0;         ///< samples dropped because their stamp leapt ahead
  Timestamp newest_imu_{INT64_MIN};
  Timestamp newest_event_{INT64_MIN};  ///< whether played or passed over
  Timestamp from_{INT64_MIN};          ///< first frame of the span, camera's clock
  Timestamp imu_from_{INT64_MIN};      ///< first inertial sample that may be of use
};

}  // namespace pled
