#pragma once

#include <cstdint>
#include <cstdio>
#include <functional>
#include <string_view>

namespace pled::apps {

/// Tells how far a job has come: on a terminal one line that is drawn anew, with
/// speed and time left; elsewhere a plain line at most every 10 %. Only for the
/// user: nothing that is computed depends on its clock.
class Progress {
 public:
  using Clock = std::function<double()>;  ///< seconds, never decreasing

  enum class Kind : std::uint8_t {
    kRecording,  ///< seconds of a recording, with the speed against real time
    kShare,      ///< 0 ... 1 of a job; says nothing when it takes less than a second
  };

  /// `total` is the length of the recording in seconds (0 when unknown, then nothing
  /// is said before finish()), or 1 for a share.
  Progress(std::FILE* out, bool on_terminal, double total, Clock clock,
           Kind kind = Kind::kRecording);
  /// On stderr with the steady clock; a bar when stderr is a terminal.
  [[nodiscard]] static Progress on_stderr(double total_s);
  [[nodiscard]] static Progress share_on_stderr();

  /// So much of the total is done; `words` go behind the figures. Cheap to call for
  /// every frame.
  void update(double done, std::string_view words = {});
  /// Ends the line of the bar, or says that all is done.
  void finish();

 private:
  void draw_bar(double share, double elapsed_s, std::string_view words);
  void print_line(double share, double elapsed_s, std::string_view words);

  std::FILE* out_;
  bool on_terminal_;
  double total_;
  Clock clock_;
  Kind kind_;
  double started_s_;
  double drawn_s_ = -1e9;  ///< when the bar was drawn last
  int next_percent_ = 10;  ///< of the next plain line
  double done_ = 0.0;
};

}  // namespace pled::apps
