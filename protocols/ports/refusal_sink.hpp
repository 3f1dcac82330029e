#pragma once

#include <string_view>

namespace aprsim::protocols {

/// Hears what listeners say no to themselves, before the cell sees it. Thread: any; never waits.
class RefusalSink {
 public:
  virtual ~RefusalSink() = default;
  /// `source`: the listener, "crcl.fanuc"; `what` was refused, and why.
  virtual void refused(std::string_view source, std::string_view what) = 0;
};

}  // namespace aprsim::protocols
