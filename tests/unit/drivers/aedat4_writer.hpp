#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#if PLED_WITH_LZ4
#include <lz4frame.h>
#endif
#if PLED_WITH_ZSTD
#include <zstd.h>
#endif

#include "pled_vins/core/messages.hpp"

/// Writes AEDAT 4.0 packets and files for tests.
namespace pled::support {

using Bytes = std::vector<std::byte>;

inline void append_all(Bytes& bytes, std::span<const std::byte> more) {
  for (const std::byte byte : more) bytes.push_back(byte);
}
template <typename T>
void append(Bytes& bytes, T value) {
  append_all(bytes, std::as_bytes(std::span(&value, 1)));
}

/// A FlatBuffer from front to back: every table after the one that points to it.
class FlatWriter {
 public:
  /// A field of a table.
  struct Field {
    unsigned index = 0;
    Bytes bytes;
  };
  template <typename T>
  [[nodiscard]] static Field number(unsigned index, T value) {
    Field field{index, {}};
    append(field.bytes, value);
    return field;
  }
  /// The place of an offset that point() fills in.
  [[nodiscard]] static Field offset(unsigned index) { return number<std::uint32_t>(index, 0); }

  explicit FlatWriter(std::string_view identifier) {
    put<std::uint32_t>(0);
    for (const char c : identifier) bytes_.push_back(static_cast<std::byte>(c));
  }

  template <typename T>
  void put(T value) {
    append(bytes_, value);
  }
  void put_text(std::string_view text) {
    put<std::uint32_t>(static_cast<std::uint32_t>(text.size()));
    for (const char c : text) bytes_.push_back(static_cast<std::byte>(c));
    put<char>('\0');
  }

  /// Adds a vtable and its table, which the offset at `from` points to; where the first
  /// field lies.
  std::size_t table(std::size_t from, const std::vector<Field>& fields) {
    unsigned entries = 0;
    for (const Field& field : fields) entries = std::max(entries, field.index + 1);
    std::vector<std::uint16_t> offsets(entries, 0);
    std::uint16_t size = 4;
    for (const Field& field : fields) {
      offsets[field.index] = size;
      size = static_cast<std::uint16_t>(size + field.bytes.size());
    }
    const std::size_t vtable = bytes_.size();
    put(static_cast<std::uint16_t>(4 + 2 * entries));
    put(size);
    for (const std::uint16_t offset : offsets) put(offset);
    point(from);
    put(static_cast<std::int32_t>(bytes_.size() - vtable));
    const std::size_t first = bytes_.size();
    for (const Field& field : fields) append_all(bytes_, field.bytes);
    return first;
  }

  /// Lets the offset at `from` point to what is written next.
  void point(std::size_t from) {
    const auto distance = static_cast<std::uint32_t>(bytes_.size() - from);
    std::memcpy(bytes_.data() + from, &distance, sizeof(distance));
  }
  [[nodiscard]] std::size_t size() const { return bytes_.size(); }

  [[nodiscard]] Bytes size_prefixed() const {
    Bytes out;
    append(out, static_cast<std::uint32_t>(bytes_.size()));
    append_all(out, bytes_);
    return out;
  }

