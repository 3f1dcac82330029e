#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "protocols/access/peer_address.hpp"
#include "world/base/result.hpp"

namespace aprsim::protocols {

/// How many connections a listener takes, and from whom.
struct ConnectionLimits {
  /// From all addresses together; one more place is kept for an address that has none.
  std::size_t at_once = 64;
  /// From one address; clients on this machine, which share one, may have all.
  std::size_t per_address = 32;
  /// A connection that nothing has been asked on for so long gives way to a newcomer.
  std::chrono::milliseconds yield_after{60'000};
};

/// The places that a listener has for connections. None is taken from whoever has it before a
/// newcomer needs it, and then from whom it costs least: idle ones yield, those first that have
/// never asked for anything whole, then the longest idle; never one of an address that has fewer
/// than the newcomer's. A newcomer whose address has none finds a place also among busy ones, at
/// the cost of the address that has most; so no full table locks others out.
/// Thread: one at a time, but open().
class ConnectionPlaces : public std::enable_shared_from_this<ConnectionPlaces> {
 public:
  using Clock = std::chrono::steady_clock;

 private:
  struct Holder;

 public:
  /// A connection's hold on its place, until leave() or its end.
  class Place {
   public:
    Place() = default;
    Place(Place&&) noexcept = default;
    Place& operator=(Place&& other) noexcept {
      if (this == &other) return *this;
      leave();
      places_ = std::move(other.places_);
      holder_ = std::move(other.holder_);
      return *this;
    }
    ~Place() { leave(); }

    /// Something whole has been asked for, or taken.
    void used(Clock::time_point now = Clock::now());
    /// What ends the connection when its place is needed; called once at most.
    void on_needed(std::function<void()> end);
    /// From now on it is never idle.
    void keep();
    /// Again: nothing.
    void leave();

   private:
    friend class ConnectionPlaces;
    Place(std::shared_ptr<ConnectionPlaces> places, std::shared_ptr<Holder> holder)
        : places_(std::move(places)), holder_(std::move(holder)) {}

    std::shared_ptr<ConnectionPlaces> places_;
    std::shared_ptr<Holder> holder_;
  };

  [[nodiscard]] static std::shared_ptr<ConnectionPlaces> create(ConnectionLimits limits) {
    return std::shared_ptr<ConnectionPlaces>(new ConnectionPlaces(limits));
  }

  /// A place for a connection from a numeric host; another connection may have been ended for it.
  /// Fails with the limit that is reached.
  [[nodiscard]] Result<Place> take(std::string_view host, Clock::time_point now = Clock::now());

  [[nodiscard]] std::size_t open() const { return open_; }  ///< Thread: any.

 private:
  struct Holder {
    std::string address;
    Clock::time_point used_at;
    bool proven = false, kept = false;
    std::function<void()> end = {};
  };

  explicit ConnectionPlaces(ConnectionLimits limits) : limits_(limits) {}
  [[nodiscard]] std::size_t held_by(const std::string& address) const;
  [[nodiscard]] bool is_idle(const Holder& holder, Clock::time_point now) const;
  template <typename May>
  [[nodiscard]] std::shared_ptr<Holder> least_needed(const May& may_go,
                                                     Clock::time_point now) const;
  void remove(const Holder& holder);

  const ConnectionLimits limits_;
  std::vector<std::shared_ptr<Holder>> holders_;
  std::atomic<std::size_t> open_{0};
};

}  // namespace aprsim::protocols
