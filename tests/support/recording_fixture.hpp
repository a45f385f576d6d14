#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace pled::support {

/// What a run of the executable left behind.
struct Outcome {
  int code = -1;  ///< exit code; -1 when it did not exit by itself
  std::string out;
  std::string err;
};

/// Runs the real pled-vins and waits for it.
[[nodiscard]] Outcome run_pled_vins(const std::vector<std::string>& arguments);
/// The same on a disk that breaks: reading `file` fails from byte `from` on.
[[nodiscard]] Outcome run_on_broken_disk(const std::vector<std::string>& arguments,
                                         const std::filesystem::path& file, std::uintmax_t from);

[[nodiscard]] bool contains(std::string_view text, std::string_view part);
[[nodiscard]] std::vector<std::string> lines_of(const std::filesystem::path& file);
[[nodiscard]] std::string bytes_of(const std::filesystem::path& file);

/// A recording of its own for one case: 2.5 s of simulated flight, which the first
/// case of a test run that wants the scene makes. Files are shared by hard links until a case
/// changes them. Removed with the object.
class RecordingCopy {
 public:
  enum class Scene : std::uint8_t { kStill, kWithMovers, kTextEvents };  ///< last: still

  explicit RecordingCopy(Scene scene = Scene::kStill);
  RecordingCopy(const RecordingCopy&) = delete;
  RecordingCopy& operator=(const RecordingCopy&) = delete;
  ~RecordingCopy();

  [[nodiscard]] std::filesystem::path path() const { return root_ / "recording"; }
  /// Where replay() writes; beside the recording.
  [[nodiscard]] std::filesystem::path out() const { return root_ / "out"; }

  void remove(const std::string& name) const;
  /// Replaces a file of the copy; the others never see it.
  void write(const std::string& name, std::string_view bytes) const;
  [[nodiscard]] std::vector<std::string> lines(const std::string& name) const;
  void set_lines(const std::string& name, const std::vector<std::string>& lines) const;
  /// Replaces the first occurrence of `from` in a text file; it must be there.
  void replace(const std::string& name, const std::string& from, const std::string& to) const;

  /// `pled-vins replay RECORDING --out OUT --force --no-report` and more arguments.
  [[nodiscard]] Outcome replay(const std::vector<std::string>& more = {}) const;
  /// report.json of the last replay, as text.
  [[nodiscard]] std::string report() const { return bytes_of(out() / "report.json"); }

 private:
  std::filesystem::path root_;
};

/// A line of trajectory.tum.
struct TumPose {
  std::string stamp;  ///< as written
  double t_s = 0.0;
  std::array<double, 3> p{};
  std::array<double, 4> q{};  ///< x y z w
};

/// Every field of a line that is not there, or is no number, is NaN.
[[nodiscard]] std::vector<TumPose> read_tum(const std::filesystem::path& file);

/// The comma-separated fields of a line, empty ones too.
[[nodiscard]] std::vector<std::string> csv_fields(const std::string& line);

/// Largest distance of any pose to the first, metres.
[[nodiscard]] double farthest_from_first_m(const std::vector<TumPose>& poses);

}  // namespace pled::support
