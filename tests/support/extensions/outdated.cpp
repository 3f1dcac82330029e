// A library of another version of the interface. Nothing of it but the version may be called.

#include <cstdint>
#include <cstdlib>

extern "C" __attribute__((visibility("default"))) std::uint32_t aprsim_device_interface() {
  return 0;
}

extern "C" __attribute__((visibility("default"))) void* aprsim_make_device(void* /*setup*/) {
  std::abort();
}
