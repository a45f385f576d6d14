#include "drivers/replay/file.hpp"

#include <cerrno>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace pled::replay {
namespace {

[[nodiscard]] Error error_from_errno() noexcept {
  const int number = errno;
  switch (number) {
    case ENOENT:
    case ENOTDIR: return {ErrorCode::kNotFound, number};
    case EACCES:
    case EPERM: return {ErrorCode::kPermission, number};
    case EISDIR: return {ErrorCode::kInvalidArgument, number};
    default: return {ErrorCode::kIoFailure, number};
  }
}

}  // namespace

File::File(File&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)), size_(std::exchange(other.size_, 0)) {}

File& File::operator=(File&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  std::swap(size_, other.size_);
  return *this;
}

File::~File() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Result<File> File::open(const char* path) noexcept {
  File file;
  // A pipe would wait for a writer that may never come; O_NONBLOCK changes nothing for a file.
  file.descriptor_ = ::open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (file.descriptor_ < 0) return error_from_errno();
  struct stat status {};
  if (::fstat(file.descriptor_, &status) != 0) return error_from_errno();
  if (S_ISDIR(status.st_mode)) return Error{ErrorCode::kInvalidArgument, EISDIR};
  if (!S_ISREG(status.st_mode)) return Error{ErrorCode::kInvalidArgument, ESPIPE};
  file.size_ = status.st_size;
  return file;
}

Result<std::size_t> File::read(std::span<std::byte> out) noexcept {
  std::size_t got = 0;
  while (got < out.size()) {
    const ssize_t n = ::read(descriptor_, out.data() + got, out.size() - got);
    if (n == 0) break;
    if (n < 0) {
      if (errno == EINTR) continue;
      return Error{ErrorCode::kIoFailure, errno};
    }
    got += static_cast<std::size_t>(n);
  }
  return got;
}

Result<void> File::seek(std::int64_t offset) noexcept {
  if (::lseek(descriptor_, static_cast<off_t>(offset), SEEK_SET) < 0) {
    return Error{ErrorCode::kIoFailure, errno};
  }
  return {};
}

std::string_view open_reason(Error error) noexcept {
  if (error.code != ErrorCode::kInvalidArgument) return to_string(error.code);
  return error.detail == EISDIR ? "it is a folder, not a file" : "it is no regular file";
}

std::string open_failure(const std::string& path, Error error) {
  return std::string("cannot open ").append(path).append(": ").append(open_reason(error));
}

}  // namespace pled::replay
