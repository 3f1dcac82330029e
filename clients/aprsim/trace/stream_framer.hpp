#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "aprsim/v1/journal.pb.h"
#include "crcl/framer.hpp"

namespace aprsim::trace {

/// Cuts what went one way over a connection into CRCL documents, Modbus units or lines. Finds its
/// way again where bytes are missing. Thread: one at a time.
class StreamFramer {
 public:
  StreamFramer(v1::WireKind kind, bool from_client);

  /// What has become complete with these bytes.
  [[nodiscard]] std::vector<std::string> take(std::string_view bytes);
  /// Bytes are missing here: what was begun is lost.
  void lose();
  /// Why nothing more is read; empty = it is.
  [[nodiscard]] const std::string& broken() const { return broken_; }

 private:
  void take_documents(std::string_view bytes, std::vector<std::string>& out);
  void take_units(std::string_view bytes, std::vector<std::string>& out);
  void take_lines(std::string_view bytes, std::vector<std::string>& out);

  v1::WireKind kind_;
  bool from_client_;
  bool searching_ = true;  ///< for a beginning
  crcl::Framer documents_;
  std::string buffer_;
  std::string broken_;
};

}  // namespace aprsim::trace
