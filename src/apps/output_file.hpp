#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace pled::apps {

/// Puts the stamp exactly, as seconds with 9 decimals, into `out` (at least 32
/// characters). Returns its length.
std::size_t format_stamp(std::int64_t stamp_ns, char* out) noexcept;

/// A result file that is written from front to back. The first failure is kept with
/// its words, and everything after it is refused. Allocates in open() only.
class OutputFile {
 public:
  /// Creates or empties the file. False when that fails; see error().
  bool open(const std::filesystem::path& file);
  /// False when a byte could not be handed over; see error().
  bool write(std::string_view text) noexcept;
  /// Hands everything written so far to the system: it survives the process.
  bool flush() noexcept;
  /// Flushes and closes. False when anything was lost since open().
  bool close() noexcept;
  [[nodiscard]] bool ok() const noexcept { return errno_ == 0; }
  /// "cannot write FILE: REASON"; empty when all is well.
  [[nodiscard]] std::string error() const;

 private:
  struct Closer {
    void operator()(std::FILE* file) const noexcept { std::fclose(file); }
  };

  bool fail() noexcept;

  std::string name_;
  std::vector<char> buffer_;  ///< outlives file_, which writes through it
  std::unique_ptr<std::FILE, Closer> file_;
  int errno_ = 0;
};

/// Writes a file whole or not at all: a reader never sees half of it. Returns what
/// went wrong, empty when nothing did.
[[nodiscard]] std::string write_whole(const std::filesystem::path& target, std::string_view text);

/// Makes `folder` ready for results with the given file names: creates it, refuses
/// to overwrite any of them unless `force`, and tries that a file can be written.
/// Returns what is wrong, empty when it is ready.
[[nodiscard]] std::string prepare_output_folder(const std::filesystem::path& folder,
                                                const std::vector<std::string>& names, bool force);

}  // namespace pled::apps
