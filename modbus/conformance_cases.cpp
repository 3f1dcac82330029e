#include "modbus/conformance_cases.hpp"

#include <utility>

namespace aprsim::modbus::conformance {
std::string section_of(std::uint8_t function) {
  switch (function) {
    case 15:
      return "6.11";
    case 16:
      return "6.12";
    case 22:
      return "6.16";
    case 23:
      return "6.17";
    case 43:
      return "6.21";
    default:
      return "6." + std::to_string(function);
  }
}

namespace {

class Cases {
 public:
  void add(std::string name, Bytes body, int exception) {
    std::string section = section_of(body.front());
    all_.push_back({std::move(name), std::move(section), std::move(body), exception});
  }
  [[nodiscard]] std::vector<ConformanceCase> take() { return std::move(all_); }

 private:
  std::vector<ConformanceCase> all_;
};

void add_reads(Cases& cases) {
  for (const std::uint8_t fc :
       {std::uint8_t{1}, std::uint8_t{2}, std::uint8_t{3}, std::uint8_t{4}}) {
    const std::string f = "Fc" + std::to_string(fc);
    const bool bits = fc < 3;
    const std::uint16_t limit = bits ? 2000 : 125;
    cases.add(f + "FirstOne", pdu(fc, {0x8000, 1}), kAccepted);
    cases.add(f + "LastOne", pdu(fc, {0x80FF, 1}), kAccepted);
    cases.add(f + "Most", pdu(fc, {0x8000, bits ? std::uint16_t{256} : std::uint16_t{125}}),
              kAccepted);
    cases.add(f + "UpToTheEnd", pdu(fc, {0x80F0, 16}), kAccepted);
    cases.add(f + "None", pdu(fc, {0x8000, 0}), 3);
    cases.add(f + "OneTooMany", pdu(fc, {0x8000, static_cast<std::uint16_t>(limit + 1)}), 3);
    cases.add(f + "AllOnes", pdu(fc, {0x8000, 0xFFFF}), 3);
    cases.add(f + "QuantityBeforeAddress", pdu(fc, {0x0000, 0}), 3);
    cases.add(f + "BelowTheRange", pdu(fc, {0x7FFF, 1}), 2);
    cases.add(f + "StartsBelow", pdu(fc, {0x7FFF, 2}), 2);
    cases.add(f + "AboveTheRange", pdu(fc, {0x8100, 1}), 2);
    cases.add(f + "EndsAbove", pdu(fc, {0x80FF, 2}), 2);
    cases.add(f + "Zero", pdu(fc, {0x0000, 1}), 2);
    cases.add(f + "Wraps", pdu(fc, {0xFFFF, 2}), 2);
    cases.add(f + "LimitOutOfRange", pdu(fc, {0x80F0, limit}), 2);
    cases.add(f + "Short", Bytes{fc, 0x80, 0x00, 0x00}, 3);
    cases.add(f + "FunctionAlone", Bytes{fc}, 3);
    cases.add(f + "Trailing", Bytes{fc, 0x80, 0x00, 0x00, 0x01, 0x00}, 3);
    Bytes smuggled = pdu(fc, {0x8000, 1});
    const Bytes hidden = adu(pdu(6, {0x8000, 1}));
    smuggled.insert(smuggled.end(), hidden.begin(), hidden.end());
    cases.add(f + "HiddenWriteBehind", smuggled, 3);
  }
}

void add_single_writes(Cases& cases) {
  cases.add("Fc5On", pdu(5, {0x8000, 0xFF00}), kAccepted);
  cases.add("Fc5Off", pdu(5, {0x80FF, 0x0000}), kAccepted);
  cases.add("Fc5NoBoolean", pdu(5, {0x8000, 0x0001}), 3);
  cases.add("Fc5ValueBeforeAddress", pdu(5, {0x0000, 0xFF01}), 3);
  cases.add("Fc5Below", pdu(5, {0x7FFF, 0xFF00}), 2);
  cases.add("Fc5Short", Bytes{5, 0x80, 0x00, 0xFF}, 3);
  cases.add("Fc6First", pdu(6, {0x8000, 1}), kAccepted);
  cases.add("Fc6Last", pdu(6, {0x80FF, 0xFFFF}), kAccepted);
  cases.add("Fc6Unsigned", pdu(6, {0x8002, 0x8000}), kAccepted);
  cases.add("Fc6Below", pdu(6, {0x7FFF, 1}), 2);
  cases.add("Fc6Above", pdu(6, {0x8100, 1}), 2);
  cases.add("Fc6Short", Bytes{6, 0x80, 0x00, 0x00}, 3);
  cases.add("Fc6Trailing", Bytes{6, 0x80, 0x00, 0x00, 0x01, 0x00}, 3);
}

void add_multiple_writes(Cases& cases) {
  cases.add("Fc15One", write_many(15, 0x8000, 1, 1, {1}), kAccepted);
  cases.add("Fc15Nine", write_many(15, 0x8000, 9, 2, {0xFF, 0x01}), kAccepted);
  cases.add("Fc15All", write_many(15, 0x8000, 256, 32, zeros(32)), kAccepted);
  cases.add("Fc15None", write_many(15, 0x8000, 0, 0, {}), 3);
  cases.add("Fc15MostIsNoAddress", write_many(15, 0x8000, 1968, 246, zeros(246)), 2);
  cases.add("Fc15TooMany", write_many(15, 0x8000, 1969, 247, zeros(247)), 3);
  cases.add("Fc15CountTooLarge", write_many(15, 0x8000, 8, 2, {0, 0}), 3);
  cases.add("Fc15CountTooSmall", write_many(15, 0x8000, 9, 1, {0}), 3);
  cases.add("Fc16One", write_many(16, 0x8000, 1, 2, {0, 1}), kAccepted);
  cases.add("Fc16Most", write_many(16, 0x8000, 123, 246, zeros(246)), kAccepted);
  cases.add("Fc16TooMany", write_many(16, 0x8000, 124, 248, zeros(246)), 3);
  cases.add("Fc16None", write_many(16, 0x8000, 0, 0, {}), 3);
  cases.add("Fc16CountTooLarge", write_many(16, 0x8000, 1, 3, {0, 1, 0}), 3);
  cases.add("Fc16CountTooSmall", write_many(16, 0x8000, 2, 2, {0, 1}), 3);
  cases.add("Fc16CountLiesLong", write_many(16, 0x8000, 2, 4, {0, 1}), 3);
  cases.add("Fc16CountLiesShort", write_many(16, 0x8000, 1, 2, {0, 1, 0, 1}), 3);
  cases.add("Fc16NoCount", Bytes{16, 0x80, 0x00, 0x00, 0x01}, 3);
  cases.add("Fc16CountBeforeAddress", write_many(16, 0x0000, 1, 3, {0, 1, 0}), 3);
  cases.add("Fc16EndsAbove", write_many(16, 0x80FF, 2, 4, zeros(4)), 2);
  cases.add("Fc16Wraps", write_many(16, 0xFFFF, 2, 4, zeros(4)), 2);
}

void add_mask_writes(Cases& cases) {
  cases.add("Fc22First", pdu(22, {0x8000, 0xFFFF, 0}), kAccepted);
  cases.add("Fc22Last", pdu(22, {0x80FF, 0, 0xFFFF}), kAccepted);
  cases.add("Fc22Below", pdu(22, {0x7FFF, 0, 0}), 2);
  cases.add("Fc22Above", pdu(22, {0x8100, 0, 0}), 2);
  cases.add("Fc22Short", pdu(22, {0x8000, 0}), 3);
  cases.add("Fc22Trailing", pdu(22, {0x8000, 0, 0, 0}), 3);
}

Bytes read_and_write(std::uint16_t read, std::uint16_t reads, std::uint16_t write,
                     std::uint16_t writes, std::uint8_t bytes, const Bytes& data) {
  Bytes body = pdu(23, {read, reads, write, writes});
  body.push_back(bytes);
  body.insert(body.end(), data.begin(), data.end());
  return body;
}

void add_reads_with_writes(Cases& cases) {
  cases.add("Fc23One", read_and_write(0x8000, 1, 0x80FF, 1, 2, zeros(2)), kAccepted);
  cases.add("Fc23Most", read_and_write(0x8083, 125, 0x8087, 121, 242, zeros(242)), kAccepted);
  cases.add("Fc23ReadsNone", read_and_write(0x8000, 0, 0x8000, 1, 2, zeros(2)), 3);
  cases.add("Fc23ReadsTooMany", read_and_write(0x8000, 126, 0x8000, 1, 2, zeros(2)), 3);
  cases.add("Fc23WritesNone", read_and_write(0x8000, 1, 0x8000, 0, 0, {}), 3);
  cases.add("Fc23WritesTooMany", read_and_write(0x8000, 1, 0x8000, 122, 244, zeros(243)), 3);
  cases.add("Fc23CountTooSmall", read_and_write(0x8000, 1, 0x8000, 2, 2, zeros(2)), 3);
  cases.add("Fc23CountLies", read_and_write(0x8000, 1, 0x8000, 2, 4, zeros(2)), 3);
  cases.add("Fc23Trailing", read_and_write(0x8000, 1, 0x8000, 1, 2, zeros(4)), 3);
  cases.add("Fc23Short", pdu(23, {0x8000, 1, 0x8000, 1}), 3);
  cases.add("Fc23ReadsBelow", read_and_write(0x7FFF, 1, 0x8000, 1, 2, zeros(2)), 2);
  cases.add("Fc23ReadsBeyond", read_and_write(0x80FF, 2, 0x8000, 1, 2, zeros(2)), 2);
  cases.add("Fc23WritesBelow", read_and_write(0x8000, 1, 0x7FFF, 1, 2, zeros(2)), 2);
  cases.add("Fc23WritesBeyond", read_and_write(0x8000, 1, 0x80FF, 2, 4, zeros(4)), 2);
  cases.add("Fc23CountBeforeAddress", read_and_write(0, 0, 0, 1, 2, zeros(2)), 3);
}

void add_device_identifications(Cases& cases) {
  cases.add("Fc43OtherInterface", Bytes{43, 13, 1, 0}, 1);
  cases.add("Fc43Alone", Bytes{43}, 3);
  cases.add("Fc43Short", Bytes{43, 14, 1}, 3);
  cases.add("Fc43Trailing", Bytes{43, 14, 1, 0, 0}, 3);
  cases.add("Fc43LevelZero", Bytes{43, 14, 0, 0}, 3);
  cases.add("Fc43LevelFive", Bytes{43, 14, 5, 0}, 3);
  cases.add("Fc43NoSuchObject", Bytes{43, 14, 4, 7}, 2);
}

}  // namespace

std::vector<ConformanceCase> conformance_cases() {
  Cases cases;
  add_reads(cases);
  add_single_writes(cases);
  add_multiple_writes(cases);
  add_mask_writes(cases);
  add_reads_with_writes(cases);
  add_device_identifications(cases);
  return cases.take();
}

}  // namespace aprsim::modbus::conformance
