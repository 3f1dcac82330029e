#include "protocols/modbus/request_reader.hpp"

#include <algorithm>

#include "protocols/net/foreign_protocol.hpp"

namespace aprsim::modbus_server {
namespace {

// Transaction and protocol id: fewer bytes do not distinguish Modbus from other protocols.
constexpr std::size_t kProtocolBytes = 4;

}  // namespace

std::string_view RequestReader::foreign_protocol() {
  if (judged_ || size_ < kProtocolBytes) return {};
  judged_ = true;
  // In these bytes a Modbus master has protocol id 0.
  if (bytes_[2] == 0 && bytes_[3] == 0) return {};
  return protocols::foreign_protocol({reinterpret_cast<const char*>(bytes_.data()), size_});
}

modbus::ValidatedRequest RequestReader::next() {
  const modbus::ValidatedRequest request = modbus::validate_request(rest(), rules_);
  incomplete_ = request.verdict == modbus::Verdict::kIncomplete;
  if (request.verdict != modbus::Verdict::kBroken) used_ += request.adu.size();
  return request;
}

void RequestReader::compact() {
  if (used_ == 0) return;
  std::copy(bytes_.begin() + static_cast<std::ptrdiff_t>(used_),
            bytes_.begin() + static_cast<std::ptrdiff_t>(size_), bytes_.begin());
  size_ -= used_;
  used_ = 0;
}

}  // namespace aprsim::modbus_server
