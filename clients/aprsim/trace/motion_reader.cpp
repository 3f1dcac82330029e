#include "clients/aprsim/trace/motion_reader.hpp"

#include <fstream>
#include <iterator>
#include <utility>

#include "clients/aprsim/trace/trace.hpp"
#include "proto/journal/frames.hpp"

namespace aprsim::trace {

Result<void> read_motion(const std::string& file, const TakeMotion& take) {
  std::ifstream in(file, std::ios::binary);
  if (!in) return fail(ErrorCode::kNotFound, "motion", file + " cannot be opened");
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  auto frames = aprsim::journal::FrameDecoder::open(bytes);
  if (!frames) return tl::unexpected(frames.error());
  v1::MotionHeader header;
  bool changed = false;
  TraceClock clock;
  for (std::string_view one = frames->next(); !one.empty(); one = frames->next()) {
    v1::MotionRecord record;
    if (!record.ParseFromArray(one.data(), static_cast<int>(one.size()))) break;
    if (record.has_header()) {
      header = std::move(*record.mutable_header());
      changed = true;
    } else if (record.has_snapshot()) {
      const v1::Snapshot& snapshot = record.snapshot();
      take(clock.at(snapshot.epoch(), seconds_of(snapshot.sim_time())), snapshot,
           std::exchange(changed, false) ? &header : nullptr);
    }
  }
  if (!frames->damage().empty()) {
    return fail(ErrorCode::kInvalidArgument, "motion", file + ": " + frames->damage());
  }
  if (!header.has_cell()) {
    return fail(ErrorCode::kInvalidArgument, "motion", file + ": it has no header");
  }
  return {};
}

}  // namespace aprsim::trace
