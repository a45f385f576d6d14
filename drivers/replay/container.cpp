#include "drivers/replay/container.hpp"

#include <array>
#include <string_view>

#include "drivers/replay/aedat_containers.hpp"

namespace pled::replay {
namespace {

constexpr std::string_view kMark = "#!AER-DAT";

/// "#!AER-DAT3.1" of a file that begins so.
[[nodiscard]] std::string_view first_line(std::span<const char> head) {
  const std::string_view text{head.data(), head.size()};
  return text.substr(0, text.find_first_of("\r\n"));
}

}  // namespace

bool Container::is_container(std::span<const std::byte> head) noexcept {
  const std::string_view text{reinterpret_cast<const char*>(head.data()), head.size()};
  return text.starts_with(kMark);
}

Result<std::shared_ptr<const Container>> Container::open(const std::string& path,
                                                         Problems& problems) {
  const auto fail = [&](Error error, std::string words) {
    problems.push_back({Severity::kError, path, 0, std::move(words)});
    return error;
  };
  auto file = File::open(path.c_str());
  if (!file.ok()) {
    problems.push_back({Severity::kError, {}, 0, open_failure(path, file.error())});
    return file.error();
  }
  std::array<char, 16> head{};
  const auto got = file.value().read(std::as_writable_bytes(std::span(head)));
  if (!got.ok()) return fail(got.error(), "cannot be read");
  const std::string_view line = first_line(std::span(head).first(got.value()));
  if (line == kAedat2Mark) return open_aedat2(path, problems);
  if (line == kAedat4Mark.substr(0, kAedat4Mark.size() - 2)) return open_aedat4(path, problems);
  return fail({ErrorCode::kUnsupported, 0},
              line.starts_with(kMark)
                  ? "is an AEDAT file of version " + std::string(line.substr(kMark.size())) +
                        "; only 2.0 and 4.0 are read"
                  : std::string("is no AEDAT file: it does not begin with ").append(kMark));
}

}  // namespace pled::replay
