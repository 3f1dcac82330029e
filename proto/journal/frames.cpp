#include "proto/journal/frames.hpp"

#include <algorithm>
#include <cstdint>
#include <stdexcept>
#include <utility>
#include <zstd.h>

namespace aprsim::journal {
namespace {

constexpr int kLevel = 3;

void check(std::size_t code) {
  if (ZSTD_isError(code) != 0) {
    throw std::runtime_error(std::string("zstd: ") + ZSTD_getErrorName(code));
  }
}

struct FreeContext {
  void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
};

std::unique_ptr<ZSTD_CCtx, FreeContext> new_context() {
  std::unique_ptr<ZSTD_CCtx, FreeContext> context(ZSTD_createCCtx());
  if (!context) throw std::runtime_error("zstd: no memory for a context");
  check(ZSTD_CCtx_setParameter(context.get(), ZSTD_c_checksumFlag, 1));
  check(ZSTD_CCtx_setParameter(context.get(), ZSTD_c_compressionLevel, kLevel));
  return context;
}

std::string frame_of(ZSTD_CCtx* context, std::string_view plain) {
  std::string frame(ZSTD_compressBound(plain.size()), '\0');
  const std::size_t size =
      ZSTD_compress2(context, frame.data(), frame.size(), plain.data(), plain.size());
  check(size);
  // Frames are kept, also in memory, where they are to take what they say.
  frame.resize(size);
  frame.shrink_to_fit();
  return frame;
}

}  // namespace

void FrameEncoder::Free::operator()(ZSTD_CCtx_s* context) const { ZSTD_freeCCtx(context); }

FrameEncoder::FrameEncoder() : context_(new_context().release()) {}
FrameEncoder::~FrameEncoder() = default;
FrameEncoder::FrameEncoder(FrameEncoder&&) noexcept = default;
FrameEncoder& FrameEncoder::operator=(FrameEncoder&&) noexcept = default;

void FrameEncoder::add(const google::protobuf::MessageLite& message) {
  const std::size_t size = message.ByteSizeLong();
  std::uint64_t left = size;
  for (; left >= 0x80; left >>= 7U) plain_.push_back(static_cast<char>(left | 0x80U));
  plain_.push_back(static_cast<char>(left));
  message.AppendToString(&plain_);
}

std::string FrameEncoder::take() {
  if (plain_.empty()) return {};
  if (plain_.size() > kMaxFrameBytes) {
    throw std::runtime_error("a frame of " + std::to_string(plain_.size()) +
                             " bytes, the limit is " + std::to_string(kMaxFrameBytes));
  }
  std::string frame = frame_of(context_.get(), plain_);
  plain_.clear();
  return frame;
}

std::string compressed(std::string_view bytes) { return frame_of(new_context().get(), bytes); }

Result<FrameDecoder> FrameDecoder::open(std::string_view bytes, const UnpackedLimits& limits) {
  if (!bytes.starts_with(kMagic)) {
    return fail(ErrorCode::kInvalidArgument, "journal",
                "no journal: it does not begin as one (APRSIMJ1)");
  }
  FrameDecoder decoder(bytes.substr(kMagic.size()), limits);
  decoder.good_ = kMagic.size();
  return decoder;
}

std::string_view FrameDecoder::next() {
  while (at_ == frame_.size()) {
    good_ += std::exchange(frame_bytes_, 0);
    if (!damage_.empty() || left_.empty() || !next_frame()) return {};
  }
  const std::string_view rest = std::string_view(frame_).substr(at_);
  std::uint64_t size = 0;
  std::size_t used = 0;
  bool whole = false;
  while (!whole && used < rest.size() && used < 10) {
    const auto byte = static_cast<std::uint8_t>(rest[used]);
    size |= std::uint64_t{byte & 0x7fU} << (7 * used);
    ++used;
    whole = byte < 0x80;
  }
  // A message of no bytes says nothing; none is written.
  if (!whole || size == 0 || size > rest.size() - used) {
    give_up("damaged: a frame has no whole records");
    return {};
  }
  at_ += used + static_cast<std::size_t>(size);
  return rest.substr(used, static_cast<std::size_t>(size));
}

bool FrameDecoder::next_frame() {
  const std::size_t size = ZSTD_findFrameCompressedSize(left_.data(), left_.size());
  if (ZSTD_isError(size) != 0) {
    give_up("cut off, or damaged, in the middle of a frame");
    return false;
  }
  const unsigned long long plain = ZSTD_getFrameContentSize(left_.data(), left_.size());
  if (plain == ZSTD_CONTENTSIZE_ERROR || plain == ZSTD_CONTENTSIZE_UNKNOWN) {
    give_up("damaged: a frame does not say its size");
    return false;
  }
  // Before any memory is taken.
  if (plain > limits_.frame || plain > limits_.file) {
    give_up("damaged: a frame would unpack to " + std::to_string(plain) + " bytes, the limit is " +
            std::to_string(std::min(limits_.frame, limits_.file)));
    return false;
  }
  limits_.file -= static_cast<std::size_t>(plain);
  frame_.resize(static_cast<std::size_t>(plain));
  at_ = 0;
  const std::size_t got = ZSTD_decompress(frame_.data(), frame_.size(), left_.data(), size);
  if (ZSTD_isError(got) != 0 || got != frame_.size()) {
    give_up("damaged: a frame's checksum or content is wrong");
    return false;
  }
  left_.remove_prefix(size);
  frame_bytes_ = size;
  return true;
}

void FrameDecoder::give_up(const std::string& why) {
  damage_ = why;
  left_ = {};
  frame_.clear();
  at_ = frame_bytes_ = 0;
}

}  // namespace aprsim::journal
