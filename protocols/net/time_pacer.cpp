#include "protocols/net/time_pacer.hpp"

#include <utility>

#include <boost/asio/post.hpp>

namespace aprsim::protocols {

TimePacer::TimePacer(api::VirtualTime* time, boost::asio::any_io_executor io)
    : time_(time), io_(std::move(io)) {}

bool TimePacer::is_registered(const std::string& role) const {
  return time_ != nullptr && time_->is_registered(role);
}

void TimePacer::join(api::PacerRole role) {
  if (joined() || time_ == nullptr) return;
  id_ =
      time_->join(std::move(role), [io = io_, then = std::weak_ptr<std::function<void()>>(then_)] {
        boost::asio::post(io, [then] {
          const auto open = then.lock();
          if (open && *open) std::exchange(*open, nullptr)();
        });
      });
}

void TimePacer::after(SimTime span, std::function<void()> then) {
  *then_ = std::move(then);
  time_->request_until(*id_, span);
}

void TimePacer::finish() {
  if (joined()) time_->finish(*id_);
}

void TimePacer::leave() {
  if (joined()) time_->leave(*id_);
  detach();
}

void TimePacer::exclude() {
  if (joined()) time_->exclude(*id_);
  detach();
}

void TimePacer::detach() {
  if (!joined()) return;
  id_.reset();
  then_ = std::make_shared<std::function<void()>>();
}

}  // namespace aprsim::protocols
