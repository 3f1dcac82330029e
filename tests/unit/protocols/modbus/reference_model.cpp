#include "tests/unit/protocols/modbus/reference_model.hpp"

#include <string>
#include <vector>

namespace aprsim::modbus::testing {
namespace {

constexpr int kLow = 0x8000, kHigh = 0x80FF;

int be(const Bytes& b, std::size_t i) { return b.at(i) * 256 + b.at(i + 1); }

Bytes exception(const Bytes& body, int code) {
  return {static_cast<std::uint8_t>(body[0] | 0x80), static_cast<std::uint8_t>(code)};
}

bool outside(int first, int count) { return first < kLow || first + count - 1 > kHigh; }

bool bad_value(int address, int value) {
  return ((address == 0x8000 || address == 0x8001) && value > 1) ||
         (address == 0x8002 && value > 0x8000);
}

}  // namespace

std::optional<Bytes> ReferenceModel::answer(const Bytes& frame) {
  if (be(frame, 2) != 0) return std::nullopt;
  const Bytes body = respond(Bytes(frame.begin() + 7, frame.end()));
  Bytes reply{frame[0], frame[1], 0, 0, 0, 0, frame[6]};
  reply[4] = static_cast<std::uint8_t>((body.size() + 1) / 256);
  reply[5] = static_cast<std::uint8_t>((body.size() + 1) % 256);
  reply.insert(reply.end(), body.begin(), body.end());
  return reply;
}

Bytes ReferenceModel::respond(const Bytes& body) {
  switch (body[0]) {
    case 1:
      return read_bits(body, coils());
    case 2:
      return read_bits(body, discrete());
    case 3:
      return read_words(body, holding_);
    case 4:
      return read_words(body, inputs());
    case 5:
      return write_coil(body);
    case 6:
      return write_register(body);
    case 15:
      return write_coils(body);
    case 16:
      return write_registers(body);
    case 22:
      return mask_write(body);
    case 23:
      return read_write(body);
    case 43:
      return identify(body);
    default:
      return exception(body, 1);
  }
}

std::map<int, int> ReferenceModel::inputs() const {
  const auto value = [this](int address) {
    const auto found = holding_.find(address);
    return found == holding_.end() ? 0 : found->second;
  };
  // The model's belt never moves; its target shows what the settings amount to (limit 30000).
  int target = value(0x8002) > 30000 ? 30000 : value(0x8002);
  if (value(0x8000) == 0) target = 0;
  const int signed_target = value(0x8001) == 1 ? target : (65536 - target) % 65536;
  const int state = faulted_ ? 4 : target == 0 ? 1 : 2;
  return {{0x8001, signed_target}, {0x8002, state}, {0x8003, faulted_ ? 2 : 0}, {0x8008, 30000}};
}

std::map<int, bool> ReferenceModel::discrete() const {
  const auto stop = coils_.find(0x8002);
  return {{0x8000, !faulted_}, {0x8003, faulted_}, {0x8004, stop != coils_.end() && stop->second}};
}

std::map<int, bool> ReferenceModel::coils() const {
  std::map<int, bool> all = coils_;
  for (const int address : {0x8000, 0x8001}) {
    const auto word = holding_.find(address);
    all[address] = word != holding_.end() && word->second == 1;
  }
  all[0x8003] = false;
  return all;
}

void ReferenceModel::store_word(int address, int value) {
  // A drive with a fault ignores the order to run.
  holding_[address] = address == 0x8000 && faulted_ ? 0 : value;
}

void ReferenceModel::store_coils(const std::map<int, bool>& values) {
  for (const auto& [address, on] : values) coils_[address] = on;
  const auto asked = values.find(0x8003);
  if (asked != values.end() && asked->second && !coils_[0x8002]) faulted_ = false;
  if (coils_[0x8002]) {
    faulted_ = true;
    holding_[0x8000] = 0;
  }
  for (const int address : {0x8000, 0x8001}) {
    const auto value = values.find(address);
    if (value != values.end()) store_word(address, value->second ? 1 : 0);
  }
}

Bytes ReferenceModel::read_bits(const Bytes& body, const std::map<int, bool>& area) {
  if (body.size() != 5) return exception(body, 3);
  const int first = be(body, 1), count = be(body, 3);
  if (count == 0 || count > 2000) return exception(body, 3);
  if (outside(first, count)) return exception(body, 2);
  Bytes reply{body[0], static_cast<std::uint8_t>(count / 8 + (count % 8 != 0 ? 1 : 0))};
  reply.resize(2U + reply[1], 0);
  for (int i = 0; i < count; ++i) {
    const auto bit = area.find(first + i);
    if (bit == area.end() || !bit->second) continue;
    auto& byte = reply[2 + static_cast<std::size_t>(i) / 8];
    byte = static_cast<std::uint8_t>(byte | (1 << (i % 8)));
  }
  return reply;
}

Bytes ReferenceModel::read_words(const Bytes& body, const std::map<int, int>& area) {
  if (body.size() != 5) return exception(body, 3);
  const int first = be(body, 1), count = be(body, 3);
  if (count == 0 || count > 125) return exception(body, 3);
  if (outside(first, count)) return exception(body, 2);
  Bytes reply{body[0], static_cast<std::uint8_t>(2 * count)};
  for (int i = 0; i < count; ++i) {
    const auto word = area.find(first + i);
    const int value = word == area.end() ? 0 : word->second;
    reply.push_back(static_cast<std::uint8_t>(value / 256));
    reply.push_back(static_cast<std::uint8_t>(value % 256));
  }
  return reply;
}

Bytes ReferenceModel::write_coil(const Bytes& body) {
  if (body.size() != 5) return exception(body, 3);
  const int value = be(body, 3);
  if (value != 0 && value != 0xFF00) return exception(body, 3);
  if (outside(be(body, 1), 1)) return exception(body, 2);
  store_coils({{be(body, 1), value != 0}});
  return body;
}

Bytes ReferenceModel::write_register(const Bytes& body) {
  if (body.size() != 5) return exception(body, 3);
  const int address = be(body, 1), value = be(body, 3);
  if (outside(address, 1)) return exception(body, 2);
  if (bad_value(address, value)) return exception(body, 3);
  store_word(address, value);
  return body;
}

Bytes ReferenceModel::write_coils(const Bytes& body) {
  if (body.size() < 6) return exception(body, 3);
  const int first = be(body, 1), count = be(body, 3), bytes = body[5];
  const int needed = count / 8 + (count % 8 != 0 ? 1 : 0);
  if (count == 0 || count > 1968 || bytes != needed) return exception(body, 3);
  if (body.size() != 6U + static_cast<std::size_t>(bytes)) return exception(body, 3);
  if (outside(first, count)) return exception(body, 2);
  std::map<int, bool> values;
  for (int i = 0; i < count; ++i) {
    values[first + i] = ((body[6 + static_cast<std::size_t>(i) / 8] >> (i % 8)) & 1) == 1;
  }
  store_coils(values);
  return {body.begin(), body.begin() + 5};
}

Bytes ReferenceModel::write_registers(const Bytes& body) {
  if (body.size() < 6) return exception(body, 3);
  const int first = be(body, 1), count = be(body, 3);
  if (count == 0 || count > 123 || body[5] != 2 * count) return exception(body, 3);
  if (body.size() != 6U + 2U * static_cast<std::size_t>(count)) return exception(body, 3);
  if (outside(first, count)) return exception(body, 2);
  const auto value = [&](int i) { return be(body, 6 + 2 * static_cast<std::size_t>(i)); };
  for (int i = 0; i < count; ++i) {
    if (bad_value(first + i, value(i))) return exception(body, 3);
  }
  for (int i = 0; i < count; ++i) store_word(first + i, value(i));
  return {body.begin(), body.begin() + 5};
}

Bytes ReferenceModel::mask_write(const Bytes& body) {
  if (body.size() != 7) return exception(body, 3);
  const int address = be(body, 1);
  if (outside(address, 1)) return exception(body, 2);
  int value = 0;
  for (int bit = 0; bit < 16; ++bit) {
    const bool keep = ((be(body, 3) >> bit) & 1) == 1;
    const int source = keep ? holding_[address] : be(body, 5);
    value += ((source >> bit) & 1) << bit;
  }
  if (bad_value(address, value)) return exception(body, 3);
  store_word(address, value);
  return body;
}

Bytes ReferenceModel::read_write(const Bytes& body) {
  if (body.size() < 10) return exception(body, 3);
  const int reads = be(body, 3), writes = be(body, 7);
  if (reads == 0 || reads > 125 || writes == 0 || writes > 121) return exception(body, 3);
  if (body[9] != 2 * writes || body.size() != 10U + body[9]) return exception(body, 3);
  if (outside(be(body, 1), reads) || outside(be(body, 5), writes)) return exception(body, 2);
  Bytes write{23};
  write.insert(write.end(), body.begin() + 5, body.end());
  const Bytes written = write_registers(write);
  if (written[0] != 23) return written;
  Bytes read{23};
  read.insert(read.end(), body.begin() + 1, body.begin() + 5);
  return read_words(read, holding_);
}

Bytes ReferenceModel::identify(const Bytes& body) {
  const std::vector<std::string> objects{"aprsim",
                                         "APRSIM-CONVEYOR",
                                         APRSIM_VERSION,
                                         "",
                                         "Simulated conveyor of the APRS kitting cell",
                                         "Belt drive with PLC",
                                         "aprsimd"};
  if (body.size() > 1 && body[1] != 14) return exception(body, 1);
  if (body.size() != 4 || body[2] == 0 || body[2] > 4) return exception(body, 3);
  if (body[2] == 4 && body[3] > 6) return exception(body, 2);
  const std::size_t end = body[2] == 1 ? 3 : 7;
  std::size_t first = body[3] < end ? body[3] : 0;
  const std::size_t last = body[2] == 4 ? first + 1 : end;
  Bytes reply{43, 14, body[2], 0x82, 0, 0, static_cast<std::uint8_t>(last - first)};
  for (; first < last; ++first) {
    reply.push_back(static_cast<std::uint8_t>(first));
    reply.push_back(static_cast<std::uint8_t>(objects[first].size()));
    for (const char c : objects[first]) reply.push_back(static_cast<std::uint8_t>(c));
  }
  return reply;
}

}  // namespace aprsim::modbus::testing
