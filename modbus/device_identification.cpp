#include "modbus/device_identification.hpp"

#include <array>
#include <string_view>

namespace aprsim::modbus {
namespace {

using Level = IdentificationRequest::Level;

/// Objects by id: vendor, product code, revision (basic); URL, product, model, application
/// (regular).
constexpr std::array<std::string_view, 7> kObjects{
    "aprsim",
    "APRSIM-CONVEYOR",
    APRSIM_VERSION,
    "",
    "Simulated conveyor of the APRS kitting cell",
    "Belt drive with PLC",
    "aprsimd",
};
constexpr std::size_t kBasicObjects = 3;
constexpr std::size_t kObjectsHead = 7;  // of the PDU: function, type, level, ..., object count

constexpr std::size_t whole_size() {
  std::size_t size = kObjectsHead;
  for (const std::string_view object : kObjects) size += 2 + object.size();
  return size;
}
static_assert(whole_size() <= 253, "the objects must fit into one reply");

// Regular objects, by stream and one by one.
constexpr std::uint8_t kConformity = 0x82;

void append(std::vector<std::uint8_t>& pdu, std::size_t id) {
  const std::string_view value = kObjects[id];
  pdu.push_back(static_cast<std::uint8_t>(id));
  pdu.push_back(static_cast<std::uint8_t>(value.size()));
  pdu.insert(pdu.end(), value.begin(), value.end());
  ++pdu[kObjectsHead - 1];
}

}  // namespace

Checked<IdentificationRequest> parse_identification(std::span<const std::uint8_t> pdu) {
  if (pdu.size() > 1 && pdu[1] != kDeviceIdentification) {
    return tl::unexpected(ExceptionCode::kIllegalFunction);
  }
  if (pdu.size() != 4 || pdu[2] < 1 || pdu[2] > 4) {
    return tl::unexpected(ExceptionCode::kIllegalDataValue);
  }
  IdentificationRequest request{static_cast<Level>(pdu[2]), pdu[3]};
  const std::size_t objects = request.level == Level::kBasic ? kBasicObjects : kObjects.size();
  if (request.object >= objects) {
    if (request.level == Level::kIndividual) {
      return tl::unexpected(ExceptionCode::kIllegalDataAddress);
    }
    request.object = 0;
  }
  return request;
}

std::vector<std::uint8_t> identification_reply(std::span<const std::uint8_t> adu,
                                               const IdentificationRequest& request) {
  std::vector<std::uint8_t> pdu{kEncapsulatedInterface,
                                kDeviceIdentification,
                                static_cast<std::uint8_t>(request.level),
                                kConformity,
                                0,   // no more follows
                                0,   // next object
                                0};  // objects, counted by append()
  if (request.level == Level::kIndividual) {
    append(pdu, request.object);
  } else {
    const std::size_t end = request.level == Level::kBasic ? kBasicObjects : kObjects.size();
    for (std::size_t id = request.object; id < end; ++id) append(pdu, id);
  }
  const auto length = static_cast<std::uint8_t>(pdu.size() + 1);
  std::vector<std::uint8_t> reply{adu[0], adu[1], 0, 0, 0, length, adu[6]};
  reply.insert(reply.end(), pdu.begin(), pdu.end());
  return reply;
}

}  // namespace aprsim::modbus
