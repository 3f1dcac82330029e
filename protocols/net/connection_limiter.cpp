#include "protocols/net/connection_limiter.hpp"

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

namespace aprsim::protocols {

void ConnectionLimiter::Slot::used(Clock::time_point now) {
  if (!holder_) return;
  holder_->used_at = now;
  holder_->proven = true;
  holder_->rests = false;
}

void ConnectionLimiter::Slot::on_evict(std::function<void()> end) {
  if (holder_) holder_->end = std::move(end);
}

void ConnectionLimiter::Slot::rest() {
  if (holder_) holder_->rests = true;
}

void ConnectionLimiter::Slot::keep() {
  if (holder_) holder_->kept = true;
}

void ConnectionLimiter::Slot::leave() {
  if (!holder_) return;
  limiter_->remove(*holder_);
  holder_.reset();
  limiter_.reset();
}

Result<ConnectionLimiter::Slot> ConnectionLimiter::take(std::string_view host,
                                                        Clock::time_point now) {
  auto newcomer = std::make_shared<Holder>(Holder{client_address(host), now});
  const std::string& address = newcomer->address;
  const std::size_t own = held_by(address);
  const std::size_t share = is_this_machine(address) ? limits_.at_once : limits_.per_address;
  const std::size_t slots = limits_.at_once + (own == 0 ? 1 : 0);
  const bool has_its_share = own >= share, full = holders_.size() >= slots;
  if (has_its_share || full) {
    const auto may_go = [&](const Holder& holder, std::size_t held) {
      if (has_its_share) return holder.address == address && is_idle(holder, now);
      if (own == 0 && held > 1) return true;
      return held >= own && is_idle(holder, now);
    };
    const std::shared_ptr<Holder> goes = least_needed(may_go, now);
    if (!goes) {
      return fail(ErrorCode::kUnavailable, "connections",
                  has_its_share && own < limits_.at_once
                      ? std::to_string(own) + " connections open from its address, the limit"
                      : std::to_string(holders_.size()) + " connections open, the limit");
    }
    remove(*goes);
    if (const auto end = std::exchange(goes->end, nullptr)) end();
  }
  holders_.push_back(newcomer);
  open_ = holders_.size();
  return Slot(shared_from_this(), std::move(newcomer));
}

std::size_t ConnectionLimiter::held_by(const std::string& address) const {
  return static_cast<std::size_t>(std::ranges::count_if(
      holders_, [&](const auto& holder) { return holder->address == address; }));
}

bool ConnectionLimiter::is_idle(const Holder& holder, Clock::time_point now) const {
  if (holder.kept) return false;
  return !holder.proven || holder.rests || now - holder.used_at >= limits_.yield_after;
}

template <typename May>
std::shared_ptr<ConnectionLimiter::Holder> ConnectionLimiter::least_needed(
    const May& may_go, Clock::time_point now) const {
  using Rank = std::tuple<std::size_t, bool, bool, Clock::duration>;
  std::map<std::string_view, std::size_t> held_by_address;
  for (const auto& holder : holders_) ++held_by_address[holder->address];
  std::shared_ptr<Holder> least;
  Rank highest;
  for (const auto& holder : holders_) {
    const std::size_t held = held_by_address[holder->address];
    if (!may_go(*holder, held)) continue;
    const Rank rank{held, is_idle(*holder, now), !holder->proven, now - holder->used_at};
    if (least && rank <= highest) continue;
    least = holder;
    highest = rank;
  }
  return least;
}

void ConnectionLimiter::remove(const Holder& holder) {
  std::erase_if(holders_, [&](const auto& one) { return one.get() == &holder; });
  open_ = holders_.size();
}

}  // namespace aprsim::protocols
