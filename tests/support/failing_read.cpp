// To be preloaded into a program: a disk that breaks. Reading the file that PLED_BROKEN_FILE names
// fails from byte PLED_BROKEN_FROM on.

#include <cerrno>
#include <climits>
#include <cstdlib>
#include <cstring>

#include <sys/syscall.h>
#include <unistd.h>

namespace {

bool is_open_as(int descriptor, const char* file) {
  char link[64] = "/proc/self/fd/";
  char digits[16];
  std::size_t count = 0;
  for (int rest = descriptor; count == 0 || rest > 0; rest /= 10)
    digits[count++] = static_cast<char>('0' + rest % 10);
  for (std::size_t end = std::strlen(link); count > 0;) link[end++] = digits[--count];
  char path[PATH_MAX];
  const ssize_t length = readlink(link, path, sizeof(path));
  return length > 0 && std::strlen(file) == static_cast<std::size_t>(length) &&
         std::memcmp(path, file, static_cast<std::size_t>(length)) == 0;
}

}  // namespace

extern "C" ssize_t read(int descriptor, void* buffer, std::size_t bytes) {
  const char* const file = std::getenv("PLED_BROKEN_FILE");
  const char* const from = std::getenv("PLED_BROKEN_FROM");
  if (descriptor >= 0 && file != nullptr && from != nullptr && is_open_as(descriptor, file) &&
      lseek(descriptor, 0, SEEK_CUR) >= std::atoll(from)) {
    errno = EIO;
    return -1;
  }
  return syscall(SYS_read, descriptor, buffer, bytes);
}
