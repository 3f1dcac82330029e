#pragma once

#include <string_view>

namespace aprsim::protocols {

/// Receives the requests that listeners refuse before the cell sees them. Thread: any; never
/// blocks.
class RefusalSink {
 public:
  virtual ~RefusalSink() = default;
  /// `source`: the listener, "crcl.fanuc"; `what`: the request and the reason.
  virtual void refused(std::string_view source, std::string_view what) = 0;
};

}  // namespace aprsim::protocols
