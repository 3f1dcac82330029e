#include "world/runtime/time/time_barrier.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace aprsim::world {
namespace {

constexpr TimeBarrier::Steps kUntilCut = std::numeric_limits<TimeBarrier::Steps>::max();
/// Silence after which a client is listed as awaited.
constexpr std::chrono::seconds kNoticeable{1};

}  // namespace

TimeBarrier::TimeBarrier(Options options) : grace_(options.grace) {
  for (std::string& role : options.declared) places_.push_back({.role = std::move(role)});
  record_fallback();
}

bool TimeBarrier::is_registered(const std::string& role) const {
  return std::ranges::find(places_, role, &Place::role) != places_.end();
}

std::optional<api::PacerId> TimeBarrier::join(api::PacerRole role, WallTime now) {
  const auto place = std::ranges::find_if(places_, [&](const Place& p) {
    return p.taken_by == 0 && !p.suspended && p.role == role.name;
  });
  const bool client = role.kind == api::PacerKind::kClient;
  if (client && has_declared() && place == places_.end()) return std::nullopt;
  const api::PacerId id = ++last_id_;
  if (place != places_.end()) {
    place->taken_by = id;
    place->given_up = false;
  }
  const auto after = std::ranges::find_if(members_, [&](const Member& member) {
    return std::pair(member.role.kind, member.role.endpoint) > std::pair(role.kind, role.endpoint);
  });
  members_.insert(after, {.id = id, .role = std::move(role), .since = now});
  begin_if_complete(now);
  record_fallback();
  return id;
}

void TimeBarrier::request_until(api::PacerId id, Steps steps) {
  Member* const member = find(id);
  if (member == nullptr) return;
  member->waiting = true;
  member->absent = false;
  member->until = steps == 0 ? kUntilCut : now_ + steps;
  record_fallback();
}

void TimeBarrier::finish(api::PacerId id) {
  Member* const member = find(id);
  if (member != nullptr) member->finished = true;
}

void TimeBarrier::leave(api::PacerId id, WallTime now) {
  std::erase_if(members_, [id](const Member& member) { return member.id == id; });
  const auto place = std::ranges::find(places_, id, &Place::taken_by);
  if (place != places_.end()) {
    place->taken_by = 0;
    place->free_since = now;
  }
  record_fallback();
}

void TimeBarrier::exclude(api::PacerId id) {
  const auto place = std::ranges::find(places_, id, &Place::taken_by);
  if (place == places_.end() || place->given_up) return;
  place->given_up = true;
  ++expired_;
}

void TimeBarrier::cut(api::PacerId id) {
  Member* const member = find(id);
  if (member != nullptr && member->waiting) member->until = now_;
}

bool TimeBarrier::paced() const {
  if (!places_.empty()) return true;
  return std::ranges::any_of(members_, [](const Member& m) { return is_client(m) && !m.absent; });
}

TimeBarrier::Steps TimeBarrier::due() const {
  if (has_declared() && !begun_) return 0;
  for (const Place& place : places_) {
    if (place.taken_by == 0 && !place.given_up && !place.suspended) return 0;
  }
  Steps until = kUntilCut;
  bool somebody = false;
  for (const Member& member : members_) {
    if (member.absent || !paces(member)) continue;
    if (!member.waiting) return 0;
    somebody = somebody || is_client(member);
    until = std::min(until, member.until);
  }
  return somebody && until > now_ ? until - now_ : 0;
}

std::vector<api::PacerId> TimeBarrier::take_reached(WallTime now) {
  std::vector<api::PacerId> reached;
  const bool waits = paced();
  for (Member& member : members_) {
    // Feeds come first.
    if (waits && member.role.kind != api::PacerKind::kFeed && feed_is_busy()) break;
    if (waits && is_client(member) && client_thinks()) break;
    if (!member.waiting || member.until > now_) continue;
    member.waiting = false;
    member.since = now;
    reached.push_back(member.id);
  }
  return reached;
}

std::vector<api::PacerId> TimeBarrier::release_clients(WallTime now) {
  std::vector<api::PacerId> released;
  for (Member& member : members_) {
    if (!is_client(member) || !member.waiting) continue;
    member.waiting = false;
    member.since = now;
    released.push_back(member.id);
  }
  return released;
}

