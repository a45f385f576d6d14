#include "src/apps/output_file.hpp"

#include <cerrno>
#include <cstring>
#include <system_error>

namespace pled::apps {
namespace fs = std::filesystem;

namespace {

constexpr std::size_t kBufferBytes = std::size_t{1} << 16;

}  // namespace

std::size_t format_stamp(std::int64_t stamp_ns, char* out) noexcept {
  constexpr std::int64_t kNsPerS = 1'000'000'000;
  // Split before the sign is dropped, so that the lowest number does not overflow.
  const long long whole_s = stamp_ns / kNsPerS;
  const long long rest_ns = stamp_ns % kNsPerS;
  const char* sign = stamp_ns < 0 ? "-" : "";
  const int length = std::snprintf(out, 32, "%s%lld.%09lld", sign, whole_s < 0 ? -whole_s : whole_s,
                                   rest_ns < 0 ? -rest_ns : rest_ns);
  return static_cast<std::size_t>(length);
}

bool OutputFile::open(const fs::path& file) {
  name_ = file.string();
  errno_ = 0;
  file_.reset(std::fopen(name_.c_str(), "wb"));
  if (!file_) return fail();
  buffer_.resize(kBufferBytes);
  std::setvbuf(file_.get(), buffer_.data(), _IOFBF, buffer_.size());
  return true;
}

bool OutputFile::write(std::string_view text) noexcept {
  if (!file_ || errno_ != 0) return false;
  return std::fwrite(text.data(), 1, text.size(), file_.get()) == text.size() || fail();
}

bool OutputFile::flush() noexcept {
  if (!file_ || errno_ != 0) return false;
  return std::fflush(file_.get()) == 0 || fail();
}

bool OutputFile::close() noexcept {
  if (!file_) return errno_ == 0;
  if (std::fclose(file_.release()) != 0 && errno_ == 0) fail();
  return errno_ == 0;
}

bool OutputFile::fail() noexcept {
  errno_ = errno != 0 ? errno : EIO;
  return false;
}

std::string OutputFile::error() const {
  if (errno_ == 0) return {};
  return "cannot write " + name_ + ": " + std::strerror(errno_);
}

std::string write_whole(const fs::path& target, std::string_view text) {
  const fs::path part = target.string() + ".part";
  OutputFile file;
  const bool written = file.open(part) && file.write(text) && file.close();
  std::error_code error;
  if (written) fs::rename(part, target, error);
  if (written && !error) return {};
  std::error_code ignored;
  fs::remove(part, ignored);
  return written ? "cannot write " + target.string() + ": " + error.message() : file.error();
}

std::string prepare_output_folder(const fs::path& folder, const std::vector<std::string>& names,
                                  bool force) {
  std::error_code error;
  if (fs::exists(folder, error) && !fs::is_directory(folder, error))
    return "cannot write to " + folder.string() + ": it is not a folder";
  fs::create_directories(folder, error);
  if (error) return "cannot create the folder " + folder.string() + ": " + error.message();
  for (const std::string& name : names) {
    if (!force && fs::exists(folder / name, error))
      return (folder / name).string() + " exists already: choose another folder or add --force";
  }
  // A folder may exist and yet refuse files: better known now than after the run.
  const fs::path trial = folder / ".pled-vins-trial";
  OutputFile file;
  if (!file.open(trial)) return file.error();
  const bool written = file.write("x") && file.close();
  fs::remove(trial, error);
  if (!written) return file.error();
  if (force)
    for (const std::string& name : names) fs::remove(folder / name, error);  // open() would tell
  return {};
}

}  // namespace pled::apps
