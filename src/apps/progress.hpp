#pragma once

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

  /// `total_s` is the length of the recording; 0 when unknown, then nothing is said
  /// before finish().
  Progress(std::FILE* out, bool on_terminal, double total_s, Clock clock);
  /// On stderr with the steady clock; a bar when stderr is a terminal.
  [[nodiscard]] static Progress on_stderr(double total_s);

  /// `done_s` of the recording are done; `words` go behind the figures. Cheap to
  /// call for every frame.
  void update(double done_s, std::string_view words = {});
  /// Ends the line of the bar, or says that all is done.
  void finish();

 private:
  void draw_bar(double share, double speed, double left_s, std::string_view words);

  std::FILE* out_;
  bool on_terminal_;
  double total_s_;
  Clock clock_;
  double started_s_;
  double drawn_s_ = -1e9;  ///< when the bar was drawn last
  int next_percent_ = 10;  ///< of the next plain line
  double done_s_ = 0.0;
};

}  // namespace pled::apps
