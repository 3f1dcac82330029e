#pragma once

#include <cstddef>
#include <limits>
#include <memory>
#include <string>
#include <string_view>

#include <google/protobuf/message_lite.h>

#include "world/base/result.hpp"

struct ZSTD_CCtx_s;

/// The layers of a journal file below its records (aprsim/v1/journal.proto): length-delimited
/// messages in zstd frames, each with a checksum.
namespace aprsim::journal {

/// The first bytes of a file: a skippable zstd frame.
inline constexpr std::string_view kMagic{
    "\x50\x2a\x4d\x18\x08\x00\x00\x00"
    "APRSIMJ1",
    16};
/// A frame holds some so many bytes of records; one record may make it larger.
inline constexpr std::size_t kFrameBytes = std::size_t{256} << 10;
/// Largest frame, unpacked. No writer makes a larger one, and readers take it for damage.
inline constexpr std::size_t kMaxFrameBytes = std::size_t{32} << 20;
/// Bounds of the memory that a file from outside takes unpacked.
struct UnpackedLimits {
  std::size_t frame = kMaxFrameBytes;                          ///< of one frame
  std::size_t file = std::numeric_limits<std::size_t>::max();  ///< of all frames together
};

/// Gathers messages and gives them out as frames. Thread: one at a time.
class FrameEncoder {
 public:
  FrameEncoder();
  ~FrameEncoder();
  FrameEncoder(FrameEncoder&&) noexcept;
  FrameEncoder& operator=(FrameEncoder&&) noexcept;

  void add(const google::protobuf::MessageLite& message);
  /// Bytes of messages that no frame has yet.
  [[nodiscard]] std::size_t pending() const { return plain_.size(); }
  /// All of them as one frame; empty when there are none. Throws std::runtime_error when zstd
  /// fails, as for want of memory.
  [[nodiscard]] std::string take();

 private:
  struct Free {
    void operator()(ZSTD_CCtx_s* context) const;
  };
  std::string plain_;
  std::unique_ptr<ZSTD_CCtx_s, Free> context_;
};

/// The bytes as one zstd frame with a checksum, for other formats. Throws as FrameEncoder::take.
[[nodiscard]] std::string compressed(std::string_view bytes);

/// Takes the messages of one file's bytes. Thread: one at a time.
class FrameDecoder {
 public:
  /// `bytes` outlive the decoder. Errors: kInvalidArgument, field "journal", where they do not
  /// begin as a journal does.
  [[nodiscard]] static Result<FrameDecoder> open(std::string_view bytes,
                                                 const UnpackedLimits& limits = {});

  /// The next message's bytes, valid until the next call; empty at the end. The end is where the
  /// bytes end, or the last frame that is complete: see damage().
  [[nodiscard]] std::string_view next();
  /// Why the end came before that of the bytes: "cut off ..." or "damaged ..."; empty = it did not.
  [[nodiscard]] const std::string& damage() const { return damage_; }
  /// Bytes of the frames given out so far, with those that begin the file.
  [[nodiscard]] std::size_t good_bytes() const { return good_; }

 private:
  FrameDecoder(std::string_view bytes, const UnpackedLimits& limits)
      : left_(bytes), limits_(limits) {}
  [[nodiscard]] bool next_frame();
  void give_up(const std::string& why);

  std::string_view left_;  ///< of the file
  UnpackedLimits limits_;
  std::string frame_;   ///< the present one, plain
  std::size_t at_ = 0;  ///< in the present one
  std::size_t good_ = 0, frame_bytes_ = 0;
  std::string damage_;
};

}  // namespace aprsim::journal
