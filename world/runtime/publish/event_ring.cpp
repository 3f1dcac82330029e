#include "world/runtime/publish/event_ring.hpp"

#include <algorithm>
#include <cstring>
#include <type_traits>

namespace aprsim::world {
namespace {

/// Parts of the ring that one event may fill.
constexpr std::size_t kParts = 8;

/// The members of an event that are numbers.
struct Numbers {
  std::uint64_t sequence = 0, epoch = 0, step = 0, number = 0;
  SimTime time{};
  api::CellEventKind kind{};
  int robot = 0;
  std::uint32_t names = 0;
};
static_assert(std::is_trivially_copyable_v<Numbers>);

template <typename T>
void append(std::string& to, const T& value) {
  to.append(reinterpret_cast<const char*>(&value), sizeof value);
}

void append_text(std::string& to, std::string_view text) {
  append(to, static_cast<std::uint32_t>(text.size()));
  to.append(text);
}

/// Reads what append() wrote, in the same order.
class Decoder {
 public:
  explicit Decoder(std::string_view bytes) : rest_(bytes) {}

  template <typename T>
  T value() {
    T value;
    std::memcpy(&value, rest_.data(), sizeof value);
    rest_.remove_prefix(sizeof value);
    return value;
  }
  std::string text() {
    const auto size = value<std::uint32_t>();
    std::string text(rest_.substr(0, size));
    rest_.remove_prefix(size);
    return text;
  }

 private:
  std::string_view rest_;
};

}  // namespace

EventRing::EventRing(std::size_t capacity, std::size_t bytes)
    : slots_(std::max<std::size_t>(capacity, 1)), arena_(bytes) {
  encoded_.reserve(bytes / kParts);
}

void EventRing::encode(const api::CellEvent& event) {
  const std::size_t most = arena_.size() / kParts;
  encoded_.clear();
  const auto names = static_cast<std::uint32_t>(std::min(event.names.size(), api::kMaxEventNames));
  append(encoded_, Numbers{event.sequence, event.epoch, event.step, event.number, event.time,
                           event.kind, event.robot, names});
  const auto add = [&](std::string_view text) {
    const std::size_t used = encoded_.size() + (names + 1) * sizeof(std::uint32_t);
    append_text(encoded_, text.substr(0, most > used ? most - used : 0));
  };
  for (std::uint32_t i = 0; i < names; ++i) add(event.names[i]);
  add(event.text);
}

void EventRing::push(const api::CellEvent& event) {
  encode(event);
  const std::size_t size = encoded_.size();
  if (count_ == slots_.size()) drop_oldest();
  if (end_ + size > arena_.size()) {
    // The events up to the arena's end are the oldest ones.
    while (count_ > 0 && slot(0).begin >= end_) drop_oldest();
    end_ = 0;
  }
  const auto overlaps = [&](const Slot& old) {
    return old.begin < end_ + size && end_ < old.begin + old.size;
  };
  while (count_ > 0 && overlaps(slot(0))) drop_oldest();
  std::memcpy(arena_.data() + end_, encoded_.data(), size);
  slots_[(first_ + count_) % slots_.size()] = {event.sequence, end_, size};
  ++count_;
  end_ += size;
}

std::string_view EventRing::bytes(std::size_t index) const {
  const Slot& at = slot(index);
  return {arena_.data() + at.begin, at.size};
}

std::size_t EventRing::memory() const {
  return arena_.size() + slots_.size() * sizeof(Slot) + encoded_.capacity();
}

api::CellEvent EventRing::decode(std::string_view bytes) {
  Decoder from(bytes);
  const auto numbers = from.value<Numbers>();
  api::CellEvent event;
  event.sequence = numbers.sequence;
  event.epoch = numbers.epoch;
  event.step = numbers.step;
  event.time = numbers.time;
  event.kind = numbers.kind;
  event.robot = numbers.robot;
  event.number = numbers.number;
  for (std::uint32_t i = 0; i < numbers.names; ++i) event.names.push_back(from.text());
  event.text = from.text();
  return event;
}

void EventRing::drop_oldest() {
  first_ = (first_ + 1) % slots_.size();
  --count_;
}

}  // namespace aprsim::world
