#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "aprsim/v1/journal.pb.h"
#include "crcl/framer.hpp"

namespace aprsim::trace {

/// Splits one direction of a connection into CRCL documents, Modbus units, lines or messages.
/// Resynchronises after missing bytes. Thread: one at a time.
class StreamFramer {
 public:
  StreamFramer(v1::WireKind kind, bool from_client);

  /// The units that these bytes complete.
  [[nodiscard]] std::vector<std::string> take(std::string_view bytes);
  /// Bytes are missing here: drops an incomplete unit.
  void lose();
  /// Why reading has stopped; empty = it has not.
  [[nodiscard]] const std::string& broken() const { return broken_; }

 private:
  void take_documents(std::string_view bytes, std::vector<std::string>& out);
  void take_units(std::string_view bytes, std::vector<std::string>& out);
  void take_lines(std::string_view bytes, std::vector<std::string>& out);
  void take_messages(std::string_view bytes, std::vector<std::string>& out);

  v1::WireKind kind_;
  bool from_client_;
  bool searching_ = true;  ///< for a beginning
  crcl::Framer documents_;
  std::string buffer_;
  std::string broken_;
};

}  // namespace aprsim::trace
