#include "world/physics/bodies/ode_handles.hpp"

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <string>

#include "world/physics/bodies/physics_failure.hpp"

namespace aprsim::physics::ode {
namespace {

[[noreturn]] void raise(const char* kind, int number, const char* format, va_list arguments) {
  char text[512];
  std::vsnprintf(text, sizeof text, format, arguments);
  throw PhysicsFailure(std::string("ODE ") + kind + " " + std::to_string(number) + ": " + text);
}

void on_error(int number, const char* format, va_list arguments) {
  raise("error", number, format, arguments);
}

void on_debug(int number, const char* format, va_list arguments) {
  raise("assertion", number, format, arguments);
}

// Messages are the direct solver's complaints about nearly singular systems; it recovers by
// itself, and the simulation thread must not write to any stream. They are counted.
thread_local std::uint64_t complaint_count = 0;
void on_message(int, const char*, va_list) { ++complaint_count; }

struct Library {
  Library() {
    dInitODE2(0);
    dSetErrorHandler(on_error);
    dSetDebugHandler(on_debug);
    dSetMessageHandler(on_message);
  }
};

}  // namespace

void initialize() { static const Library library; }

std::uint64_t complaints() { return complaint_count; }

void prepare_thread() {
  initialize();
  static thread_local const int ready = dAllocateODEDataForThread(dAllocateMaskAll);
  if (ready == 0) throw PhysicsFailure("ODE could not allocate its data for this thread");
}

void save(dBodyID body, SavedState& to) {
  std::copy_n(dBodyGetPosition(body), 3, to.p);
  std::copy_n(dBodyGetQuaternion(body), 4, to.q);
  std::copy_n(dBodyGetRotation(body), 12, to.R);
  std::copy_n(dBodyGetLinearVel(body), 3, to.v);
  std::copy_n(dBodyGetAngularVel(body), 3, to.omega);
}

void restore(dBodyID body, const SavedState& from) {
  // dBodySetQuaternion would normalise anew and change last bits. The getters return pointers to
  // ODE's own record; no geom hangs on our bodies that would have to be told.
  const auto write = [](const dReal* ours, const dReal* record, int count) {
    std::copy_n(ours, count, const_cast<dReal*>(record));
  };
  write(from.p, dBodyGetPosition(body), 3);
  write(from.q, dBodyGetQuaternion(body), 4);
  write(from.R, dBodyGetRotation(body), 12);
  write(from.v, dBodyGetLinearVel(body), 3);
  write(from.omega, dBodyGetAngularVel(body), 3);
}

}  // namespace aprsim::physics::ode
