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

/// The numbers of connections that a listener accepts.
struct ConnectionLimits {
  /// From all addresses together; one more is kept for an address that has none.
  std::size_t at_once = 64;
  /// From one address. Clients on this machine share one address and may use all.
  std::size_t per_address = 32;
  /// A connection without a request for so long may be evicted by a new client.
  std::chrono::milliseconds yield_after{60'000};
};

/// Limits the connections of a listener. At the limit a new client evicts one: an idle connection,
/// first one that never sent a whole request, then the one idle longest; never one of an address
/// with fewer connections than its own. A client whose address has none also evicts a busy
/// connection, of the address with most. So a full table locks no address out. Thread: one at a
/// time, except open().
class ConnectionLimiter : public std::enable_shared_from_this<ConnectionLimiter> {
 public:
  using Clock = std::chrono::steady_clock;

 private:
  struct Holder;

 public:
  /// One counted connection, until leave() or destruction.
  class Slot {
   public:
    Slot() = default;
    Slot(Slot&&) noexcept = default;
    Slot& operator=(Slot&& other) noexcept {
      if (this == &other) return *this;
      leave();
      limiter_ = std::move(other.limiter_);
      holder_ = std::move(other.holder_);
      return *this;
    }
    ~Slot() { leave(); }

    /// Records a complete request, or a reply that was taken.
    void used(Clock::time_point now = Clock::now());
    /// Sets the function that ends an evicted connection; it is called once at most.
    void on_evict(std::function<void()> end);
    /// The connection waits for its next request, and its client opens another one where it is
    /// closed (HTTP): idle at once, until used().
    void rest();
    /// The connection is never idle from now on.
    void keep();
    /// A second call has no effect.
    void leave();

   private:
    friend class ConnectionLimiter;
    Slot(std::shared_ptr<ConnectionLimiter> limiter, std::shared_ptr<Holder> holder)
        : limiter_(std::move(limiter)), holder_(std::move(holder)) {}

    std::shared_ptr<ConnectionLimiter> limiter_;
    std::shared_ptr<Holder> holder_;
  };

  [[nodiscard]] static std::shared_ptr<ConnectionLimiter> create(ConnectionLimits limits) {
    return std::shared_ptr<ConnectionLimiter>(new ConnectionLimiter(limits));
  }

  /// A slot for a connection from a numeric host; another connection may have been evicted for it.
  /// Fails with the limit that is reached.
  [[nodiscard]] Result<Slot> take(std::string_view host, Clock::time_point now = Clock::now());

  [[nodiscard]] std::size_t open() const { return open_; }  ///< Thread: any.

 private:
  struct Holder {
    std::string address;
    Clock::time_point used_at;
    bool proven = false, rests = false, kept = false;
    std::function<void()> end = {};
  };

  explicit ConnectionLimiter(ConnectionLimits limits) : limits_(limits) {}
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
