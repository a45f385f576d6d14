#include "src/apps/run_problems.hpp"

#include <optional>
#include <string>
#include <string_view>

#include "src/apps/text.hpp"

namespace pled::apps {

void tell_stream_faults(const OpenedRecording& opened, const Health& health) {
  const Streams& streams = opened.streams;
  const std::string_view frames =
      streams.frame_file != nullptr ? streams.frame_file->last_message() : std::string_view{};
  for (const std::string_view words : {frames, streams.imu->last_message()})
    if (!words.empty()) print_note("last fault: " + std::string(words));
  if (streams.events && health.events.in == 0)
    print_note(opened.recording.files().events + " gave not one event in the time that was played");
}

bool tell_failures(const RunEnd& end) {
  const auto tell = [](const std::optional<Error>& failure, const char* stream) {
    if (!failure) return true;
    print_error(std::string("reading the ") + stream +
                " failed before the end: " + std::string(to_string(failure->code)) +
                "; the results hold everything up to there");
    return false;
  };
  const bool imu = tell(end.imu_failure, "inertial data");
  const bool events = tell(end.event_failure, "events");
  const bool frames = tell(end.frame_failure, "frames");
  return imu && events && frames;
}

}  // namespace pled::apps
