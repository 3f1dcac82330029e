#include "clients/ros2/dds/wakeup.hpp"

namespace aprsim::ros2 {

Wakeup::Wakeup(const Node& node) : waitset_(node.create_waitset()), guard_(node.create_guard()) {
  dds_waitset_attach(waitset_, guard_, 0);
}

Wakeup::~Wakeup() {
  dds_delete(waitset_);
  dds_delete(guard_);
}

void Wakeup::attach(dds_entity_t reader) const {
  // The condition ends with its reader.
  dds_waitset_attach(waitset_, dds_create_readcondition(reader, DDS_ANY_STATE), 0);
}

void Wakeup::notify() const { dds_set_guardcondition(guard_, true); }

void Wakeup::wait(std::chrono::milliseconds longest) const {
  dds_waitset_wait(waitset_, nullptr, 0, DDS_MSECS(longest.count()));
  bool was_triggered = false;
  dds_take_guardcondition(guard_, &was_triggered);
}

}  // namespace aprsim::ros2
