#include "drivers/replay/foreign_format.hpp"

#include <array>

namespace pled::replay {
namespace {

using namespace std::string_view_literals;

struct Signature {
  std::string_view first_bytes;
  std::string_view name;
};

constexpr std::array kSignatures{
    Signature{"\x89PNG"sv, "a PNG image"},
    Signature{"\xFF\xD8\xFF"sv, "a JPEG image"},
    Signature{"#!AER-DAT"sv, "an AEDAT file"},
    Signature{"% Data file containing"sv, "a Prophesee DAT file"},
    Signature{"\x89HDF"sv, "an HDF5 file"},
    Signature{"#ROSBAG"sv, "a ROS bag"},
    Signature{"SQLite format 3"sv, "an SQLite file (a ROS 2 bag?)"},
    Signature{"PK\x03\x04"sv, "a zip archive"},
    Signature{"\x1F\x8B"sv, "packed by gzip"},
    Signature{"\xFD"
              "7zXZ"sv,
              "packed by xz"},
    Signature{"BZh"sv, "packed by bzip2"},
    Signature{"\x28\xB5\x2F\xFD"sv, "packed by zstd"},
};

}  // namespace

std::string_view foreign_format(std::span<const std::byte> head) noexcept {
  const std::string_view text{reinterpret_cast<const char*>(head.data()), head.size()};
  for (const Signature& signature : kSignatures)
    if (text.starts_with(signature.first_bytes)) return signature.name;
  return {};
}

}  // namespace pled::replay