void TimeBarrier::set_robots(const std::vector<std::string>& robots, WallTime now) {
  for (Place& place : places_) {
    const auto dot = place.role.find('.');
    const bool lacks = dot != std::string::npos &&
                       std::ranges::find(robots, place.role.substr(dot + 1)) == robots.end();
    if (place.suspended && !lacks) {
      place.given_up = false;
      place.free_since = now;
    }
    place.suspended = lacks;
  }
  // A client that paced without a declared role may have one now.
  for (Place& place : places_) {
    if (place.suspended || place.taken_by != 0) continue;
    const auto member = std::ranges::find_if(members_, [&](const Member& m) {
      return is_client(m) && m.role.name == place.role && !paces(m);
    });
    if (member != members_.end()) place.taken_by = member->id;
  }
  begin_if_complete(now);
  record_fallback();
}

void TimeBarrier::expire(WallTime now) {
  const bool declared = has_declared();
  if (grace_.count() == 0 || (declared && (!begun_ || !client_waits()))) return;
  for (Member& member : members_) {
    if (!is_client(member) || member.waiting || member.absent || !paces(member)) continue;
    if (now - std::max(member.since, begun_.value_or(member.since)) < grace_) continue;
    member.absent = true;
    ++expired_;
  }
  for (Place& place : places_) {
    if (place.taken_by != 0 || place.given_up || place.suspended) continue;
    if (now - place.free_since < grace_) continue;
    place.given_up = true;
    ++expired_;
  }
  record_fallback();
}

std::vector<api::EndpointId> TimeBarrier::endpoints() const {
  std::vector<api::EndpointId> all;
  for (const Member& member : members_) {
    if (member.role.kind != api::PacerKind::kFeed) all.push_back(member.role.endpoint);
  }
  return all;
}

api::VirtualTimeState TimeBarrier::state(WallTime now) const {
  api::VirtualTimeState state;
  state.paced = paced();
  for (const Member& member : members_) {
    if (!is_client(member) || member.absent || !paces(member)) continue;
    state.pacers.push_back(member.role.name);
    if (!member.waiting && client_waits() && now - member.since >= kNoticeable) {
      state.awaited.push_back(member.role.name);
    }
  }
  for (const Place& place : places_) {
    if (place.taken_by == 0 && !place.given_up && !place.suspended) {
      state.awaited.push_back(place.role);
    }
  }
  if (!places_.empty() && !has_declared() && state.pacers.empty()) {
    state.awaited.emplace_back("any client");
  }
  std::ranges::sort(state.pacers);
  std::ranges::sort(state.awaited);
  state.expired = expired_;
  state.fallbacks = fallbacks_;
  return state;
}

TimeBarrier::Member* TimeBarrier::find(api::PacerId id) {
  const auto found = std::ranges::find(members_, id, &Member::id);
  return found == members_.end() ? nullptr : &*found;
}

bool TimeBarrier::has_declared() const {
  return std::ranges::any_of(places_, [](const Place& place) { return !place.suspended; });
}

bool TimeBarrier::paces(const Member& member) const {
  if (!is_client(member) || !has_declared()) return true;
  return std::ranges::any_of(
      places_, [&](const Place& place) { return !place.suspended && place.taken_by == member.id; });
}

bool TimeBarrier::feed_is_busy() const {
  return std::ranges::any_of(members_, [](const Member& member) {
    return member.role.kind == api::PacerKind::kFeed && !member.waiting;
  });
}

bool TimeBarrier::client_waits() const {
  return std::ranges::any_of(members_, [this](const Member& m) {
    return is_client(m) && m.waiting && !m.finished && paces(m);
  });
}

bool TimeBarrier::client_thinks() const {
  return std::ranges::any_of(members_, [this](const Member& m) {
    return is_client(m) && !m.waiting && !m.absent && paces(m);
  });
}

void TimeBarrier::begin_if_complete(WallTime now) {
  if (begun_ || !has_declared()) return;
  if (std::ranges::all_of(
          places_, [](const Place& place) { return place.taken_by != 0 || place.suspended; })) {
    begun_ = now;
  }
}

void TimeBarrier::record_fallback() {
  const bool now_paced = paced();
  if (was_paced_ && !now_paced) ++fallbacks_;
  was_paced_ = now_paced;
}

}  // namespace aprsim::world
