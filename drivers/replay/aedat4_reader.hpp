#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/replay/aedat4_header.hpp"
#include "drivers/replay/decompressor.hpp"
#include "drivers/replay/file.hpp"
#include "drivers/replay/message.hpp"

namespace pled::replay {

/// The packets of an AEDAT 4.0 file in their order, each read and unpacked only when asked
/// for. Where the packets end is known from the table at the end of the file; the table is
/// believed only when it can be read, and without it they go on to the end of the file.
class Aedat4Reader {
 public:
  /// Larger packets, packed or not, are refused. 16 MiB hold a million events or a frame of
  /// 4096 x 1024 pixels in colour; those seen hold 10 ms.
  static constexpr std::size_t kMaxPacketBytes = std::size_t{16} << 20;

  /// Sets aside what a packet may take packed, no more than the file, and unpacked, at most
  /// kMaxPacketBytes each; the system provides what is used of it. Errors: File::open's,
  /// kUnsupported (the compression).
  [[nodiscard]] static Result<Aedat4Reader> open(const std::string& path,
                                                 const Aedat4Header& header);

  /// Begins anew at the first packet.
  void rewind() noexcept;
  /// Goes on to the next packet and gives the number of its stream. Errors: kEndOfStream,
  /// kIoFailure. Where no packet begins, or one is cut by the end, the stream ends too:
  /// is_cut() says so and last_message() has words.
  [[nodiscard]] Result<std::int32_t> next() noexcept;
  /// The packet that next() came to, unpacked: a FlatBuffer with its length in front; valid
  /// until the next call. Errors: kCorrupt, kTruncated, kTooLarge, kIoFailure, with words in
  /// last_message().
  [[nodiscard]] Result<std::span<const std::byte>> payload() noexcept;
  /// Sets the words for a packet whose content is not as its kind says.
  void blame(const char* what) noexcept;

  /// The rest of the file could not be read as packets.
  [[nodiscard]] bool is_cut() const noexcept { return is_cut_; }
  /// Packets that the table lists; -1 without a table.
  [[nodiscard]] std::int64_t listed_packets() const noexcept { return listed_packets_; }
  /// Bytes of the packets gone past, and of all.
  [[nodiscard]] std::int64_t position() const noexcept { return next_at_ - begin_; }
  [[nodiscard]] std::int64_t size() const noexcept { return end_ - begin_; }
  [[nodiscard]] double progress() const noexcept;
  [[nodiscard]] std::string_view last_message() const noexcept { return message_.text(); }

 private:
  Aedat4Reader(File file, const std::string& path, const Aedat4Header& header,
               Compression compression, Decompressor decompressor);

  void look_at_table(std::int64_t position) noexcept;
  [[nodiscard]] Result<std::span<const std::byte>> read(std::int64_t at,
                                                        std::int64_t bytes) noexcept;
  [[nodiscard]] bool is_known(std::int32_t stream) const noexcept;

  File file_;
  std::string path_;
  Decompressor decompressor_;
  std::vector<std::int32_t> streams_;
  std::size_t packed_bytes_;
  std::size_t plain_bytes_;
  std::unique_ptr<std::byte[]> packed_;
  std::unique_ptr<std::byte[]> plain_;
  std::int64_t begin_ = 0;
  std::int64_t end_ = 0;      ///< of the packets
  std::int64_t next_at_ = 0;  ///< of the packet that next() comes to
  std::int64_t at_ = 0;       ///< of the content of the current packet
  std::int64_t bytes_ = 0;    ///< its length
  std::int64_t listed_packets_ = -1;
  bool is_cut_ = false;
  Message message_;
};

}  // namespace pled::replay