 private:
  Bytes bytes_;
};

[[nodiscard]] inline Bytes event_record(std::int64_t t_us, int x, int y, int polarity) {
  Bytes out;
  append(out, t_us);
  append(out, static_cast<std::int16_t>(x));
  append(out, static_cast<std::int16_t>(y));
  append(out, static_cast<std::uint32_t>(polarity));  // and three bytes that mean nothing
  return out;
}

[[nodiscard]] inline Bytes events_packet(std::span<const Event> events) {
  FlatWriter out("EVTS");
  out.point(out.table(0, {FlatWriter::offset(0)}));
  out.put(static_cast<std::uint32_t>(events.size()));
  for (const Event& event : events)
    for (const std::byte byte :
         event_record(event.t.us, event.x_px, event.y_px, static_cast<int>(event.polarity)))
      out.put(byte);
  return out.size_prefixed();
}

/// A packet that is a list of tables.
[[nodiscard]] inline Bytes list_packet(std::string_view identifier,
                                       const std::vector<std::vector<FlatWriter::Field>>& tables) {
  FlatWriter out(identifier);
  out.point(out.table(0, {FlatWriter::offset(0)}));
  out.put(static_cast<std::uint32_t>(tables.size()));
  const std::size_t offsets = out.size();
  for (std::size_t i = 0; i < tables.size(); ++i) out.put<std::uint32_t>(0);
  for (std::size_t i = 0; i < tables.size(); ++i) out.table(offsets + 4 * i, tables[i]);
  return out.size_prefixed();
}

/// Numbers of an inertial sample as the file has them; a zero is left out, as FlatBuffers do.
struct ImuRow {
  std::int64_t t_us = 0;
  std::array<float, 3> accel_g{};
  std::array<float, 3> gyro_degps{};
};
[[nodiscard]] inline Bytes imu_packet(const std::vector<ImuRow>& rows) {
  std::vector<std::vector<FlatWriter::Field>> tables;
  for (const ImuRow& row : rows) {
    std::vector<FlatWriter::Field> fields;
    if (row.t_us != 0) fields.push_back(FlatWriter::number(0, row.t_us));
    for (unsigned axis = 0; axis < 3; ++axis) {
      if (row.accel_g[axis] != 0.0F)
        fields.push_back(FlatWriter::number(2 + axis, row.accel_g[axis]));
      if (row.gyro_degps[axis] != 0.0F)
        fields.push_back(FlatWriter::number(5 + axis, row.gyro_degps[axis]));
    }
    tables.push_back(std::move(fields));
  }
  return list_packet("IMUS", tables);
}

[[nodiscard]] inline Bytes triggers_packet(std::size_t count) {
  const std::vector<FlatWriter::Field> trigger{FlatWriter::number<std::int64_t>(0, 7)};
  return list_packet("TRIG", std::vector(count, trigger));
}

struct FrameRow {
  std::int64_t t_us = 0;
  std::int64_t exposure_begin_us = 0;
  std::int64_t exposure_end_us = 0;
  int format = 0;
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> pixels;
};
[[nodiscard]] inline Bytes frame_packet(const FrameRow& row) {
  FlatWriter out("FRME");
  std::vector<FlatWriter::Field> fields{FlatWriter::offset(10)};
  const auto add = [&fields](unsigned index, auto value) {
    if (value != 0) fields.push_back(FlatWriter::number(index, value));
  };
  add(0, row.t_us);
  add(3, row.exposure_begin_us);
  add(4, row.exposure_end_us);
  add(5, static_cast<std::int8_t>(row.format));
  add(6, static_cast<std::int16_t>(row.width));
  add(7, static_cast<std::int16_t>(row.height));
  out.point(out.table(0, fields));
  out.put(static_cast<std::uint32_t>(row.pixels.size()));
  for (const std::uint8_t pixel : row.pixels) out.put(pixel);
  return out.size_prefixed();
}

/// Number of a compression as in a file: 0 none, 1 LZ4, 3 Zstandard.
[[nodiscard]] inline bool can_pack(int compression) {
  return compression == 0 || (compression == 1 && PLED_WITH_LZ4) ||
         (compression == 3 && PLED_WITH_ZSTD);
}
[[nodiscard]] inline Bytes packed(const Bytes& plain, int compression) {
  Bytes out = plain;
#if PLED_WITH_LZ4
  if (compression == 1) {
    out.resize(LZ4F_compressFrameBound(plain.size(), nullptr));
    out.resize(LZ4F_compressFrame(out.data(), out.size(), plain.data(), plain.size(), nullptr));
  }
#endif
#if PLED_WITH_ZSTD
  if (compression == 3) {
    out.resize(ZSTD_compressBound(plain.size()));
    out.resize(ZSTD_compress(out.data(), out.size(), plain.data(), plain.size(), 1));
  }
#endif
  return out;
}

/// An AEDAT 4.0 file: events 0, frames 1, inertial samples 2, triggers 3.
class Aedat4File {
 public:
  struct Options {
    int compression = 0;
    bool table = true;  ///< of packets, at the end
    int width = 20;
    int height = 10;
    bool frames = true;     ///< the stream of frames is declared
    std::string more = "";  ///< of the description, inside outInfo
  };

  explicit Aedat4File(Options options) : options_(std::move(options)) {}

  Aedat4File& add(std::int32_t stream, const Bytes& packet) {
    const Bytes content = packed(packet, options_.compression);
    append(packets_, stream);
    append(packets_, static_cast<std::int32_t>(content.size()));
    append_all(packets_, content);
    ++count_;
    return *this;
  }
  Aedat4File& add_raw(const Bytes& bytes) {
    append_all(packets_, bytes);
    return *this;
  }

  [[nodiscard]] Bytes bytes() const {
    const Bytes empty = head(0);
    const auto end = static_cast<std::int64_t>(empty.size() + packets_.size());
    Bytes out = head(options_.table ? end : -1);
    append_all(out, packets_);
    if (!options_.table) return out;
    const std::vector<FlatWriter::Field> entry{FlatWriter::number<std::int64_t>(0, 1)};
    const Bytes table =
        packed(list_packet("FTAB", std::vector(count_, entry)), options_.compression);
    append_all(out, table);
    return out;
  }
  /// Where the first packet begins.
  [[nodiscard]] std::size_t head_bytes() const { return head(0).size(); }

  /// The head with another table position.
  [[nodiscard]] Bytes head(std::int64_t table_position) const {
    FlatWriter out("IOHE");
    std::vector<FlatWriter::Field> fields{FlatWriter::offset(2)};
    fields.push_back(FlatWriter::number(1, table_position));
    if (options_.compression != 0)
      fields.push_back(FlatWriter::number<std::int32_t>(0, options_.compression));
    out.point(out.table(0, fields));
    out.put_text(description());
    Bytes bytes;
    for (const char c : std::string("#!AER-DAT4.0\r\n")) bytes.push_back(static_cast<std::byte>(c));
    const Bytes flat = out.size_prefixed();
    append_all(bytes, flat);
    return bytes;
  }

 private:
  [[nodiscard]] std::string stream(int id, const std::string& type) const {
    const std::string size = type == "IMUS" || type == "TRIG"
                                 ? ""
                                 : "<attr key=\"sizeX\" type=\"int\">" +
                                       std::to_string(options_.width) +
                                       "</attr><attr key=\"sizeY\" type=\"int\">" +
                                       std::to_string(options_.height) + "</attr>";
    return "<node name=\"" + std::to_string(id) +
           "\" path=\"/o/\">\n<attr key=\"typeIdentifier\" " + "type=\"string\">" + type +
           "</attr>\n<node name=\"info\">" + size + "</node></node>\n";
  }
  [[nodiscard]] std::string description() const {
    return "<dv version=\"2.0\"><node name=\"outInfo\">" + stream(0, "EVTS") +
           (options_.frames ? stream(1, "FRME") : "") + stream(2, "IMUS") + stream(3, "TRIG") +
           options_.more + "</node></dv>";
  }

  Options options_;
  Bytes packets_;
  std::size_t count_ = 0;
};

}  // namespace pled::support
