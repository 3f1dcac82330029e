#include "world/physics/ode_handles.hpp"

#include <cstdarg>
#include <cstdio>
#include <string>

#include "world/physics/physics_failure.hpp"

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
  dBodyCopyPosition(body, to.p);
  dBodyCopyQuaternion(body, to.q);
  const dReal* v = dBodyGetLinearVel(body);
  const dReal* omega = dBodyGetAngularVel(body);
  for (int i = 0; i < 3; ++i) {
    to.v[i] = v[i];
    to.omega[i] = omega[i];
  }
}

void restore(dBodyID body, const SavedState& from) {
  dBodySetPosition(body, from.p[0], from.p[1], from.p[2]);
  dBodySetQuaternion(body, from.q);
  dBodySetLinearVel(body, from.v[0], from.v[1], from.v[2]);
  dBodySetAngularVel(body, from.omega[0], from.omega[1], from.omega[2]);
}

}  // namespace aprsim::physics::ode
